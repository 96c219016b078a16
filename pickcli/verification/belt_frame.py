"""The frame of a running belt, and what is seen from it: written anew, apart from how plans are made.

The frame of a conveyor at a time is that of its carrier, carried on along its own +x. Items keep their poses
in that frame. The hall and the arm that stands in it keep theirs in the world: in the frame of the belt they
slide along -x.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import takewhile

import numpy as np

from pickcli.cell.robot import Joint, JointType, Limits, Robot, massless_link
from pickcli.geometry import Array, inverse, pose
from pickcli.motion.plan import LineTracking, Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import Scene

FARTHEST = 100.0  # m that a conveyor carries anything
_X = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class BeltFrame:
    """The frame of a running belt.

    Attributes:
        conveyor: Name of the conveyor.
        T_world_start: (4, 4) pose of the frame when the plan starts: that of the carrier.
        speed: m/s of the belt.
    """

    conveyor: str
    T_world_start: Array
    speed: float

    @classmethod
    def of(cls, tracking: LineTracking, scene: Scene) -> BeltFrame:
        """Return the frame of the conveyor of a plan.

        Args:
            tracking: The conveyor, one of the cell's.
            scene: The scene at the start of the plan.

        Returns:
            The frame.
        """
        carrier = scene.cell.carriers[tracking.conveyor]
        return cls(tracking.conveyor, scene.pose_of(carrier).T_world_carrier, tracking.speed)

    def at(self, t: float) -> Array:
        """Return the pose of the frame.

        Args:
            t: s of the plan.

        Returns:
            (4, 4) in the world.
        """
        return self.T_world_start @ pose((self.speed * t, 0.0, 0.0))

    def scene_at(self, scene: Scene, t: float) -> Scene:
        """Return the scene at a time: what rides on the belt keeps its pose in the frame of the belt.

        Args:
            scene: The scene at the start of the plan.
            t: s of the plan.

        Returns:
            The scene, where nothing else has moved.
        """
        riding, T_now_start = scene.cell.carriers[self.conveyor].places, self.at(t) @ inverse(self.at(0.0))
        items = (
            replace(each, T_world_item=T_now_start @ each.T_world_item) if each.location in riding else each
            for each in scene.items
        )
        return replace(scene, items=tuple(items))

    def seen_robot(self, robot: Robot, t_seen: float) -> Robot:
        """Return a robot as it is seen from the belt: it stands on a carriage that slides along the belt's x.

        Args:
            robot: The robot.
            t_seen: s of the plan at which the carriage is at 0 m.

        Returns:
            The robot, with the carriage's joint before its own, unlimited in speed.
        """
        rail, carriage = f"{self.conveyor}: rail", f"{self.conveyor}: carriage"
        root = robot.links[0].name
        T_belt_root = inverse(self.at(t_seen)) @ robot.T_world_base
        slides = Joint(
            _travel(self.conveyor), JointType.PRISMATIC, rail, carriage, np.eye(4), _X, -FARTHEST, FARTHEST
        )
        carries = Joint(f"{carriage} to {root}", JointType.FIXED, carriage, root, T_belt_root, _X, 0.0, 0.0)
        own = robot.limits
        limits = Limits(
            lower=np.append(-FARTHEST, own.lower),
            upper=np.append(FARTHEST, own.upper),
            velocity=np.append(np.inf, own.velocity),
            acceleration=np.append(np.inf, own.acceleration),
            jerk=np.append(np.inf, own.jerk),
        )
        return replace(
            robot,
            T_world_base=self.at(t_seen),
            links=(massless_link(rail), massless_link(carriage), *robot.links),
            joints=(slides, carries, *robot.joints),
            joint_names=(slides.name, *robot.joint_names),
            limits=limits,
        )

    def seen_plan(self, plan: Plan, t_seen: float, t_end: float) -> Plan:
        """Return a plan as it is seen from the belt until some time, and from the hall after that.

        Args:
            plan: The plan of a robot.
            t_seen: s of the plan at which belt and hall coincide.
            t_end: s of the plan up to which it is seen from the belt.

        Returns:
            The plan for ``seen_robot``.
        """
        at = plan.trajectory
        is_seen = at.times <= t_end
        ahead = np.where(is_seen, self.speed * at.times - self.speed * t_seen, 0.0)  # m, of belt over hall
        gain = np.where(is_seen, self.speed, 0.0)
        seen = Trajectory(
            joint_names=(_travel(self.conveyor), *at.joint_names),
            times=at.times,
            positions=np.insert(at.positions, 0, -ahead, axis=1),
            velocities=np.insert(at.velocities, 0, -gain, axis=1),
            accelerations=np.insert(at.accelerations, 0, 0.0, axis=1),
        )
        return replace(plan, trajectory=seen)


def working_times(segments: Sequence[Segment]) -> tuple[float, float]:
    """Find when the tool works on what rides on the belt.

    Args:
        segments: The segments of a plan with one contact and a transfer after it.

    Returns:
        s of the plan at which its first transits end, and at which the transfer that follows the contact
        begins.
    """
    coming = list(takewhile(lambda each: each.kind is SegmentKind.TRANSIT, segments))
    kinds = [each.kind for each in segments]
    leaving = kinds.index(SegmentKind.TRANSFER, kinds.index(SegmentKind.CONTACT))
    return coming[-1].t_end if coming else 0.0, segments[leaving].t_start


def farthest_brought(tracking: LineTracking, t_left: float, duration: float, max_speed: float) -> float:
    """Bound how far the belt brings what comes while a plan lasts.

    Until the tool leaves the belt, the belt is where the plan says, but for its deviation; from then on
    nothing is known of it but that it never exceeds its greatest speed.

    Args:
        tracking: The conveyor.
        t_left: s of the plan at which the tool leaves the belt.
        duration: s that the plan lasts.
        max_speed: m/s.

    Returns:
        m.
    """
    return float(np.dot([tracking.speed, max_speed], [t_left, duration - t_left])) + tracking.deviation


def _travel(conveyor: str) -> str:
    """Name the joint of what slides, as seen from a conveyor."""
    return f"{conveyor}: travel of the hall"
