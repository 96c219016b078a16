"""The fingerprint changes with everything that a motion's validity depends on, and with nothing else."""

from __future__ import annotations

import re

import pytest

from pickcli.cell.cell import Cell
from support.cell_copies import CellCopy

YAML_MATTERS = {
    "clearance": ("clearance: 0.003", "clearance: 0.006"),
    "speed": ("speed_scale: 1.0", "speed_scale: 0.9"),
    "tool speed": ("speed_scale: 1.0", "speed_scale: 1.0\nmax_tool_speed: 0.25"),
    "velocity": ("max_velocity: 1.0,", "max_velocity: 1.1,"),
    "jerk": ("max_jerk: 40.0", "max_jerk: 50.0"),
    "base": ("T_world_base: {xyz: [-1.758", "T_world_base: {xyz: [-1.757"),
    "pod pose": ("T_world_pod: {xyz: [0, 0, 0]", "T_world_pod: {xyz: [0, 0.001, 0]"),
    "post": ("post: 0.4043", "post: 0.4042"),
    "displacement": ("displacement: {x: 0.05", "displacement: {x: 0.04"),
    "slope": ("floor_slope: 0.08726646", "floor_slope: 0.08726746"),
    "tote": ("wall_thickness: 0.003", "wall_thickness: 0.004"),
    "obstacle": ("lower: [-1.742, -0.934, 0.0]", "lower: [-1.743, -0.934, 0.0]"),
    "tip": ("cup_length: 0.03 ", "cup_length: 0.031 "),
    "stroke": ("cup_stroke: 0.008", "cup_stroke: 0.007"),
}
YAML_DOES_NOT = {
    "comment": ("# Team Delft's cell", "# The cell"),
    "layout": ("speed_scale: 1.0", "speed_scale:    1.0e0"),
    "lead": ("lead: 2.0", "lead: 2.5"),
    "force": ("rail: 1000", "rail: 6000"),
    "named pose": (
        "kind: home, tool_state: straight, q: [0.1580",
        "kind: home, tool_state: straight, q: [0.1680",
    ),
    "reason": ("the carriage rides on", "the carriage sits on"),
    "contact speed": ("contact_speed: 0.075", "contact_speed: 0.05"),
    "seal time": ("seal_time: 0.25", "seal_time: 0.3"),
}
URDF_MATTERS = {
    "limit": ('lower="0.05"', 'lower="0.06"'),
    "origin": ('<origin xyz="0 0 0.49"', '<origin xyz="0 0 0.491"'),
    "shape": ('radius="0.0125" length="0.45"', 'radius="0.0126" length="0.45"'),
}
URDF_DOES_NOT = {
    "mass": ('<mass value="150"/>', '<mass value="151"/>'),
    "comment": ("The rail itself stands still", "The rail stands still"),
    "written otherwise": ('lower="0.05"', 'lower="5e-2"'),
}


@pytest.mark.parametrize("name", YAML_MATTERS)
def test_it_changes_with_the_cell(cell: Cell, cell_copy: CellCopy, name: str) -> None:
    cell_copy.yaml.replace(*YAML_MATTERS[name])
    assert cell_copy.load().fingerprint != cell.fingerprint


@pytest.mark.parametrize("name", URDF_MATTERS)
def test_it_changes_with_the_robot(cell: Cell, cell_copy: CellCopy, name: str) -> None:
    old, new = URDF_MATTERS[name]
    text = cell_copy.urdf.path.read_text()
    assert old in text
    cell_copy.urdf.path.write_text(text.replace(old, new, 1))
    assert cell_copy.load().fingerprint != cell.fingerprint


@pytest.mark.parametrize("name", YAML_DOES_NOT)
def test_it_stays_when_no_motion_is_touched(cell: Cell, cell_copy: CellCopy, name: str) -> None:
    cell_copy.yaml.replace(*YAML_DOES_NOT[name])
    assert cell_copy.load().fingerprint == cell.fingerprint


@pytest.mark.parametrize("name", URDF_DOES_NOT)
def test_it_stays_when_the_urdf_says_the_same(cell: Cell, cell_copy: CellCopy, name: str) -> None:
    cell_copy.urdf.replace(*URDF_DOES_NOT[name])
    assert cell_copy.load().fingerprint == cell.fingerprint


def test_the_order_of_keys_and_obstacles_means_nothing(cell: Cell, cell_copy: CellCopy) -> None:
    lines = cell_copy.yaml.path.read_text().splitlines(keepends=True)
    first = next(i for i, line in enumerate(lines) if "name: hall_floor" in line)
    lines[first], lines[first + 1] = lines[first + 1], lines[first]
    joint = next(i for i, line in enumerate(lines) if line.startswith("  joint_s: {has"))
    lines[joint], lines[joint + 1] = lines[joint + 1], lines[joint]
    cell_copy.yaml.path.write_text("".join(lines))
    assert cell_copy.load().fingerprint == cell.fingerprint


def test_dropping_an_allowed_pair_changes_it(cell: Cell, cell_copy: CellCopy) -> None:
    text = cell_copy.yaml.path.read_text()
    cell_copy.yaml.path.write_text(re.sub(r"  - \{a: link_b.*\n", "", text))
    assert cell_copy.load().fingerprint != cell.fingerprint


def test_it_is_a_sha256(cell: Cell) -> None:
    assert re.fullmatch(r"[0-9a-f]{64}", cell.fingerprint)
