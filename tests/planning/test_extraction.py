"""Ways out that are planned: proven, repeatable, rolled over where nothing else goes through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cartesian.corridor import SIDEWAYS_OFFSETS
from pickcli.cell.cell import Cell
from pickcli.collision.free_flyer import LINE_FOLLOWING_RESERVE, FreeItemChecker
from pickcli.errors import Failures
from pickcli.geometry import Array, pose
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.extraction import CorridorSet, Extraction, extraction_of
from pickcli.planning.stages.lift_sampling import IN_OPEN_BOX, IN_SHELF, LiftSpace, climbed
from pickcli.planning.stages.planned_extraction import MAX_LINES, OUT_OF_SHELF, planned_corridors
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.scene.unknown_space import UnknownSpace

BIN = "bin_E"


def ways_out(context: PlanningContext, *placed: tuple[str, Array], seed: int = 0) -> Extraction:
    """Of the first of the items (name, pose in the bin's frame)."""
    cell = context.cell
    T_bin = cell.T_world_place(cell.pod.bins[BIN])
    items = tuple(PlacedItem(name, cell.item(name), BIN, T_bin @ T) for name, T in placed)
    scene = Scene(cell, cell.T_world_pod, items, PoseNoise(0.002, float(np.radians(1.0))))
    return extraction_of(
        PickProblem(context, scene, cell.pod.bins[BIN], items[0], cell.places["tote"], seed=seed)
    )


def standing(cell: Cell, name: str, x: float, y: float) -> tuple[str, Array]:
    height = float(cell.item(name).shape.extents[2])
    return name, pose([x, y, cell.pod.bins[BIN].room.floor_back + height / 2 + 0.0005])


def lying_across(cell: Cell, name: str, x: float, y: float) -> tuple[str, Array]:
    radius = float(cell.item(name).shape.size[0])
    T = pose([x, y, cell.pod.bins[BIN].room.floor_back + radius + 0.0005], rpy=[np.pi / 2, 0.0, 0.0])
    return name, T


def planned(ways: Extraction, seed: int = 0) -> list[Array]:
    found = planned_corridors(
        OUT_OF_SHELF, ways.T_entry_item, ways.shape, ways.leaving, ways.carrying, ways.first_stretch, seed
    )
    return [np.stack([c.first_stretch, c.lift, *c.retreat]) for c in found]


@pytest.fixture(scope="module")
def behind(context: PlanningContext) -> Extraction:
    """A bottle that stands too tall to be lifted over the can that lies across in front of it."""
    cell = context.cell
    bottle = standing(cell, "up_glucose_bottle", 0.33, 0.0)
    return ways_out(context, bottle, lying_across(cell, "folgers_classic_roast_coffee", 0.2, 0.0))


@pytest.fixture(scope="module")
def overhung(context: PlanningContext) -> Extraction:
    """A carton on the floor of the tote, most of it under a box that reaches over it."""
    cell = context.cell
    tote = cell.places["tote"]
    floor = (cell.T_world_place(tote) @ [0.0, 0.0, tote.room.floor_back, 1.0])[2]
    middle = (cell.T_world_place(tote) @ [*(tote.room.low + tote.room.high)[:2] / 2, 0.0, 1.0])[:2]
    height = float(cell.item("crayola_24_ct").shape.extents[2])
    carton = pose([*middle, floor + height / 2 + 0.0005])
    box_height = float(cell.item("kleenex_tissue_box").shape.extents[2])
    box = pose([middle[0] + 0.05, middle[1], floor + height + box_height / 2 + 0.025])
    items = tuple(
        PlacedItem(name, cell.item(name), "tote", T)
        for name, T in (("crayola_24_ct", carton), ("kleenex_tissue_box", box))
    )
    scene = Scene(cell, cell.T_world_pod, items, PoseNoise(0.002, float(np.radians(1.0))))
    return extraction_of(PickProblem(context, scene, tote, items[0], cell.pod.bins[BIN]))


def test_out_of_an_open_box_it_is_led_out_from_under_what_reaches_over_it(overhung: Extraction) -> None:
    assert not isinstance(overhung.corridors, Failures)
    for corridor in overhung.corridors:
        D = np.stack([corridor.first_stretch, corridor.lift, *corridor.retreat])
        assert is_proven(overhung.leaving, overhung.carrying, D)
        assert D[0, 0] <= 0.0  # the entry's x points down
        assert np.linalg.norm(D[0, :3]) <= overhung.first_stretch + 1e-12
        assert np.abs(D[:, 1:3]).max() > max(SIDEWAYS_OFFSETS)


def test_what_pushes_others_aside_leaves_an_open_box_straight_up_or_not_at_all(overhung: Extraction) -> None:
    failures = replace(overhung, sparing=overhung).corridors
    assert isinstance(failures, Failures)
    assert failures.in_the_way == ("kleenex_tissue_box",)


def test_ways_without_pushing_are_preferred(context: PlanningContext) -> None:
    free = ways_out(context, standing(context.cell, "up_glucose_bottle", 0.1, 0.0))
    others = replace(free, first_stretch=free.first_stretch / 2)
    found, spared = replace(free, sparing=others).corridors, others.corridors
    assert not isinstance(found, Failures) and not isinstance(spared, Failures)
    assert [way.first_stretch.tolist() for way in found] == [way.first_stretch.tolist() for way in spared]
    both, alone = (each.transforms(CorridorSet.MANY) for each in (replace(free, sparing=others), others))
    assert not isinstance(both, Failures) and not isinstance(alone, Failures)
    assert len(both) > len(alone)  # those that push come after them


def is_proven(leaving: FreeItemChecker, carrying: FreeItemChecker, D: Array) -> bool:
    is_left = leaving.is_valid_path(np.stack([np.zeros(6), D[0]]))
    return is_left and carrying.is_valid_path(D)


def test_what_is_planned_is_proven_and_short(behind: Extraction) -> None:
    found = planned(behind)
    assert found
    for D in found:
        assert is_proven(behind.leaving, behind.carrying, D)
        assert np.linalg.norm(D[0, :3]) <= behind.first_stretch
        assert len(D) - 2 <= MAX_LINES


def test_a_bottle_is_rolled_over_where_it_is_too_tall_to_be_lifted(behind: Extraction) -> None:
    assert not isinstance(behind.corridors, Failures)
    for corridor in behind.corridors:
        assert max(abs(d[5]) for d in corridor.retreat) > np.radians(30.0)


def test_the_seed_of_a_query_decides_which_ways_are_planned(context: PlanningContext) -> None:
    bottle = standing(context.cell, "up_glucose_bottle", 0.33, 0.0)
    can = lying_across(context.cell, "folgers_classic_roast_coffee", 0.2, 0.0)
    first, again, other = (ways_out(context, bottle, can, seed=seed).corridors for seed in (1, 1, 2))
    assert (
        not isinstance(first, Failures)
        and not isinstance(again, Failures)
        and not isinstance(other, Failures)
    )
    assert np.array_equal(first[0].first_stretch, again[0].first_stretch)
    assert not np.array_equal(first[0].first_stretch, other[0].first_stretch)


def test_the_same_seed_gives_the_same_ways(behind: Extraction) -> None:
    first, again = planned(behind, 5), planned(behind, 5)
    assert len(first) == len(again)
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))


