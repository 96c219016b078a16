"""Layouts: every one another, the best first, none where the items find no room."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from pickcli.cell.cell_file import load_cell
from pickcli.random_scenes.bin_layout import ItemInstance, lay_out
from pickcli.random_scenes.packing_search import fill
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene

CELL = load_cell("apc2016_delft")
EMPTY = Scene(CELL, CELL.T_world_pod, (), PoseNoise())


def contents(*names: str) -> list[ItemInstance]:
    return [ItemInstance(name, CELL.item(name)) for name in names]


def poses(layout: tuple[PlacedItem, ...]) -> np.ndarray:
    return np.array([placed.T_world_item for placed in layout])


def test_no_layout_is_given_twice_though_the_search_holds_copies_of_the_best() -> None:
    wanted = contents("hanes_tube_socks", "peva_shower_curtain_liner", "jane_eyre_dvd", "rawlings_baseball")
    numbers, copied = set(), 0
    for seed in range(6):
        fillings = fill(CELL.pod.bins["bin_D"], [c.item for c in wanted], np.random.default_rng(seed))
        best = np.sort(fillings.cost[fillings.is_full()])[:3]
        copied += len(np.unique(best)) < len(best)
        layouts = lay_out(EMPTY, "bin_D", wanted, seed)
        numbers.add(len(layouts))
        assert all(not np.array_equal(poses(a), poses(b)) for a, b in combinations(layouts, 2))
    assert copied > 0 and len(numbers) > 1


def test_the_first_layout_is_the_cheapest_filling() -> None:
    wanted = contents("crayola_24_ct", "kleenex_tissue_box", "dove_beauty_bar")
    fillings = fill(CELL.pod.bins["bin_E"], [c.item for c in wanted], np.random.default_rng(4))
    best = int(np.argmin(np.where(fillings.is_full(), fillings.cost, np.inf)))
    T_world_bin = EMPTY.T_world_place(CELL.pod.bins["bin_E"])
    first = lay_out(EMPTY, "bin_E", wanted, 4)[0]
    np.testing.assert_allclose(poses(first), T_world_bin @ fillings.poses(best), atol=1e-12)


def test_two_rolls_that_are_wider_than_the_bin_have_no_layout() -> None:
    rolls = [ItemInstance(f"roll {k}", CELL.item("kleenex_paper_towels")) for k in range(2)]
    assert lay_out(EMPTY, "bin_D", rolls, 1) == []
