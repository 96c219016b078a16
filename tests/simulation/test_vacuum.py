"""The pressure model: what the devices' lead times promise."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.tools.lip_leak import FULL_VACUUM
from pickcli.planning.pick_settings import PickSettings
from pickcli.simulation.suction import RELEASE_VACUUM
from pickcli.simulation.vacuum import Vacuum


def run(vacuum: Vacuum, duration: float, seal: float = 0.0, step: float = 1e-3) -> None:
    for _ in range(round(duration / step)):
        vacuum.advance(step, seal)


def pumped(duration: float = 2.0) -> Vacuum:
    vacuum = Vacuum(pump_lead=2.0, valve_lead=0.05)
    vacuum.switch_pump(True)
    run(vacuum, duration)
    return vacuum


def test_the_pump_needs_its_lead_to_full_vacuum() -> None:
    assert pumped(2.0).line > 0.98 * FULL_VACUUM
    assert pumped(1.0).line < 0.90 * FULL_VACUUM


def test_the_valve_opens_after_its_lead_and_not_before() -> None:
    vacuum = pumped()
    vacuum.switch_valve(True)
    run(vacuum, 0.049)
    assert not vacuum.is_valve_open
    run(vacuum, 0.001)
    assert vacuum.is_valve_open


def test_a_sealed_cup_is_evacuated_within_a_quarter_second() -> None:
    vacuum = pumped()
    vacuum.switch_valve(True)
    run(vacuum, 0.3, seal=1.0)
    assert vacuum.cup > 0.97 * FULL_VACUUM


def test_an_open_cup_leaks_the_line_empty_and_the_pump_must_begin_again() -> None:
    vacuum = pumped()
    vacuum.switch_valve(True)
    run(vacuum, 0.3)
    assert vacuum.line < 0.1 * FULL_VACUUM
    assert vacuum.cup == 0.0
    run(vacuum, 0.3, seal=1.0)
    assert vacuum.cup < 0.5 * FULL_VACUUM


@given(seal=st.floats(0.05, 1.0))
def test_a_leaking_face_is_kept_at_its_share_of_the_vacuum(seal: float) -> None:
    vacuum = pumped()
    vacuum.switch_valve(True)
    run(vacuum, 4.0, seal=seal)
    assert vacuum.cup == pytest.approx(seal * FULL_VACUUM, rel=2e-3)


def test_a_leak_empties_the_line_that_is_not_pumped() -> None:
    pressures = []
    for seal in (1.0, 0.9, 0.3):
        vacuum = pumped()
        vacuum.switch_pump(False)
        vacuum.switch_valve(True)
        run(vacuum, 0.5, seal=seal)
        pressures.append(vacuum.line)
    assert pressures == sorted(pressures, reverse=True)
    assert pressures[0] > 0.95 * FULL_VACUUM and pressures[2] < 0.3 * FULL_VACUUM


def test_a_closed_valve_vents_the_cup() -> None:
    vacuum = pumped()
    vacuum.switch_valve(True)
    run(vacuum, 0.5, seal=1.0)
    vacuum.switch_valve(False)
    run(vacuum, 0.15, seal=1.0)
    assert vacuum.cup < 0.02 * FULL_VACUUM
    assert vacuum.line > 0.9 * FULL_VACUUM


@given(n=st.integers(1, 50))
def test_the_line_does_not_depend_on_the_time_step(n: int) -> None:
    fine, coarse = Vacuum(2.0, 0.05), Vacuum(2.0, 0.05)
    for vacuum in (fine, coarse):
        vacuum.switch_pump(True)
    run(fine, 0.5, step=0.5 / n)
    run(coarse, 0.5, step=0.5)
    assert fine.line == pytest.approx(coarse.line, rel=1e-9)


def test_a_closed_valve_vents_the_cup_while_the_tool_rests_where_it_lets_go() -> None:
    """From full vacuum, which takes longest; and no longer than that, for the tool is to be gone."""
    vacuum = pumped()
    vacuum.switch_valve(True)
    run(vacuum, 1.0, seal=1.0)
    vacuum.switch_valve(False)
    run(vacuum, 0.05, seal=1.0)  # its lead
    rest = PickSettings().release_time
    run(vacuum, rest - 0.02, seal=1.0)
    assert vacuum.cup > RELEASE_VACUUM
    run(vacuum, 0.02, seal=1.0)
    assert vacuum.cup < RELEASE_VACUUM
