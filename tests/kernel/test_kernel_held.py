"""A solid in the hand: against solids of the world by slabs, against frames exactly."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import minimize

from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.kernel import Checker, set_simd, simd
from support.kernel_cases import (
    random_arm,
    random_configuration,
    random_edge,
    random_pose,
    random_solid,
    random_world,
)
from support.kernel_reference import BOX, CYLINDER, SPHERE, Arm, Solid, World, along, frames, self_spheres

SEEDS = st.integers(0, 2**32 - 1)
NONE = np.empty(0, np.int32)
SLIDER = Arm(
    joint_types=np.array([1], np.int32),
    T_parent_joint=np.eye(4)[None],
    axes=np.array([[1.0, 0.0, 0.0]]),
    q_index=np.array([0], np.int32),
    centers=np.empty((0, 3)),
    radii=np.empty(0),
    frame=NONE,
    self_pairs=np.empty((0, 2), np.int32),
)
AT_ZERO = np.zeros(1)
NO_SPHERES: dict[str, Any] = {
    f"{fine}{name}": getattr(SLIDER, name) for fine in ("", "fine_") for name in ("centers", "radii", "frame")
}


def hold(checker: Checker, solid: Solid, tested: NDArray[np.int32] = NONE) -> Checker:
    checker.set_held_solid(solid.T, solid.half, tested, solid.kind, solid.rounding)
    return checker


def world_of(*solids: Solid) -> World:
    n = len(solids)
    T, half = np.array([s.T for s in solids]), np.array([s.half for s in solids])
    kind, rounding = np.array([s.kind for s in solids], np.int32), np.array([s.rounding for s in solids])
    return World(T, half, np.zeros(n, np.uint64), kind, rounding)


def pair(held: Solid, standing: Solid) -> Checker:
    """A rail along x with one solid on it and one beside it."""
    return hold(SLIDER.checker(world_of(standing)), held)


def distance(a: Solid, b: Solid) -> float:
    """Distance of two solids: the least of a convex function of a point in each, by sequential quadratic
    programming. An upper bound wherever it ends; zero where they overlap."""
    half = np.concatenate([a.half, b.half])
    turns = np.hstack([a.T[:3, :3], -b.T[:3, :3]]) * half
    round_ = [(3 * i, 2 if s.kind == CYLINDER else 3) for i, s in enumerate((a, b)) if s.kind != BOX]

    def between(u: Array) -> Array:  # u: the two points in half extents
        return np.asarray(turns @ u + a.T[:3, 3] - b.T[:3, 3])

    inside = [{"type": "ineq", "fun": lambda u, i=i, n=n: 1 - (u[i : i + n] ** 2).sum()} for i, n in round_]
    u = np.zeros(6)
    for _ in range(3):  # it stops early at times
        u = minimize(
            lambda u: 1e3 * (between(u) ** 2).sum(),
            u,
            jac=lambda u: 2e3 * turns.T @ between(u),
            bounds=[(-1, 1)] * 6,
            constraints=inside,
            options={"ftol": 1e-13, "maxiter": 300},
        ).x
    u = np.clip(u, -1, 1)
    for i, n in round_:
        u[i : i + n] /= max(1.0, float(np.linalg.norm(u[i : i + n])))
    return float(np.linalg.norm(between(u))) - a.rounding - b.rounding


def random_pair(rng: np.random.Generator) -> tuple[Solid, Solid]:
    """Two solids near each other; in half of the cases they stand nearly in line."""
    a, b = random_solid(rng, 0.25, 0.1), random_solid(rng, 0.05, 0.1)
    if rng.random() < 0.5:
        turned = random_pose(rng, 0.0)[:3, :3]
        angles = rng.choice([0.0, np.pi / 2], 3) + 0.02 * rng.normal(size=3)
        R = np.eye(3)
        for axis, angle in zip(np.eye(3), angles, strict=True):
            R = R @ rotation_axis_angle(axis, float(angle))
        a = replace(a, T=pose(a.T[:3, 3], R=turned @ R))
        b = replace(b, T=pose(b.T[:3, 3], R=turned))
    return a, b


def flipping_margin(checker: Checker, q: Array) -> float:
    """The margin at which q stops being free; 0 if it never is."""
    low, high = 0.0, 2.0
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if checker.is_free(q, middle) else (low, middle)
    return low


@settings(max_examples=100, deadline=None)
@given(SEEDS)
def test_clearance_of_two_solids_is_their_distance(seed: int) -> None:
    a, b = random_pair(np.random.default_rng(seed))
    expected, measured = distance(a, b), pair(a, b).clearance(AT_ZERO)[0]
    assert measured <= expected + 1e-7
    if expected > -a.rounding - b.rounding + 1e-3:  # the cores are apart
        assert measured == pytest.approx(expected, abs=1e-5)


@settings(max_examples=100, deadline=None)
@given(SEEDS)
def test_a_held_solid_is_never_called_free_within_the_margin(seed: int) -> None:
    a, b = random_pair(np.random.default_rng(seed))
    assert flipping_margin(pair(a, b), AT_ZERO) <= max(0.0, distance(a, b))


def test_a_cylinder_a_millimetre_beside_a_box_is_free() -> None:
    """The direction between a rim and an edge is none of a face or an edge: it takes steps to find it."""
    rng, n_free = np.random.default_rng(3), 0
    roll = Solid(np.eye(4), np.array([0.075, 0.075, 0.15]), CYLINDER, 0.0)
    for _ in range(300):
        held = replace(roll, T=random_pose(rng, 0.0))
        half = np.array([0.3, 0.0025, 0.015]) if rng.random() < 0.5 else rng.uniform(0.01, 0.15, 3)
        checker = pair(held, Solid(random_pose(rng, 0.05), half, BOX, 0.0))
        low, high = 0.0, 1.0
        for _ in range(40):
            middle = (low + high) / 2
            is_near = checker.clearance(np.array([middle]))[0] < 0.001
            low, high = (middle, high) if is_near else (low, middle)
        n_free += checker.is_free(np.array([high]))
    assert n_free >= 297


def test_slabs_are_nearly_as_wide_as_the_distance() -> None:
    """How much clearance the bound leaves unseen, over pairs that are 1 to 60 mm apart."""
    rng = np.random.default_rng(0)
    lost: dict[bool, list[float]] = {False: [], True: []}
    while min(map(len, lost.values())) < 300:
        a, b = random_pair(rng)
        checker = pair(a, b)
        apart = checker.clearance(AT_ZERO)[0]
        if 0.001 < apart < 0.06:
            is_round = CYLINDER in (a.kind, b.kind)
            lost[is_round].append(apart - flipping_margin(checker, AT_ZERO) - 2 * checker.rounding)
    assert max(lost[False]) < 0.001
    assert np.quantile(lost[True], 0.95) < 0.001
    assert np.quantile(lost[True], 0.8) < 1e-4


def test_depth_of_two_boxes_is_the_shortest_way_out() -> None:
    box = Solid(pose((0.0, 0.0, 0.0)), np.array([0.1, 0.1, 0.1]))
    assert pair(box, replace(box, T=pose((0.17, 0.02, 0.0)))).clearance(AT_ZERO)[0] == pytest.approx(-0.03)
    rounded = replace(box, T=pose((0.17, 0.02, 0.0)), rounding=0.01)
    assert pair(box, rounded).clearance(AT_ZERO)[0] == pytest.approx(-0.04)


@pytest.mark.parametrize("kind", [BOX, CYLINDER, SPHERE])
@pytest.mark.parametrize("standing", [BOX, CYLINDER, SPHERE])
def test_a_solid_on_a_rail_is_judged_exactly(kind: int, standing: int) -> None:
    """Half extents of 0.1 m along the rail; the other one's surface is met at x = 1."""
    held = Solid(np.eye(4), np.full(3, 0.1), kind, 0.01)
    other = Solid(pose((1.22, 0.0, 0.0)), np.full(3, 0.2), standing, 0.02)
    checker = pair(held, other)
    for margin in (0.0, 0.05):
        for slack in (np.zeros(1), np.array([0.03])):
            end = 1.0 - 0.11 - margin - slack
            assert checker.edge_is_free(AT_ZERO, end - 4e-4, margin, slack)
            assert not checker.edge_is_free(AT_ZERO, end + 4e-4, margin, slack)


