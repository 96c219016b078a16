"""Items that lean on purpose: at rest, between 3 and 20 degrees, apart, and the same from the same seed."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.errors import InputError, Reason
from pickcli.geometry import inverse, pose
from pickcli.random_scenes.bin_layout import ItemInstance
from pickcli.random_scenes.leaning_items import drawn_to_lean, leaning_items, leans
from pickcli.random_scenes.leaning_placements import LeanKind, lean_angle, leaning_stances
from pickcli.random_scenes.make_scene import make_scene
from pickcli.random_scenes.packing_search import fill
from pickcli.scene.scene import PlacedItem, Scene, empty_scene
from pickcli.scene.scene_file import read_scene, write_scene
from pickcli.scene.solid_overlap import PosedSolid, overlap_depth
from pickcli.simulation.places import bounds
from pickcli.simulation.settle import settle

CELL = load_cell("apc2016_delft")
BINS = sorted(CELL.pod.bins)
THIN = ["crayola_24_ct", "staples_index_cards", "laugh_out_loud_joke_book", "command_hooks"]
OTHERS = ["kleenex_tissue_box", "dove_beauty_bar", "easter_turtle_sippy_cup"]


def tilt(placed: PlacedItem, scene: Scene) -> float:
    """Degrees between the vertical of the world and the nearest axis of an item."""
    upright = np.abs(placed.T_world_item[2, :3]).max()
    assert scene.T_world_pod[2, 2] == 1.0
    return float(np.degrees(np.arccos(upright)))


@given(
    st.sampled_from(BINS),
    st.lists(st.sampled_from(THIN), min_size=1, max_size=2, unique=True),
    st.lists(st.sampled_from(OTHERS), max_size=2, unique=True),
    st.integers(0, 10**6),
)
@settings(max_examples=12, deadline=None)
def test_what_is_drawn_to_lean_rests_apart_inside_at_its_angle(
    bin_name: str, thin: list[str], others: list[str], seed: int
) -> None:
    names = [*others, *thin]
    scene = make_scene({bin_name: names}, CELL, seed, leaning_share=1.0)
    place = CELL.places[bin_name]
    assert sorted(placed.id for placed in scene.items) == sorted(names)
    leaning = leaning_items(scene)
    assert set(leaning) <= set(names)  # what finds no place to lean at stands or lies
    for placed in scene.items:
        if placed.id in leaning:
            # The floor slopes by less than 5 degrees, and the angle is against the floor.
            assert 3.0 < np.degrees(leaning[placed.id]) <= 20.0
            assert abs(tilt(placed, scene) - np.degrees(leaning[placed.id])) < 5.0
        low, high = bounds(placed.item.shape, inverse(scene.T_world_place(place)) @ placed.T_world_item)
        assert low[0] >= 0.0 and high[0] <= place.room.depth + 1e-3
    again = settle(scene, scene.items)
    assert not isinstance(again, Reason)
    for before, after in zip(scene.items, again, strict=True):
        assert np.linalg.norm(before.T_world_item[:3, 3] - after.T_world_item[:3, 3]) < 1e-3
    solids = [PosedSolid(placed.item.shape, placed.T_world_item) for placed in scene.items]
    boards = [PosedSolid(body.shape, scene.T_world_pod @ body.T_parent_shape) for body in CELL.pod.bodies]
    assert all(overlap_depth(a, b) == 0.0 for a, b in combinations(solids, 2))
    assert all(overlap_depth(a, b) == 0.0 for a in solids for b in boards)


@pytest.mark.parametrize("name", ["jane_eyre_dvd", "laugh_out_loud_joke_book"])
@pytest.mark.parametrize("bin_name", ["bin_D", "bin_K"])
def test_a_book_alone_finds_a_wall_to_lean_on(name: str, bin_name: str) -> None:
    for seed in range(3):
        scene = make_scene({bin_name: [name]}, CELL, seed, leaning_share=1.0)
        assert set(leaning_items(scene)) == {name}


def test_one_seed_one_file_that_can_be_read_and_without_a_share_none_leans(tmp_path: Path) -> None:
    contents = {"bin_E": ["kleenex_tissue_box", *THIN[:2]]}
    leaning, again = (make_scene(contents, CELL, 7, leaning_share=1.0) for _ in range(2))
    upright, as_before = make_scene(contents, CELL, 7, leaning_share=0.0), make_scene(contents, CELL, 7)
    files = []
    for k, scene in enumerate((leaning, again, upright, as_before)):
        write_scene(scene, tmp_path / f"{k}.json")
        files.append((tmp_path / f"{k}.json").read_bytes())
    assert files[0] == files[1] != files[2] == files[3]
    assert leaning_items(leaning) and not leaning_items(upright)
    assert leaning_items(read_scene(tmp_path / "0.json", CELL)) == pytest.approx(leaning_items(leaning))


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("staples_index_cards", set(LeanKind)),
        ("i_am_a_bunny_book", {LeanKind.PROPPED}),  # too thin to stand on an edge
        ("kleenex_tissue_box", set()),  # falls back from 20 degrees
        ("dasani_water_bottle", set()),  # rolls
        ("cherokee_easy_tee_shirt", set()),  # folded: slumps
    ],
)
def test_what_can_lean_is_thin_and_rigid(name: str, kinds: set[LeanKind]) -> None:
    assert {kind for kind in LeanKind if leaning_stances(CELL.item(name), kind)} == kinds


def test_a_stance_leans_farther_than_its_middle_is_over_its_edge() -> None:
    for item in CELL.items.values():
        for kind in (LeanKind.WALL, LeanKind.NEIGHBOUR):
            for stance in leaning_stances(item, kind):
                assert np.tan(stance.least_angle) > stance.length / stance.height


@pytest.mark.parametrize("kind", list(LeanKind))
@pytest.mark.parametrize("seed", [1, 2])
def test_each_way_of_leaning_comes_to_rest_as_drawn(kind: LeanKind, seed: int) -> None:
    """A high box and a low one to lean on; each way leans on what it says."""
    place = CELL.places["bin_E"]
    names = ["fitness_gear_3lb_dumbbell", "kleenex_tissue_box", "dove_beauty_bar", "staples_index_cards"]
    items = [CELL.item(name) for name in names]
    packings = fill(place, items, np.random.default_rng(seed), leaning={3: [kind]})
    full = np.flatnonzero(packings.is_full())
    best = int(full[np.argmin(packings.cost[full])])
    onto = int(packings.lying.leans_on[best, 3])
    assert (onto == -1) if kind is LeanKind.WALL else (onto in (0, 1, 2))
    empty = empty_scene(CELL)
    T = empty.T_world_place(place)
    laid = tuple(
        PlacedItem(name, item, place.name, T @ T_bin)
        for name, item, T_bin in zip(names, items, packings.poses(best), strict=True)
    )
    rested = settle(empty, laid)
    assert not isinstance(rested, Reason)
    assert leans(empty, place, rested[3])
    touching = {
        names[k]
        for k in range(3)
        if overlap_depth(
            PosedSolid(items[k].shape.inflated(0.002), rested[k].T_world_item),
            PosedSolid(items[3].shape, rested[3].T_world_item),
        )
        > 0.0
    }
    assert touching == (set() if onto == -1 else {names[onto]})


def test_angles_are_against_the_floor() -> None:
    """On the slope of a bin's floor what lies flat leans by nothing."""
    place = CELL.places["bin_E"]
    room = place.room
    slope = np.arctan2(room.floor_front - room.floor_back, room.floor_flat_from - room.slope_from)
    on_slope = pose((0.1, 0.0, 0.0), rpy=(0.0, slope, 0.0)) @ pose((0.0, 0.0, 0.0), rpy=(0.0, 0.0, 0.4))
    assert lean_angle(place, on_slope) == pytest.approx(0.0, abs=1e-6)
    assert lean_angle(place, pose((0.1, 0.0, 0.0))) == pytest.approx(slope)
    level = pose((0.3, 0.0, 0.0), rpy=(np.radians(90.0 - 12.0), 0.0, 0.0))
    assert lean_angle(place, level) == pytest.approx(np.radians(12.0))