def test_what_is_built_in_has_no_way_out_and_says_by_what(context: PlanningContext) -> None:
    cell = context.cell
    target = standing(cell, "crayola_24_ct", 0.3, 0.0)
    cover = standing(cell, "peva_shower_curtain_liner", 0.25, 0.0)
    cover[1][2, 3] += float(cell.item("crayola_24_ct").shape.extents[2]) + 0.001
    failures = ways_out(context, target, cover).corridors
    assert isinstance(failures, Failures)
    assert failures.in_the_way == ("peva_shower_curtain_liner",)


@pytest.fixture(scope="module")
def mailer(context: PlanningContext) -> Extraction:
    """A mailer wider than the mouth of its bin, between walls that are 11 mm away."""
    cell = context.cell
    cell_bin = cell.pod.bins["bin_I"]
    T_bin = cell.T_world_place(cell_bin)
    item = cell.item("scotch_bubble_mailer")
    at = [0.33, sum(cell_bin.room.y_range) / 2, cell_bin.room.floor_back + item.shape.extents[2] / 2 + 0.0005]
    placed = PlacedItem(item.name, item, cell_bin.name, T_bin @ pose(at, rpy=[0.0, 0.0, np.pi / 2]))
    scene = Scene(cell, cell.T_world_pod, (placed,), PoseNoise(0.002, float(np.radians(1.0))))
    return extraction_of(PickProblem(context, scene, cell_bin, placed, context.cell.places["tote"]))


