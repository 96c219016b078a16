"""Scenes made from orders: at rest, the same bytes for the same seed, bins of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.station import POD
from pickcli.errors import InputError, Reason, UnknownNameError
from pickcli.geometry import inverse
from pickcli.progress import Progress
from pickcli.random_scenes.make_scene import MAX_ITEMS, make_scene, refuse_too_much
from pickcli.scene.scene import CarrierPose, Scene
from pickcli.scene.scene_file import read_scene, write_scene
from pickcli.scene.solid_overlap import PosedSolid, overlap_depth
from pickcli.simulation.engine import Engine
from pickcli.simulation.places import bounds
from pickcli.simulation.reality import DEFAULT
from pickcli.simulation.scene_bodies import add_items, add_statics, true_masses
from pickcli.simulation.settle import settle
from pickcli.simulation.world import TIME_STEP
from pickcli.trial.make_order import make_order
from pickcli.trial.order import OrderKind
from pickcli.trial.order_file import read_order
from pickcli.trial.pod_shift import RANDOM, pod_pose

CELL = load_cell("apc2016_delft")
SMALL = {
    "bin_A": ["crayola_24_ct", "kleenex_tissue_box"],
    "bin_F": ["dasani_water_bottle", "crayola_24_ct", "rawlings_baseball"],
    "bin_L": [],
}
TASKS = Path(__file__).parents[2] / "data" / "tasks"


def made(contents: Mapping[str, Sequence[str]], seed: int = 1) -> Scene:
    return make_scene(contents, CELL, seed)


def moved_awake(scene: Scene, duration: float) -> float:
    """How far in m the item that moves most gets in a world that never lets it sleep."""
    engine = Engine(TIME_STEP)
    try:
        add_statics(engine, scene)
        add_items(engine, scene, true_masses(scene, DEFAULT, 0))
        for _ in range(round(duration / 0.05)):
            for placed in scene.items:
                engine.wake(placed.id)
            for _ in range(round(0.05 / TIME_STEP)):
                engine.step()
        moved = [np.linalg.norm(engine.pose(p.id)[:3, 3] - p.T_world_item[:3, 3]) for p in scene.items]
    finally:
        engine.close()
    return float(max(moved))


@pytest.fixture(scope="module")
def small() -> Scene:
    return made(SMALL)


def test_every_item_of_the_order_is_there_once(small: Scene) -> None:
    for name, items in SMALL.items():
        assert sorted(placed.item.name for placed in small.in_location(name)) == sorted(items)
    assert {placed.id for placed in small.items} >= {"crayola_24_ct", "crayola_24_ct#2"}


def test_what_was_made_is_at_rest(small: Scene) -> None:
    for name, items in SMALL.items():
        placed = small.in_location(name)
        again = settle(small, placed)
        assert len(placed) == len(items) and not isinstance(again, Reason)
        for before, after in zip(placed, again, strict=True):
            assert np.linalg.norm(before.T_world_item[:3, 3] - after.T_world_item[:3, 3]) < 1e-3


def test_one_seed_one_file_and_another_seed_another(small: Scene, tmp_path: Path) -> None:
    paths = [tmp_path / f"{k}.json" for k in range(3)]
    for path, scene in zip(paths, (small, made(SMALL), made(SMALL, 2)), strict=True):
        write_scene(scene, path)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert paths[0].read_bytes() != paths[2].read_bytes()


def test_a_bin_does_not_depend_on_the_others(small: Scene) -> None:
    alone = made({"bin_A": SMALL["bin_A"]})
    assert len(alone.items) == len(SMALL["bin_A"])
    for placed in alone.items:
        np.testing.assert_array_equal(placed.T_world_item, small.find(placed.id, "bin_A").T_world_item)


def test_too_much_for_a_bin_is_an_error_that_names_it() -> None:
    """Two rolls of 150 mm side by side are wider than any bin, and on each other they are higher."""
    with pytest.raises(InputError, match=r"bin_H.*2 items do not fit at rest.*take another seed"):
        made({"bin_H": ["kleenex_paper_towels"] * 2})


@pytest.mark.slow
@pytest.mark.parametrize("order_name", ["jsk_pick_sample", "kth_2015_example"])
def test_a_whole_pod_stands_inside_and_mostly_on_the_floor(order_name: str) -> None:
    order = read_order(TASKS / f"{order_name}.json", CELL)
    scene = make_scene(order.bin_contents, CELL, 3, order.year)
    assert len(scene.items) == sum(len(names) for names in order.bin_contents.values())
    for name, cell_bin in CELL.pod.bins.items():
        here = scene.in_location(name)
        T_bin_world = inverse(scene.T_world_place(cell_bin))
        spans = [bounds(placed.item.shape, T_bin_world @ placed.T_world_item) for placed in here]
        assert all(low[0] >= 0.0 and high[0] <= cell_bin.room.depth + 1e-3 for low, high in spans)
        if len(here) <= 3:
            assert all(low[2] < cell_bin.room.floor_front for low, _ in spans), (
                f"{name}: something lies on others"
            )


def test_more_than_a_bin_has_room_for_is_refused_at_once() -> None:
    with pytest.raises(InputError, match=r"bin_A: its 40 items take 65.8 litres, the place has 31.6"):
        made({"bin_A": ["kleenex_tissue_box"] * 40})


def test_more_items_than_are_laid_out_are_refused_at_once() -> None:
    small = min(CELL.items.values(), key=lambda item: item.shape.volume).name
    with pytest.raises(
        InputError, match=f"bin_A: its {MAX_ITEMS + 1} items are more than are laid out in one"
    ):
        made({"bin_A": [small] * (MAX_ITEMS + 1)})


@pytest.mark.parametrize("size", [(0.3, 0.3, 0.3), (0.01, 0.01, 0.6)])
def test_what_is_larger_than_its_bin_is_refused_at_once(size: tuple[float, float, float]) -> None:
    shape = Shape(ShapeKind.BOX, size)
    large = replace(CELL.item("kleenex_tissue_box"), shape=shape, year=2016)
    cell = replace(CELL, items={**CELL.items, ("kleenex_tissue_box", 2016): large})
    with pytest.raises(InputError, match=r"order: bin_D: kleenex_tissue_box fits in no way: .* mm inside"):
        refuse_too_much({"bin_D": ["kleenex_tissue_box"]}, cell, 2016, "order")
    refuse_too_much({name: ["kleenex_paper_towels"] for name in CELL.pod.bins}, CELL, 2016, "order")


def fullest_bin(seed: int) -> dict[str, tuple[str, ...]]:
    """The bin of a fresh order that has the least air left."""
    bins = make_order(OrderKind.PICK, 2016, seed).bin_contents
    name = max(bins, key=lambda name: sum(CELL.item(item).shape.volume for item in bins[name]))
    return {name: bins[name]}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [6001, 6008])
def test_a_crowded_bin_is_stowed_inside_apart_and_at_rest_and_again_to_the_same_bytes(
    seed: int, tmp_path: Path
) -> None:
    """Each of these holds paper towels that leave too little width for what else there is to lie flat."""
    contents = fullest_bin(seed)
    scene = made(contents, seed)
    (name,) = contents
    assert sorted(placed.item.name for placed in scene.in_location(name)) == sorted(contents[name])
    solids = [PosedSolid(placed.item.shape, placed.T_world_item) for placed in scene.items]
    boards = [PosedSolid(body.shape, scene.T_world_pod @ body.T_parent_shape) for body in CELL.pod.bodies]
    assert max(overlap_depth(a, b) for a, b in combinations(solids, 2)) == 0.0
    assert max(overlap_depth(a, b) for a in solids for b in boards) == 0.0
    assert moved_awake(scene, 2.0) < 1e-3
    for path, one in zip((tmp_path / "1", tmp_path / "2"), (scene, made(contents, seed)), strict=True):
        write_scene(one, path)
    assert (tmp_path / "1").read_bytes() == (tmp_path / "2").read_bytes()


def test_a_scene_of_heavy_things_on_soft_ones_can_be_read_again(tmp_path: Path) -> None:
    """In its first layout a roll stood 1.8 mm deep in gloves, which the engine's contacts did not tell."""
    names = ["womens_knit_gloves", "barkely_hide_bones", "dasani_water_bottle", "kleenex_paper_towels"]
    write_scene(make_scene({"bin_K": names}, CELL, 20004), tmp_path / "scene.json")
    assert len(read_scene(tmp_path / "scene.json", CELL).items) == 4


