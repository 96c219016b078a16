"""Errors of poses as they are compared with bounds."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle, rotation_rpy, transform_points
from pickcli.perception.items.pose_spread import pose_spread
from pickcli.perception.items.symmetry import displacement_between, error_of, symmetries
from pickcli.scene.scene import PoseNoise

BRICK = Shape(ShapeKind.BOX, (0.2, 0.1, 0.05))
COLUMN = Shape(ShapeKind.BOX, (0.1, 0.1005, 0.3))  # two of its sides are taken for each other
CAN = Shape(ShapeKind.CYLINDER, (0.04, 0.12))
BALL = Shape(ShapeKind.SPHERE, (0.04,))
SHAPES = st.sampled_from([BRICK, COLUMN, CAN, BALL])
TRUE = pose(np.array([0.4, -0.1, 0.9]), R=rotation_rpy(0.3, -1.0, 2.0))
COMPONENT = st.floats(-1.0, 1.0)
VECTORS = st.tuples(COMPONENT, COMPONENT, COMPONENT).map(np.array)


def moved(T: Array, shift: Array, turn: Array) -> Array:
    angle = float(np.linalg.norm(turn))
    R = rotation_axis_angle(turn / angle, 0.3 * angle) if angle > 1e-9 else np.eye(3)
    return pose(T[:3, 3] + 0.02 * shift, R=R @ T[:3, :3])


def surface(shape: Shape) -> Array:
    """Points of a surface: of a box its corners, of which all others are means."""
    if shape.kind is ShapeKind.BOX:
        return np.array(list(product((-0.5, 0.5), repeat=3))) * shape.extents
    turns = np.linspace(0.0, 2.0 * np.pi, 60)
    if shape.kind is ShapeKind.CYLINDER:
        rim = shape.extents[0] / 2 * np.column_stack([np.cos(turns), np.sin(turns)])
        return np.concatenate(
            [np.column_stack([rim, np.full(60, z)]) for z in shape.extents[2] * np.array([-0.5, 0.5])]
        )
    directions = np.array(list(product((-1.0, 0.0, 1.0), repeat=3)))
    directions = directions[np.any(directions != 0.0, axis=1)]
    radius = float(shape.extents[0]) / 2
    return np.asarray(radius * directions / np.linalg.norm(directions, axis=1)[:, None])


@given(SHAPES, VECTORS, VECTORS, st.integers(0, 7))
def test_a_shape_grown_by_its_displacement_holds_itself_elsewhere(
    shape: Shape, shift: Array, turn: Array, k: int
) -> None:
    S = symmetries(shape)[k % len(symmetries(shape))]
    T = moved(TRUE, shift, turn) @ pose(np.zeros(3), R=S)
    grown = shape.inflated(displacement_between(shape, T, TRUE) + 1e-6)
    assert grown.contains(transform_points(inverse(T) @ TRUE, surface(shape))).all()
    assert grown.contains(transform_points(inverse(TRUE) @ T, surface(shape))).all()


@given(SHAPES, VECTORS, VECTORS)
def test_no_point_is_off_by_more_than_position_and_angle_make_possible(
    shape: Shape, shift: Array, turn: Array
) -> None:
    error = error_of(shape, moved(TRUE, shift, turn), TRUE)
    assert error.displacement is not None
    unlike = 0.0005  # m, by which sides differ that are taken for each other
    most = error.position + error.angle * shape.bounding_radius
    assert error.position - 1e-9 <= error.displacement <= most + unlike


def test_a_pose_beside_the_truth_is_off_by_as_much() -> None:
    for shape in (BRICK, COLUMN, CAN, BALL):
        error = error_of(shape, moved(TRUE, np.array([0.1, 0.0, 0.0]), np.zeros(3)), TRUE)
        assert error.position == pytest.approx(0.002)
        assert error.displacement == pytest.approx(0.002)
        assert error.angle == pytest.approx(0.0, abs=1e-6)


def test_a_box_that_turns_about_one_of_its_edges_is_off_by_less_than_its_errors_apart() -> None:
    edge, turn = np.array([0.0, 0.05, 0.025]), rotation_axis_angle(np.array([1.0, 0.0, 0.0]), 0.05)
    T = pose(edge - turn @ edge, R=turn)
    error = error_of(BRICK, T, np.eye(4))
    assert error.displacement is not None
    across = 2.0 * np.hypot(0.05, 0.025)
    assert error.displacement == pytest.approx(0.05 * across, rel=0.01)
    assert error.displacement < 0.75 * float(
        PoseNoise(error.position, error.angle).at(np.array(BRICK.bounding_radius))
    )


@pytest.mark.parametrize("shape", [BRICK, CAN, BALL])
def test_the_spread_of_the_surface_is_that_of_its_corners(shape: Shape) -> None:
    """By what corners cost: their sum of squares in units of a millimetre."""
    corners = np.array(list(product((-0.5, 0.5), repeat=3))) * shape.extents
    at = transform_points(TRUE, corners)

    def costs(poses: Array) -> Array:
        off = np.array([transform_points(T, corners) - at for T in poses])
        return np.asarray((off**2).sum(axis=(1, 2)) / 2.0 / 0.001**2)

    spread = pose_spread(shape, TRUE, costs)
    assert spread.position == pytest.approx(0.001 / np.sqrt(8), rel=0.02)
    assert spread.surface >= spread.position
    assert spread.surface <= spread.position + spread.angle * shape.bounding_radius * 1.02
