"""Points of a cloud that a motion comes near to: none is missed, and few others are looked at."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind, hull
from pickcli.geometry import Array, pose
from pickcli.scene.cloud import Cloud
from pickcli.scene.scene import Scene
from pickcli.verification import cloud_points
from pickcli.verification.cloud_points import (
    DISTANCE_CAP,
    MAX_STATE_DISTANCE,
    _outside,
    _strided,
    near_points,
)
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.forward_kinematics import link_poses
from pickcli.verification.moving_parts import Part, parts
from support.handmade_plans import cell, make_scene
from support.rail_motions import HOME, rail, states_of

RADIUS, ERROR = 0.002, 0.001
BOX = Shape(ShapeKind.BOX, (0.2, 0.4, 0.6))
CAN = Shape(ShapeKind.CYLINDER, (0.1, 0.6))
BALL = Shape(ShapeKind.SPHERE, (0.3,))
WEDGE = hull("wedge", np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.4], [0.3, 0, 0.1]])).shape


@pytest.mark.parametrize(
    ("shape", "point", "far"),
    [
        (BOX, (0.05, -0.1, 0.2), 0.0), (BOX, (0.15, 0.0, 0.0), 0.05), (BOX, (-0.13, 0.24, 0.0), 0.05),
        (BOX, (0.0, 0.23, -0.34), 0.05), (BOX, (-0.13, -0.24, 0.42), 0.13),
        (CAN, (0.05, 0.05, -0.2), 0.0), (CAN, (0.09, -0.12, 0.0), 0.05), (CAN, (0.0, 0.0, -0.35), 0.05),
        (CAN, (0.13, 0.0, 0.34), 0.05), (CAN, (-0.12, 0.09, -0.42), 0.13),
        (BALL, (0.0, 0.24, 0.32), 0.1), (BALL, (0.24, 0.0, -0.32), 0.1), (BALL, (0.3, 0.0, 0.0), 0.0),
    ],
)  # fmt: skip
def test_a_point_is_as_far_outside_as_its_nearest_point(
    shape: Shape, point: tuple[float, float, float], far: float
) -> None:
    inside = np.zeros(3)
    found = _outside(shape, np.array([point, inside]))
    assert found[0] == pytest.approx(far, abs=1e-12) and found[1] <= 0.0


def test_of_a_hull_it_is_no_less_than_from_its_nearest_side() -> None:
    corners = np.array(WEDGE.vertices)
    assert _outside(WEDGE, corners) == pytest.approx(0.0, abs=1e-6)
    middle = corners.mean(axis=0)
    assert _outside(WEDGE, middle[None])[0] < -0.01
    for way in np.eye(3):  # of three of its sides
        at = (corners * -way).sum(axis=1).max() + 0.05
        assert _outside(WEDGE, (middle + (-at - middle @ way) * way)[None])[0] >= 0.05 - 1e-6


@pytest.mark.parametrize("way", [0.0, 0.003, 0.1, 0.1234])
@pytest.mark.parametrize("first", [0, 3])
def test_between_states_that_are_looked_at_nothing_moves_farther_than_a_stride(
    way: float, first: int
) -> None:
    """And no point is farther than half of that from where it is in one of them."""
    plan = rail(way)
    states = states_of(plan)
    moving = [p for p in parts(make_scene(), plan.segments[0], None) if p.is_cup]
    last = len(states.times) - 1
    if last <= first:
        return
    chosen, slack = _strided(states, first, last, tuple(moving))
    assert (chosen[0], chosen[-1]) == (first, last) and (np.diff(chosen) > 0).all()
    gone = states.travel[:, 0]
    assert slack == pytest.approx(np.diff(gone[chosen]).max() / 2)
    step = np.diff(gone).max()
    assert slack <= (MAX_STATE_DISTANCE + step) / 2
    assert len(chosen) <= 2 + np.ceil((gone[last] - gone[first]) / MAX_STATE_DISTANCE)


def cup() -> tuple[Part, Array]:
    """The cup, and the way of the rail from home."""
    scene, plan = make_scene(), rail(0.0)
    (part,) = [p for p in parts(scene, plan.segments[0], None) if p.is_cup][:1]
    here, there = link_poses(cell().robot, np.array([HOME, HOME + np.eye(len(HOME))[0]]))[part.link, :, :3, 3]
    return part, there - here


def cloud_of(*points: Array) -> Cloud:
    return Cloud(Path("cloud.npy"), np.eye(4), np.array(points), RADIUS, ERROR)


def found(cloud: Cloud, way: float, slack: float = 0.0, moves: bool = True) -> list[int]:
    """Indices of the points that are near to the cup while the rail goes that way."""
    scene: Scene = replace(make_scene(), cloud=cloud)
    plan = rail(way)
    part = replace(cup()[0], slack=slack)
    part = part if moves else replace(part, reach=np.zeros_like(part.reach))
    near = near_points(plan, scene, states_of(plan), [(part,)])
    assert near.proven == DISTANCE_CAP
    places = [fixture.T_world_shape[:3, 3] for fixture in near.fixtures]
    for fixture in near.fixtures:
        assert fixture.shape == Shape(ShapeKind.SPHERE, (RADIUS,)) and fixture.slack == ERROR
        x, y, z = fixture.T_world_shape[:3, 3]
        assert fixture.name == f"point of the cloud at ({x:.3f}, {y:.3f}, {z:.3f})"
        assert fixture.solid.distance(Solid(BALL)) == pytest.approx(
            max(0.0, float(np.linalg.norm((x, y, z))) - 0.3 - RADIUS), abs=1e-4
        )
    return [i for i, point in enumerate(cloud.points) if any(np.array_equal(point, p) for p in places)]


def ahead(far: float) -> Array:
    """A point straight ahead of the cup, so many m from its surface."""
    part, way = cup()
    T = link_poses(cell().robot, HOME[None])[part.link, 0] @ part.T_link_shape
    part.solid.place(T)
    ball = Solid(Shape(ShapeKind.SPHERE, (1e-6,)))
    ball.place(pose(T[:3, 3] + way))
    gap = part.solid.distance(ball) + 1e-6
    return np.asarray(T[:3, 3] + way * (1.0 + far - gap))


@pytest.mark.parametrize("slack", [0.0, 0.01])
def test_what_the_cup_never_comes_near_to_is_left_out(slack: float) -> None:
    """Near is 20 mm, the point's own radius, and what it and the part may be off: at rest, nothing more."""
    most = DISTANCE_CAP + RADIUS + ERROR + slack
    cloud = cloud_of(ahead(most - 1e-4), ahead(most + 1e-4), ahead(0.001), ahead(0.9))
    assert found(cloud, 0.0, slack) == [0, 2]
    assert found(cloud, 0.0, slack, moves=False) == []


