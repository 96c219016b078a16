"""A lip over open edges: the open area of its disc, and the vacuum at which the pump draws what comes in."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from pickcli.cell.cell_file import load_cell
from pickcli.cell.tools.lip_leak import AMBIENT, DENSITY, FULL_VACUUM, kept_vacuum, open_area

CELL = load_cell("apc2016_delft")
CUP = CELL.robot.tool.cup
RADII = st.floats(0.002, 0.05)
FLOWS = st.floats(10.0, 3000.0)
SEALS = st.floats(0.01, 1.0)
AREAS = st.floats(1e-7, 2e-3)


@given(radius=RADII, share=st.floats(-1.2, 1.2))
def test_the_open_area_is_that_of_the_points_beyond_the_edge(radius: float, share: float) -> None:
    x = np.linspace(-radius, radius, 4001)
    heights = 2.0 * np.sqrt(radius**2 - x**2)
    beyond = float(np.trapezoid(np.where(x > share * radius, heights, 0.0), x))
    assert open_area(radius, np.array([share * radius])) == pytest.approx(beyond, abs=2e-3 * radius**2)


@given(seal=SEALS, area=AREAS, flow=FLOWS)
def test_as_much_air_comes_in_as_the_pump_draws(seal: float, area: float, flow: float) -> None:
    def excess(share: float) -> float:  # m^3/s
        drop = share * FULL_VACUUM
        orifice = 0.61 * (1.0 - 0.41 / 1.4 * drop / AMBIENT) * area * np.sqrt(2.0 * drop / DENSITY)
        return float(orifice + flow / 6e4 * (share * (1.0 - seal) / seal - (1.0 - share)))

    assert kept_vacuum(seal, area, flow) == pytest.approx(brentq(excess, 0.0, 1.0, xtol=1e-12), abs=1e-9)


@given(seal=SEALS, area=AREAS, flow=FLOWS, more=st.floats(1.0, 10.0))
def test_a_wider_gap_costs_vacuum_and_a_pump_of_more_flow_regains_it(
    seal: float, area: float, flow: float, more: float
) -> None:
    kept = kept_vacuum(seal, area, flow)
    assert 0.0 < kept <= seal
    assert kept_vacuum(seal, area * more, flow) <= kept + 1e-12
    assert kept_vacuum(seal, area, flow * more) >= kept - 1e-12
    assert kept_vacuum(seal, 0.0, flow) == seal


@pytest.mark.parametrize(("off", "kept"), [(0.0, 0.37), (0.001, 0.35), (0.002, 0.30), (0.003, 0.22)])
def test_a_toothbrush_under_the_cup_of_the_cell(off: float, kept: float) -> None:
    """The figures of docs/formats/items.md: 25 mm wide, under 30 mm at 600 l/min."""
    rooms = np.array([[0.0125, 0.0125], [0.1, 0.1]])
    assert CUP.kept_vacuum(1.0, rooms, off) == pytest.approx(kept, abs=0.01)


@pytest.mark.parametrize(("tip", "off", "kept"), [
    ((0.008, -0.002, 0.0075), 0.0, 0.46), ((0.008, -0.002, 0.0075), 0.0022, 0.34),
])  # fmt: skip
def test_the_scissors_under_the_cup_of_the_cell(tip: tuple[float, ...], off: float, kept: float) -> None:
    """The figures of docs/formats/items.md: an area of 26 mm in the middle of a wider box."""
    scissors = CELL.item("fiskars_scissors_red", 2016)
    rooms = scissors.rooms("+z", np.array(tip))
    assert rooms.min(axis=1) == pytest.approx([0.0175, 0.013])
    assert CUP.kept_vacuum(scissors.seals["+z"], rooms, off) == pytest.approx(kept, abs=0.01)


@given(
    width=st.floats(0.02, 0.04),
    length=st.floats(0.03, 0.08),
    at=st.floats(-0.003, 0.003),
    off=st.floats(0.0, 0.004),
)
def test_the_stated_share_is_a_lower_bound_for_all_places_within_the_error(
    width: float, length: float, at: float, off: float
) -> None:
    rooms = np.array([[width / 2 + at, width / 2 - at], [length / 2, length / 2]])
    stated, covered = CUP.kept_vacuum(0.9, rooms, off), CUP.covered(rooms, off)
    for way in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False):
        aside = off * np.array([np.cos(way), np.sin(way)])
        moved = rooms + np.outer(aside, [1.0, -1.0])
        assert CUP.kept_vacuum(0.9, moved) >= stated - 1e-9
        assert CUP.covered(moved) >= covered - 1e-9
