"""What slumps in a box, judged by physics: it lets go of what is lifted, and stays in the box."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.planning.pick_settings import DEFAULTS
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import Scene
from pickcli.scene.touching import PosedSolids, gaps
from pickcli.statics.supports import supports_of
from pickcli.trial.order_file import read_order
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from support.lifting import lifted

CELL = load_cell("ur5e_crates")
HARMLESS = 0.5  # N: less counts as no contact


@cache
def heap(seed: int) -> Scene:
    """The items of the order that comes with the crates, heaped in both."""
    order = read_order(data_path() / "cells" / "ur5e_crates" / "moves_24.json", CELL)
    return make_scene(order.bin_contents, CELL, seed, order.year)


def keeps_clear(scene: Scene, name: str) -> frozenset[str]:
    """Items from which one keeps the clearance, as plans have to, when it was lifted by the first stretch."""
    index = [placed.id for placed in scene.items].index(name)
    solids = PosedSolids.of(scene, scene.items, ())
    solids.T[index, 2, 3] += DEFAULTS.first_stretch
    others = np.array([k for k in range(len(scene.items)) if k != index])
    width = gaps(solids, np.full(len(others), index), others).width
    return frozenset(scene.items[k].id for k in others[width >= CELL.clearance])


def check_heap(seed: int) -> int:
    """Lift whatever nothing blocks although something slumps, and count how much that was."""
    scene = heap(seed)
    supports, n_lifted = supports_of(perceive(scene, DEFAULT_NOISE, seed, 1)), 0
    for placed in scene.items:
        if supports.blocking(placed.id) or not supports.slumping(placed.id):
            continue
        found, clear = lifted(scene, placed.id, DEFAULTS.first_stretch), keeps_clear(scene, placed.id)
        pressing = {name: force for name, force in found.pressed.items() if force > HARMLESS}
        assert not pressing.keys() & clear, (seed, placed.id, pressing)
        assert found.out == (), (seed, placed.id)
        n_lifted += 1
    return n_lifted


@pytest.mark.slow
def test_what_slumps_lets_go_and_stays_in_the_box() -> None:
    assert check_heap(25) >= 3


@pytest.mark.slow
def test_what_slumps_lets_go_and_stays_in_the_box_in_any_heap() -> None:
    assert sum(check_heap(seed) for seed in range(40, 44)) >= 8


@pytest.mark.slow
def test_the_judge_sees_what_is_carried_along() -> None:
    """What lies on the item that is lifted presses on it, as what slumps does not."""
    scene = heap(25)
    supports = supports_of(scene)
    below = [placed.id for placed in scene.items if supports.graph.lying_on(placed.id)][:4]
    carried = [lifted(scene, name, DEFAULTS.first_stretch).pressed for name in below]
    assert sum(max(pressed.values(), default=0.0) > HARMLESS for pressed in carried) >= 3