@pytest.mark.parametrize("within", [IN_SHELF, IN_OPEN_BOX])
def test_displacements_are_raised_along_gravity_and_nothing_else_changes(within: LiftSpace) -> None:
    rng = np.random.default_rng(3)
    D, rises = rng.uniform(-0.04, 0.04, (50, 6)), rng.uniform(0.0, 0.04, 50)
    raised = within.risen(D, rises)
    np.testing.assert_allclose(within.heights(raised), rises, atol=1e-15)
    k = int(np.argmax(np.abs(within.up)))
    np.testing.assert_array_equal(np.delete(raised, k, axis=1), np.delete(D, k, axis=1))


def test_first_stretches_that_are_climbed_to_are_proven_short_and_never_sink(mailer: Extraction) -> None:
    found = climbed(mailer.leaving, mailer.carrying, IN_SHELF, mailer.first_stretch, np.random.default_rng(0))
    assert found
    for d in found:
        assert is_proven(mailer.leaving, mailer.carrying, d[None])
        assert np.linalg.norm(d[:3]) <= mailer.first_stretch + 1e-12
        assert d[2] >= 0.0


def test_what_is_wider_than_the_mouth_goes_through_it_rolled(mailer: Extraction) -> None:
    found = planned(mailer)
    assert found
    width = float(mailer.shape.extents.max())
    for D in found:
        assert is_proven(mailer.leaving, mailer.carrying, D)
        assert np.abs(D[:, 5]).max() > np.arccos(mailer.place.access.width / width)


@pytest.mark.parametrize("beyond", [-1e-6, 1e-11, 1e-8, 1e-6, 1e-5, 5e-5, 1.2e-4, 1e-3])
def test_what_is_a_hair_beyond_what_lines_keep_off_does_not_hold_an_item_down(
    context: PlanningContext, beyond: float
) -> None:
    """Unknown space right under the thin floor: no edge is proven that begins at just the needed distance."""
    cell = context.cell
    below, (name, T) = cell.pod.bins["bin_H"], standing(cell, "crayola_24_ct", 0.2, 0.0)
    T_below = cell.T_world_place(below)
    noise = PoseNoise(0.002, float(np.radians(1.0)))
    placed = PlacedItem(name, cell.item(name), BIN, cell.T_world_place(cell.pod.bins[BIN]) @ T)
    bottom = float(placed.T_world_item[2, 3]) - float(placed.item.shape.extents[2]) / 2
    apart = cell.clearance + LINE_FOLLOWING_RESERVE + noise.bound(placed.item) + beyond
    top = bottom - apart - float(T_below[2, 3])
    middle = (np.linalg.inv(T_below) @ placed.T_world_item)[:2, 3]
    box = np.array([[[*(middle - 0.02), top - 0.05], [*(middle + 0.02), top]]])
    scene = Scene(cell, cell.T_world_pod, (placed,), noise, unknown=(UnknownSpace("bin_H", T_below, box),))
    problem = PickProblem(context, scene, cell.pod.bins[BIN], placed, cell.places["tote"], seed=0)
    assert not isinstance(extraction_of(problem).corridors, Failures)
