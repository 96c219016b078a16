"""Pads found in the shapes of fingers: where both are flat and face each other, and as large as that is."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.shapes import Body, Shape, ShapeKind, box
from pickcli.geometry import pose
from pickcli.robot_setup.finger_pads import GRID_STEP, FingerPads, find_pads

SIDES = st.floats(0.006, 0.06)


def hull_of(body: Body) -> Body:
    """The box of a body as a hull of its corners."""
    half = np.array(body.shape.size) / 2
    corners = [tuple((half * signs).tolist()) for signs in itertools.product((-1, 1), repeat=3)]
    return replace(body, shape=Shape(ShapeKind.HULL, body.shape.size, tuple(corners)))


@given(SIDES, SIDES, st.floats(-0.02, 0.02), st.floats(-0.02, 0.02), st.floats(0.0, 0.05), st.booleans())
def test_the_face_of_two_boxes_is_found(
    x: float, z: float, x_middle: float, z_middle: float, gap: float, as_hulls: bool
) -> None:
    low, high = (x_middle - x / 2, z_middle - z / 2), (x_middle + x / 2, z_middle + z / 2)
    upper = box("upper", (low[0], gap / 2, low[1]), (high[0], gap / 2 + 0.01, high[1]))
    lower = box("lower", (low[0], -gap / 2 - 0.01, low[1]), (high[0], -gap / 2, high[1]))
    fingers = [hull_of(each) if as_hulls else each for each in (upper, lower)]
    pads = find_pads(fingers[:1], fingers[1:])
    assert pads is not None
    np.testing.assert_allclose(pads.middle, (x_middle, 0.0, z_middle), atol=GRID_STEP)
    assert pads.gap == pytest.approx(gap, abs=1e-9)
    for found, side in zip(pads.size, (x, z), strict=True):
        assert side - 3 * GRID_STEP <= found <= side


def test_a_pad_ends_where_a_finger_steps_back() -> None:
    tip = box("tip", (-0.01, 0.0, 0.03), (0.01, 0.01, 0.05))
    stem = box("stem", (-0.01, 0.004, 0.0), (0.01, 0.014, 0.05))
    below = box("below", (-0.01, -0.01, 0.0), (0.01, 0.0, 0.05))
    pads = find_pads([tip, stem], [below])
    assert pads is not None
    np.testing.assert_allclose(pads.middle, (0.0, 0.0, 0.04), atol=GRID_STEP)
    assert pads.size[1] == pytest.approx(0.02, abs=3 * GRID_STEP)


@given(st.floats(0.004, 0.1), st.floats(0.004, 0.1), st.floats(-0.02, 0.02))
def test_the_outer_end_of_long_pads_ends_where_they_end(along: float, most: float, middle: float) -> None:
    whole = FingerPads(np.array([0.001, 0.002, middle]), (0.01, along), 0.003)
    end = whole.ending(most)
    assert end.size == (0.01, min(along, most)) and end.gap == whole.gap
    assert end.middle[2] + end.size[1] / 2 == pytest.approx(middle + along / 2)
    np.testing.assert_array_equal(end.middle[:2], whole.middle[:2])


def test_a_tilted_face_and_balls_are_no_pads() -> None:
    ball = Body("ball", Shape(ShapeKind.SPHERE, (0.01,)), pose((0.0, 0.01, 0.0)))
    opposite = replace(ball, T_parent_shape=pose((0.0, -0.01, 0.0)))
    assert find_pads([ball], [opposite]) is None
    flat = box("flat", (-0.02, -0.01, -0.02), (0.02, 0.0, 0.02))
    tilted = Body("tilted", Shape(ShapeKind.BOX, (0.04, 0.01, 0.04)), pose((0, 0.02, 0), rpy=(0.3, 0, 0)))
    assert find_pads([tilted], [flat]) is None


def test_thin_shapes_carry_no_pad() -> None:
    flat = box("flat", (-0.02, -0.01, -0.02), (0.02, 0.0, 0.02))
    assert find_pads([box("sheet", (-0.02, 0.0, -0.02), (0.02, 0.001, 0.02))], [flat]) is None
    mantle = Body("rod", Shape(ShapeKind.CYLINDER, (0.01, 0.04)), pose((0, 0.01, 0), rpy=(np.pi / 2, 0, 0)))
    found = find_pads([mantle], [flat])  # its end faces the other finger
    assert found is not None and found.gap == pytest.approx(-0.01, abs=1e-9)
