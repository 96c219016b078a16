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
    GRASP_LOST = "grasp lost"  # they close further while something is carried
    SENSOR = "sensor"  # the vacuum sensor answers that nothing is held


EMPTY = (
    StopCause.NOT_SEALED, StopCause.SEAL_LOST, StopCause.NOT_GRASPED, StopCause.GRASP_LOST, StopCause.SENSOR,
)  # fmt: skip


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
        """Whether the vacuum, or the width of the fingers, says that nothing is held."""
        return self.cause in EMPTY

    def __str__(self) -> str:
        if self.cause is StopCause.SENSOR:
            return f"the {self.where} reads that nothing is held"
        return f"{self.cause}: {self.where} at {self.measured:.4g} {self.unit} (limit {self.threshold:.4g})"
