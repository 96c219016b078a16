"""Data that the stages of a pick pass on, in the order in which it is computed."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pickcli.cartesian.corridor import LiftPoses
from pickcli.cartesian.key_waypoints import PickPoses
from pickcli.cell.robot import Limits
from pickcli.cell.tool import ToolState
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.motion_segment import MotionSegment
from pickcli.geometry import Array
from pickcli.grasping.grasp_method import GraspModes
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.motion.plan import Grasp
from pickcli.path_planning.lattice_planner import LatticePlan
from pickcli.roadmap.query_experience import QueryExperience
from pickcli.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class ToolLines:
    """Tool motions of one grasp, planned for the tool without the arm.

    Attributes:
        grasp: Grasp of the target.
        modes: Modes of the grasp's segments, without the target.
        inward: Ways to the contact, the simplest first.
        outward: Ways out of the place with clearance for the tool, on which it holds the target.
    """

    grasp: Grasp
    modes: GraspModes
    inward: tuple[PickPoses, ...]
    outward: tuple[LiftPoses, ...]

    @property
    def contact(self) -> Array:
        """(4, 4) pose of the tool in the world at the grasp."""
        return self.inward[0].contact


@dataclass(frozen=True, eq=False)
class GraspMotion:
    """All segments of one grasp inside its place. Each starts at the end of the one before.

    Attributes:
        grasp: Grasp of the target.
        attached: The target, attached to the tool.
        inward: Pre-approach, approach and contact, with the empty tool. For fingers, the contact has no
            length.
        outward: First stretch of the lift, lift and retreat, with the target.
    """

    grasp: Grasp
    attached: AttachedItem
    inward: tuple[MotionSegment, ...]
    outward: tuple[MotionSegment, ...]

    @property
    def start(self) -> Array:
        """Configuration (n,) of the pre-approach."""
        return self.inward[0].start

    @property
    def end(self) -> Array:
        """Configuration (n,) at the end of the retreat."""
        return self.outward[-1].end

    @property
    def holding_state(self) -> ToolState:
        """State of the tool while it holds the target."""
        return self.outward[-1].mode.tool_state

    def unwound_towards(self, limits: Limits, q: Array) -> GraspMotion:
        """Shift the motion by whole turns, to start within half a turn of a configuration in every joint.

        Args:
            limits: Limits of the n joints.
            q: (n,) the configuration from which it is reached.

        Returns:
            The shifted motion.
        """
        by = unwound_towards(limits, self.start, q) - self.start
        if not by.any():
            return self
        inward, outward = (tuple(s.unwound(by) for s in part) for part in (self.inward, self.outward))
        return replace(self, inward=inward, outward=outward)


@dataclass(frozen=True, eq=False)
class GraspTransit:
    """A grasp with the transit to it.

    Attributes:
        taking: The motion inside the place, to the item and out with it.
        transit: From the start configuration to the start of ``taking``.
        cost: s, estimated time to the end of the retreat, plus the cost of the grasp's score.
        experience: New experience of the search for transits, also to grasps that were not chosen.
        searched: What ARA* found on the lattice of hand poses; None of transits that are not planned by it.
        is_rolled_out: Whether a controller rolled it out, and no planner took over; None if none was asked.
    """

    taking: GraspMotion
    transit: MotionSegment
    cost: float
    experience: tuple[QueryExperience, ...] = ()
    searched: LatticePlan | None = None
    is_rolled_out: bool | None = None

    @property
    def figures(self) -> dict[str, float]:
        """What a search with a bound, or a controller, knows of the transit, by name; nothing of others."""
        found = {} if self.searched is None else dict(self.searched.figures)
        if self.is_rolled_out is not None:
            found["transit_rolled_out"] = float(self.is_rolled_out)
        return found


@dataclass(frozen=True, eq=False)
class PlaceMotion:
    """One way to place the item. Each segment starts at the end of the one before.

    Attributes:
        scene: Scene in which ``away`` is proven: after the release, the item at its new pose; of an item that
            is dropped, whose new pose is unknown, the scene before the pick.
        inward: With the item, to the release.
        away: With the empty tool, in ``scene``. For fingers, the first has no length.
        cost: s, penalty of the placement.
    """

    scene: Scene
    inward: tuple[MotionSegment, ...]
    away: tuple[MotionSegment, ...]
    cost: float

    @property
    def start(self) -> Array:
        """Configuration (n,) at the end of the transfer."""
        return self.inward[0].start

    @property
    def ends_at_release(self) -> bool:
        """Whether the arm stays where it lets the item go."""
        return not any(segment.has_length for segment in self.away)

    @property
    def holding_state(self) -> ToolState:
        """State of the tool while it holds the item."""
        return self.inward[0].mode.tool_state

    def unwound_towards(self, limits: Limits, q: Array) -> PlaceMotion:
        """Shift the motion by whole turns, to start within half a turn of a configuration in every joint.

        Args:
            limits: Limits of the n joints.
            q: (n,) the configuration from which it is reached.

        Returns:
            The shifted motion.
        """
        by = unwound_towards(limits, self.start, q) - self.start
        if not by.any():
            return self
        inward, away = (tuple(s.unwound(by) for s in part) for part in (self.inward, self.away))
        return replace(self, inward=inward, away=away)


@dataclass(frozen=True, eq=False)
class Transfer:
    """A way from the end of the retreat to a placement.

    Attributes:
        segments: One coarse motion; or two, between which the tool changes its state while the arm rests, in
            a segment without length.
        placement: The placement.
        experience: New experience of the search for it.
    """

    segments: tuple[MotionSegment, ...]
    placement: PlaceMotion
    experience: tuple[QueryExperience, ...] = ()


@dataclass(frozen=True, eq=False)
class PickMotion:
    """All segments of a pick, not yet timed.

    Attributes:
        transit: From the start configuration to the pre-approach.
        taking: Inside the place, to the item and out with it.
        transfer: From the end of the retreat to the start of the placement.
    """

    transit: MotionSegment
    taking: GraspMotion
    transfer: Transfer

    @property
    def placement(self) -> PlaceMotion:
        """The placement to which the transfer leads."""
        return self.transfer.placement
