"""Protective stops of a motion: the cause, and the measurement that exceeded a threshold."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class StopCause(StrEnum):
    """Faults that a robot can detect. None of them uses the engine's ground truth."""

    FOLLOWING_ERROR = "following error"  # a joint or the tool is not at its commanded position
    CONTACT = "unexpected contact"  # motor torques differ from those of the motion
    EARLY_CONTACT = "early contact"  # the cup meets its item before the plan expects it
    NOT_SEALED = "not sealed"  # the vacuum does not build up although the cup is pressed on
    SEAL_LOST = "seal lost"  # the vacuum drops while an item is carried
    NOT_GRASPED = "not grasped"  # the fingers are not at the width of the item before the lift
    GRASP_LOST = "grasp lost"  # the fingers leave that width while an item is carried
    WRONG_WEIGHT = "wrong weight"  # what is held is lighter or heavier than the item can be
    BELT = "conveyor"  # the belt that the arm follows stands too long, or is off the plan
    OPERATOR = "operator"  # who stops a motion that has not taken its item off a belt, and cannot go on later
    SENSOR = "sensor"  # the vacuum sensor reads that nothing is held

    @property
    def has_lost_item(self) -> bool:
        """Whether a carried item is falling."""
        return self in (StopCause.SEAL_LOST, StopCause.GRASP_LOST)

    @property
    def is_measured_empty(self) -> bool:
        """Whether a measured pressure or width shows that nothing is held, not a binary sensor."""
        return self.has_lost_item or self.has_left_item

    @property
    def has_left_item(self) -> bool:
        """Whether a measured pressure or width shows that the item was not taken from where it was."""
        return self in (StopCause.NOT_SEALED, StopCause.NOT_GRASPED)

    @property
    def is_empty(self) -> bool:
        """Whether a measurement or a sensor says that nothing is held."""
        return self.is_measured_empty or self is StopCause.SENSOR


@dataclass(frozen=True)
class ProtectiveStop:
    """A protective stop (ISO 10218-1), which ends at rest on the planned path.

    The drives stay on, and a motion planned from there may follow.

    Attributes:
        cause: The detected fault.
        where: Joint, "tool" or device that was measured.
        measured: Value in ``unit`` that passed the threshold.
        threshold: In ``unit``.
        unit: Unit of both.
        t: s, simulated, time of the request.
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
        if self.cause is StopCause.OPERATOR:
            return f"{self.cause}: the item on {self.where} was not taken yet"
        if self.cause is StopCause.SENSOR:
            return f"the {self.where} reads that nothing is held"
        return f"{self.cause}: {self.where} at {self.measured:.4g} {self.unit} (limit {self.threshold:.4g})"