def test_a_floor_without_a_slope_is_level() -> None:
    shelf = load_cell("ur5e_crates").places["shelf_1_2"]
    assert lean_angle(shelf, pose((0.1, 0.0, 0.05))) == pytest.approx(0.0, abs=1e-6)


def test_fewer_are_tried_to_lean_and_in_a_box_open_above_none() -> None:
    contents = [ItemInstance(name, CELL.item(name)) for name in (*THIN, "rawlings_baseball")]
    drawn = list(drawn_to_lean(CELL.places["bin_A"], contents, 1, 1.0))
    assert [sorted(each) for each in drawn] == [[0, 1, 2, 3], [0, 1, 2, 3], [0, 1, 2], [0, 1], [0]]
    assert all(len(kinds) == 1 for kinds in drawn[0].values())
    assert not list(drawn_to_lean(CELL.places["bin_A"], contents, 1, 0.0))
    assert not list(drawn_to_lean(CELL.places["tote"], contents, 1, 1.0))


@pytest.mark.parametrize("share", [-0.1, 1.5, float("nan")])
def test_a_share_that_is_none_is_refused(share: float) -> None:
    with pytest.raises(InputError, match=r"leaning_share: .* give a number from 0 to 1"):
        make_scene({"bin_A": THIN}, CELL, 1, leaning_share=share)
