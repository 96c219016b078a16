"""Which targets a cell can pick, as everything lies and once the bin is cleared."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from bench import lances
from pickcli.cell.cell_file import load_cell
from pickcli.geometry import pose
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.trial.pose_noise import DEFAULT_NOISE

CELL = load_cell("apc2016_delft")
CARDS, BAR, DUMBBELL = "staples_index_cards", "dove_beauty_bar", "fitness_gear_3lb_dumbbell"


def test_a_target_is_held_planned_when_cleared_or_planned_as_it_lies(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only what is alone with what no tool holds is planned here."""
    T = CELL.T_world_place(CELL.pod.bins["bin_E"]) @ pose([0.2, 0.0, 0.05])
    items = tuple(PlacedItem(name, CELL.item(name, 2016), "bin_E", T) for name in (CARDS, BAR, DUMBBELL))
    scene = Scene(CELL, CELL.T_world_pod, items, PoseNoise())

    def alone(target: PlacedItem, left: Scene, warm: Sequence[PlanningContext]) -> bool:
        assert left.noise == DEFAULT_NOISE and warm
        return target.id != DUMBBELL and {p.id for p in left.items} == {target.id, DUMBBELL}

    monkeypatch.setattr(lances, "is_plannable", alone)
    warm = [PlanningContext(CELL)]
    found = {name: lances.judged([scene.find(name)], scene, warm) for name in (CARDS, DUMBBELL)}
    assert found == {CARDS: (True, True, False), DUMBBELL: (False, False, False)}