def surface(solid: Solid, rng: np.random.Generator) -> Array:
    """Points (400, 3) of a solid's core, corners and rims among them, in its frame."""
    unit = rng.uniform(-1, 1, (400, 3))
    unit[::2] = np.sign(unit[::2])
    if solid.kind == SPHERE:
        unit /= np.maximum(1.0, np.linalg.norm(unit, axis=1))[:, None]
    if solid.kind == CYLINDER:
        angle = rng.uniform(-np.pi, np.pi, 400)
        unit[:, :2] = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.asarray(unit * solid.half)


def nearest_samples(arm: Arm, held: Solid, world: World, Q: Array, rng: np.random.Generator) -> float:
    """Clearance of points of the held solid from the world's solids, at all Q: never below the true one."""
    T = frames(arm, Q)[:, -1] @ held.T
    points = T[:, None, :3, :3] @ surface(held, rng)[None, :, :, None]
    points = points[..., 0] + T[:, None, :3, 3]
    found = [
        float(solid.distances(points).min()) - held.rounding
        for solid, ignored in zip(world.solids(), world.ignored_frames.tolist(), strict=True)
        if not ignored >> arm.n_frames & 1
    ]
    return min(found, default=np.inf)


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_free_edges_have_no_point_of_the_held_solid_within_the_margin(seed: int) -> None:
    """Edges and tubes, asked at the clearance of samples of the whole way."""
    rng = np.random.default_rng(seed)
    arm = replace(random_arm(rng), **NO_SPHERES)
    world = random_world(rng, arm)
    held = random_solid(rng, 0.1, 0.08)
    checker = hold(arm.checker(world), held)
    q0, q1 = random_edge(rng, arm)
    slack = rng.uniform(0.0, 0.03, arm.n) * (rng.random(arm.n) < 0.7)
    Q = along(q0, q1, 200)
    for tube in (0 * slack, slack):
        lowest = nearest_samples(arm, held, world, Q + np.sign(rng.uniform(-1, 1, Q.shape)) * tube, rng)
        if lowest < np.inf:
            assert not checker.edge_is_free(q0, q1, max(lowest, 0.0), tube)


