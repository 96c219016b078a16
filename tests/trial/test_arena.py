"""The simulated arena: truth comes out of it, refusals are stops, time passes only inside."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fake_crew import FakeCrew, scene_of
from order_builders import pick_order

from pickcli.cell.load import load_cell
from pickcli.cell.robot import PivotState
from pickcli.cell.scene import TOTE
from pickcli.trial.arena import LET_GO, SimulatedArena

ORDER = pick_order({"bin_A": ("crayola_24_ct",)}, ("bin_A", "crayola_24_ct"))


@pytest.fixture
def arena() -> SimulatedArena:
    return SimulatedArena(scene_of(ORDER, load_cell("apc2016_delft")))


def test_it_starts_at_home_with_everything_in_its_place(arena: SimulatedArena) -> None:
    scene = arena.now()
    np.testing.assert_allclose(arena.q, scene.cell.configurations["home"].q, atol=1e-9)
    assert arena.pivot is PivotState.STRAIGHT
    assert arena.held is None
    assert [(i.id, i.location) for i in scene.items] == [("crayola_24_ct", "bin_A")]


def test_a_plan_from_elsewhere_is_a_stop_and_moves_nothing(arena: SimulatedArena) -> None:
    cell = arena.now().cell
    fake = FakeCrew(arena.now())
    plan = fake.plan(arena.now(), "bin_A", "crayola_24_ct", TOTE, arena.q, arena.pivot, 0, ())
    before = arena.q.copy()
    done = arena.execute(replace(plan, cell_fingerprint=cell.fingerprint))
    assert "refusing to start" in done.stopped
    assert done.duration == 0.0
    np.testing.assert_array_equal(arena.q, before)


def test_letting_go_takes_simulated_time(arena: SimulatedArena) -> None:
    assert arena.release().duration == pytest.approx(LET_GO)


def test_the_picture_shows_something(arena: SimulatedArena) -> None:
    picture = arena.picture()
    assert picture.ndim == 3 and picture.shape[2] == 3
    assert picture.std() > 5.0