@pytest.mark.parametrize("way", [0.02, 0.1])
def test_what_the_cup_comes_near_to_on_its_way_is_found(way: float) -> None:
    """On its way in, where it ends, and a little beyond that, by half of a stride at most."""
    most = way + DISTANCE_CAP + RADIUS + ERROR
    at = [0.001, way / 2, way, most - 1e-4, most + (MAX_STATE_DISTANCE + 0.002) / 2 + 1e-4, most + 0.5]
    assert found(cloud_of(*map(ahead, at)), way) == [0, 1, 2, 3]


@pytest.mark.parametrize("most", [0, 1, 7, 1000])
def test_however_few_are_looked_at_at_once_the_same_are_found(
    most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(3)
    cloud = cloud_of(*(ahead(0.05) + rng.uniform(-0.1, 0.1, (60, 3))))
    expected = found(cloud, 0.1)
    assert 0 < len(expected) < 60
    monkeypatch.setattr(cloud_points, "MOST_AT_ONCE", most)
    assert found(cloud, 0.1) == expected


def test_without_a_cloud_nothing_is_near() -> None:
    plan = rail(0.1)
    none = near_points(plan, make_scene(), states_of(plan), [(cup()[0],)])
    assert (none.fixtures, none.proven) == ((), np.inf)


def test_of_several_segments_each_is_looked_at_with_what_moves_in_it() -> None:
    """A point that only the second of two ways comes near to, and one at which the cup is not yet a part."""
    plan, part = rail(0.1, 0.1), cup()[0]
    scene = replace(make_scene(), cloud=cloud_of(ahead(0.01), ahead(0.2)))
    states = states_of(plan)
    both = near_points(plan, scene, states, [(part,), (part,)]).fixtures
    second = near_points(plan, scene, states, [(replace(part, reach=0.0 * part.reach),), (part,)]).fixtures
    first = near_points(plan, scene, states, [(part,), (replace(part, reach=0.0 * part.reach),)]).fixtures
    assert (len(both), len(first)) == (2, 1)
    assert [np.array_equal(f.T_world_shape[:3, 3], ahead(0.2)) for f in second] == [True]
