"""A pinched item that stands off by its pose error: no error within bounds loads more than those checked."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tools.gripper import Finger, ParallelGripper
from pickcli.cell.tools.pinch_limits import PinchLimits
from pickcli.geometry import Array, inverse, rotation_rpy
from pickcli.grasping.antipodal import Pinch, limits_of, pinches
from pickcli.scene.scene import PoseNoise
from pickcli.verification.pinch_check import pads_on
from pickcli.verification.strayed_pinch_check import closed_on, strayed

PAD = (0.0175, 0.0185)
GRIPPER = ParallelGripper(
    (Finger("left", "left_slide", 1.0, 1.0), Finger("right", "right_slide", -1.0, 1.0)),
    PAD, 0.0, PinchLimits(70.0, 0.5, PAD), 0.1, 0.1,
)  # fmt: skip
BETWEEN_POINTS = 1.1  # the contact is known at points, and does not shrink evenly between two corners
PLANNED = 0.8  # share of what the pads bear that planned motion uses

sizes = st.floats(0.03, 0.12)
boxes = st.builds(lambda *size: Shape(ShapeKind.BOX, size), sizes, sizes, sizes)
cylinders = st.builds(lambda *size: Shape(ShapeKind.CYLINDER, size), st.floats(0.015, 0.04), sizes)
spheres = st.builds(lambda r: Shape(ShapeKind.SPHERE, (r,)), st.floats(0.015, 0.04))
shapes = st.one_of(boxes, cylinders, spheres)
noises = st.builds(PoseNoise, st.floats(0.0, 0.003), st.floats(0.0, np.radians(1.5)))
seeds = st.integers(0, 10_000)


def pinch_of(shape: Shape, rng: np.random.Generator) -> Pinch | None:
    """One of the planner's, from any side."""
    way_in = rotation_rpy(*rng.uniform(-3.0, 3.0, 3))[:, 0]
    found = [*pinches(shape, PAD, way_in, (0.0,), 3, rng, 3)]
    return found[rng.integers(len(found))] if found else None


def ball(rng: np.random.Generator, radius: float) -> Array:
    """A vector of at most that length, half of them of all of it."""
    v = rng.normal(size=3)
    return np.asarray(v / np.linalg.norm(v) * radius * rng.choice([1.0, rng.uniform()]))


def load(shape: Shape, T_tip_item: Array, force: Array) -> float:
    """Of a force (3,) that the pads exert, which passes through the item's centre."""
    pads = pads_on(shape, inverse(T_tip_item), GRIPPER)
    wrench = np.append(force, np.cross(T_tip_item[:3, 3], force))
    return np.inf if pads is None else float(pads.ratio(wrench[None], GRIPPER)[0])


@settings(deadline=None, max_examples=60)
@given(shapes, noises, seeds)
def test_no_error_within_the_bounds_loads_more_than_the_worst_that_is_checked(
    shape: Shape, noise: PoseNoise, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    pinch = pinch_of(shape, rng)
    if pinch is None:
        return
    T, force = inverse(pinch.T_item_tip), rng.normal(size=3) * 10.0
    worst = max(load(shape, there, force) for there in strayed(T, noise))
    assert load(shape, T, force) <= BETWEEN_POINTS * worst
    for _ in range(20):
        there = closed_on(T, ball(rng, noise.position), ball(rng, noise.angle))
        assert load(shape, there, force) <= BETWEEN_POINTS * worst


@settings(deadline=None, max_examples=60)
@given(shapes, noises, seeds)
def test_what_the_planner_lets_the_pads_bear_the_verifier_accepts_at_every_corner(
    shape: Shape, noise: PoseNoise, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    pinch = pinch_of(shape, rng)
    limits = None if pinch is None else limits_of(GRIPPER, shape, pinch.face, pinch.T_item_tip, noise)
    if pinch is None or limits is None:
        return
    T, force = inverse(pinch.T_item_tip), rng.normal(size=3) * 10.0
    planned = float(limits.ratio(np.append(force, np.cross(T[:3, 3], force))))
    assert max(load(shape, there, force) for there in strayed(T, noise)) <= planned / PLANNED


@given(noises, seeds)
def test_closed_fingers_have_between_them_what_they_were_to_have(noise: PoseNoise, seed: int) -> None:
    """The point of the item that was to be in the middle is there along y, to the second order."""
    rng = np.random.default_rng(seed)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = rotation_rpy(*rng.uniform(-3.0, 3.0, 3)), rng.uniform(-0.05, 0.05, 3)
    shift, turn = ball(rng, noise.position), ball(rng, noise.angle)
    there = closed_on(T, shift, turn)
    assert abs((there @ inverse(T))[1, 3]) <= noise.angle**2 * 0.1 + 1e-12
    assert_allclose(there[[0, 2], 3] - T[[0, 2], 3], shift[[0, 2]], atol=1e-12)
    assert_allclose(closed_on(T, 0.0 * shift, 0.0 * turn), T, atol=1e-12)
