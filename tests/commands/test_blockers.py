"""Advice on picks without a plan: what removing the items in the way is worth."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.errors import NoExtractionError, NoPlanError, Reason
from pickcli.geometry import pose
from pickcli.motion.plan import Plan
from pickcli.planning.blockers import with_blockers
from pickcli.planning.pick_problem import PickQuery
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_file import write_scene
from support.command_line import apc

TARGET, BOX, HOOKS, GLUE = "crayola_24_ct", "kleenex_tissue_box", "command_hooks", "dove_beauty_bar"
BOOK = "i_am_a_bunny_book"


def scene_of(cell: Cell, *names: str) -> Scene:
    T = cell.T_world_place(cell.pod.bins["bin_E"])
    items = tuple(
        PlacedItem(name, cell.item(name), "bin_E", T @ pose([0.1 + 0.1 * k, 0.0, 0.05]))
        for k, name in enumerate(names)
    )
    return Scene(cell, cell.T_world_pod, items, PoseNoise())


def blamed(query: PickQuery, *names: str) -> NoPlanError:
    reasons = [Reason("no way out", "lift", "too near", name) for name in names]
    return NoPlanError(f"pick {query.item}", reasons)


def planning(free_without: set[str], stuck: set[str], *blame: str):  # type: ignore[no-untyped-def]
    """Planning that finds the target when some items are gone, and others unless they are stuck."""

    def plan_in(scene: Scene, query: PickQuery) -> Plan:
        here = {placed.id for placed in scene.items}
        if (free_without & here) if query.item == TARGET else query.item in stuck:
            raise blamed(query, *(name for name in blame if name in here))
        return None  # type: ignore[return-value]

    return plan_in


@pytest.mark.parametrize(
    ("needed", "blame", "stuck", "told"),
    [
        ({BOX}, (BOX,), set(), f"without {BOX} there is a plan"),
        ({BOX}, (HOOKS, BOX), set(), f"without {BOX} there is a plan"),
        ({BOX, HOOKS}, (BOX, HOOKS), set(), f"without {BOX} and {HOOKS} there is a plan"),
        ({BOX}, (BOX,), {BOX}, f"without {BOX} there is a plan, but {BOX} cannot be picked either"),
        ({BOX, HOOKS}, (BOX, HOOKS), {BOX, HOOKS},
         f"without {BOX} and {HOOKS} there is a plan, but {BOX} and {HOOKS} cannot be picked either"),
    ],
)  # fmt: skip
def test_the_items_that_matter_are_named_and_those_that_are_stuck_themselves(
    cell: Cell, needed: set[str], blame: tuple[str, ...], stuck: set[str], told: str
) -> None:
    scene, query = scene_of(cell, TARGET, BOX, HOOKS), PickQuery("bin_E", TARGET)
    error = with_blockers(blamed(query, *blame), planning(needed, stuck, *blame), scene, [query])
    assert str(error).splitlines()[-1] == told and set(error.blockers) == needed
    assert len(error.reasons) == len(blame)


def test_several_destinations_are_all_planned_without_the_items_and_the_lines_of_each_are_kept(
    cell: Cell,
) -> None:
    scene = scene_of(cell, TARGET, BOX)
    queries = [PickQuery("bin_E", TARGET, into=name) for name in ("bin_A", "bin_B")]
    failed = [(query.into, blamed(query, BOX)) for query in queries]
    error = NoPlanError.of_alternatives(f"stow {TARGET}", failed)
    into_second = planning({BOX}, set(), BOX)

    def plan_in(scene: Scene, query: PickQuery) -> Plan:
        if query.into == "bin_A":
            raise blamed(query, GLUE)
        return into_second(scene, query)  # type: ignore[no-any-return]

    told = with_blockers(error, plan_in, scene, queries)
    assert told.blockers == (BOX,)
    lines = str(told).splitlines()
    assert lines[-1] == f"without {BOX} there is a plan"
    assert [line.split(":")[0].strip() for line in lines[1:-1]] == ["bin_A", "bin_B"]


def test_what_can_be_brought_to_another_of_the_destinations_is_not_stuck(cell: Cell) -> None:
    there = scene_of(cell, TARGET, BOX)
    scene = replace(there, items=tuple(replace(placed, location=TOTE) for placed in there.items))
    queries = [PickQuery(TOTE, TARGET, into=name) for name in ("bin_A", "bin_B")]
    only_into_b, nowhere = planning({BOX}, set(), BOX), planning({BOX}, {BOX}, BOX)

    def plan_in(scene: Scene, query: PickQuery) -> Plan:
        return (only_into_b if query.into == "bin_B" else nowhere)(scene, query)  # type: ignore[no-any-return]

    told = with_blockers(blamed(queries[0], BOX), plan_in, scene, queries)
    assert str(told).splitlines()[-1] == f"without {BOX} there is a plan"
    told = with_blockers(blamed(queries[0], BOX), nowhere, scene, queries)
    assert str(told).endswith(f"but {BOX} cannot be picked either")


def test_the_type_of_the_error_is_kept(cell: Cell) -> None:
    scene, query = scene_of(cell, TARGET, BOX), PickQuery("bin_E", TARGET)
    stuck = NoExtractionError("pick", blamed(query, BOX).reasons)
    assert isinstance(with_blockers(stuck, planning({BOX}, set(), BOX), scene, [query]), NoExtractionError)


@pytest.mark.parametrize("blame", [(), (BOX, HOOKS)])
def test_where_removing_items_does_not_help_nothing_is_advised(cell: Cell, blame: tuple[str, ...]) -> None:
    scene, query = scene_of(cell, TARGET, BOX, HOOKS), PickQuery("bin_E", TARGET)
    error = blamed(query, *blame)
    assert with_blockers(error, planning({TARGET}, set(), *blame), scene, [query]) is error


def test_a_pick_behind_a_box_says_that_the_box_has_to_go(cell: Cell, tmp_path: Path) -> None:
    room, T = cell.pod.bins["bin_E"].room, cell.T_world_place(cell.pod.bins["bin_E"])

    def on_floor(name: str, x: float) -> PlacedItem:
        z = room.floor_back + float(cell.item(name).shape.extents[2]) / 2 + 0.0005
        return PlacedItem(name, cell.item(name), "bin_E", T @ pose([x, 0.0, z]))

    scene, out = tmp_path / "scene.json", tmp_path / "plan.json"
    items = (on_floor(GLUE, 0.38), on_floor(BOX, 0.27))
    write_scene(Scene(cell, cell.T_world_pod, items, PoseNoise(0.002, float(np.radians(1.0)))), scene)
    answer = apc("plan-pick", "--scene", scene, "--bin", "bin_E", "--item", GLUE, "-o", out, "--json")
    error = json.loads(answer.out)["error"]
    if answer.code == 5:
        assert error["blockers"] == [BOX] and error["message"].endswith(f"without {BOX} there is a plan")
    else:
        pytest.fail(answer.out)


def test_a_stow_of_what_lies_below_names_what_lies_on_it(cell: Cell, tmp_path: Path) -> None:
    """Without --into the bins are tried in turn; none of them has a plan as long as the cover is there."""
    T, below, above = cell.T_world_place(cell.places[TOTE]), cell.item(BOOK), cell.item(TARGET)
    height = float(below.shape.extents[2])
    placed = (
        PlacedItem(BOOK, below, TOTE, T @ pose([0.0, 0.0, height / 2 + 0.0005])),
        PlacedItem(TARGET, above, TOTE, T @ pose([0.0, 0.0, height + above.shape.extents[2] / 2 + 0.001])),
    )
    scene, out = tmp_path / "scene.json", tmp_path / "plan.json"
    write_scene(Scene(cell, cell.T_world_pod, placed, PoseNoise(0.002, float(np.radians(1.0)))), scene)
    answer = apc("plan-stow", "--scene", scene, "--item", BOOK, "-o", out, "--json")
    assert answer.code == 5, answer.out
    error = json.loads(answer.out)["error"]
    assert error["kind"] == "NoExtractionError" and error["blockers"] == [TARGET]
    assert error["message"].endswith(f"without {TARGET} there is a plan")


def test_a_pick_with_two_arms_names_what_is_in_the_way_of_both(tmp_path: Path) -> None:
    cell = load_cell("apc2016_kth_picking", arm="right")
    cell_bin = cell.pod.bins["bin_E"]
    T = cell.T_world_place(cell_bin)

    def on_floor(name: str, x: float) -> PlacedItem:
        size = cell.item(name).shape.extents
        floor, _ = cell_bin.room.rest(np.array(x - size[0] / 2), np.array(0.0))
        z = float(floor) + float(size[2]) / 2 + 0.002
        return PlacedItem(name, cell.item(name), "bin_E", T @ pose([x, 0.0, z]))

    scene, out = tmp_path / "scene.json", tmp_path / "plan.json"
    items = (on_floor(GLUE, 0.25), on_floor(BOX, 0.13))
    write_scene(Scene(cell, cell.T_world_pod, items, PoseNoise(0.002, float(np.radians(1.0)))), scene)
    answer = apc("plan-pick", "--scene", scene, "--bin", "bin_E", "--item", GLUE, "-o", out, "--json")
    assert answer.code == 5, answer.out
    error = json.loads(answer.out)["error"]
    assert error["blockers"] == [BOX]
    assert "arm" in error["message"] and f"without {BOX} there is a plan" in error["message"]
