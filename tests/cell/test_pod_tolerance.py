"""The swept boxes hold every displaced copy of a body, and no more than their axes force them to."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import Displacement, displaced, pod_stand
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse, pose, transform_points
from support.cell_copies import CellCopy

BOUNDS = load_cell("apc2016_delft").pod.displacement
CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))

lengths = st.floats(0.001, 2.0)
places = st.tuples(*[st.floats(-2.0, 2.0)] * 3)
angles = st.tuples(*[st.floats(-np.pi, np.pi)] * 3)
shares = st.tuples(*[st.floats(-1.0, 1.0)] * 3)
bounds = st.builds(Displacement, *[st.floats(0.0, 0.5)] * 3)


def _inside(box: Body, T_parent_body: Array, extents: Array) -> Array:
    """(8, 3) m, how far each corner of a displaced body lies outside of a box along each of its axes."""
    corners = transform_points(inverse(box.T_parent_shape) @ T_parent_body, CORNERS * extents)
    return np.asarray(np.abs(corners) - box.shape.extents / 2)


@given(bounds, st.tuples(lengths, lengths, lengths), places, angles, shares)
def test_a_swept_box_holds_every_displaced_copy(
    allowed: Displacement,
    size: tuple[float, float, float],
    place: tuple[float, float, float],
    rpy: tuple[float, float, float],
    share: tuple[float, float, float],
) -> None:
    body = Body("part", Shape(ShapeKind.BOX, size), pose(place, rpy=rpy))
    T = displaced(np.eye(4), share[0] * allowed.x, share[1] * allowed.y, share[2] * allowed.yaw)
    assert allowed.allows(T)
    assert _inside(allowed.swept(body), T @ body.T_parent_shape, np.array(size)).max() < 1e-9


@pytest.mark.parametrize("body", load_cell("apc2016_delft").pod.bodies, ids=lambda body: body.name)
def test_each_face_of_a_swept_box_is_touched_by_some_displaced_copy(body: Body) -> None:
    swept, farthest = BOUNDS.swept(body), np.full(3, -np.inf)
    for x, y, yaw in product((-1.0, 1.0), (-1.0, 1.0), np.linspace(-1.0, 1.0, 201)):
        T = displaced(np.eye(4), x * BOUNDS.x, y * BOUNDS.y, yaw * BOUNDS.yaw)
        farthest = np.maximum(
            farthest, _inside(swept, T @ body.T_parent_shape, body.shape.extents).max(axis=0)
        )
    assert np.all(farthest <= 1e-9) and np.all(farthest > -2e-5)


def test_a_body_that_cannot_move_is_its_own_sweep() -> None:
    bodies = load_cell("apc2016_delft").pod.bodies
    assert bodies
    for body in bodies:
        swept = Displacement().swept(body)
        np.testing.assert_allclose(swept.shape.extents, body.shape.extents, atol=1e-12)
        np.testing.assert_allclose(swept.T_parent_shape, body.T_parent_shape, atol=1e-12)


@given(shares)
def test_only_what_is_within_the_bounds_is_allowed(share: tuple[float, float, float]) -> None:
    T = displaced(np.eye(4), *(s * b for s, b in zip(share, (BOUNDS.x, BOUNDS.y, BOUNDS.yaw), strict=True)))
    assert BOUNDS.allows(T)
    for beyond in (pose((0.1001, 0, 0)), pose((0, -0.1001, 0)), pose((0, 0, 2e-6)), pose(rpy=(0, 0, 0.105)),
                   pose(rpy=(2e-6, 0, 0)), pose(rpy=(0, np.pi, 0))):  # fmt: skip
        assert not BOUNDS.allows(beyond @ T)


def test_bounds_that_are_not_stated_are_the_default_ones(cell_copy: CellCopy) -> None:
    line = "  displacement: {x: 0.05, y: 0.05, yaw: 0.0523598776}"
    cell_copy.yaml.replace(line, "  #")
    stated = cell_copy.load().pod.displacement
    assert (stated.x, stated.y, stated.yaw) == pytest.approx((0.05, 0.05, np.radians(3.0)))


def test_a_bound_that_is_none_is_told_with_its_place(cell_copy: CellCopy) -> None:
    line = cell_copy.yaml.replace("displacement: {x: 0.05,", "displacement: {x: -0.05,")
    with pytest.raises(InputError, match=rf"cell.yaml:{line}:\d+: pod.displacement.x: expected m, 0 to 0.5"):
        cell_copy.load()


def test_a_pod_at_its_place_is_told_without_a_sign_of_nothing() -> None:
    told = pod_stand(displaced(np.eye(4), -1e-6, 0.02, -1e-7))
    assert told == "+0.0 mm in x, +20.0 mm in y, +0.00 degrees off its place"
