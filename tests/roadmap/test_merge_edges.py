"""A roadmap that is given polylines has each of them once, and what it had."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pickcli.roadmap import validate
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.merge_edges import SAME_ENDS_DISTANCE, with_polylines, without_doubles

Array = NDArray[np.float64]

NAMES = ("x", "y")
coordinates = st.integers(-3, 3).map(float)
polylines = st.lists(
    st.lists(st.tuples(coordinates, coordinates), min_size=2, max_size=4).map(np.array), max_size=8
)


def _leads(roadmap: Roadmap, a: Array, b: Array) -> int:
    """How many edges lead from one place to the other."""
    ends = roadmap.configurations[roadmap.edges]
    return sum(
        min(np.abs(pair - [a, b]).max(), np.abs(pair - [b, a]).max()) <= SAME_ENDS_DISTANCE for pair in ends
    )


@given(polylines)
def test_every_polyline_that_leads_somewhere_is_an_edge_once(given_lines: list[Array]) -> None:
    grown = with_polylines(Roadmap.empty(NAMES), given_lines)
    validate.roadmap(grown, None)
    for line in given_lines:
        assert _leads(grown, line[0], line[-1]) == (0 if np.array_equal(line[0], line[-1]) else 1)
    assert len(np.unique(grown.configurations, axis=0)) == grown.n_nodes


@given(polylines, polylines)
def test_what_was_there_stays_and_growing_twice_is_growing_once(old: list[Array], new: list[Array]) -> None:
    base = with_polylines(Roadmap.empty(NAMES), old)
    grown = with_polylines(base, new)
    for edge in range(base.n_edges):
        np.testing.assert_array_equal(grown.edge_path(edge), base.edge_path(edge))
    again = with_polylines(grown, [*new, *(line[::-1] for line in new)])
    assert again.n_edges == grown.n_edges and again.n_nodes == grown.n_nodes


def test_a_polyline_is_a_double_however_it_winds_and_a_little_beside() -> None:
    straight = np.array([[0.0, 0.0], [1.0, 0.0]])
    beside = np.array([[1.0, 0.5 * SAME_ENDS_DISTANCE], [0.5, 3.0], [0.0, 0.0]])
    elsewhere = np.array([[0.0, 0.0], [1.0, 2.0 * SAME_ENDS_DISTANCE]])
    fresh = without_doubles([straight], [beside, elsewhere, elsewhere])
    assert len(fresh) == 1
    np.testing.assert_array_equal(fresh[0], elsewhere)
