"""The load on the cup against bodies made of point masses, and each figure just within and just beyond."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from pickcli.verification.load_check import (
    SAME_LEAST,
    SAME_SHARE,
    SAMPLE_TIME,
    SIDE_HOLD_SLOPE,
    _stated,
    _taken_up,
    check_load,
    held_wrenches,
    wrenches,
)
from support.handmade_plans import CRAYOLA, cell, make_scene, tip
from support.tool_states import STRAIGHT

BRICK = replace(
    cell().item(CRAYOLA), shape=Shape(ShapeKind.BOX, (0.2, 0.12, 0.05)), mass=0.7, mass_error=0.25
)
UP = 9.81
HANGING = pose((0.03, -0.02, 0.06), rpy=(0.4, 0.2, -0.7))


def swinging(t: float) -> Array:
    """A tool that goes and turns about all axes at once."""
    turn = np.array([0.3 * np.sin(3 * t), 0.5 * np.cos(2 * t), 0.4 * t + 0.2 * t**2])
    angle = float(np.linalg.norm(turn))
    R = rotation_axis_angle(turn / angle, angle)
    return pose((0.3 * np.sin(2 * t), 0.2 * t**2, 0.1 * np.cos(3 * t)), R=R)


@pytest.mark.parametrize("t", [0.1, 0.7, 1.9])
def test_the_wrench_is_the_sum_over_the_points_of_the_item(t: float) -> None:
    """Eight points at 1 / sqrt(3) of the half extents have the mass and the inertia of a uniform box."""
    half = np.array(BRICK.shape.size) / 2
    points = np.array([np.array(signs) * half / np.sqrt(3) for signs in product((-1, 1), repeat=3)])
    local = points @ HANGING[:3, :3].T + HANGING[:3, 3]  # in the tool frame

    def at(time: float) -> Array:
        T = swinging(time)
        return np.asarray(local @ T[:3, :3].T + T[:3, 3])

    h, T = 1e-3, swinging(t)
    forces = 0.7 * 1.25 / 8 * ((at(t + h) - 2 * at(t) + at(t - h)) / h**2 + [0.0, 0.0, UP])
    torque = np.cross(at(t) - T[:3, 3], forces).sum(axis=0)
    expected = np.concatenate([forces.sum(axis=0) @ T[:3, :3], torque @ T[:3, :3]])
    found = wrenches(np.array([swinging(t + k * h) for k in (-1, 0, 1)]), HANGING, BRICK, h)
    np.testing.assert_allclose(found, [expected], rtol=1e-4, atol=1e-5)


NAMES = ("pull", "shear", "moment", "twist")
WRENCHES = np.array([[3.0, 4.0, -20.0, 0.3, 0.4, -0.8], [1.0, 1.0, 30.0, 0.1, 0.1, 0.2]])
LOAD = {"pull": 20.0, "shear": 5.0, "moment": 0.5, "twist": 0.8, "load_ratio": 0.6}


def grasp(**load: float) -> Grasp:
    figures = [{**LOAD, **load}[name] for name in ("moment", "pull", "shear", "twist", "load_ratio")]
    return Grasp(CRAYOLA, "top-down", "+z", STRAIGHT, np.eye(4), 0.1, *figures)


def test_what_is_stated_of_a_load_is_its_worst() -> None:
    assert list(_stated(grasp(), WRENCHES, 0.6)) == []
    pushed = WRENCHES * [1.0, 1.0, -1.0, 1.0, 1.0, 1.0]
    assert list(_stated(grasp(pull=30.0), pushed, 0.6)) == []
    assert list(_stated(grasp(pull=0.0), pushed[:1], 0.6)) == []


@pytest.mark.parametrize("name", LOAD)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_load_is_as_stated_within_a_hundredth(name: str, sign: float) -> None:
    """Or within a hundredth of its unit, whichever is more."""
    most = max(SAME_LEAST, SAME_SHARE * LOAD[name])
    for off, is_refused in ((0.99 * most, False), (1.01 * most, True)):
        told = [r.where for r in _stated(grasp(**{name: LOAD[name] + sign * off}), WRENCHES, 0.6)]
        assert told == [f"grasp.{name}"] * is_refused


def test_a_load_may_be_off_by_the_very_hundredth() -> None:
    assert list(_stated(grasp(pull=0.0), np.array([[3.0, 4.0, -SAME_LEAST, 0.3, 0.4, 0.8]]), 0.6)) == []


# A lift by the rail, sideways

HOME = np.asarray(cell().configurations["home"].q)


def lifted(
    *moves: tuple[float, float, float], before: SegmentKind | None = SegmentKind.CONTACT, q: Array = HOME
) -> Plan:
    """A second before the lift and one of it; the rail is at (s, m, m/s) and rests before."""
    times = np.array([0.0, 1.0, *(t for t, _, _ in moves)])
    p, v = np.tile(q, (len(times), 1)), np.zeros((len(times), len(q)))
    p[:, 0] += [0.0, 0.0, *(at for _, at, _ in moves)]
    v[:, 0] = [0.0, 0.0, *(speed for _, _, speed in moves)]
    segments = [Segment(SegmentKind.LIFT, 1.0, float(times[-1]), STRAIGHT, CRAYOLA)]
    if before is not None:
        segments.insert(0, Segment(before, 0.0, 1.0, STRAIGHT, None))
    trajectory = Trajectory(cell().robot.joint_names, times, p, v, np.zeros_like(v))
    return Plan("pick", "", "", 0, tuple(segments), trajectory, (), grasp())


def holding(mass: float) -> Scene:
    item = replace(cell().item(CRAYOLA), mass=mass, mass_error=0.0)
    return make_scene(PlacedItem(CRAYOLA, item, TOTE, np.eye(4)))


SLOW = cell().robot.tool.cup.take_up_speed  # m/s
TAKE_UP = cell().robot.tool.cup.take_up  # m
BESIDE = inverse(tip(HOME))[:3, :3] @ [0.1, 0.0, 0.0]  # m, in the tool frame: where the weight turns the item


def at_speed(speed: float, way: float, then: float) -> Plan:
    """The rail goes at a speed over a way, having been brought to it at once, and at another after that."""
    start, over = 1e-5, way / speed
    return lifted(
        (1.0 + 2 * start / speed, start, speed),
        (1.0 + 2 * start / speed + over, start + way, speed),
        (1.0 + 2 * start / speed + over + 0.05, start + way + 0.025 * (speed + then), then),
        (4.0, start + way + 0.5, 0.0),
    )


@pytest.mark.parametrize(
    ("speed", "way", "is_refused"),
    [
        (0.98 * SLOW, 1.2 * TAKE_UP, False),
        (1.02 * SLOW, 1.2 * TAKE_UP, True),
        (0.98 * SLOW, 0.8 * TAKE_UP, True),
    ],
)
def test_a_weight_on_a_lever_is_taken_up_slowly_over_a_stated_way(
    speed: float, way: float, is_refused: bool
) -> None:
    hanging = pose(BESIDE)
    found = list(_taken_up(at_speed(speed, way, 0.2), holding(1.6), hanging, 1.0))
    assert [r.what for r in found] == ["weight taken up too fast"] * is_refused


def test_only_what_a_contact_took_and_what_its_weight_turns_is_taken_up_slowly() -> None:
    fast, heavy, beside = lifted((1.5, 0.3, 0.0), (2.0, 0.3, 0.0)), holding(1.6), pose(BESIDE)
    assert [r.what for r in _taken_up(fast, heavy, beside, 1.0)] == ["weight taken up too fast"]
    assert list(_taken_up(lifted((1.5, 0.3, 0.0), before=None), heavy, beside, 1.0)) == []
    assert list(_taken_up(lifted((1.5, 0.3, 0.0), before=SegmentKind.TRANSIT), heavy, beside, 1.0)) == []
    assert list(_taken_up(fast, heavy, np.eye(4), 1.0)) == []
    down = np.asarray(cell().configurations["drop_01"].q)
    hanging = pose(inverse(tip(down))[:3, :3] @ [0.1, 0.0, 0.0])
    from_above = lifted((1.5, 0.3, 0.0), (2.0, 0.3, 0.0), q=down)
    assert abs(tip(down)[2, 2]) > SIDE_HOLD_SLOPE > abs(tip(HOME)[2, 2])
    assert list(_taken_up(from_above, heavy, hanging, 1.0)) == []


def test_a_torque_counts_from_three_tenths_of_what_the_cup_bears_at_its_vacuum() -> None:
    """The weight of 1 kg at the length of a lever, across the cup's axis or about it."""
    fast, limits = lifted((1.5, 0.3, 0.0), (2.0, 0.3, 0.0)), cell().robot.tool.cup.limits
    R = tip(HOME)[:3, :3]
    for lever in np.eye(3):
        torque = np.cross(lever, R.T @ [0.0, 0.0, UP])
        share = max(np.hypot(*torque[:2]) / limits.max_moment, abs(torque[2]) / limits.max_twist)
        if share < 1e-3:
            continue
        for vacuum in (1.0, 0.5):
            for ratio, is_refused in ((0.299, False), (0.301, True)):
                hanging = pose(lever * ratio * vacuum / share)
                assert bool(list(_taken_up(fast, holding(1.0), hanging, vacuum))) is is_refused


