"""What the stages of a pick hand to each other, in the order in which it is made: values only."""

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
from pickcli.kinematics.continuous_joints import turned_towards
from pickcli.motion.plan import Grasp
from pickcli.roadmap.query_experience import QueryExperience
from pickcli.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class ToolLines:
    """What the tool alone can do for one grasp.

    Attributes:
        grasp: Where the tool takes the target.
        modes: What each stage of the grasp must be free for, without the target.
        inward: Ways to the contact, the plainest first.
        outward: Ways out of the place that leave the tool room, and on which it holds.
    """

    grasp: Grasp
    modes: GraspModes
    inward: tuple[PickPoses, ...]
    outward: tuple[LiftPoses, ...]

    @property
    def contact(self) -> Array:
        """(4, 4) pose of the tool in the world where it takes the target."""
        return self.inward[0].contact


@dataclass(frozen=True, eq=False)
class GraspMotion:
    """All segments of one grasp inside its place. Each starts where the one before ends.

    Attributes:
        grasp: Where the tool takes the target.
        attached: The target in the tool.
        inward: Pre-approach, approach and contact, with the empty tool. Where fingers close, the contact has
            no length.
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

    def turned_towards(self, limits: Limits, q: Array) -> GraspMotion:
        """The motion turned by whole turns, to start within half a turn of a configuration in every joint.

        Args:
            limits: Limits of the n joints.
            q: (n,) the configuration that it is reached from.

        Returns:
            The motion, turned by whole turns.
        """
        by = turned_towards(limits, self.start, q) - self.start
        if not by.any():
            return self
        inward, outward = (tuple(s.turned(by) for s in part) for part in (self.inward, self.outward))
        return replace(self, inward=inward, outward=outward)


@dataclass(frozen=True, eq=False)
class GraspTransit:
    """A grasp with the transit to it.

    Attributes:
        taking: The motion inside the place, to the item and out with it.
        transit: From the start to where that begins.
        cost: s, about the time to the end of the retreat, and what the grasp's score is worth.
        experience: What was found on the way to it that was not stored, also of grasps that were not chosen.
    """

    taking: GraspMotion
    transit: MotionSegment
    cost: float
    experience: tuple[QueryExperience, ...] = ()


@dataclass(frozen=True, eq=False)
class PlaceMotion:
    """One way to let the item go. Each segment starts where the one before ends.

    Attributes:
        scene: The scene when the item has been let go.
        inward: With the item, to the release.
        away: With the empty tool, in that scene. Where fingers open, the first has no length.
        cost: s that a better place would be worth.
    """

    scene: Scene
    inward: tuple[MotionSegment, ...]
    away: tuple[MotionSegment, ...]
    cost: float

    @property
    def start(self) -> Array:
        """Configuration (n,) in which the transfer arrives."""
        return self.inward[0].start

    def turned_towards(self, limits: Limits, q: Array) -> PlaceMotion:
        """The motion turned by whole turns, to start within half a turn of a configuration in every joint.

        Args:
            limits: Limits of the n joints.
            q: (n,) the configuration that it is reached from.

        Returns:
            The motion, turned by whole turns.
        """
        by = turned_towards(limits, self.start, q) - self.start
        if not by.any():
            return self
        inward, away = (tuple(s.turned(by) for s in part) for part in (self.inward, self.away))
        return replace(self, inward=inward, away=away)


@dataclass(frozen=True, eq=False)
class PickMotion:
    """The geometry of a whole pick.

    Attributes:
        transit: From where the robot is to the pre-approach.
        taking: Inside the place, to the item and out with it.
        transfer: From the end of the retreat to where the placement begins.
        placement: To the release, and away from there.
        experience: What the search for the transfer found that was not stored.
    """

    transit: MotionSegment
    taking: GraspMotion
    transfer: MotionSegment
    placement: PlaceMotion
    experience: tuple[QueryExperience, ...] = ()