@pytest.mark.slow
def test_make_scene_leaves_no_pile_that_creeps() -> None:
    """Nine items; in one layout that seemed at rest they crept while awake, and fell within a trial."""
    names = [
        "laugh_out_loud_joke_book", "peva_shower_curtain_liner", "i_am_a_bunny_book",
        "oral_b_toothbrush_green", "kleenex_paper_towels", "expo_dry_erase_board_eraser",
        "staples_index_cards", "safety_first_outlet_plugs", "barkely_hide_bones",
    ]  # fmt: skip
    T_world_pod = pod_pose(RANDOM, CELL, 9103)
    scene = make_scene({"bin_F": names}, CELL, 9103, carriers={POD: CarrierPose(T_world_pod)})
    assert moved_awake(scene, 5.0) < 5e-3  # awake all the time, which a pile in a trial is not; 1.4 m before


@pytest.mark.parametrize(
    ("bin_name", "items", "seed"),
    [
        (
            "bin_E",
            "kleenex_paper_towels peva_shower_curtain_liner elmers_washable_no_run_school_glue jane_eyre_dvd "
            "i_am_a_bunny_book",
            951002,
        ),
        (
            "bin_I",
            "fiskars_scissors_red scotch_bubble_mailer kleenex_tissue_box peva_shower_curtain_liner "
            "dove_beauty_bar rawlings_baseball staples_index_cards",
            951004,
        ),
    ],
)
def test_what_is_loaded_into_another_world_stays(bin_name: str, items: str, seed: int) -> None:
    """These layouts stood only on contacts that had formed as they came to rest."""
    assert moved_awake(made({bin_name: items.split()}, seed), 1.0) < 1e-3


def test_progress_is_told_inside_the_search_for_one_bin_and_decides_nothing() -> None:
    contents = {"bin_D": ("dove_beauty_bar", "crayola_24_ct")}
    told: list[Progress] = []
    scene = make_scene(contents, CELL, 3, on_progress=told.append)
    assert set(told) == {Progress(0, 1, "bin_D")} and len(told) > 20
    same = make_scene(contents, CELL, 3)
    assert len(scene.items) == 2
    for a, b in zip(scene.items, same.items, strict=True):
        assert np.array_equal(a.T_world_item, b.T_world_item)


def test_a_place_that_is_none_and_a_name_in_place_of_names_are_refused(cell: Cell) -> None:
    with pytest.raises(UnknownNameError, match="unknown place 'bin_c'; did you mean 'bin_C'"):
        make_scene({"bin_c": ["dove_beauty_bar"]}, cell, 1)
    with pytest.raises(InputError, match="bin_C: expected a list of items, got 'dove_beauty_bar'"):
        make_scene({"bin_C": "dove_beauty_bar"}, cell, 1)
