"""``apc init --place``: where the arm reaches best, a configuration at each, and what is left."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.geometry import inverse
from pickcli.kinematics.arm import Arm
from pickcli.precompute.empty_cell_checkers import why_not_free
from pickcli.scene.scene import empty_scene
from pickcli.scene.solid_overlap import PosedSolid, overlap_depth
from support.command_line import apc, refused
from support.new_robots import write_gripper_arm

LIMITS = ("--max-acceleration", "5", "--max-jerk", "50")
UR5E = (
    "--urdf", data_path() / "cells" / "ur5e_crates" / "robot.urdf", "--without", "tube", *LIMITS,
    "--tip", "wrist_3_link", "--tool", "suction",
)  # fmt: skip
PANDA = (
    "--urdf", data_path() / "cells" / "panda_table" / "robot.urdf", *LIMITS, "--tool", "gripper",
    "--tool-figure", "force=70", "--tool-figure", "friction=0.5", "--tool-figure", "closing_speed=0.1",
)  # fmt: skip


def solids(cell: Cell) -> dict[str, list[PosedSolid]]:
    """What stands in the cell by the carrier that it is part of."""
    return {
        name: [PosedSolid(b.shape, carrier.T_world_carrier @ b.T_parent_shape) for b in carrier.bodies]
        for name, carrier in cell.carriers.items()
    }


def waits_before(cell: Cell, name: str) -> bool:
    """Whether the tip waits before the mouth of a place and looks in, in the configuration of its name."""
    place, q = cell.places[name], cell.configurations[name].q
    T_world_tip = Arm(cell.robot).tip(q, cell.robot.tool.default_state)
    T = inverse(cell.T_world_place(place) @ place.T_place_entry) @ T_world_tip
    return bool(-0.35 < T[0, 3] < -0.05 and T[0, 2] > 0.99)


def test_two_boxes_stand_apart_and_are_waited_over(tmp_path: Path) -> None:
    path = tmp_path / "ur5e"
    made = apc("init", path, *UR5E, "--place", "left=box", "--place", "box", "--json")
    assert made.code == 0, made.err
    told = json.loads(made.out)
    assert told["left_to_fill_in"] == []
    cell = load_cell(path)
    assert list(cell.places) == ["left", "box"] == list(told["places"])
    one, other = solids(cell).values()
    assert all(overlap_depth(a, b) == 0.0 for a in one for b in other)
    assert why_not_free(cell) == {}
    for name in cell.places:
        assert cell.places[name].access.is_from_above and waits_before(cell, name)
        np.testing.assert_allclose(cell.carriers[name].T_world_carrier[:3, 3], told["places"][name]["xyz"])
    checked = json.loads(apc("check", path, "--json").out)
    for reach in checked["reach"]:
        assert reach["share"] > 0.7 and reach["share_in_line"] > 0.5, reach


def test_a_gripper_waits_over_a_table(tmp_path: Path) -> None:
    path = tmp_path / "panda"
    made = apc("init", path, *PANDA, "--place", "table")
    assert made.code == 0 and "left to fill in" not in made.out, made.err
    assert "place: table, table at " in made.out and "tool poses in it and before it are reached" in made.out
    cell = load_cell(path)
    assert waits_before(cell, "table")
    assert apc("check", path).code == 0
    move = tmp_path / "move.json"
    planned = apc("plan-move", "--cell", path, "--from", "home", "--to", "table", "-o", move)
    assert planned.code == 0 and "certified" in planned.out, planned.err


def test_every_room_of_a_shelf_has_a_configuration_or_is_listed(tmp_path: Path) -> None:
    path = tmp_path / "ur5e"
    made = apc("init", path, *UR5E, "--place", "rack=grid", "--json")
    assert made.code == 0, made.err
    left, cell = json.loads(made.out)["left_to_fill_in"], load_cell(path)
    assert len(cell.places) == 6 and len(cell.configurations) >= 5
    for name in cell.places:
        listed = [each for each in left if f"--bin {name} " in each]
        assert (name in cell.configurations and waits_before(cell, name)) or len(listed) == 1
        assert all(each.startswith("places.rack: ") for each in listed)
    schema = json.loads((path / "cell.schema.json").read_text())
    (kinds,) = schema["properties"]["places"]["patternProperties"].values()
    assert (
        set(kinds["discriminator"]["mapping"]) >= {"grid", "box", "table"}
        and "rows" in schema["$defs"]["GridModel"]["properties"]
    )
    text = (path / "cell.yaml").read_text()
    rack = text.partition("places:\n")[2].partition("\n\n")[0].splitlines()
    assert rack[0] == "  rack:" and all("#" in line for line in rack[2:]), rack


def test_nothing_that_is_placed_stands_in_the_robot(tmp_path: Path) -> None:
    path = tmp_path / "ur5e"
    assert apc("init", path, *UR5E, "--place", "table", "--place", "table").code == 0
    cell = load_cell(path)
    assert list(cell.places) == ["table", "table_2"]
    base = [link for link in cell.robot.links if link.name == "base"] or [cell.robot.links[0]]
    standing = [PosedSolid(b.shape, cell.robot.T_world_base @ b.T_parent_shape) for b in base[0].bodies]
    around = [
        PosedSolid(b.shape, T @ b.T_parent_shape) for b, T in empty_scene(cell).standing if "table" in b.name
    ]
    assert standing and len(around) == 2
    assert all(overlap_depth(a, b) == 0.0 for a in standing for b in around)


MISTAKES = {
    "a kind that is none": (
        ("--place", "bin=gird"), "--place bin=gird: unknown kind of place 'gird'; did you mean",
    ),
    "one name twice": (
        ("--place", "a=box", "--place", "a=grid"), "--place a=grid: there is a place 'a' already; give each",
    ),
    "a name that a kind has taken": (
        ("--place", "box", "--place", "box=grid"), "there is a place 'box' already",
    ),
    "a name that is none": (("--place", "1st=box"), "--place 1st=box: expected a name of letters"),
    "no name": (("--place", "=box"), "--place =box: expected a name of letters"),
    "a name of something else": (
        ("--place", "home=box"), "--place home=box: 'home' is the name of something else",
    ),
    "two pods": (("--place", "pod", "--place", "pod"), "--place pod: a cell has one pod"),
    "a pod with a name": (("--place", "shelf=pod"), "--place shelf=pod: the pod has no name but its own"),
    "too many": (("--place", "box") * 21, "--place: 21 places; at most 20 are sought at once"),
    "no reach": (
        ("--place", "box"), "--place box=box: the arm takes none of 24 tool poses in it, from any of",
    ),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_told_and_nothing_is_written(mistake: str, tmp_path: Path) -> None:
    words, told = MISTAKES[mistake]
    urdf = write_gripper_arm(tmp_path)  # three joints: it takes next to no pose
    made = apc("init", tmp_path / "arm", "--urdf", urdf, *LIMITS, "--tool", "suction", *words)
    refused(made, 3, told)
    assert not (tmp_path / "arm").exists()
