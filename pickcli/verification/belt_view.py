"""A plan that takes its item from a running conveyor, as seen from the hall and from the belt.

Seen from the belt, what rides on it stands still and the arm travels backwards: one more linear joint below
its base. While the tool works on the belt, what rides on it is judged there, as far off the plan as that
allows, and the hall wherever a way off the belt may have taken the arm along it. Before and after that, the
arm may have been stopped anywhere: what rides on the belt occupies all that it may come to. Lines, rests
and events are judged relative to what the tool works on: to the belt until the transfer begins, to the hall
from then on.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from pickcli.cell.robot import JointType, Robot
from pickcli.cell.shapes import ShapeKind, hull
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import Scene
from pickcli.verification.belt_frame import BeltFrame, farthest_brought, working_times
from pickcli.verification.contact_exemptions import releases
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.moving_parts import Fixture
from pickcli.verification.static_solids import PlanFixtures
from pickcli.verification.straightness_check import every_millisecond, tip_points

TIME_TOLERANCE = 1e-6  # s
SPEED_TOLERANCE = 1e-9  # m/s
RESTS_WITHIN = 1e-6  # m of where the tool takes an item from the belt, from which on it rests there
RESTS_SOONER = 0.01  # s that it is so near before it is at rest
LENGTH_TOLERANCE = 1e-6  # m
N_SIDES = 32  # of the prism around a cylinder
PARALLEL = 1e-5  # difference of the cosine from 1 up to which an axis may take the arm along the belt
_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


@dataclass(frozen=True, eq=False)
class BeltView:
    """A plan in three frames. Those of hall and belt coincide when the contact is made.

    Attributes:
        scene: The scene with the items where the belt has carried them at the contact.
        seen_scene: That scene with a robot that travels along the belt.
        seen: The plan as seen from the belt, for that robot.
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
        tracking, t_contact = plan.tracking, _contact(plan).t_end
        belt, carrier = BeltFrame.of(tracking, scene), scene.cell.carriers[tracking.conveyor]
        at_contact, robot = belt.scene_at(scene, t_contact), belt.seen_robot(scene.cell.robot, t_contact)
        t_left = working_times(plan.segments)[1]
        return cls(
            scene=at_contact,
            seen_scene=replace(at_contact, cell=replace(scene.cell, robot=robot)),
            seen=belt.seen_plan(plan, t_contact, plan.trajectory.duration),
            at_work=belt.seen_plan(plan, t_contact, t_left + TIME_TOLERANCE),
            riding=frozenset(placed.id for placed in scene.items if placed.location in carrier.places),
            along=belt.T_world_start[:3, 0],
        )

    def in_hall(self, world: PlanFixtures, item: str) -> PlanFixtures:
        """Return what stands in the hall, and what rides on the belt while the tool does not work on it.

        Args:
            world: All fixtures.
            item: Id of the item that is taken, which may stand somewhere else after its release.

        Returns:
            The fixtures. While the tool works on the belt those of the hall are swept against it, as far as
            the axis along the belt may take the arm; before and after that those on the belt along it.
        """
        tracking, contact = self.seen.tracking, _contact(self.seen)
        assert tracking is not None
        conveyor = self.scene.cell.carriers[tracking.conveyor].conveyor
        assert conveyor is not None
        t_works, t_left = working_times(self.seen.segments)
        since = tracking.speed * (t_left - contact.t_end) - tracking.deviation
        coming = self._swept(world, -tracking.speed * contact.t_end, conveyor.farthest)
        leaving = self._swept(world, since, since + conveyor.farthest)
        way = _axis_range(self.scene.cell.robot, self.along)
        hall = tuple(
            _swept(each, self.along, -way, way) for each in world.before if each.name not in self.riding
        )
        still = tuple(each for each in world.before if each.name not in self.riding)
        kinds = (
            (still + coming, hall, still + leaving)[_stage(s, t_works, t_left)] for s in world.plan.segments
        )
        after = world.set_down and tuple(
            each for each in world.set_down if each.name not in self.riding or each.name == item
        )
        return SweptFixtures(world.plan, world.before, after, (), tuple(kinds), leaving)

    def on_belt(self, world: PlanFixtures) -> PlanFixtures:
        """Return what rides on the belt while the tool works on it.

        Args:
            world: All fixtures of ``seen``.

        Returns:
            The items on the belt, swept over all that they may be off the plan; none in other segments.
        """
        assert self.seen.tracking is not None
        off, (t_works, t_left) = self.seen.tracking.deviation, working_times(self.seen.segments)
        riding = self._swept(world, -off, off)
        swept = (riding if _stage(s, t_works, t_left) == 1 else () for s in world.plan.segments)
        return SweptFixtures(world.plan, world.before, (), (), tuple(swept))

    def _swept(self, world: PlanFixtures, low: float, high: float) -> tuple[Fixture, ...]:
        """Return the items on the belt, swept along it from low to high, m."""
        return tuple(_swept(each, self.along, low, high) for each in world.before if each.name in self.riding)


def _stage(segment: Segment, t_works: float, t_left: float) -> int:
    """Say whether a segment is before the tool works on the belt, 0, while it does, 1, or after that, 2."""
    middle = (segment.t_start + segment.t_end) / 2
    return int(middle > t_works) + int(middle > t_left)