@settings(max_examples=100, deadline=None)
@given(SEEDS)
def test_frames_keep_clear_of_the_held_solid(seed: int) -> None:
    rng = np.random.default_rng(seed)
    arm = random_arm(rng)
    held, tested = random_solid(rng, 0.2, 0.1), np.unique(arm.frame)
    nothing = World(np.empty((0, 4, 4)), np.empty((0, 3)), np.empty(0, np.uint64))
    checker = hold(replace(arm, self_pairs=np.empty((0, 2), np.int32)).checker(nothing), held, tested)
    q = random_configuration(rng, arm)
    T = frames(arm, q[None])[0]
    bare = replace(arm, held_centers=np.empty((0, 3)), held_radii=np.empty(0))
    centers, radii, _ = self_spheres(bare, q[None])
    apart = float((replace(held, T=T[-1] @ held.T).distances(centers[0]) - radii).min())
    assert checker.clearance(q, 3.0)[0] == pytest.approx(min(apart, 3.0), abs=1e-12)
    assert flipping_margin(checker, q) <= max(apart, 0.0)
    assert flipping_margin(checker, q) >= min(apart, 2.0) - 2 * checker.rounding - 1e-9


def test_a_solid_replaces_spheres_and_is_replaced() -> None:
    block = Solid(pose((0.15, 0.0, 0.0)), np.full(3, 0.1))
    checker = pair(replace(block, T=np.eye(4)), block)
    assert not checker.is_free(AT_ZERO)
    checker.set_held(np.zeros((1, 3)), np.array([0.01]), NONE)
    assert checker.clearance(AT_ZERO)[0] == pytest.approx(0.04)
    hold(checker, Solid(np.eye(4), np.full(3, 0.02), SPHERE))
    distance, group = checker.clearance(AT_ZERO)[:2]
    assert distance == pytest.approx(0.03) and group == 1
    checker.set_held(np.empty((0, 3)), np.empty(0), NONE)
    assert checker.clearance(AT_ZERO)[1:] == (-1, -1, -1)


