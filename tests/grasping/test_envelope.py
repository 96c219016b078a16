"""Envelopes: terms against formulas of their own, gradients against differences, samples and bounds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse, pose, rotation_from_vector
from pickcli.grasping.envelope import Alignment, Envelope
from pickcli.grasping.finger_envelopes import (
    FingerReach,
    finger_envelopes,
)
from pickcli.kernel import SurfaceKind, pose_constraint_gradients

FINGERS = FingerReach(depth=0.05, pad=(0.02, 0.02), widest=0.08)
SURFACES = (SurfaceKind.PLANE, SurfaceKind.CYLINDER, SurfaceKind.SPHERE)


def envelopes() -> st.SearchStrategy[Envelope]:
    """Envelopes of every surface, somewhere, with and without alignment, with sectors narrow and wide."""

    @st.composite
    def build(draw: st.DrawFn) -> Envelope:
        number = st.floats(-1.0, 1.0)
        surface = draw(st.sampled_from(SURFACES))
        T = pose(
            [draw(number) for _ in range(3)],
            R=rotation_from_vector(np.array([3 * draw(number) for _ in range(3)])),
        )
        low = np.array(
            [draw(st.floats(-3.0, -0.1)), draw(st.floats(-1.2, -0.01)), draw(st.floats(0.02, 0.1))]
        )
        high = np.array([draw(st.floats(0.1, 3.0)), draw(st.floats(0.01, 1.2)), draw(st.floats(0.1, 0.3))])
        cone, angle = draw(st.floats(0.02, 0.6)), draw(st.floats(0.05, 0.6))
        object_axis = T[:3, 0] if surface is SurfaceKind.PLANE else T[:3, 2]
        is_aligned = surface is not SurfaceKind.SPHERE and draw(st.booleans())
        aligned = Alignment(np.array([1.0, 0.0, 0.0]), object_axis, angle) if is_aligned else None
        return Envelope("any", surface, T, low, high, cone, aligned, draw(st.floats(0.0, 0.2)))

    return build()


def off(envelope: Envelope, T_object_tip: Array) -> float:
    """Return the largest excess of a pose over the envelope's bounds, in m or rad."""
    palm = inverse(envelope.T_object_surface) @ T_object_tip @ pose((0.0, 0.0, -envelope.depth))
    x, y, z = palm[:3, 3]
    if envelope.surface is SurfaceKind.PLANE:
        coordinates, normal = np.array([x, y, z]), np.array([0.0, 0.0, 1.0])
    elif envelope.surface is SurfaceKind.CYLINDER:
        coordinates = np.array([np.arctan2(y, x), z, np.hypot(x, y)])
        normal = np.array([x, y, 0.0]) / np.hypot(x, y)
    else:
        d = float(np.sqrt(x * x + y * y + z * z))
        coordinates, normal = np.array([np.arctan2(y, x), np.arcsin(z / d), d]), np.array([x, y, z]) / d
    excess = [*(envelope.low - coordinates), *(coordinates - envelope.high)]
    excess.append(np.arccos(np.clip(-palm[:3, 2] @ normal, -1.0, 1.0)) - envelope.cone)
    if (aligned := envelope.alignment) is not None:
        cosine = (T_object_tip[:3, :3] @ aligned.tool_axis) @ aligned.object_axis
        excess.append(np.arccos(np.clip(cosine, -1.0, 1.0)) - aligned.angle)
    return float(max(excess))


@settings(max_examples=60, deadline=None)
@given(envelopes(), st.integers(0, 2**31))
def test_a_sample_is_in_the_envelope_by_formulas_of_its_own(envelope: Envelope, seed: int) -> None:
    for T in envelope.sample(np.random.default_rng(seed), 20):
        assert off(envelope, T) <= 1e-6


@settings(max_examples=60, deadline=None)
@given(envelopes(), st.integers(0, 2**31))
def test_poses_are_inside_where_no_bound_is_exceeded(envelope: Envelope, seed: int) -> None:
    rng = np.random.default_rng(seed)
    T = envelope.sample(rng, 10)
    T[:, :3, 3] += rng.normal(size=(len(T), 3)) * 0.05
    turns = [rotation_from_vector(v) for v in rng.normal(size=(len(T), 3)) * 0.2]
    T[:, :3, :3] = np.array(turns).reshape(-1, 3, 3) @ T[:, :3, :3]
    for pose_, is_inside in zip(T, envelope.contains(T), strict=True):
        excess = off(envelope, pose_)
        if abs(excess) > 1e-4:
            assert is_inside == (excess < 0.0)


@settings(max_examples=60, deadline=None)
@given(envelopes(), st.integers(0, 2**31))
def test_gradients_are_those_of_differences(envelope: Envelope, seed: int) -> None:
    for T in envelope.sample(np.random.default_rng(seed), 3):
        found, h = pose_constraint_gradients(envelope.constraints, T @ envelope.T_tip_palm), 1e-6
        palm = T @ envelope.T_tip_palm
        for k in range(6):
            step = np.zeros(6)
            step[k] = h
            ahead, behind = (
                pose(palm[:3, 3] + d[:3], R=rotation_from_vector(d[3:]) @ palm[:3, :3])
                @ inverse(envelope.T_tip_palm)
                for d in (step, -step)
            )
            difference = (envelope.terms(ahead[None]) - envelope.terms(behind[None]))[0] / (2 * h)
            assert np.abs(found[:, k] - difference).max() < 1e-6


