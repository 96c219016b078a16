"""Scenes made of orders: what lies where, at rest, the same every time."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.load import load_cell
from pickcli.cell.model import Cell
from pickcli.cell.scene import Scene
from pickcli.cell.scene_file import read_scene, scene_hash, write_scene
from pickcli.errors import InputError, Reason, UnknownNameError
from pickcli.simulation.places import bounds
from pickcli.simulation.settle import settle
from pickcli.trial.make_scene import make_scene

FEW = {"bin_A": ("crayola_24_ct", "dasani_water_bottle"), "bin_E": ("rawlings_baseball",), "bin_L": ()}
FULL = (  # bin_H of the second of Delft's orders
    "i_am_a_bunny_book",
    "creativity_chenille_stems",
    "dasani_water_bottle",
    "kyjen_squeakin_eggs_plush_puppies",
    "scotch_bubble_mailer",
    "staples_index_cards",
    "scotch_duct_tape",
    "up_glucose_bottle",
    "kleenex_paper_towels",
)


@pytest.fixture(scope="module")
def cell() -> Cell:
    return load_cell("apc2016_delft")


def assert_in_bins_at_rest(scene: Scene) -> None:
    for name, cell_bin in scene.cell.pod.bins.items():
        items = scene.in_location(name)
        for placed in items:
            low, high = bounds(placed.item.shape, np.linalg.inv(cell_bin.T_pod_bin) @ placed.T_world_item)
            assert low[0] > 0.0, f"{placed.id} sticks out"
            assert high[0] < cell_bin.depth + 1e-3
            assert cell_bin.y_range[0] - 1e-3 < low[1] and high[1] < cell_bin.y_range[1] + 1e-3
        again = settle(scene, items)
        assert not isinstance(again, Reason), str(again)
        for before, after in zip(items, again, strict=True):
            assert np.linalg.norm(after.T_world_item[:3, 3] - before.T_world_item[:3, 3]) < 1e-3


def test_every_item_lies_at_rest_in_its_bin(cell: Cell) -> None:
    scene = make_scene(FEW, cell, seed=1)
    assert {name: Counter(p.item.name for p in scene.in_location(name)) for name in FEW} == {
        name: Counter(names) for name, names in FEW.items()
    }
    assert_in_bins_at_rest(scene)
    assert scene.noise.position == 0.0


@pytest.mark.slow
def test_nine_items_fit_a_bin(cell: Cell) -> None:
    assert_in_bins_at_rest(make_scene({"bin_H": FULL}, cell, seed=2))


def test_one_seed_one_scene(cell: Cell) -> None:
    one, same, other = (make_scene(FEW, cell, seed) for seed in (1, 1, 2))
    poses = [np.array([p.T_world_item for p in scene.items]).tobytes() for scene in (one, same, other)]
    assert poses[0] == poses[1] != poses[2]


def test_a_bin_looks_the_same_whatever_the_others_hold(cell: Cell) -> None:
    alone = make_scene({"bin_E": FEW["bin_E"]}, cell, seed=1)
    among = make_scene(FEW, cell, seed=1)
    assert np.array_equal(alone.items[0].T_world_item, among.find("rawlings_baseball").T_world_item)


def test_copies_get_ids_of_their_own(cell: Cell) -> None:
    scene = make_scene({"bin_A": ("crayola_24_ct",) * 2, "bin_B": ("crayola_24_ct",)}, cell, seed=1)
    assert sorted(p.id for p in scene.items) == ["crayola_24_ct", "crayola_24_ct#2", "crayola_24_ct#3"]


def test_the_year_decides_the_figures(cell: Cell) -> None:
    sizes = [
        make_scene({"bin_A": ("laugh_out_loud_joke_book",)}, cell, 1, year).items[0].item.shape.size
        for year in (2015, 2016)
    ]
    assert sizes[0] != sizes[1]


@pytest.mark.slow
def test_what_does_not_fit_names_the_bin(cell: Cell) -> None:
    with pytest.raises(InputError, match="bin_D"):
        make_scene({"bin_D": ("kleenex_paper_towels", "hanes_tube_socks", "kleenex_tissue_box") * 2}, cell, 1)


def test_unknown_items_are_named(cell: Cell) -> None:
    with pytest.raises(UnknownNameError, match="crayola_24_ct"):
        make_scene({"bin_A": ("crayola_24",)}, cell, 1)


def test_a_scene_survives_its_file(cell: Cell, tmp_path: Path) -> None:
    scene = make_scene(FEW, cell, seed=1)
    write_scene(scene, tmp_path / "scene.json")
    assert scene_hash(read_scene(tmp_path / "scene.json", cell)) == scene_hash(scene)


def test_progress_is_told(cell: Cell) -> None:
    told: list[tuple[int, int, str]] = []
    make_scene(FEW, cell, 1, on_progress=lambda done, total, what: told.append((done, total, what)))
    assert told == [(0, 3, "bin_A"), (1, 3, "bin_E"), (2, 3, "bin_L")]
