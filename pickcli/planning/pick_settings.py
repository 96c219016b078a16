"""Parameters of a pick. Lengths in m, speeds in m/s, times in s."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

SLOWER_THAN_ALLOWED = 0.98  # of a limit of the tool's speed: between points timing bounds it only roughly


class Neighbours(StrEnum):
    """How lines inside the bin treat other items."""

    AVOID = "avoid"  # Delft: no contact with neighbours except for the stated first stretch of the lift
    PUSH = "push"  # out of an open box the held item may push others aside
    IGNORE = "ignore"  # KTH: collisions with other items in the bin are ignored


class GraspApproach(StrEnum):
    """Where the grasps of a pick come from, to each of which all lines are proven alike."""

    LINES = "lines"  # fixed candidates on every face: few, then many
    REGION = "region"  # a region query: found in envelopes from the arm
    REACTIVE = "reactive"  # as by region; a controller rolls out the transit to where its lines begin
    LINES_THEN_REGION = "lines-then-region"  # a region query where no fixed candidate succeeds


class DropPlace(StrEnum):
    """From where an item is dropped into a tote or another open box."""

    INSIDE = "inside"  # between the walls, low over what lies there
    RIM = "rim"  # over the rim, where that is not too high: without the way down and up again


@dataclass(frozen=True)
class PickSettings:
    """Shape of a pick and effort of the search (counted, not timed).

    Attributes:
        approach: Where the grasps come from.
        drop_from: From where items are dropped into open boxes.
        approach_offset: m, length of the approach along the tool axis.
        first_stretch: m, first part of the lift, in which support and neighbours may be touched.
        approach_speed: m/s of the tool on the approach.
        preapproach_speed: m/s of the tool from the pre-approach into the bin.
        lift_speed: m/s of the tool on the lift.
        retreat_speed: m/s of the tool on the retreat.
        push_speed: m/s of the tool on lift and retreat where the item may push others aside, and where the
            empty tool comes out after a push.
        push_rest: s at rest at the end of a push that topples an item, in which it falls.
        drop_speed: m/s of the tool on the last line to where the item is dropped.
        release_time: s at rest at the release, while the cup is vented. Not longer: an item that lands on an
            edge turns over, and its other end rises.
        load_ratio: Share of what the cup bears that planned motion may use.
        push_load_ratio: The same where the item may push others aside, including all that lies on it.
        load_worth: s of cost difference between a grasp without load and one with all that the cup bears.
        wanted: Number of feasible grasps among which the best whole motion is chosen.
        solutions_per_grasp: Number of inverse-kinematics branches followed per grasp.
        shortcuts: Number of shortcuts tried on a coarse motion.
        rrt_iterations: Most iterations of the coarse planner.
        upright: rad, the most that the held item is tilted from how it stood when it was taken; None for any.
        expansions: Most expansions of ARA* on the lattice of hand poses, by which transits to grasps are
            planned, as the PR2 did in 2013; None for precomputed files and the coarse planner.
    """

    approach: GraspApproach = GraspApproach.LINES
    drop_from: DropPlace = DropPlace.INSIDE
    approach_offset: float = 0.04
    first_stretch: float = 0.053
    approach_speed: float = 0.35
    preapproach_speed: float = 0.8
    lift_speed: float = 0.25
    retreat_speed: float = 0.6
    push_speed: float = 0.095
    push_rest: float = 0.2
    drop_speed: float = 0.5
    release_time: float = 0.06
    load_ratio: float = 0.8
    push_load_ratio: float = 0.5
    load_worth: float = 1.0
    wanted: int = 3
    solutions_per_grasp: int = 4
    shortcuts: int = 60
    rrt_iterations: int = 4000
    upright: float | None = None
    expansions: int | None = None

    @property
    def while_pushing(self) -> PickSettings:
        """The settings of a pick that may push items aside: slow, and with a reserve of load."""
        return replace(
            self,
            lift_speed=min(self.lift_speed, self.push_speed),
            retreat_speed=min(self.retreat_speed, self.push_speed),
            load_ratio=min(self.load_ratio, self.push_load_ratio),
        )


DEFAULTS = PickSettings()