@pytest.fixture
def both() -> Iterator[tuple[str, str]]:
    before = simd()
    if before == "baseline":
        pytest.skip("this processor has no AVX2")
    yield "avx2", "baseline"
    set_simd(before)


def test_both_builds_give_the_same_bits(both: tuple[str, str]) -> None:
    def everything() -> list[object]:
        out: list[object] = []
        for seed in range(60):
            rng = np.random.default_rng(seed)
            arm = random_arm(rng)
            checker = hold(
                arm.checker(random_world(rng, arm)), random_solid(rng, 0.1, 0.08), np.unique(arm.frame)
            )
            q0, q1 = random_edge(rng, arm)
            report = checker.check_edge(q0, q1)
            out.append(
                (report.free, report.t, report.frame, report.kind, report.index, report.n_configurations)
            )
            out.append(flipping_margin(pair(*random_pair(rng)), AT_ZERO))
        return out

    results = []
    for name in both:
        set_simd(name)
        results.append(everything())
    assert results[0] == results[1]


@pytest.mark.parametrize(
    ("half", "kind", "rounding", "message"),
    [
        ((0.1, -0.1, 0.1), BOX, 0.0, "half extents 0.1.*, -0.1.*: must be at least 0"),
        ((0.1, 0.1, 0.1), BOX, -0.1, "rounding -0.1.*: must be at least 0"),
        ((0.1, 0.2, 0.1), CYLINDER, 0.0, "must be its radius"),
        ((0.1, 0.1, 0.2), SPHERE, 0.0, "must be its radius"),
        ((0.1, 0.1, 0.1), 3, 0.0, "0 is a box, 1 a cylinder, 2 a sphere"),
    ],
)
def test_what_is_no_solid_is_refused(
    half: tuple[float, float, float], kind: int, rounding: float, message: str
) -> None:
    solid = Solid(np.eye(4), np.array(half), kind, rounding)
    good = Solid(np.eye(4), np.full(3, 0.1))
    with pytest.raises(ValueError, match=message):
        pair(solid, good)
    with pytest.raises(ValueError, match=rf"\[0\].*{message}"):
        pair(good, solid)


@given(SEEDS)
@settings(max_examples=40, deadline=None)
def test_a_bare_copy_is_the_robot_as_it_was_made(seed: int) -> None:
    """It outlives what it was copied from, and holds and meets nothing until it is told to."""
    rng = np.random.default_rng(seed)
    arm = random_arm(rng)
    world, other = random_world(rng, arm), random_world(rng, arm)
    copy = arm.checker(world).bare()
    fine = (arm.fine_centers, arm.fine_radii, arm.fine_frame)
    made = Checker(arm.chain(), arm.centers, arm.radii, arm.frame, arm.self_pairs, *fine)
    Q = np.array([random_configuration(rng, arm) for _ in range(20)])
    assert (copy.clearances(Q, 1.0) == made.clearances(Q, 1.0)).all()
    for checker in (copy, made):
        other.enter(checker)
        checker.set_held(arm.held_centers, arm.held_radii, arm.held_tested)
    assert (copy.clearances(Q, 1.0) == made.clearances(Q, 1.0)).all()
    assert (copy.are_free(Q, 0.01) == made.are_free(Q, 0.01)).all()
