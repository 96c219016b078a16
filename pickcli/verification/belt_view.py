"""A plan that takes its item from a running conveyor, as seen from the hall and from the belt.

Seen from the belt, what rides on it stands still and the arm travels backwards: one more linear joint below
its base. Everything that rides on the belt is judged there, everything else in the hall; it occupies all that
it may have come to, ahead of where the plan states it, or behind. Lines, rests and events are judged relative
to what the tool works on: to the belt until the transfer begins, to the hall from then on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from pickcli.cell.robot import Joint, JointType, Limits, Link, Robot
from pickcli.cell.shapes import hull
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan, times_at_work
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.item_stream import after_travel
from pickcli.scene.scene import Scene
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.moving_parts import Fixture
from pickcli.verification.static_solids import PlanFixtures

TIME_TOLERANCE = 1e-6  # s
SPEED_TOLERANCE = 1e-9  # m/s
LENGTH_TOLERANCE = 1e-6  # m
SLICE = 0.05  # s of a transfer during which an item occupies all that it may have come to
SLICE_GROWTH = 0.25  # of the time since the tool has left the belt, by which a slice is longer
_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


@dataclass(frozen=True, eq=False)
class BeltView:
    """A plan in three frames. Those of hall and belt coincide when the contact is made.

    Attributes:
        scene: The scene with the items where the belt has carried them at the contact.
        seen_scene: That scene with a robot that travels along the belt.
        seen: The plan as seen from the belt, for that robot; its transfers are cut into slices, within each
            of which an item occupies all that it may have come to.
        at_work: The plan as seen from the belt until the transfer begins, and from the hall after that.
        riding: Ids of the items on the belt.
        along: (3,) unit vector in the world, in which the belt runs.
    """

    scene: Scene
    seen_scene: Scene
    seen: Plan
    at_work: Plan
    riding: frozenset[str]
    along: Array

    @classmethod
    def of(cls, plan: Plan, scene: Scene) -> BeltView:
        """Describe a plan without a fault in its structure and its conveyor.

        Args:
            plan: The plan, with a conveyor.
            scene: The scene at its start.

        Returns:
            The plan in its frames.
        """
        assert plan.tracking is not None and plan.grasp is not None
        tracking, contact = plan.tracking, _contact(plan)
        carrier = scene.cell.carriers[tracking.conveyor]
        at_contact = after_travel(scene, tracking.conveyor, tracking.speed * contact.t_end)
        along = scene.pose_of(carrier).T_world_carrier[:3, 0]
        robot = _travelling(scene.cell.robot, along, tracking.conveyor)
        seen_scene = replace(at_contact, cell=replace(scene.cell, robot=robot))
        t = plan.trajectory.times
        travel, speeds = -tracking.speed * (t - contact.t_end), np.full(len(t), -tracking.speed)
        t_left = times_at_work(plan.segments)[1]
        is_on_belt = t <= t_left + TIME_TOLERANCE
        return cls(
            at_contact,
            seen_scene,
            _with_travel(replace(plan, segments=_sliced(plan.segments, t_left)), robot, travel, speeds),
            _with_travel(plan, robot, np.where(is_on_belt, travel, 0.0), np.where(is_on_belt, speeds, 0.0)),
            frozenset(placed.id for placed in scene.items if placed.location in carrier.places),
            along,
        )

    def in_hall(self, world: PlanFixtures, item: str) -> PlanFixtures:
        """Return the fixtures without what rides on the belt.

        Args:
            world: All fixtures.
            item: Id of the item that is taken, which may stand somewhere else after its release.

        Returns:
            The fixtures of the hall.
        """
        before = tuple(each for each in world.before if each.name not in self.riding)
        after = world.set_down and tuple(
            each for each in world.set_down if each.name not in self.riding or each.name == item
        )
        return replace(world, before=before, set_down=after)

    def on_belt(self, world: PlanFixtures, item: str) -> RidingFixtures:
        """Return the fixtures that ride on the belt.

        Args:
            world: All fixtures of ``seen``.
            item: Id of the item that is taken, which is gone after its release.

        Returns:
            The items on the belt, swept in each segment over all that they may have come to.
        """
        tracking, segments = self.seen.tracking, self.seen.segments
        assert tracking is not None
        conveyor = self.scene.cell.carriers[tracking.conveyor].conveyor
        assert conveyor is not None
        ends = np.array([(s.t_start, s.t_end) for s in segments])
        off = tracking.off_by(ends, times_at_work(segments), conveyor.max_speed)
        behind, ahead = (each.max(axis=1).tolist() for each in off)
        before = tuple(each for each in world.before if each.name in self.riding)
        after = world.set_down and tuple(
            each for each in world.set_down if each.name in self.riding and each.name != item
        )
        swept = tuple(
            tuple(_swept(fixture, self.along, -low, high) for fixture in before)
            for low, high in zip(behind, ahead, strict=True)
        )
        return RidingFixtures(world.plan, before, after, (), swept)


@dataclass(frozen=True, eq=False)
class RidingFixtures(PlanFixtures):
    """The items on a belt, each swept along it.

    Attributes:
        swept: The items of every segment.
    """

    swept: tuple[tuple[Fixture, ...], ...] = ()

    def of(self, k: int) -> tuple[Fixture, ...]:
        """Return the items of a segment, without the one that is held or gone.

        Args:
            k: Index of the segment.

        Returns:
            The fixtures.
        """
        here = {fixture.name for fixture in super().of(k)}
        return tuple(fixture for fixture in self.swept[k] if fixture.name in here)


def _swept(fixture: Fixture, along: Array, low: float, high: float) -> Fixture:
    """Return the hull of the box around a fixture, displaced along a direction from low to high, m."""
    at = fixture.T_world_shape
    corners = at[:3, 3] + (_CORNERS * fixture.shape.extents / 2) @ at[:3, :3].T
    body = hull(fixture.name, np.vstack([corners + low * along, corners + high * along]))
    solid = Solid(body.shape)
    solid.place(body.T_parent_shape)
    return replace(fixture, T_world_shape=body.T_parent_shape, shape=body.shape, solid=solid)


def _sliced(segments: Sequence[Segment], t_left: float) -> tuple[Segment, ...]:
    """Cut the transfers after the tool has left the belt, the more finely the shorter that is ago."""
    found: list[Segment] = []
    for segment in segments:
        t, t_end = segment.t_start, segment.t_end
        while segment.kind is SegmentKind.TRANSFER and (
            t + (lasts := SLICE + SLICE_GROWTH * max(0.0, t - t_left)) < t_end - TIME_TOLERANCE
        ):
            found.append(replace(segment, t_start=t, t_end=t + lasts))
            t += lasts
        found.append(replace(segment, t_start=t))
    return tuple(found)


def check_tracking(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check the conveyor of a plan, and that the item is taken from it within its window.

    Args:
        plan: A plan with a conveyor, without a fault in its structure.
        scene: The scene at its start.

    Yields:
        The faults.
    """
    assert plan.tracking is not None
    tracking, where = plan.tracking, "tracking"
    carrier = scene.cell.carriers.get(tracking.conveyor)
    if carrier is None or carrier.conveyor is None:
        yield Reason("unknown conveyor", where, f"the cell has no conveyor {tracking.conveyor!r}")
        return
    most = carrier.conveyor.max_speed
    if not 0.0 < tracking.speed <= most + SPEED_TOLERANCE or not 0.0 <= tracking.speed_error <= most:
        stated = f"{tracking.speed:g} m/s, within {tracking.speed_error:g}"
        yield Reason("belt speed", where, f"{stated}; the conveyor runs at up to {most:g} m/s")
        return
    kinds = [segment.kind for segment in plan.segments]
    if plan.recovery is not None or plan.grasp is None or kinds.count(SegmentKind.CONTACT) != 1:
        yield Reason("nothing taken from the belt", where, "a plan with a conveyor takes one item from it")
        return
    if SegmentKind.TRANSFER not in kinds[kinds.index(SegmentKind.CONTACT) :]:
        yield Reason("does not leave the belt", where, "no transfer follows the contact")
        return
    if scene.find(plan.grasp.item).location not in carrier.places:
        yield Reason("not on the belt", where, f"{plan.grasp.item} is not on {tracking.conveyor}")
        return
    known = carrier.conveyor.upstream
    end, most_speed = plan.trajectory.duration, carrier.conveyor.max_speed
    ahead = tracking.off_by(np.array([end]), times_at_work(plan.segments), most_speed)[1]
    if (way := tracking.speed * end + float(ahead[0])) > known + LENGTH_TOLERANCE:
        brought = f"the belt brings what was {way:.2f} m before its infeed, {known:.2f} m of that are known"
        yield Reason("lasts too long", where, brought)
    first, last = _times_in_window(plan, scene)
    t_left = times_at_work(plan.segments)[1]
    if not first - TIME_TOLERANCE <= _contact(plan).t_end or not t_left <= last + TIME_TOLERANCE:
        within = f"taken from {_contact(plan).t_end:.3f} to {t_left:.3f} s"
        yield Reason(
            "out of the window", where, f"{within}, the item is in it from {first:.3f} to {last:.3f} s"
        )


