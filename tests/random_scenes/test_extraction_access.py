"""Ways out: what is open, what is blocked, and laws that hold for any boxes."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.geometry import Array
from pickcli.random_scenes.box_arrays import BoxArrays
from pickcli.random_scenes.extraction_access import have_way_out

BIN = load_cell("apc2016_delft").pod.bins["bin_E"]
FLOOR = BIN.room.floor_back

Corners = tuple[float, float, float, float, float, float]


def boxes(*corners: Corners) -> BoxArrays:
    """From (x, y, z of the bottom over the floor, length, width, height) in m."""
    a = np.array(corners)
    low = a[:, :3] + (0.0, 0.0, FLOOR)
    return BoxArrays(low, low + a[:, 3:])


THING = (0.25, -0.04, 0.0, 0.10, 0.08, 0.06)


def ways(*corners: Corners) -> list[bool]:
    return [bool(way) for way in have_way_out(BIN, boxes(*corners))]


def test_alone_in_the_middle_it_comes_out() -> None:
    assert ways(THING) == [True]


def test_what_something_lies_on_stays() -> None:
    assert ways(THING, (0.26, -0.03, 0.06, 0.05, 0.05, 0.02)) == [False, True]


def test_over_what_is_low_but_not_over_what_is_high() -> None:
    assert ways(THING, (0.06, -0.12, 0.0, 0.10, 0.24, 0.02)) == [True, True]
    assert ways(THING, (0.06, -0.12, 0.0, 0.10, 0.24, 0.14)) == [False, True]


def test_past_what_is_high_if_there_is_room_beside() -> None:
    assert ways(THING, (0.06, -0.13, 0.0, 0.10, 0.08, 0.14))[0]


def test_wedged_between_high_neighbours() -> None:
    tall = [(0.20, y, 0.0, 0.15, 0.05, 0.14) for y in (-0.095, 0.045)]
    assert not ways(THING, *tall)[0]
    wide = [(0.20, y, 0.0, 0.15, 0.05, 0.14) for y in (-0.115, 0.065)]
    assert ways(THING, *wide)[0]


def test_too_high_for_the_mouth() -> None:
    assert ways((0.25, -0.04, 0.0, 0.10, 0.08, 0.215)) == [False]


some_boxes = st.lists(
    st.tuples(
        st.floats(0.02, 0.3), st.floats(-0.14, 0.05), st.floats(0.0, 0.1),
        st.floats(0.02, 0.12), st.floats(0.02, 0.09), st.floats(0.01, 0.15),
    ),
    min_size=2, max_size=6,
)  # fmt: skip


@given(some_boxes)
@settings(max_examples=60, deadline=None)
def test_taking_something_away_never_closes_a_way(corners: list[Corners]) -> None:
    every = have_way_out(BIN, boxes(*corners))
    fewer = have_way_out(BIN, boxes(*corners[:-1]))
    assert np.all(fewer | ~every[:-1])


@given(some_boxes)
@settings(max_examples=60, deadline=None)
def test_left_and_right_are_alike(corners: list[Corners]) -> None:
    given_boxes = boxes(*corners)

    def mirrored(a: Array) -> Array:
        return a * (1.0, -1.0, 1.0)

    low, high = mirrored(given_boxes.low), mirrored(given_boxes.high)
    mirror = BoxArrays(np.minimum(low, high), np.maximum(low, high))
    np.testing.assert_array_equal(have_way_out(BIN, given_boxes), have_way_out(BIN, mirror))


@given(some_boxes, some_boxes)
@settings(max_examples=20, deadline=None)
def test_many_bins_at_once_are_as_one_by_one(a: list[Corners], b: list[Corners]) -> None:
    n = min(len(a), len(b))
    one, two = boxes(*a[:n]), boxes(*b[:n])
    both = have_way_out(BIN, BoxArrays(np.stack([one.low, two.low]), np.stack([one.high, two.high])))
    np.testing.assert_array_equal(both, [have_way_out(BIN, one), have_way_out(BIN, two)])