def test_an_item_is_weighed_at_every_millisecond_that_it_is_held() -> None:
    plan = lifted((1.5, 0.02, 0.0), (2.0, 0.02, 0.0))
    times, found = held_wrenches(plan, holding(1.0), pose((0.0, 0.0, 0.05)))
    np.testing.assert_allclose(np.diff(times), SAMPLE_TIME, atol=1e-12)
    assert times[0] == pytest.approx(1.0) and 2.0 <= times[-1] <= 2.0 + 1.5 * SAMPLE_TIME
    assert found.shape == (len(times), 6)
    resting = np.abs(times - 1.75) < 0.2
    np.testing.assert_allclose(np.linalg.norm(found[resting, :3], axis=1), UP, rtol=1e-6)
    no = replace(plan, segments=(replace(plan.segments[0], t_end=2.0),))
    times, found = held_wrenches(no, holding(1.0), np.eye(4))
    assert times.shape == (0,) and found.shape == (0, 6)


@pytest.mark.parametrize(("beyond", "is_refused"), [(0.99, False), (1.01, True)])
@pytest.mark.parametrize("vacuum", [1.0, 0.6])
def test_a_cup_bears_what_its_limits_say_at_its_vacuum_and_no_more(
    beyond: float, is_refused: bool, vacuum: float
) -> None:
    """An item that hangs still: by its shear and twist, or by its pull and moment."""
    limits, R = cell().robot.tool.cup.limits, tip(HOME)[:3, :3]
    plan = lifted((1.5, 0.0, 0.0), (2.0, 0.0, 0.0))
    for lever in np.vstack([np.zeros(3), 0.05 * np.eye(3)]):
        force = R.T @ [0.0, 0.0, UP]
        unit = np.concatenate([force, np.cross(lever, force)])[None]
        peel, slip = float(limits.peel(unit, vacuum)[0]), float(limits.slip(unit, vacuum)[0])
        scene = holding(beyond / max(peel, slip))
        found = [r for r in check_load(plan, scene, pose(lever), vacuum) if r.what == "does not hold"]
        assert bool(found) is is_refused
        what = "pull and moment" if peel > slip else "shear and twist"
        assert all(what in r.where for r in found)
    assert list(check_load(plan, holding(100.0), np.eye(4), 0.0)) == []
