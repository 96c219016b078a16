"""The figures that shape a pick. Lengths in m, speeds in m/s, times in s."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Neighbours(StrEnum):
    """What the lines inside the bin do about other items."""

    AVOID = "avoid"  # Delft: no contact with neighbours but for the stated first stretch of the lift
    IGNORE = "ignore"  # KTH: collisions with the bin's content are not considered


@dataclass(frozen=True)
class PickSettings:
    """How a pick is shaped and how long the search goes on (counted, never timed)."""

    approach_offset: float = 0.04  # of the approach along the tool axis
    lift_contact: float = 0.053  # first stretch of the lift in which support and neighbours may be touched
    approach_speed: float = 0.35
    preapproach_speed: float = 0.8
    lift_speed: float = 0.25
    retreat_speed: float = 0.6
    place_speed: float = 0.5
    seal_time: float = 0.25  # at rest on the item, for the vacuum to build up under the cup
    release_time: float = 0.15  # at rest over the tote, for the vacuum to leak away
    start_dwell: float = 0.0
    load_ratio: float = 0.8  # of what the cup bears, that planned motion may use
    load_worth: float = 1.0  # that a grasp without load gains over one that takes up all that the cup bears
    wanted: int = 3  # feasible grasps among which the best whole motion is chosen
    solutions_per_grasp: int = 4  # inverse-kinematics branches followed per grasp
    shortcuts: int = 60
    rrt_iterations: int = 4000


DEFAULTS = PickSettings()
