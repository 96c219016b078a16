"""Items in places of a cell's own: heaps in boxes, side by side on tables, stowed in shelves, all at rest."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import InputError
from pickcli.geometry import inverse
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.scene.solid_overlap import PosedSolid, overlap_depth
from support.cell_copies import CellCopy
from support.place_cells import BENCH, CRATES, RACK, with_places

CONTENTS = {
    "crate_left": (
        *("dove_beauty_bar", "crayola_24_ct", "rawlings_baseball"),
        *("dove_beauty_bar", "oral_b_toothbrush_red"),
    ),
    "bench": ("dove_beauty_bar", "expo_dry_erase_board_eraser"),
    "rack_1_2": ("crayola_24_ct",),
}  # fmt: skip


@pytest.fixture
def own(cell_copy: CellCopy) -> Cell:
    return with_places(cell_copy, CRATES, RACK, BENCH).load()


def refuse_overlaps(scene: Scene) -> None:
    solids = [PosedSolid(each.item.shape, each.T_world_item) for each in scene.items]
    assert all(overlap_depth(a, b) == 0.0 for k, a in enumerate(solids) for b in solids[:k])


def test_everything_lies_in_its_place_and_nothing_in_something_else(own: Cell) -> None:
    scene = make_scene(CONTENTS, own, seed=4)
    assert {name: len(scene.in_location(name)) for name in CONTENTS} == {
        name: len(names) for name, names in CONTENTS.items()
    }
    for placed in scene.items:
        place = own.places[placed.location]
        T = inverse(scene.T_world_place(place)) @ placed.T_world_item
        reach = placed.item.shape.reach(T[:3, :3])
        assert place.holds(T[:3, 3], above=0.1)
        assert T[2, 3] - reach[2] > place.room.floor_back - 1e-3
    refuse_overlaps(scene)


def test_on_a_table_there_is_room_between_items(own: Cell) -> None:
    one, other = make_scene({"bench": CONTENTS["bench"]}, own, seed=5).items
    apart = np.linalg.norm((one.T_world_item - other.T_world_item)[:2, 3])
    assert apart > 0.05
    assert abs(one.T_world_item[2, 3] - one.item.shape.reach(one.T_world_item[:3, :3])[2] - 0.75) < 2e-3


def test_a_place_looks_the_same_whatever_the_others_hold(own: Cell) -> None:
    crate = {"crate_left": CONTENTS["crate_left"][:3]}
    both = make_scene(crate | {"bench": CONTENTS["bench"]}, own, seed=6)
    alone, again, other = (make_scene(crate, own, seed) for seed in (6, 6, 7))
    assert scene_hash(alone) == scene_hash(again) != scene_hash(other)
    for a, b in zip(alone.items, both.in_location("crate_left"), strict=True):
        assert np.array_equal(a.T_world_item, b.T_world_item)


def test_what_finds_no_room_is_told(own: Cell) -> None:
    with pytest.raises(InputError, match="bench: its 30 items do not fit at rest"):
        make_scene({"bench": ["expo_dry_erase_board_eraser"] * 30}, own, seed=1)
