"""Why a motion was stopped before its end: a cause, and what was measured against which threshold."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class StopCause(StrEnum):
    """What a robot can know of a motion that goes wrong. None of them is taken from the engine's truth."""

    FOLLOWING_ERROR = "following error"  # a joint or the tool is not where it was told to be
    CONTACT = "unexpected contact"  # the motors need another torque than the motion does
    EARLY_CONTACT = "early contact"  # the cup meets its item before the plan expects it
    NOT_SEALED = "not sealed"  # the vacuum does not rise although the cup is pressed on
    SEAL_LOST = "seal lost"  # the vacuum falls while something is carried
    NOT_GRASPED = "not grasped"  # the fingers do not stand at the width of the item when it is to be lifted
    GRASP_LOST = "grasp lost"  # the fingers leave that width while something is carried
    SENSOR = "sensor"  # the vacuum sensor answers that nothing is held

    @property
    def has_lost_item(self) -> bool:
        """Whether something that was carried falls."""
        return self in (StopCause.SEAL_LOST, StopCause.GRASP_LOST)

    @property
    def is_measured_empty(self) -> bool:
        """Whether pressure in the cup or the width of the fingers says so, not a sensor's yes or no."""
        return self.has_lost_item or self in (StopCause.NOT_SEALED, StopCause.NOT_GRASPED)

    @property
    def is_empty(self) -> bool:
        """Whether a measurement or a sensor says that nothing is held."""
        return self.is_measured_empty or self is StopCause.SENSOR


@dataclass(frozen=True)
class ProtectiveStop:
    """A protective stop (ISO 10218-1), which ends at rest on the planned path.

    Motion ceases, drives stay on, and a motion planned from there may follow.

    Attributes:
        cause: What the robot knew.
        where: Joint, "tool" or device that was measured.
        measured: In ``unit``; the stop was asked for when it passed the threshold.
        threshold: In ``unit``.
        unit: Of both.
        t: s, simulated, when it was asked for.
    """

    cause: StopCause
    where: str
    measured: float
    threshold: float
    unit: str
    t: float

    @property
    def is_empty(self) -> bool:
        """Whether a measurement or a sensor says that nothing is held."""
        return self.cause.is_empty

    def __str__(self) -> str:
        if self.cause is StopCause.SENSOR:
            return f"the {self.where} reads that nothing is held"
        return f"{self.cause}: {self.where} at {self.measured:.4g} {self.unit} (limit {self.threshold:.4g})"
