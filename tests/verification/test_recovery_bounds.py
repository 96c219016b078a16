"""Ways out of a stop, by the rail alone: how far, how fast and how near is told by where the rail is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import pose
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import Scene
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.forward_kinematics import link_poses
from pickcli.verification.moving_parts import Fixture, fixtures, parts
from pickcli.verification.recovery_check import (
    SLOW_SHARE,
    Opening,
    _followed,
    _near_at_start,
    check_recovery,
    needed_clearance,
)
from pickcli.verification.state_sampling import sample_states
from support.handmade_plans import CRAYOLA, cell, make_scene, tip
from support.rail_motions import HOME, rail, states_of

ALONG = tip(HOME + np.eye(len(HOME))[0])[:3, 3] - tip(HOME)[:3, 3]  # where the rail takes the tool
SLOW_LEVELS = (RecoveryLevel.SLOWLY, RecoveryLevel.JOG)
NEAR = Opening((frozenset({("cup", "box")}),))
FREE = Opening()


def told(
    plan: Plan,
    scene: Scene,
    velocity: float = 0.05,
    opening: Opening = NEAR,
    stopped: Trajectory | None = None,
) -> list[str]:
    return [r.what for r in check_recovery(plan, scene, states_of(plan), velocity, opening, stopped)]


def pod_at(depth: float) -> Scene:
    """A scene whose pod begins so many m behind the tool, as the rail goes: that goes straight in."""
    x = ALONG / np.linalg.norm(ALONG)
    y = np.cross([0.0, 0.0, 1.0], x)
    R = np.column_stack([x, y / np.linalg.norm(y), np.cross(x, y / np.linalg.norm(y))])
    return replace(make_scene(), T_world_pod=pose(tip(HOME)[:3, 3] - depth * x, R=R))


def test_only_a_slow_way_out_may_come_as_near_as_poses_may_be_off() -> None:
    for level in (None, *RecoveryLevel):
        kept = needed_clearance(rail(0.1, level=level), make_scene())
        assert kept == (0.0 if level in SLOW_LEVELS else cell().clearance)


def test_what_is_no_recovery_claims_nothing() -> None:
    assert told(rail(3.0), pod_at(0.0), velocity=1.0, opening=FREE) == []
    assert told(rail(3.0, level=RecoveryLevel.AS_PLANNED), pod_at(0.0), velocity=1.0, opening=FREE) == []


@pytest.mark.parametrize("level", list(RecoveryLevel))
def test_a_way_out_takes_nothing_and_a_slow_one_holds_nothing_and_is_slow(level: RecoveryLevel) -> None:
    outside, way = pod_at(-1.0), rail(-0.02, level=level)
    assert told(way, outside) == []
    event = Event("valve", "off", Anchor(AnchorKind.TIME, 0, 0.0), 0.05, 0.5, 0.45)
    contact = rail(-0.02, level=level, kind=SegmentKind.CONTACT)
    assert told(replace(way, events=(event,)), outside) == told(contact, outside) == ["not a way out"]
    carried = replace(way, segments=(replace(way.segments[0], held=CRAYOLA),))
    is_slow = level in SLOW_LEVELS
    twice = rail(-0.01, -0.01, level=level)
    for k in (0, 1):  # one segment of two is enough
        ends = [*twice.segments]
        ends[k] = replace(ends[k], kind=SegmentKind.CONTACT)
        assert told(replace(twice, segments=tuple(ends)), outside) == ["not a way out"]
        ends[k] = replace(twice.segments[k], held=CRAYOLA)
        assert told(replace(twice, segments=tuple(ends)), outside) == ["not a way out"] * is_slow
    assert told(carried, outside) == ["not a way out"] * is_slow
    for velocity, is_refused in (
        (SLOW_SHARE, False),
        (SLOW_SHARE * (1 + 0.9e-6), False),
        (SLOW_SHARE * (1 + 1.1e-6), is_slow),
    ):
        assert told(way, outside, velocity) == ["not slow"] * is_refused


@pytest.mark.parametrize(
    ("ways", "is_long"),
    [((-0.0299,), False), ((-0.0301,), True), ((-0.015, 0.0149), False), ((-0.015, 0.0151), True)],
)
def test_a_jog_is_as_long_as_all_of_its_way(ways: tuple[float, ...], is_long: bool) -> None:
    for level in RecoveryLevel:
        is_refused = is_long and level is RecoveryLevel.JOG
        assert told(rail(*ways, level=level), pod_at(-1.0)) == ["not a jog"] * is_refused


@pytest.mark.parametrize(("way", "is_long"), [(0.0299, False), (0.0301, True)])
def test_a_jog_is_as_long_as_the_way_of_the_tool_where_no_link_goes_as_far(way: float, is_long: bool) -> None:
    """A joint of the wrist turns the tool aside by an arc of so many m."""
    plan, joint = rail(0.1, level=RecoveryLevel.JOG), len(HOME) - 2
    radius = (
        float(np.linalg.norm(tip(HOME + 1e-4 * np.eye(len(HOME))[joint])[:3, 3] - tip(HOME)[:3, 3])) * 1e4
    )
    p = np.tile(HOME, (2, 1))
    p[1, joint] += way / radius
    turned = replace(plan, trajectory=replace(plan.trajectory, positions=p))
    assert told(turned, pod_at(-1.0)) == ["not a jog"] * is_long


@pytest.mark.parametrize("level", [RecoveryLevel.OPENING, RecoveryLevel.SLOWLY, RecoveryLevel.BACKWARDS])
@pytest.mark.parametrize(
    ("depth", "ways", "is_refused"),
    [
        (0.1, (0.0149,), False), (0.1, (0.0151,), True), (0.1, (-0.2,), False),
        (0.1, (-0.05, 0.0149), False), (0.1, (-0.05, 0.0151), True), (0.1, (-0.05, 0.01, -0.05, 0.01), False),
        (-0.05, (0.0649,), False), (-0.05, (0.0651,), True), (-0.5, (0.4,), False),
    ],
)  # fmt: skip
def test_a_way_out_leads_at_most_15_mm_deeper_than_it_has_been(
    level: RecoveryLevel, depth: float, ways: tuple[float, ...], is_refused: bool
) -> None:
    assert told(rail(*ways, level=level), pod_at(depth)) == ["leads into the pod"] * is_refused


@pytest.mark.parametrize("level", [RecoveryLevel.OPENING, RecoveryLevel.SLOWLY, RecoveryLevel.BACKWARDS])
def test_a_way_that_leads_into_the_pod_is_told_with_how_deep_and_when_and_what_a_way_back_lacks(
    level: RecoveryLevel,
) -> None:
    """Out by 50 mm and in by 30 mm; it begins 100 mm inside."""
    plan = rail(-0.05, 0.03, -0.01, level=level)
    (reason,) = check_recovery(plan, pod_at(0.1), states_of(plan), 0.05, NEAR, None)
    assert "again, 30 mm at 2.000 s; at most 15 mm" in reason.detail
    assert ("apc verify --stopped" in reason.detail) is (level is RecoveryLevel.BACKWARDS)


def test_a_slow_way_out_begins_in_the_pod_or_near_to_something() -> None:
    for level in (RecoveryLevel.OPENING, RecoveryLevel.BACKWARDS, *SLOW_LEVELS):
        for depth in (-1.0, -1e-6, 1e-6):
            problem = ["not a way out"] * (level in SLOW_LEVELS and depth < 0.0)
            assert told(rail(-0.01, level=level), pod_at(depth), opening=FREE) == problem
            assert told(rail(-0.01, level=level), pod_at(depth), opening=NEAR) == []


def test_a_way_back_is_held_against_the_motion_that_stopped_where_that_is_known() -> None:
    back, there = rail(0.2, level=RecoveryLevel.BACKWARDS), rail(0.2, -0.2).trajectory
    assert told(back, pod_at(0.1)) == ["leads into the pod"]
    assert told(back, pod_at(0.1), stopped=there) == []
    assert told(back, pod_at(0.1), stopped=rail(0.1, -0.1).trajectory) == ["not back the way it came"]
    assert told(rail(0.2, level=RecoveryLevel.OPENING), pod_at(0.1), stopped=there) == ["leads into the pod"]
    first = check_recovery(back, pod_at(0.1), states_of(back), 0.05, NEAR, rail(0.1, -0.1).trajectory)[0]
    assert "rad or m off the motion that stopped" in first.detail


# What is near, and comes near again

RADIUS = 0.02


def ball_beside_the_cup(apart: float) -> tuple[Scene, Fixture]:
    """A ball that the rail drives the cup straight at, so many m away (overlapping, if negative)."""
    scene = make_scene()
    cup = next(p for p in parts(scene, rail(0.0).segments[0], None) if p.is_cup)
    T = link_poses(cell().robot, HOME[None])[cup.link, 0] @ cup.T_link_shape
    way = ALONG / np.linalg.norm(ALONG)
    cup.solid.place(T)
    solid = Solid(Shape(ShapeKind.SPHERE, (RADIUS,)))
    solid.place(pose(T[:3, 3] + way))
    far = cup.solid.distance(solid)  # from 1 m away it is nearer by what lies in between
    T_ball = pose(T[:3, 3] + way * (1.0 - far + apart))
    solid.place(T_ball)
    return scene, Fixture("ball", T_ball, Shape(ShapeKind.SPHERE, (RADIUS,)), solid)


CLEAR = 0.003  # m


@pytest.mark.parametrize(
    ("apart", "ways", "closes"),
    [
        (0.002, (-0.05,), False), (0.002, (0.0009,), False), (0.002, (0.0012,), True),
        (0.0005, (-0.0015, 0.0009), False), (0.0005, (-0.0015, 0.0012), True),
        (0.0005, (-0.02, 0.0184), False), (0.0005, (-0.02, 0.0188), True),
        (-0.004, (-0.003, 0.0008), False), (-0.004, (-0.003, 0.0012), True), (-0.004, (0.0012,), True),
        (0.0005, (-0.03, 0.01, -0.01, 0.01), False),
    ],
)  # fmt: skip
def test_what_was_near_may_come_nearer_by_a_millimetre_than_it_has_been(
    apart: float, ways: tuple[float, ...], closes: bool
) -> None:
    """What it has been counts up to the clearance; the ball is straight ahead."""
    scene, ball = ball_beside_the_cup(apart)
    plan = rail(*ways)
    states, cups = states_of(plan), [p for p in parts(scene, plan.segments[0], None) if p.is_cup]
    nearest = {(cups[0].name, "ball"): -np.inf}
    found = _followed(states, cups, ball, range(len(states.times)), CLEAR, nearest)
    assert (found is not None) is closes
    assert found is None or found.what == "closes again"
    if not closes:
        most = max(apart - at for at in np.cumsum([0.0, *ways]))
        assert nearest[cups[0].name, "ball"] == pytest.approx(min(CLEAR, most), abs=1e-4)


@pytest.mark.parametrize("order", [1, -1])
def test_of_several_parts_the_one_that_reaches_farthest_says_when_they_may_be_near(order: int) -> None:
    """They go away, come nearer than they were and go away again; one of them would not have moved at all."""
    scene, ball = ball_beside_the_cup(0.0005)
    plan = rail(-0.02, 0.0188, -0.02)
    states, cup = states_of(plan), next(p for p in parts(scene, plan.segments[0], None) if p.is_cup)
    turned = [cup, replace(cup, reach=np.zeros_like(cup.reach))][::order]
    nearest = {(cup.name, "ball"): -np.inf}
    found = _followed(states, turned, ball, range(len(states.times)), CLEAR, nearest)
    assert found is not None and found.what == "closes again"
    apart = float(found.detail.split(" s, ")[1].split(" mm apart after 3.0")[0])
    assert 1.7 <= apart <= 2.0, "a millimetre nearer than it was, and the rail stops 0.3 mm farther on"


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize(("way", "closes"), [(0.0009, False), (0.0012, True)])
def test_of_several_parts_the_nearest_may_not_come_nearer(order: int, way: float, closes: bool) -> None:
    """One of two poses of a cup that moves is far from the ball."""
    scene, ball = ball_beside_the_cup(0.0005)
    plan = rail(way)
    states, cup = states_of(plan), next(p for p in parts(scene, plan.segments[0], None) if p.is_cup)
    both = [cup, replace(cup, T_link_shape=pose((0.0, 0.0, 0.5)) @ cup.T_link_shape)][::order]
    nearest = {(cup.name, "ball"): -np.inf}
    found = _followed(states, both, ball, range(len(states.times)), CLEAR, nearest)
    assert (found is not None) is closes


def test_a_ball_is_as_near_as_it_says_and_its_pose_may_be_off() -> None:
    for apart in (-0.002, 0.0005, 0.004):
        scene, ball = ball_beside_the_cup(apart)
        plan = rail(0.0)
        moving = [p for p in parts(scene, plan.segments[0], None) if p.is_cup]
        for slack, is_near in ((0.0, apart <= CLEAR), (0.002, True)):
            found = list(_near_at_start(states_of(plan), moving, [replace(ball, slack=slack)], CLEAR))
            assert bool(found) is is_near


@pytest.mark.parametrize(("slack", "is_near"), [(0.0, False), (0.056, False), (0.058, True), (0.1, True)])
def test_what_may_be_outside_of_a_part_counts_as_near_too(slack: float, is_near: bool) -> None:
    """A ball 60 mm ahead of a cup, of which 3 mm is near."""
    scene, ball = ball_beside_the_cup(0.06)
    plan = rail(0.0)
    moving = [replace(p, slack=slack) for p in parts(scene, plan.segments[0], None) if p.is_cup]
    assert bool(list(_near_at_start(states_of(plan), moving, [ball], CLEAR))) is is_near


@pytest.mark.parametrize("most", [0.003, 0.1])
def test_what_is_near_at_the_start_is_what_exact_distances_say(most: float) -> None:
    scene = make_scene()
    q = np.asarray(cell().configurations["bin_H"].q)
    still = np.zeros((2, len(q)))
    trajectory = Trajectory(cell().robot.joint_names, np.array([0.0, 1.0]), np.stack([q, q]), still, still)
    states = sample_states(cell().robot, trajectory, np.empty(0), np.zeros(len(q)))
    moving, world = parts(scene, rail(0.0).segments[0], None), fixtures(scene)
    expected = set()
    for part in moving:
        part.solid.place(states.links[part.link, 0] @ part.T_link_shape)
        near = [f.name for f in world if part.solid.distance(f.solid) - part.slack - f.slack <= most]
        expected |= {(part.name, name) for name in near}
    assert set(_near_at_start(states, moving, world, most)) == expected
