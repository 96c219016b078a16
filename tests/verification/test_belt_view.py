"""Plans for a running conveyor that are wrong in one thing, and what the verifier says of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial import Delaunay

from pickcli.cell.shapes import box
from pickcli.cell.station import Obstacles
from pickcli.geometry import pose, rotation_axis_angle
from pickcli.motion.plan import LineTracking, Plan, times_at_work
from pickcli.motion.segment import SegmentKind
from pickcli.planning.belt_picks.belt_query import DEVIATION
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.timing.concatenation import delayed
from pickcli.verification.belt_view import _axis_range, _swept
from pickcli.verification.moving_parts import fixtures
from pickcli.verification.verify import verify
from support.belt_picks import BeltPick, belt_pick, context


def told(plan: Plan, scene: Scene) -> str:
    """What the verifier says of a plan that states the scene as its own."""
    verdict = verify(replace(plan, scene_hash=scene_hash(scene)), scene)
    assert verdict.certificate is None
    return "\n".join(map(str, verdict.reasons))


def tracking(**values: Any) -> Callable[[Plan], Plan]:
    def change(plan: Plan) -> Plan:
        assert plan.tracking is not None
        return replace(plan, tracking=replace(plan.tracking, **values))

    return change


def later(plan: Plan) -> Plan:
    """The plan, begun a tenth of a second later."""
    segments = tuple(
        replace(s, t_start=s.t_start + 0.1 if k else 0.0, t_end=s.t_end + 0.1)
        for k, s in enumerate(plan.segments)
    )
    events = tuple(
        replace(e, t_anchor=(e.t_anchor or 0.0) + 0.1, t_trigger=(e.t_trigger or 0.0) + 0.1)
        for e in plan.events
    )
    return replace(plan, trajectory=delayed(plan.trajectory, 0.1), segments=segments, events=events)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (tracking(speed=0.30), "misses the item"),
        (tracking(speed=0.34), "no time to seal"),
        (tracking(speed=0.6), "the conveyor runs at up to 0.5 m/s"),
        (tracking(speed=float("nan")), "belt speed"),
        (tracking(speed=0.0), "belt speed"),
        (tracking(speed_error=-0.1), "belt speed"),
        (tracking(conveyor="tote"), "the cell has no conveyor 'tote'"),
        (later, "misses the item"),
        (lambda plan: replace(plan, tracking=None), "misses the item"),
    ],
)  # fmt: skip
def test_another_belt_is_rejected(change: Callable[[Plan], Plan], reason: str) -> None:
    pick = belt_pick()
    assert reason in told(change(pick.plan), pick.scene)


def with_box(pick: BeltPick, x: float, y: float, name: str = "kleenex_tissue_box") -> Scene:
    """The scene with a box on the belt, by default a tall one, some m ahead of and beside the target."""
    assert pick.plan.grasp is not None
    target = pick.scene.find(pick.plan.grasp.item)
    item = pick.scene.cell.item(name)
    height = float(item.shape.extents[2])
    T = pose((target.T_world_item[0, 3] + x, target.T_world_item[1, 3] + y, 0.60 + height / 2))
    return replace(pick.scene, items=(*pick.scene.items, PlacedItem("box", item, "belt", T)))


LOW = "command_hooks"  # 46 mm, under the arm where it waits and over the top of the target


def test_what_rides_beside_the_item_is_met_where_it_is_then() -> None:
    """At its start the plan is far from the box, which the belt brings along."""
    pick = belt_pick()
    assert "box" in told(pick.plan, with_box(pick, 0.09, 0.0, LOW))


@pytest.mark.parametrize(("x", "name"), [(2.4, "kleenex_tissue_box"), (-0.4, LOW), (-1.0, LOW)])
def test_what_rides_far_ahead_or_low_enough_is_not(x: float, name: str) -> None:
    pick = belt_pick()
    far = with_box(pick, x, 0.0, name)
    verdict = verify(replace(pick.plan, scene_hash=scene_hash(far)), far)
    assert verdict.reasons == ()


@pytest.mark.parametrize("x", [0.6, -0.26, -1.0, -3.0])
def test_what_a_belt_may_bring_under_the_arm_where_it_waits_is_met(x: float) -> None:
    """At the speed of the plan it is far from the arm all the time."""
    pick = belt_pick()
    assert "box" in told(pick.plan, with_box(pick, x, 0.0))


def test_neighbours_that_a_belt_off_the_plan_brings_nearer_are_kept_away_from() -> None:
    """The box is far enough from the arm as long as the belt is as near to the plan as that states."""
    pick = belt_pick()
    scene = with_box(pick, -0.26, 0.0, LOW)
    here = replace(pick.plan, scene_hash=scene_hash(scene))
    assert verify(here, scene).reasons == ()
    assert "box" in told(tracking(deviation=0.2)(here), scene)


def test_the_hall_is_kept_away_from_wherever_a_way_off_the_belt_takes_the_arm() -> None:
    """The beam stands where the arm comes to only if it goes on with the belt longer than planned."""
    pick = belt_pick()
    _, t_left = times_at_work(pick.plan.segments)
    tip = context().arm.tip(pick.plan.trajectory.sample(t_left)[0], pick.plan.segments[0].tool_state)
    x, y, z = (tip[:3, 3] + [0.25, 0.0, 0.0]).tolist()
    beam = box("beam", (x - 0.03, y - 0.2, z - 0.03), (x + 0.03, y + 0.2, z + 0.03))
    cell = pick.scene.cell
    other = replace(pick.scene, cell=replace(cell, obstacles=Obstacles((*cell.obstacles.bodies, beam))))
    reasons = told(pick.plan, other).splitlines()
    assert any("beam" in each and "(approach)" in each for each in reasons)
    assert not any("beam" in each and "(transit)" in each for each in reasons)


def test_only_an_axis_along_the_belt_takes_the_arm_with_it() -> None:
    """On a belt that is askew to its rail an arm follows with all joints, and its way off is its path."""
    robot, limits = context().cell.robot, context().cell.robot.limits
    along = np.array([1.0, 0.0, 0.0])
    assert _axis_range(robot, along) == float(limits.upper[0] - limits.lower[0])
    for angle in (0.06, -0.2, 1.2):
        assert _axis_range(robot, rotation_axis_angle((0.0, 0.0, 1.0), angle)[:3, :3] @ along) == 0.0


def test_a_box_in_the_hall_where_the_arm_chases_is_met() -> None:
    """It stands beside the belt, where the item is taken, and would not ride away."""
    pick = belt_pick()
    contact = next(s for s in pick.plan.segments if s.kind is SegmentKind.CONTACT)
    assert pick.plan.grasp is not None
    x, y, z = (
        pick.scene.find(pick.plan.grasp.item).T_world_item[:3, 3] + [0.33 * contact.t_end, 0.0, 0.0]
    ).tolist()
    cell = pick.scene.cell
    beam = box("beam", (x - 0.03, y - 0.3, z + 0.15), (x + 0.03, y + 0.3, z + 0.2))
    other = replace(pick.scene, cell=replace(cell, obstacles=Obstacles((*cell.obstacles.bodies, beam))))
    assert "beam" in told(pick.plan, other)


def test_the_window_of_the_conveyor_is_kept() -> None:
    pick = belt_pick()
    carrier = pick.scene.cell.carriers["belt"]
    assert carrier.conveyor is not None
    short = replace(carrier, conveyor=replace(carrier.conveyor, window=(1.2, 1.6)))
    other = replace(pick.scene, cell=replace(pick.scene.cell, own_carriers=(short,)))
    assert "out of the window" in told(pick.plan, other)


def test_the_window_begins_where_the_tool_meets_the_item_and_not_where_it_is_sealed() -> None:
    pick = belt_pick()
    contact = next(s for s in pick.plan.segments if s.kind is SegmentKind.CONTACT)
    carrier, cell = pick.scene.cell.carriers["belt"], pick.scene.cell
    belt = carrier.conveyor
    assert belt is not None and pick.plan.grasp is not None
    rests = context().method.rests(cell.devices, context().settings.release_time).taking
    riding = pick.stream.find(pick.plan.grasp.item)
    met = pick.stream.travel_at(riding, pick.now + contact.t_end - rests)

    def starting_at(first: float) -> Scene:
        later = replace(carrier, conveyor=replace(belt, window=(first, belt.window[1])))
        return replace(pick.scene, cell=replace(cell, own_carriers=(later,)))

    assert "out of the window" in told(pick.plan, starting_at(met + 0.01))
    within = starting_at(met - 0.001)
    assert verify(replace(pick.plan, scene_hash=scene_hash(within)), within).reasons == ()


def test_a_tracked_plan_takes_one_item_from_the_belt() -> None:
    pick = belt_pick()
    cut = next(k for k, s in enumerate(pick.plan.segments) if s.kind is SegmentKind.CONTACT)
    keep = pick.plan.trajectory.times <= pick.plan.segments[0].t_end
    assert cut > 0
    t = pick.plan.trajectory
    first = replace(
        t, times=t.times[keep], positions=t.positions[keep], velocities=t.velocities[keep],
        accelerations=t.accelerations[keep],
    )  # fmt: skip
    only = replace(pick.plan, segments=pick.plan.segments[:1], trajectory=first, events=(), grasp=None)
    assert "takes one item from it" in told(replace(only, query="move from home"), pick.scene)


def test_the_file_keeps_the_conveyor() -> None:
    import json

    from pickcli.motion.plan_file import plan_to_dict
    from pickcli.motion.plan_schema import parse_plan

    plan = belt_pick().plan
    again, _ = parse_plan(json.dumps(plan_to_dict(plan)), "plan.json")
    stated = LineTracking("belt", 0.33, 0.0, DEVIATION, belt_pick().now)
    assert again.tracking == plan.tracking == stated
    assert np.array_equal(again.trajectory.positions, plan.trajectory.positions)


@pytest.mark.parametrize("upright", [False, True])
def test_a_bottle_that_rolled_along_is_swept_as_high_and_wide_as_it_is(upright: bool) -> None:
    """The box around it, turned with it, is 1.4 times as high: plans were rejected that keep clear of it."""
    pick = belt_pick()
    bottle = pick.scene.cell.item("up_glucose_bottle")
    rolled = rotation_axis_angle(np.array([0.0, 0.0, 1.0]), np.pi / 4)
    lying = rotation_axis_angle(np.array([0.2, 1.0, 0.0]) / np.hypot(0.2, 1.0), np.pi / 2)
    T = pose((-2.0, 0.6, 0.65), R=rolled if upright else lying @ rolled)
    scene = replace(pick.scene, items=(PlacedItem("bottle", bottle, "belt", T),))
    (fixture,) = (each for each in fixtures(scene) if each.name == "bottle")
    found = _swept(fixture, np.array([1.0, 0.0, 0.0]), -0.1, 0.3)
    corners = found.T_world_shape[:3, 3] + np.array(found.shape.vertices)
    half = bottle.shape.reach(T[:3, :3])
    low, high = T[:3, 3] - half - [0.1, 0.0, 0.0], T[:3, 3] + half + [0.3, 0.0, 0.0]
    assert (corners.min(axis=0) <= low + 1e-9).all() and (corners.max(axis=0) >= high - 1e-9).all()
    assert (corners.min(axis=0) > low - 2e-4).all() and (corners.max(axis=0) < high + 2e-4).all()
    around = np.linspace(0.0, 2.0 * np.pi, 97)
    radius, length = bottle.shape.size
    rim = radius * np.stack([np.cos(around), np.sin(around)], axis=1)
    ends = np.vstack([np.column_stack([rim, np.full(len(rim), z)]) for z in (-length / 2, length / 2)])
    points = T[:3, 3] + ends @ T[:3, :3].T
    inside = Delaunay(corners)
    for way in (-0.1, 0.1, 0.3):
        assert (inside.find_simplex(points + np.array([way, 0.0, 0.0]), tol=1e-6) >= 0).all()
