"""Arrays that are none of the arrays asked for: refused by name, never read beyond their end."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from pickcli.geometry import Array
from pickcli.kernel import (
    Chain,
    Checker,
    fastest_pace,
    quintic_peaks,
    quintic_states,
    rrt_connect,
    shorten,
    smoothed_pace,
)
from support.kernel_cases import random_arm, random_world

ARM = random_arm(np.random.default_rng(7))
N = ARM.n
Q0 = np.zeros(N)
EYE, ONES = np.eye(4), np.ones(N)
WIDE = (np.full(N, -4.0), np.full(N, 4.0))


def _checker() -> Checker:
    return ARM.checker(random_world(np.random.default_rng(8), ARM))


def _peaks(p: Array) -> object:
    return quintic_peaks(np.arange(float(len(p))), p, np.zeros((len(p), N)), np.zeros((len(p), N)))


def _pace(dq: Array) -> object:
    return fastest_pace(np.arange(float(len(dq))), dq, dq, dq[1:], ONES, ONES, np.zeros(4, np.int32))


def _world(kind: Any) -> None:
    boxes = np.tile(np.eye(4), (5, 1, 1)), np.ones((5, 3)), np.zeros(5, np.uint64)
    _checker().set_world(*boxes, kind)


def _cloud(centers: Any) -> None:
    _checker().set_cloud(centers, 0.01)


REST = np.zeros((2, N))


def _robot(radii: Array) -> object:
    return Checker(ARM.chain(), np.zeros((5, 3)), radii, np.zeros(5, np.int32), np.zeros((0, 2), np.int32))


# name -> what takes the array, and the shape of one row of it
ROWS: dict[str, tuple[Callable[[Any], Any], tuple[int, ...]]] = {
    "Q of fk_batch": (lambda a: ARM.chain().fk_batch(a), (N,)),
    "Q of tip_motion": (lambda a: ARM.chain().tip_motion(a, a, a, EYE)[0], (N,)),
    "rates": (lambda a: ARM.chain().tip_motion(np.zeros((5, N)), a, np.zeros((5, N)), EYE), (N,)),
    "Q of are_free": (lambda a: _checker().are_free(a), (N,)),
    "Q of clearances": (lambda a: _checker().clearances(a), (N,)),
    "Q of clearest": (lambda a: _checker().clearest(a, 3)[0], (N,)),
    "Q of first_blocked_edge": (lambda a: _checker().first_blocked_edge(a), (N,)),
    "seeds": (lambda a: ARM.chain().ik(EYE, EYE, a, *WIDE, ONES), (N,)),
    "T_world_targets": (lambda a: ARM.chain().follow(a, EYE, Q0, *WIDE, ONES, ONES, 1.0, 1.0)[0], (4, 4)),
    "Q of tips": (lambda a: ARM.chain().tips(a, EYE), (N,)),
    "Q of longest_chords": (
        lambda a: ARM.chain().longest_chords(a, np.tile(EYE, (5, 1, 1)), EYE, 1.0, 1.0),
        (N,),
    ),
    "goals": (lambda a: rrt_connect(_checker(), Q0, a, *WIDE, 0, 1, 0.1), (N,)),
    "Q of shorten": (lambda a: shorten(_checker(), a, np.zeros((1, 2)), ONES, 0.05, 1e-3, 0.0), (N,)),
    "shortcuts": (lambda a: shorten(_checker(), np.stack([Q0, Q0]), a, ONES, 0.05, 1e-3, 0.0), (2,)),
    "kind": (_world, ()),
    "centers of set_cloud": (_cloud, (3,)),
    "held radii": (lambda a: _checker().set_held(np.zeros((5, 3)), a, np.zeros(0, np.int32)), ()),
    "positions": (_peaks, (N,)),
    "t": (lambda a: quintic_states(np.arange(2.0), REST, REST, REST, a, 0)[0], ()),
    "dq": (_pace, (N,)),
    "v": (lambda a: smoothed_pace(np.arange(5.0), np.arange(5.0), a, 0.1, 3), ()),
    "joint_types": (lambda a: Chain(a, np.zeros((5, 4, 4)), np.ones((5, 3)), np.zeros(5, np.int32)), ()),
    "sphere radii": (_robot, ()),
}


@pytest.mark.parametrize("name", ROWS)
@pytest.mark.parametrize("n_rows", [1, 5, 10**7])
def test_rows_without_entries_are_refused(name: str, n_rows: int) -> None:
    """An array (N, 0) has no entry at all: to read N rows of it would be to read foreign memory."""
    takes, row = ROWS[name]
    with pytest.raises(ValueError):
        takes(np.empty((n_rows, 0, *row[1:])))
    with pytest.raises(ValueError):
        takes(np.empty((n_rows, *row, 0)))


@pytest.mark.parametrize(
    "name",
    [
        "Q of fk_batch",
        "Q of tips",
        "Q of are_free",
        "Q of clearances",
        "Q of clearest",
        "seeds",
        "T_world_targets",
    ],
)
def test_no_rows_give_no_results(name: str) -> None:
    takes, row = ROWS[name]
    empty_array, empty_list = np.empty((0, *row)), list[float]()
    assert len(takes(empty_array)) == len(takes(empty_list)) == 0


@pytest.mark.parametrize("value", [2**32, 2**31, -(2**31) - 1])
def test_integers_that_do_not_fit_are_refused(value: int) -> None:
    poses, axes = np.eye(4)[None], np.array([[0.0, 0.0, 1.0]])
    with pytest.raises(ValueError, match="q_index: not an array of int32"):
        Chain(np.zeros(1, np.int32), poses, axes, np.array([value]))


@pytest.mark.parametrize("distance", [np.nan, -1.0])
def test_a_distance_that_is_none_is_refused(distance: float) -> None:
    with pytest.raises(ValueError, match="max_distance"):
        _checker().clearance(Q0, distance)
    with pytest.raises(ValueError, match="max_distance"):
        _checker().clearances(Q0[None], distance)


@pytest.mark.parametrize(("scale", "step"), [(1e61, 1.0), (1e308, 1.0), (1.0, 1e-61)])
def test_numbers_whose_powers_are_not_finite_are_refused(scale: float, step: float) -> None:
    rest = np.zeros((2, 1))
    with pytest.raises(ValueError, match=r"1e-?60"):
        quintic_peaks(np.array([0.0, step]), np.array([[0.0], [scale]]), rest, rest)


def test_the_largest_numbers_allowed_give_finite_peaks() -> None:
    values = 1e60 * np.array([[-1.0], [1.0]])
    for duration in (1e-60, 1e60):
        peaks = quintic_peaks(np.array([0.0, duration]), values, values, values)
        assert len(peaks) == 3 and all(np.isfinite(peak).all() for peak in peaks)
