"""Advice on picks without a plan: what removing the items in the way is worth."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import pose
from pickcli.motion.plan import Plan
from pickcli.planning.blockers import with_blockers
from pickcli.planning.pick_problem import PickQuery
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_file import write_scene
from support.command_line import apc

TARGET, BOX, HOOKS, GLUE = "crayola_24_ct", "kleenex_tissue_box", "command_hooks", "dove_beauty_bar"


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
    error = with_blockers(blamed(query, *blame), planning(needed, stuck, *blame), scene, query)
    assert str(error).splitlines()[-1] == told and set(error.blockers) == needed
    assert len(error.reasons) == len(blame)


@pytest.mark.parametrize("blame", [(), (BOX, HOOKS)])
def test_where_removing_items_does_not_help_nothing_is_advised(cell: Cell, blame: tuple[str, ...]) -> None:
    scene, query = scene_of(cell, TARGET, BOX, HOOKS), PickQuery("bin_E", TARGET)
    error = blamed(query, *blame)
    assert with_blockers(error, planning({TARGET}, set(), *blame), scene, query) is error


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
