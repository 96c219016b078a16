"""The proof of edges: never free wrongly, and complete down to its resolution."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.geometry import pose
from pickcli.kernel import Checker, set_simd, simd
from support.kernel_cases import random_arm, random_configuration, random_edge, random_world
from support.kernel_reference import Arm, World, along, clearances, pair_clearances

SEEDS = st.integers(0, 2**32 - 1)
RESOLUTION = 2e-4


def case(seed: int) -> tuple[np.random.Generator, Arm, World, Checker]:
    rng = np.random.default_rng(seed)
    arm = random_arm(rng)
    world = random_world(rng, arm)
    return rng, arm, world, arm.checker(world)


@settings(max_examples=120, deadline=None)
@given(SEEDS)
def test_free_edges_have_no_sample_within_the_margin(seed: int) -> None:
    """Asked at the sampled clearance itself, the kernel must say no; a little below it, yes."""
    rng, arm, world, checker = case(seed)
    for _ in range(3):
        q0, q1 = random_edge(rng, arm)
        lowest = float(clearances(arm, world, along(q0, q1, 1001)).min())
        assert checker.edge_is_free(q0, q1) <= (lowest > 0)
        if 2e-3 < lowest < np.inf:
            assert not checker.edge_is_free(q0, q1, lowest, resolution=RESOLUTION)
            # Between two of the samples the clearance may be lower, by little as they stand so close.
            assert checker.edge_is_free(q0, q1, lowest - 1e-3, resolution=RESOLUTION)


@settings(max_examples=100, deadline=None)
@given(SEEDS)
def test_a_blocked_edge_is_blocked_where_and_by_what_is_reported(seed: int) -> None:
    rng, arm, world, checker = case(seed)
    q0, q1 = random_edge(rng, arm)
    report = checker.check_edge(q0, q1, 0.01, resolution=RESOLUTION)
    assert report.free == checker.edge_is_free(q0, q1, 0.01, resolution=RESOLUTION)
    if report.free:
        assert (report.t, report.frame, report.kind, report.index) == (-1.0, -1, -1, -1)
    else:
        there = pair_clearances(arm, world, (q0 + report.t * (q1 - q0))[None])
        at_most = 0.01 + RESOLUTION + 2 * checker.rounding
        assert there[report.frame, report.kind, report.index][0] <= at_most


@settings(max_examples=100, deadline=None)
@given(SEEDS)
def test_a_tube_that_is_free_has_no_sample_within_the_margin(seed: int) -> None:
    rng, arm, world, checker = case(seed)
    q0, q1 = random_edge(rng, arm)
    slack = rng.uniform(0.0, 0.05, arm.n) * (rng.random(arm.n) < 0.7)
    inside = rng.uniform(-1, 1, (500, arm.n))
    inside[:250] = np.sign(inside[:250])
    lowest = float(clearances(arm, world, along(q0, q1, 500) + inside * slack).min())
    for margin in (0.0, 0.02, max(min(lowest, 3.0), 0.0)):
        if checker.edge_is_free(q0, q1, margin, slack):
            assert lowest >= margin
            assert checker.edge_is_free(q0, q1, margin)
    assert checker.edge_is_free(q0, q1, 0.01, np.zeros(arm.n)) == checker.edge_is_free(q0, q1, 0.01)


def slider_before_a_wall() -> Checker:
    """A ball of 0.1 m on a rail along x; the wall begins at x = 1. The clearance is 0.9 - q."""
    empty = np.empty((0, 2), np.int32)
    arm = Arm(
        joint_types=np.array([1], np.int32),
        T_parent_joint=np.eye(4)[None],
        axes=np.array([[1.0, 0.0, 0.0]]),
        q_index=np.array([0], np.int32),
        centers=np.zeros((1, 3)),
        radii=np.array([0.1]),
        frame=np.array([0], np.int32),
        self_pairs=empty,
    )
    wall = World(pose([2.0, 0, 0])[None], np.array([[1.0, 5, 5]]), np.zeros(1, np.uint64))
    return arm.checker(wall)


@settings(deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(0.0, 0.3), st.floats(0.0, 0.3))
def test_a_sliding_ball_is_judged_exactly(q0: float, q1: float, margin: float, slack: float) -> None:
    """Both ends of the edge count, and slack adds exactly what it moves."""
    left = 0.9 - max(q0, q1) - slack - margin
    free = slider_before_a_wall().edge_is_free(np.array([q0]), np.array([q1]), margin, np.array([slack]))
    assert free == (left > 0) or abs(left) < 3e-4


def test_only_joints_between_two_frames_move_them_apart() -> None:
    """A rail that carries the whole arm cannot bring two of its links together, however far it goes."""
    arm = Arm(
        joint_types=np.array([1, 0], np.int32),
        T_parent_joint=np.stack([np.eye(4), pose([0.5, 0, 0])]),
        axes=np.array([[1.0, 0, 0], [0, 0, 1]]),
        q_index=np.array([0, 1], np.int32),
        centers=np.array([[0.0, 0, 0], [0.2, 0, 0]]),
        radii=np.array([0.1, 0.1]),
        frame=np.array([0, 1], np.int32),
        self_pairs=np.array([[0, 1]], np.int32),
    )
    nothing = World(np.empty((0, 4, 4)), np.empty((0, 3)), np.empty(0, np.uint64))
    checker = arm.checker(nothing)
    report = checker.check_edge(np.array([-100.0, 0.0]), np.array([100.0, 0.0]), slack=np.array([100.0, 0.0]))
    assert report.free
    assert report.n_configurations == 8
    assert checker.edge_is_free(np.array([0.0, 0.0]), np.array([0.0, 2 * np.pi]), 0.099)
    assert checker.check_edge(np.array([0.0, 0.0]), np.array([0.0, np.pi]), 0.101).frame == 1


@settings(deadline=None)
@given(SEEDS, st.integers(2, 30), st.sampled_from([0.005, 0.1]))
def test_a_path_is_free_when_all_its_edges_are(seed: int, n_vertices: int, size: float) -> None:
    """Also where its edges are so many and so short that eight are proven at once."""
    rng, arm, _, checker = case(seed)
    Q = np.array([random_configuration(rng, arm) for _ in range(n_vertices)])
    Q = Q[0] + size * (Q - Q[0])
    slack = rng.uniform(0, 0.1 * size, (n_vertices - 1, arm.n))
    free = [checker.edge_is_free(*edge, 0.01, s) for edge, s in zip(pairwise(Q), slack, strict=True)]
    assert checker.first_blocked_edge(Q, 0.01, slack) == (free.index(False) if False in free else -1)
    assert (checker.first_blocked_edge(Q[:1], 0.01) == -1) == checker.is_free(Q[0], 0.01)


@settings(deadline=None)
@given(SEEDS)
def test_whole_turns_change_nothing(seed: int) -> None:
    """Continuous joints may stand many turns away from zero."""
    rng, arm, world, checker = case(seed)
    q0, q1 = random_edge(rng, arm)
    turns = 2 * np.pi * rng.integers(-50, 50, arm.n)
    turns[arm.q_index[arm.joint_types == 1]] = 0.0
    lowest = min(float(clearances(arm, world, along(q0, q1, 501)).min()), 3.0)
    if lowest > 2e-3:
        assert checker.edge_is_free(q0 + turns, q1 + turns, lowest - 1e-3)


@pytest.fixture
def both() -> Iterator[tuple[str, str]]:
    before = simd()
    if before == "baseline":
        pytest.skip("this processor has no AVX2")
    yield "avx2", "baseline"
    set_simd(before)


def flipping_margin(checker: Checker, q: np.ndarray) -> float:
    """The margin at which q stops being free, to the last bit of single precision."""
    low, high = 0.0, 4.0
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if checker.is_free(q, middle) else (low, middle)
    return low


def test_both_builds_give_the_same_bits(both: tuple[str, str]) -> None:
    def everything() -> list[object]:
        out: list[object] = []
        for seed in range(40):
            rng, arm, _, checker = case(seed)
            for _ in range(5):
                q0, q1 = random_edge(rng, arm)
                slack = rng.uniform(0, 0.01, arm.n)
                for report in (checker.check_edge(q0, q1), checker.check_edge(q0, q1, 0.02, slack)):
                    out.append((report.free, report.t, report.frame, report.kind, report.index))
                    out.append(report.n_configurations)
                out.append(flipping_margin(checker, q0))
        return out

    results = []
    for name in both:
        set_simd(name)
        assert simd() == name
        results.append(everything())
    assert results[0] == results[1]


def test_an_unknown_build_is_refused() -> None:
    with pytest.raises(ValueError, match="baseline"):
        set_simd("quantum")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"margin": -0.1}, "margin"),
        ({"margin": np.nan}, "margin"),
        ({"resolution": 0.0}, "resolution"),
        ({"slack": np.array([-1.0])}, "slack must not be negative"),
        ({"slack": np.array([[1.0]])}, r"slack: shape \(1, 1\) instead of \(1\)"),
        ({"q1": np.array([np.inf])}, "q1: not finite"),
        ({"q1": np.array([1e7])}, "q1: beyond"),
        ({"q1": np.array([0.0, 1.0])}, r"q1: shape \(2\) instead of \(1\)"),
        ({"q1": "far"}, "q1: not an array of float64"),
    ],
)
def test_bad_arguments_are_named(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        slider_before_a_wall().edge_is_free(**{"q0": [0.0], "q1": [0.5], **arguments})  # type: ignore[arg-type]


def test_lists_and_other_number_types_are_taken() -> None:
    checker = slider_before_a_wall()
    assert checker.edge_is_free([0], np.array([0.5], np.float32))  # type: ignore[arg-type]
    strided = np.zeros(4)[::4]
    assert checker.edge_is_free(strided, strided)