@settings(max_examples=40, deadline=None)
@given(envelopes(), st.integers(0, 2**31))
def test_no_pose_of_the_envelope_is_rolled_farther_than_stated(envelope: Envelope, seed: int) -> None:
    rng = np.random.default_rng(seed)
    coordinates = envelope.low + (envelope.high - envelope.low) * rng.random((200, 3))
    off_axis, around = envelope.cone * rng.random(200), rng.uniform(-np.pi, np.pi, 200)
    tilt = off_axis[:, None] * np.stack([np.cos(around), np.sin(around)], axis=1)
    roll = rng.uniform(-np.pi, np.pi, 200)
    is_inside = envelope.contains(envelope.poses_at(coordinates, roll, tilt))
    assert (np.abs(roll[is_inside]) <= envelope.most_roll + 1e-9).all()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"low": np.array([0.0, 0.0, 0.2]), "high": np.array([1.0, 1.0, 0.1])}, "distance: from 0.2 to 0.1"),
        ({"low": np.array([0.0, 0.0, 0.0])}, "where there is no normal"),
        ({"cone": -0.1}, "cone"),
        ({"alignment": Alignment(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), 2.0)}, "alignment"),
        ({"alignment": Alignment(np.array([1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]), 0.1)}, "other"),
    ],
)  # fmt: skip
def test_an_empty_envelope_says_which_bound_no_pose_meets(change: dict[str, object], says: str) -> None:
    bounds = {"low": np.array([-1.0, 0.0, 0.05]), "high": np.array([1.0, 0.1, 0.1]), "cone": 0.2}
    envelope = Envelope("side", SurfaceKind.CYLINDER, np.eye(4), **{**bounds, **change})  # type: ignore[arg-type]
    assert says in envelope.why_empty()


def test_fingers_enclose_each_kind_of_shape_from_every_side() -> None:
    can = finger_envelopes(Shape(ShapeKind.CYLINDER, (0.025, 0.12)), FINGERS)
    assert [each.name for each in can] == ["side", "side, turned over", "+z", "-z"]
    ball = finger_envelopes(Shape(ShapeKind.SPHERE, (0.03,)), FINGERS)
    assert [each.name for each in ball] == ["sphere"]
    # Of a box of 40 x 60 x 200 mm fingers of 80 mm close on two pairs of sides: from every face but those
    # across them.
    box = finger_envelopes(Shape(ShapeKind.BOX, (0.04, 0.06, 0.2)), FINGERS)
    closings = {each.name.split(", ")[1] for each in box}
    assert closings == {"closing along x", "closing along y"}
    assert len(box) == 2 * (4 + 4)


@pytest.mark.parametrize(
    "shape",
    [
        Shape(ShapeKind.CYLINDER, (0.05, 0.1)),
        Shape(ShapeKind.SPHERE, (0.05,)),
        Shape(ShapeKind.BOX, (0.1,) * 3),
    ],
)
def test_what_the_fingers_do_not_span_has_no_envelope(shape: Shape) -> None:
    assert finger_envelopes(shape, FINGERS) == ()


def test_the_pads_of_a_side_grasp_are_beside_the_middle_of_a_can() -> None:
    side = finger_envelopes(Shape(ShapeKind.CYLINDER, (0.025, 0.12)), FINGERS)[0]
    T = side.sample(np.random.default_rng(1), 500)
    assert (
        np.linalg.norm(T[:, :2, 3], axis=1) <= FINGERS.pad[1] / 2 + 2 * 0.05 * np.sin(FINGERS.cone / 2)
    ).all()
    assert (np.abs(T[:, 2, 1]) <= np.sin(FINGERS.cone) + 1e-9).all()  # the tool closes across the axis


@settings(max_examples=60, deadline=None)
@given(envelopes(), st.integers(0, 2**31))
def test_clipped_poses_are_within_bounds_and_those_inside_stay(envelope: Envelope, seed: int) -> None:
    rng = np.random.default_rng(seed)
    inside = envelope.sample(rng, 10)
    np.testing.assert_allclose(envelope.clipped(inside), inside, atol=1e-9)
    outside = inside.copy()
    outside[:, :3, 3] += rng.normal(size=(len(inside), 3)) * 0.05
    clipped = envelope.clipped(outside)
    np.testing.assert_array_equal(clipped[:, :3, :3], outside[:, :3, :3])  # they are not turned
    np.testing.assert_allclose(envelope.clipped(clipped), clipped, atol=1e-9)
    turned_at_will = replace(envelope, cone=np.pi, alignment=None)
    assert all(off(turned_at_will, T) <= 1e-6 for T in clipped)
