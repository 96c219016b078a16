"""Which motions are stored for a cell of crates and shelves: between any two places, empty and laden."""

from __future__ import annotations

from itertools import combinations

from pickcli.cell.cell_file import load_cell
from pickcli.precompute.motion_pairs import coarse_pairs
from pickcli.roadmap.trajectory_database import MotionKey, PayloadClass


def test_any_two_places_are_joined_where_there_is_no_tote() -> None:
    cell = load_cell("ur5e_crates")
    wanted = set(coarse_pairs(cell))
    assert len(cell.places) == 8
    for a, b in combinations(("home", *cell.places), 2):
        assert {MotionKey(a, b, payload) for payload in (PayloadClass.EMPTY, PayloadClass.CUBE)} <= wanted


def test_each_place_has_a_configuration_in_front_of_it() -> None:
    cell = load_cell("ur5e_crates")
    assert [[named.name for named in cell.configurations_at(place)] for place in cell.places.values()] == [
        [name] for name in cell.places
    ]
