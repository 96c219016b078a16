"""Distances between solids, against those that the verifier measures with fcl and a search of its own."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, pose, rotation_rpy
from pickcli.scene.solid_distance import TOLERANCE, separation
from pickcli.scene.solid_overlap import PosedSolid
from pickcli.verification.fcl_solids import Solid

MEASURE_TOLERANCE = 1e-4  # m, of either search: both end within some 0.01 mm, few stop a little earlier

sizes = st.floats(0.002, 0.3)
boxes = st.tuples(sizes, sizes, sizes).map(lambda s: Shape(ShapeKind.BOX, s))
cylinders = st.tuples(sizes, sizes).map(lambda s: Shape(ShapeKind.CYLINDER, s))
balls = sizes.map(lambda r: Shape(ShapeKind.SPHERE, (r,)))
offsets, angles = st.floats(-0.4, 0.4), st.floats(-np.pi, np.pi)
places = st.builds(
    lambda p, rpy: pose(p, rpy=rpy), st.tuples(offsets, offsets, offsets), st.tuples(angles, angles, angles)
)
directions = st.builds(lambda rpy: rotation_rpy(*rpy)[0], st.tuples(angles, angles, angles))
solids = st.builds(PosedSolid, st.one_of(boxes, cylinders, balls), places)

UP = np.array([0.0, 0.0, 1.0])
CAN, CARTON = Shape(ShapeKind.CYLINDER, (0.04, 0.2)), Shape(ShapeKind.BOX, (0.1, 0.1, 0.1))

PIN = np.array([
    [2.220446049250313e-16, 0.0, 1.0, 0.35527618926517973], [0.0, 1.0, 0.0, 0.359645373169289],
    [-1.0, 0.0, 2.220446049250313e-16, -0.5427068227421141], [0.0, 0.0, 0.0, 1.0],
])  # fmt: skip
DISC = np.array([
    [-5.551115123125783e-17, -0.7071067811865472, 0.7071067811865477, 0.2225142295147809],
    [1.6653345369377348e-16, 0.7071067811865477, 0.7071067811865472, 0.7651958136592047],
    [-1.0, 1.6653345369377348e-16, 5.551115123125783e-17, 0.13911509963430602], [0.0, 0.0, 0.0, 1.0],
])  # fmt: skip


@given(solids, solids, directions)
@settings(max_examples=300, deadline=None)
@example(PosedSolid(CAN, pose()), PosedSolid(CAN, pose()), UP)
@example(PosedSolid(CAN, pose()), PosedSolid(CARTON, pose((0.15, 0.0, 0.0))), UP)
@example(PosedSolid(CAN, pose()), PosedSolid(CARTON, pose((0.15, 0.02, 0.16), rpy=(0.5, 0.3, 0.2))), UP)
def test_the_distance_is_that_of_the_verifier_whatever_direction_is_guessed(
    a: PosedSolid, b: PosedSolid, along: Array
) -> None:
    distance, across = separation(a, b, along)
    one, other = Solid(a.shape), Solid(b.shape)
    one.place(a.T)
    other.place(b.T)
    assert distance == pytest.approx(one.distance(other), abs=MEASURE_TOLERANCE)
    if distance > 0.0:  # the slab proves it
        assert (b.support(-across) - a.support(across)) @ across == pytest.approx(distance, abs=1e-9)


def test_corners_that_nearly_coincide_do_not_keep_it_from_an_end() -> None:
    """Least squares over all corners ever found do not converge for these two, a pin and a disc."""
    a = PosedSolid(Shape(ShapeKind.CYLINDER, (0.013754240993922551, 0.01991125567780891)), PIN)
    b = PosedSolid(Shape(ShapeKind.CYLINDER, (0.7851617304974539, 0.05746171105642393)), DISC)
    one, other = Solid(a.shape), Solid(b.shape)
    one.place(a.T)
    other.place(b.T)
    distance, across = separation(a, b, UP)
    assert distance == pytest.approx(0.147387, abs=1e-5)
    assert distance == pytest.approx(one.distance(other), abs=MEASURE_TOLERANCE)
    assert (b.support(-across) - a.support(across)) @ across == pytest.approx(distance, abs=1e-9)


def test_the_distance_of_a_corner_from_a_rim() -> None:
    a = PosedSolid(CAN, pose())
    b = PosedSolid(CARTON, pose((0.04 + 0.05 + 0.03, 0.0, 0.1 + 0.05 + 0.04)))
    distance, across = separation(a, b, UP)
    assert distance == pytest.approx(0.05, abs=TOLERANCE)
    assert across == pytest.approx([0.6, 0.0, 0.8], abs=2e-2)