def _contact(plan: Plan) -> Segment:
    return next(segment for segment in plan.segments if segment.kind is SegmentKind.CONTACT)


def _times_in_window(plan: Plan, scene: Scene) -> tuple[float, float]:
    """S at which the item that is taken enters and leaves the window of its conveyor."""
    assert plan.tracking is not None and plan.grasp is not None
    carrier = scene.cell.carriers[plan.tracking.conveyor]
    assert carrier.conveyor is not None
    T = scene.pose_of(carrier).T_world_carrier
    travel = float((scene.find(plan.grasp.item).T_world_item[:3, 3] - T[:3, 3]) @ T[:3, 0])
    first, last = carrier.conveyor.window
    return (first - travel) / plan.tracking.speed, (last - travel) / plan.tracking.speed


def _travelling(robot: Robot, along: Array, name: str) -> Robot:
    """Return the robot on a linear joint along a direction (3,) of the world."""
    ground, root = f"{name} at the contact", robot.links[0].name
    axis = robot.T_world_base[:3, :3].T @ along
    joint = Joint(
        f"travel of {name}", JointType.PRISMATIC, ground, root, np.eye(4), axis, lower=-100.0, upper=100.0
    )
    limits = robot.limits
    rows = (limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk)
    return replace(
        robot,
        links=(Link(ground, (), 0.0, np.eye(4)), *robot.links),
        joints=(joint, *robot.joints),
        joint_names=(joint.name, *robot.joint_names),
        limits=Limits(
            *(np.insert(row, 0, end) for row, end in zip(rows, (-100.0, 100.0, *3 * [np.inf]), strict=True))
        ),
    )


def _with_travel(plan: Plan, robot: Robot, positions: Array, velocities: Array) -> Plan:
    """Return the plan for a robot that also travels, by (N,) m at (N,) m/s at the points."""
    at = plan.trajectory
    columns = (
        (positions, at.positions),
        (velocities, at.velocities),
        (np.zeros(len(at.times)), at.accelerations),
    )
    rows = (np.column_stack(pair) for pair in columns)
    return replace(plan, trajectory=Trajectory(robot.joint_names, at.times, *rows))
