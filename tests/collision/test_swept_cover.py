"""The volume that a body sweeps while one joint moves it lies inside the swept spheres."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.robot import Joint, JointType, joint_motion
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.collision.sphere_cover import cover_shape
from pickcli.collision.swept_cover import MAX_GROWTH, sweep
from pickcli.geometry import Array, pose, rotation_rpy, transform_points


def _joint(kind: JointType, axis: Array) -> Joint:
    return Joint("moves", kind, "lance", "cup", np.eye(4), axis, -3.0, 3.0)


@pytest.mark.parametrize("kind", [JointType.REVOLUTE, JointType.PRISMATIC])
@settings(max_examples=25, deadline=None)
@given(
    turn=st.tuples(*3 * [st.floats(-3, 3)]), offset=st.floats(0, 0.3), least=st.floats(-3.0, 0.5),
    way=st.floats(0.05, 3.0), seed=st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_the_swept_spheres_hold_the_body_at_every_position(
    kind: JointType, turn: tuple[float, float, float], offset: float, least: float, way: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    joint = _joint(kind, rotation_rpy(*turn) @ np.array([1.0, 0, 0]))
    cover = cover_shape(Shape(ShapeKind.CYLINDER, (0.015, 0.03))).moved(pose((0, 0, offset)))
    swept = sweep(cover, joint, least, least + way)
    for at in rng.uniform(least, least + way, 25):
        centers = transform_points(joint_motion(joint, at), cover.centers)
        for center, radius in zip(centers, cover.radii, strict=True):
            directions = rng.normal(size=(20, 3))
            surface = center + radius * directions / np.linalg.norm(directions, axis=1, keepdims=True)
            gaps = np.linalg.norm(surface[:, None] - swept.centers, axis=2) - swept.radii
            assert gaps.min(axis=1).max() <= 1e-9


def test_a_small_body_hardly_grows() -> None:
    cover = cover_shape(Shape(ShapeKind.CYLINDER, (0.015, 0.03))).moved(pose((0, 0, 0.015)))
    swept = sweep(cover, _joint(JointType.REVOLUTE, np.array([0.0, 1, 0])), 0.0, np.pi / 2)
    assert swept.excess <= cover.excess + MAX_GROWTH