def _axis_range(robot: Robot, along: Array) -> float:
    """Length (m) over which axes along the belt may take the arm with it: on no other one does it leave."""
    limits, T, found = robot.limits, robot.T_world_base[:3, :3], 0.0
    for joint in robot.joints:
        T = T @ joint.T_parent_joint[:3, :3]
        if joint.type is JointType.PRISMATIC and joint.name in robot.joint_names:
            k, share = robot.joint_names.index(joint.name), abs(float(T @ joint.axis @ along))
            found += float(limits.upper[k] - limits.lower[k]) if share > 1.0 - PARALLEL else 0.0
    return found


@dataclass(frozen=True, eq=False)
class SweptFixtures(PlanFixtures):
    """Fixtures of which some fill more in one segment than in another.

    Attributes:
        swept: The fixtures of every segment.
        after: Those on the belt after the release of an item that is set down.
    """

    swept: tuple[tuple[Fixture, ...], ...] = ()
    after: tuple[Fixture, ...] = ()

    def of(self, k: int) -> tuple[Fixture, ...]:
        """Return the fixtures of a segment, without an item that is held or gone.

        Args:
            k: Index of the segment.

        Returns:
            The fixtures.
        """
        gone = {segment.held for segment in self.plan.segments[: k + 1]}
        if self.set_down and k > releases(self.plan)[0]:
            return self.set_down + tuple(each for each in self.after if each.name not in gone)
        return tuple(fixture for fixture in self.swept[k] if fixture.name not in gone)


def _swept(fixture: Fixture, along: Array, low: float, high: float) -> Fixture:
    """Return the hull of what is around a fixture, displaced along a direction from low to high, m."""
    corners = _around(fixture)
    body = hull(fixture.name, np.vstack([corners + low * along, corners + high * along]))
    solid = Solid(body.shape)
    solid.place(body.T_parent_shape)
    return replace(fixture, T_world_shape=body.T_parent_shape, shape=body.shape, solid=solid)


def _around(fixture: Fixture) -> Array:
    """Corners (V, 3) in the world of a polyhedron around a fixture: a cylinder's has as many sides as needed.

    The box around a bottle that lies on the belt, turned by 45 degrees about its axis, is 1.4 times as high
    as the bottle. Of the prism, one side is uppermost: it is just as high.
    """
    shape, at = fixture.shape, fixture.T_world_shape
    if shape.kind is not ShapeKind.CYLINDER:
        return np.asarray(at[:3, 3] + (_CORNERS * shape.extents / 2) @ at[:3, :3].T)
    radius, length = shape.size
    x, y = at[2, :2]  # of the world's vertical, across the axis
    middles = np.arctan2(y, x) + 2.0 * np.pi / N_SIDES * (np.arange(N_SIDES) + 0.5)
    rim = radius / np.cos(np.pi / N_SIDES) * np.stack([np.cos(middles), np.sin(middles)], axis=1)
    ends = [np.column_stack([rim, np.full(N_SIDES, end)]) for end in (-length / 2, length / 2)]
    return np.asarray(at[:3, 3] + np.vstack(ends) @ at[:3, :3].T)


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
    end, t_left = plan.trajectory.duration, working_times(plan.segments)[1]
    if (way := farthest_brought(tracking, t_left, end, most)) > known + LENGTH_TOLERANCE:
        brought = f"the belt brings what was {way:.2f} m before its infeed, {known:.2f} m of that are known"
        yield Reason("lasts too long", where, brought)
    first, last = _times_in_window(plan, scene)
    t_met = _meets_at(plan, scene)
    if not first - RESTS_SOONER <= t_met or not t_left <= last + TIME_TOLERANCE:
        within = f"taken from {t_met:.3f} to {t_left:.3f} s"
        yield Reason(
            "out of the window", where, f"{within}, the item is in it from {first:.3f} to {last:.3f} s"
        )


def _contact(plan: Plan) -> Segment:
    return next(segment for segment in plan.segments if segment.kind is SegmentKind.CONTACT)


def _meets_at(plan: Plan, scene: Scene) -> float:
    """Time (s) from which on the tool rests on the item, as seen from the belt."""
    assert plan.tracking is not None
    contact = _contact(plan)
    times = every_millisecond(contact.t_start, contact.t_end)
    carrier = scene.cell.carriers[plan.tracking.conveyor]
    travel = plan.tracking.speed * times[:, None] * scene.pose_of(carrier).T_world_carrier[:3, 0]
    seen = tip_points(plan, scene.cell.robot, contact.tool_state, times) - travel
    moves = np.flatnonzero(np.linalg.norm(seen - seen[-1], axis=1) > RESTS_WITHIN)
    return float(times[moves[-1] + 1] if len(moves) else times[0])


def _times_in_window(plan: Plan, scene: Scene) -> tuple[float, float]:
    """Time (s) at which the item that is taken enters and leaves the window of its conveyor."""
    assert plan.tracking is not None and plan.grasp is not None
    carrier = scene.cell.carriers[plan.tracking.conveyor]
    assert carrier.conveyor is not None
    T = scene.pose_of(carrier).T_world_carrier
    travel = float((scene.find(plan.grasp.item).T_world_item[:3, 3] - T[:3, 3]) @ T[:3, 0])
    first, last = carrier.conveyor.window
    return (first - travel) / plan.tracking.speed, (last - travel) / plan.tracking.speed
