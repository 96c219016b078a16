"""Groups of symmetry of shapes, and differences of poses without them."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, pose, rotation_angle, rotation_axis_angle, rotation_rpy
from pickcli.perception.items.symmetry import (
    displacement_between,
    faced_as,
    symmetries,
    turn_between,
    unlikeness,
)

BRICK = Shape(ShapeKind.BOX, (0.2, 0.1, 0.05))
COLUMN = Shape(ShapeKind.BOX, (0.1, 0.1, 0.3))
CUBE = Shape(ShapeKind.BOX, (0.1, 0.1, 0.1))
CAN = Shape(ShapeKind.CYLINDER, (0.04, 0.12))
BALL = Shape(ShapeKind.SPHERE, (0.04,))


def contains(group: tuple[Array, ...], R: Array) -> bool:
    return any(np.allclose(R, other) for other in group)


@pytest.mark.parametrize(("shape", "n"), [(BRICK, 4), (COLUMN, 8), (CUBE, 24), (CAN, 2), (BALL, 1)])
def test_symmetries_are_a_group_that_keeps_the_shape(shape: Shape, n: int) -> None:
    group = symmetries(shape)
    assert len(group) == n
    for R in group:
        assert np.linalg.det(R) == pytest.approx(1.0)
        np.testing.assert_allclose(np.abs(R) @ shape.extents, shape.extents)
        assert contains(group, R.T)
        assert all(contains(group, R @ other) for other in group)


def test_sides_that_differ_little_count_as_equal() -> None:
    assert len(symmetries(Shape(ShapeKind.BOX, (0.101, 0.1, 0.3)))) == 8
    assert len(symmetries(Shape(ShapeKind.BOX, (0.104, 0.1, 0.3)))) == 4


def test_what_exchanged_sides_move_is_known() -> None:
    """The surface is off by no more than that, and by as much after one of the exchanges."""
    nearly = Shape(ShapeKind.BOX, (0.0985, 0.1, 0.3))
    T = pose((0.2, 0.1, 0.4), R=rotation_rpy(0.3, -1.0, 2.0))
    off = [displacement_between(nearly, T @ pose(np.zeros(3), R=S), T) for S in symmetries(nearly)]
    assert max(off) <= unlikeness(nearly) == pytest.approx(0.0015 / np.sqrt(2))
    corner = np.abs(nearly.extents - nearly.extents[[1, 0, 2]]) / 2
    assert unlikeness(nearly) == pytest.approx(np.linalg.norm(corner))
    assert [unlikeness(shape) for shape in (BRICK, COLUMN, CUBE, CAN, BALL)] == [0.0] * 5


@pytest.mark.parametrize("shape", [BRICK, COLUMN, CUBE, CAN, BALL])
def test_a_symmetry_is_no_turn_and_a_small_turn_is_itself(shape: Shape) -> None:
    R = rotation_rpy(0.3, -1.0, 2.0)
    small = 0.0 if shape is BALL else 0.05
    for S in symmetries(shape):
        assert turn_between(shape, R @ S, R) < 1e-6
        turned = R @ rotation_axis_angle((1.0, 0.0, 0.0), 0.05) @ S
        assert turn_between(shape, turned, R) == pytest.approx(small, abs=1e-6)


def test_a_can_may_turn_about_its_axis() -> None:
    R = rotation_rpy(0.3, -1.0, 2.0)
    assert turn_between(CAN, R @ rotation_axis_angle((0.0, 0.0, 1.0), 1.0), R) < 1e-6


def test_a_quarter_turn_of_a_brick_is_one() -> None:
    assert turn_between(BRICK, rotation_axis_angle((0.0, 0.0, 1.0), np.pi / 2), np.eye(3)) == pytest.approx(
        np.pi / 2
    )


@pytest.mark.parametrize("shape", [BRICK, COLUMN, CUBE, CAN, BALL])
def test_a_pose_is_faced_as_another_and_looks_as_it_did(shape: Shape) -> None:
    T_faced = pose((0.2, 0.1, 0.4), R=rotation_rpy(0.3, -1.0, 2.0))
    roll = 0.0 if shape not in (CAN, BALL) else 1.2
    about = rotation_axis_angle((0.0, 0.0, 1.0), roll) @ rotation_axis_angle((1.0, 0.0, 0.0), 0.02)
    for S in symmetries(shape):
        T = pose(T_faced[:3, 3], R=T_faced[:3, :3] @ about @ S)
        found = faced_as(shape, T, T_faced)
        assert rotation_angle(found[:3, :3].T @ T_faced[:3, :3]) < 0.03
        assert displacement_between(shape, found, T) < 1e-6
        assert np.linalg.det(found[:3, :3]) == pytest.approx(1.0)
