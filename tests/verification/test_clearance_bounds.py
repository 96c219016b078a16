"""What the proof of the clearance makes of distances that are told by hand, of pairs that move evenly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.verification.broad_phase import Stretches
from pickcli.verification.clearance_check import _reason, _Search
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.moving_parts import Fixture, parts
from pickcli.verification.pair_distance import Pair
from pickcli.verification.solid_arrays import SolidArrays
from pickcli.verification.state_sampling import States
from support.handmade_plans import Builder, cell, make_scene, move_plan
from support.tool_states import STRAIGHT

HOME = np.asarray(cell().configurations["home"].q)
NEEDED = 0.003  # m
BALL = Shape(ShapeKind.SPHERE, (0.02,))


@dataclass(eq=False)
class Told(Pair):
    """A pair whose distances are told; where it overlaps it is 7 mm deep."""

    def depth(self, i: int) -> float:
        return 0.007


def waiting() -> Plan:
    builder = Builder(HOME)
    builder.wait(SegmentKind.TRANSIT, 1.0, tool_state=STRAIGHT)
    return move_plan(make_scene(), builder)


PLAN = waiting()
(CUP,) = (part for part in parts(make_scene(), PLAN.segments[0], None) if part.is_cup)


def evenly(n: int, way: float) -> States:
    """n states, a second apart, from each of which to the next every pair moves by so many m."""
    links = np.zeros((1, n, 4, 4))
    travel: Array = way * np.arange(float(n))[:, None]
    return States(np.arange(float(n)), np.zeros((n, 1)), links, travel, way, cell().robot, PLAN.trajectory)


def pair_of(distances: Sequence[float], way: float, name: str = "ball") -> Told:
    states = evenly(len(distances), way)
    pair = Told(0, CUP, Fixture(name, np.eye(4), BALL, Solid(BALL)), states, np.ones(1))
    pair.measured.update(enumerate(distances))
    pair._order.extend(range(len(distances)))
    return pair


def search_of(needed: float, *pairs: Pair) -> _Search:
    """The search over whole motions of pairs, of which no bound is known."""
    none = np.empty(0, dtype=np.int64)
    nothing = Stretches(np.empty(0), none, none, none, none, none)
    states = pairs[0].states
    search = _Search(PLAN, states, SolidArrays.of((CUP,)), nothing, needed)
    search._below = 1.0  # as if all had been tightened
    for ticket, pair in zip(count(), pairs, strict=False):
        search._heap.append((-1.0, -1 - ticket, pair, 0, len(states.times) - 1, False))
    search._heap.sort(key=lambda entry: entry[:2])
    return search


@pytest.mark.parametrize(
    ("needed", "distances", "way", "problem"),
    [
        (0.0, (0.001, 0.001), 0.0019, ""), (0.0, (0.001, 0.001), 0.002, "too close to prove"),
        (0.0, (0.0, 0.001), 0.0001, "collision"),
        (0.0, (0.001, 0.0), 0.0001, "collision"), (0.0, (1e-9, 0.001), 0.0009, ""),
        (NEEDED, (NEEDED - 1e-5, 0.004), 1e-6, "too close"), (NEEDED, (NEEDED - 0.9e-5, 0.004), 1e-6, ""),
        (NEEDED, (0.004, NEEDED - 1e-5), 1e-6, "too close"), (NEEDED, (0.002, 0.002), 1e-6, "too close"),
        (NEEDED, (0.002995, 0.002995), 0.000188, ""), (NEEDED, (0.002995, 0.002995), 0.000192, "too close"),
        (NEEDED, (0.004, 0.004), 0.001, ""), (NEEDED, (0.0, 0.004), 0.001, "collision"),
    ],
)  # fmt: skip
def test_a_distance_may_fall_short_of_the_clearance_by_10_um_and_a_bound_by_100_um(
    needed: float, distances: tuple[float, float], way: float, problem: str
) -> None:
    """From one state to the next; without a clearance, nothing may touch at all."""
    search, pair = search_of(needed, pair_of(distances, way)), pair_of(distances, way)
    assert search._measure(pair, 0, 1) is (problem == "")
    assert [reason.what for reason in search._reasons.values()] == [problem] * bool(problem)
    if not problem:
        assert search._smallest == min(distances)
        assert search._proven == pytest.approx((sum(distances) - way) / 2)


def test_a_stretch_that_proves_nothing_is_split_and_no_reason() -> None:
    pair = pair_of((0.001, 0.02, 0.001), 0.02)
    search = search_of(0.0, pair)
    search._heap.clear()
    assert search._measure(pair, 0, 2) and search._reasons == {}
    ((bound, _, _, i, j, is_measured),) = search._heap
    assert bound == pytest.approx(-0.019) and (i, j, is_measured) == (0, 2, True)
    assert search._proven == 0.05 and search._smallest == 0.001


@pytest.mark.parametrize("n", [3, 65, 1025])
@pytest.mark.parametrize("lowest", [0.01, 0.0201, 0.049])
def test_what_is_proven_is_at_most_a_fifth_of_a_millimetre_below_what_was_measured(
    n: int, lowest: float
) -> None:
    """A pair that stays as near as it is, of which every bound is lower by half of what it may have moved."""
    for way in np.geomspace(2e-5, 3e-4, 7):
        found = search_of(0.0, pair_of([lowest] * n, float(way))).run()
        assert found.reasons == ()
        assert lowest - 2e-4 <= found.minimum <= lowest
        assert found.minimum <= lowest - way / 2 or found.minimum == pytest.approx(lowest - way / 2)


@pytest.mark.parametrize("at", [0, 1, 77, 128, 200])
def test_the_smallest_distance_is_found_wherever_it_is(at: int) -> None:
    """It comes and goes as fast as it may."""
    way, i = 1e-4, np.arange(201)
    near = pair_of((0.002 + way * np.abs(i - at)).tolist(), way)
    far = pair_of([0.03] * 201, way, "other")
    for pairs in ((near, far), (far, near)):
        found = search_of(0.0, *pairs).run()
        assert found.reasons == () and 0.0018 <= found.minimum <= 0.002 + 1e-12
    touching = pair_of((way * np.maximum(0, np.abs(i - at) - 1)).tolist(), way)
    (reason,) = search_of(0.0, far, touching).run().reasons
    met = float(reason.detail.split(" at ")[1].split(" s, ")[0])
    assert reason.what == "collision" and abs(met - at) <= 1.0


def test_beyond_5_cm_clearances_are_not_told_apart() -> None:
    for lowest, told in ((0.04, 0.04), (0.06, 0.05), (0.5, 0.05)):
        assert search_of(0.0, pair_of([lowest] * 9, 1e-6)).run().minimum == pytest.approx(told, abs=1e-5)


@pytest.mark.parametrize(("n", "told"), [(3, 3), (19, 19), (20, 20), (21, 20), (30, 20)])
def test_twenty_reasons_are_told_one_of_each_pair(n: int, told: int) -> None:
    pairs = [pair_of([0.0] * 5, 1e-4, f"ball {k}") for k in range(n)]
    reasons = search_of(0.0, *pairs, *pairs).run().reasons
    assert len(reasons) == len({reason.detail for reason in reasons}) == told


@pytest.mark.parametrize(
    ("distances", "what", "detail"),
    [
        ((0.002, 0.001), "too close", "cup and ball at 1.000 s, 1.00 mm apart, 3.0 mm are kept"),
        ((0.001, 0.002), "too close", "cup and ball at 0.000 s, 1.00 mm apart, 3.0 mm are kept"),
        ((0.0, 0.002), "collision", "cup and ball at 0.000 s, 7.0 mm deep"),
        ((0.003, 0.004), "too close to prove", "cup and ball at 0.000 s, 3.00 mm apart"),
    ],
)
def test_a_reason_tells_the_nearer_state(distances: tuple[float, float], what: str, detail: str) -> None:
    reason = _reason(PLAN, pair_of(distances, 1e-4), (0, 1), min(distances), NEEDED)
    assert (reason.what, reason.where, reason.detail) == (what, "segment 0 (transit)", detail)


@pytest.mark.parametrize(
    ("near", "what", "detail"),
    [
        (0.0, "collision", "cup and ball at 0.000 s, shortly before or after"),
        (0.001, "too close", "cup and ball at 0.000 s, 1.00 mm apart, 3.0 mm are kept"),
    ],
)
def test_a_reason_is_that_of_measurements_between_two_states(near: float, what: str, detail: str) -> None:
    reason = _reason(PLAN, pair_of((0.003, 0.004), 1e-4), (0, 1), near, NEEDED)
    assert (reason.what, reason.detail) == (what, detail)


@pytest.mark.parametrize("touched", [("ball",), ("other",), ()])
@pytest.mark.parametrize(("is_cup", "is_held"), [(True, False), (False, True), (False, False)])
def test_a_reason_tells_of_a_touch_that_is_named_and_not_planned(
    touched: tuple[str, ...], is_cup: bool, is_held: bool
) -> None:
    plan = replace(PLAN, segments=(replace(PLAN.segments[0], touching=touched),))
    pair = pair_of((0.0, 0.0), 1e-4)
    pair.a = replace(CUP, is_cup=is_cup, is_held=is_held)
    is_told = "named as touched, but" in _reason(plan, pair, (0, 1), 0.0, 0.0).detail
    assert is_told is ("ball" in touched and (is_cup or is_held))
