"""The volume a turning body sweeps lies inside the swept spheres."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.collision.sphere_cover import cover_shape
from pickcli.collision.swept_cover import MAX_GROWTH, sweep
from pickcli.geometry import pose, rotation_axis_angle, rotation_rpy, transform_points


@settings(max_examples=25, deadline=None)
@given(
    turn=st.tuples(*3 * [st.floats(-3, 3)]), offset=st.floats(0, 0.3), angle=st.floats(0.05, 3.0),
    seed=st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_every_angle_stays_inside(
    turn: tuple[float, float, float], offset: float, angle: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    axis = rotation_rpy(*turn) @ np.array([1.0, 0, 0])
    cover = cover_shape(Shape(ShapeKind.CYLINDER, (0.015, 0.03))).moved(pose((0, 0, offset)))
    swept = sweep(cover, axis, angle)
    for at in rng.uniform(0, angle, 25):
        centers = transform_points(pose(R=rotation_axis_angle(axis, at)), cover.centers)
        for center, radius in zip(centers, cover.radii, strict=True):
            directions = rng.normal(size=(20, 3))
            surface = center + radius * directions / np.linalg.norm(directions, axis=1, keepdims=True)
            gaps = np.linalg.norm(surface[:, None] - swept.centers, axis=2) - swept.radii
            assert gaps.min(axis=1).max() <= 1e-9


def test_a_small_body_hardly_grows() -> None:
    cover = cover_shape(Shape(ShapeKind.CYLINDER, (0.015, 0.03))).moved(pose((0, 0, 0.015)))
    swept = sweep(cover, np.array([0.0, 1, 0]), np.pi / 2)
    assert swept.excess <= cover.excess + MAX_GROWTH
