"""Figures that a cell may have and hardly any has, told by whatever reads it."""

from __future__ import annotations

import logging
import re
import shutil
from pathlib import Path

import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import cell_names, load_cell, load_workcell
from pickcli.cell.checks.cell_warnings import CELL_WARNINGS
from pickcli.cell.checks.inertial_plausibility import warn_of_masses
from pickcli.cell.data_path import data_path
from pickcli.cell.inertial import is_possible
from pickcli.files.file_kind import CELL
from pickcli.files.file_warnings import FileWarnings
from pickcli.files.yaml_reader import read_yaml
from support.cell_copies import CellCopy
from support.gripper_cell import with_gripper
from support.place_cells import BENCH, with_places


@pytest.mark.parametrize("name", cell_names())
def test_the_cells_that_ship_have_none(name: str) -> None:
    assert [cell.warnings for cell in load_workcell(name).arms.values() if cell.warnings] == []


@pytest.mark.parametrize(
    ("old", "taken", "told", "name"),
    [
        ("lead: 2.0", "lead: 5", "lead: 5.01", "slow_device:pump"),
        ("clearance: 0.003", "clearance: 0.03", "clearance: 0.0301", "odd_clearance:clearance"),
        ("clearance: 0.003", "clearance: 0.0005", "clearance: 0.0004", "odd_clearance:clearance"),
        ("max_velocity: 6.8", "max_velocity: 15", "max_velocity: 15.1", "fast_joint:joint_t"),
        ("max_velocity: 1.0", "max_velocity: 5", "max_velocity: 5.1", "fast_joint:rail"),
        ("max_acceleration: 10.0", "max_acceleration: 200", "max_acceleration: 201", "fast_joint:joint_t"),
        ("max_pull: 42.0", "max_pull: 71", "max_pull: 72", "weak_or_strong_cup:max_pull"),
        ("max_moment: 0.6", "max_moment: 1.25", "max_moment: 1.27", "weak_or_strong_cup:max_moment"),
        ("max_shear: 21.0", "max_shear: 84", "max_shear: 84.1", "weak_or_strong_cup:max_shear"),
        ("cup_stroke: 0.008", "cup_stroke: 0.03", "cup_stroke: 0.031", "large_cup:cup_stroke"),
        ("max_jerk: 200.0", "max_jerk: 5", "max_jerk: 4.99", "slow_joint:joint_t"),
        ("max_acceleration: 10.0", "max_acceleration: 0.69", "max_acceleration: 0.67", "slow_joint:joint_t"),
        ("  seal_time", "  cup_stiffness: 13\n  seal_time", "  cup_stiffness: 12\n  seal_time",
         "weak_or_strong_cup:cup_stiffness"),
        ("  seal_time", "  cup_stiffness: 5200\n  seal_time", "  cup_stiffness: 5300\n  seal_time",
         "weak_or_strong_cup:cup_stiffness"),
        ("  seal_time", "  max_twist: 0.315\n  seal_time", "  max_twist: 0.32\n  seal_time",
         "weak_or_strong_cup:max_twist"),
        ("rail: 1000,", "rail: 10000,", "rail: 10001,", "strong_motor:rail"),
        ("-0.404, 0.567]}", "-0.404, 0.584]}", "-0.404, 0.586]}", "blocked_place:table"),
        ("xyz: [0, 0, 0], rpy: [0, 0, 0]}", "xyz: [0, 0, 0], rpy: [0, 0.09, 0]}",
         "xyz: [0, 0, 0], rpy: [0, 0.11, 0]}", "tilted_pod:pod"),
        ("position: 0.001, angle: 0.0035", "position: 0.02, angle: 0.0035", "position: 0.021, angle: 0.0035",
         "odd_camera:hand.position"),
        ("position: 0.001, angle: 0.0035", "position: 0.001, angle: 0.05", "position: 0.001, angle: 0.2",
         "odd_camera:hand.angle"),
        ("[-1.758, 0, 0], rpy", "[-1.95, 0, 0], rpy", "[-2.09, 0, 0], rpy", "astray"),
    ],
)  # fmt: skip
def test_a_figure_is_odd_from_its_bound_on(
    cell_copy: CellCopy, old: str, taken: str, told: str, name: str
) -> None:
    cell_copy.yaml.replace(old, taken)
    assert cell_copy.load().warnings == ()
    line = cell_copy.yaml.replace(taken, told)
    (warning,) = cell_copy.load().warnings
    assert re.search(
        rf"cell\.yaml:{line}:\d+: .*\(if it is meant, add {name} to accepted_warnings\)", warning
    )
    cell_copy.yaml.replace("untested_pair:carriage-rail_drive", name)
    assert cell_copy.load().warnings == ()


@pytest.mark.parametrize(("key", "limit"), [("cup_length", 0.001), ("cup_radius", 0.001)])
def test_a_cup_is_not_larger_than_its_shapes(cell_copy: CellCopy, key: str, limit: float) -> None:
    lines = cell_copy.yaml.path.read_text().splitlines()
    (old,) = (line.split("#")[0].strip() for line in lines if line.strip().startswith(f"{key}:"))
    drawn = float(old.split(":")[1])
    cell_copy.yaml.replace(old, f"{key}: {drawn + 0.9 * limit:.5f}")
    assert cell_copy.load().warnings == ()
    cell_copy.yaml.replace(f"{key}: {drawn + 0.9 * limit:.5f}", f"{key}: {drawn + 1.5 * limit:.5f}")
    (warning,) = cell_copy.load().warnings
    assert f"tool.{key}: {1e3 * drawn + 1.5:g} mm, but the shapes of" in warning
    assert f"add cup_not_as_drawn:{key} to" in warning


def test_limits_of_a_continuous_joint_are_told_unless_the_cell_narrows_it(cell_copy: CellCopy) -> None:
    text = cell_copy.urdf.path.read_text()
    cell_copy.urdf.path.write_text(
        re.sub(r'(name="joint_t"\s+type=)"revolute"', r'\1"continuous"', text, count=1)
    )
    (warning,) = cell_copy.load().warnings
    assert "joint_limits.joint_t: the URDF limits joint_t to " in warning and "it is continuous" in warning
    assert "add ignored_limits:joint_t to" in warning
    cell_copy.yaml.replace("max_velocity: 6.8,", "max_velocity: 6.8, min_position: -3, max_position: 3,")
    assert cell_copy.load().warnings == ()


def test_a_warning_is_logged_and_changes_no_fingerprint(
    cell_copy: CellCopy, cell: Cell, caplog: pytest.LogCaptureFixture
) -> None:
    cell_copy.yaml.replace("lead: 2.0", "lead: 20")
    with caplog.at_level(logging.WARNING, logger="pickcli"):
        read = cell_copy.load()
    assert [record.getMessage() for record in caplog.records] == list(read.warnings)
    assert read.fingerprint == cell.fingerprint


def test_a_configuration_elsewhere_is_astray(cell_copy: CellCopy) -> None:
    cell_copy.yaml.replace("q: [0.0908, 0.0299, 0.6293, 0.0067, -1.4746, -0.0187, 0.4940",
                           "q: [1.1000, 0.0299, 0.6293, 0.0067, -1.4746, -0.0187, -1.9100")  # fmt: skip
    (warning,) = cell_copy.load().warnings
    assert "bin_E" in warning and "astray:bin_E" in warning


def test_a_configuration_of_a_misspelt_bin_is_told(cell_copy: CellCopy) -> None:
    line = cell_copy.yaml.replace("{name: bin_E,", "{name: bin_EE,")
    told, missing = cell_copy.load().warnings
    assert f"cell.yaml:{line}:" in told and "no place is called bin_EE" in told
    assert "did you mean 'bin_E'?" in told and "no_such_place:bin_EE" in told
    assert "no_configuration:bin_E" in missing


def test_commands_begin_at_home(cell_copy: CellCopy) -> None:
    cell_copy.yaml.replace("{name: home,", "{name: Home,")
    (warning,) = cell_copy.load().warnings
    assert "none is called home, where commands begin unless --from names another" in warning
    assert "did you mean 'Home'? (if it is meant, add no_configuration:home" in warning


def test_an_unknown_kind_is_refused(cell_copy: CellCopy) -> None:
    cell_copy.yaml.replace("untested_pair:carriage-rail_drive", "untested_pairs")
    with pytest.raises(Exception, match=r"no warning is called 'untested_pairs'; did you mean"):
        cell_copy.load()


def test_every_kind_is_in_the_docs() -> None:
    docs = (data_path().parent / "docs" / "formats" / "cell.md").read_text()
    assert [kind for kind in CELL_WARNINGS if f"`{kind}`" not in docs] == []


def own(cell_copy: CellCopy, places: str) -> tuple[str, ...]:
    return with_places(cell_copy, f"places:\n{places}").load().warnings


def crate(name: str, x: float, yaw: float = 0.0) -> str:
    at = f"T_world_place: {{xyz: [{x}, -0.62, 0.58], rpy: [0, 0, {yaw}]}}"
    return f"  {name}: {{kind: box, {at}, inner: [0.3, 0.24, 0.14], wall_thickness: 0.006}}\n"


@pytest.mark.parametrize(
    ("places", "told"),
    [
        (crate("a", -0.9) + crate("b", -1.25), ""),
        (crate("a", -0.9) + crate("b", -1.205), ""),  # wall in wall
        (crate("a", -0.9) + crate("b", -1.19), "places.b: b stands in a; correct the pose or the size"),
        (crate("a", -0.9) + crate("b", -0.9), "blocked_place:b"),
        (crate("a", -0.9, 3.19), ""),
        (crate("a", -0.9, 5), r"T_world_place.rpy: 5 rad is 286 degrees; .*odd_angle:a"),
        (BENCH.replace("[0.5, 0.4, 0.03]", "[0.003, 0.5, 0.4]"), "it has 3 x 500 x 500 mm .*narrow_place"),
    ],
)  # fmt: skip
def test_places_stand_beside_each_other(cell_copy: CellCopy, places: str, told: str) -> None:
    warnings = [
        text for text in own(cell_copy, places) if "no_such_place" not in text and "astray" not in text
    ]
    assert len(warnings) == (told != "") and all(re.search(told, text) for text in warnings)


def test_a_link_of_grams_is_told(cell_copy: CellCopy) -> None:
    noted = FileWarnings.of(read_yaml(cell_copy.yaml.path, CELL))
    cell_copy.urdf.path.write_text(
        re.sub('(<mass value=")[^"]*', r"\g<1>5000", cell_copy.urdf.path.read_text())
    )
    warn_of_masses(noted, cell_copy.load())
    (warning,) = noted.lines
    assert "of 5000 kg has shapes too small for it" in warning and "heavy_link" in warning


def test_an_inertia_that_no_body_has_is_told_and_replaced(cell_copy: CellCopy) -> None:
    noted = FileWarnings.of(read_yaml(cell_copy.yaml.path, CELL))
    text = cell_copy.urdf.path.read_text()
    cell_copy.urdf.path.write_text(re.sub('ixx="[^"]*"', 'ixx="1e6"', text))
    cell = cell_copy.load()
    warn_of_masses(noted, cell)
    (warning,) = noted.lines
    assert "states an inertia that no body has" in warning and "odd_inertia" in warning
    assert all(is_possible(link.inertial.inertia) for link in cell.robot.links)


def test_an_inertia_in_other_units_is_told(cell_copy: CellCopy) -> None:
    noted = FileWarnings.of(read_yaml(cell_copy.yaml.path, CELL))
    text = cell_copy.urdf.path.read_text()
    cell_copy.urdf.path.write_text(re.sub(r'(i(?:xx|yy|zz))="([^"]*)"', r'\1="\g<2>e4"', text))
    warn_of_masses(noted, cell_copy.load())
    (warning,) = noted.lines
    assert re.search(r"m away from their centre by its inertia, but its shapes reach [\d.]+ m only", warning)


def test_a_hand_needs_what_closes_it_and_looks_outwards(cell_copy: CellCopy) -> None:
    copy = with_gripper(cell_copy)
    text = copy.yaml.path.read_text()
    assert copy.load().warnings == ()
    copy.yaml.path.write_text(re.sub(r"devices:\n *\w+: \{kind: gripper, .*", "devices: {}", text))
    (warning,) = copy.load().warnings
    assert "no gripper is among them" in warning and "no_device:gripper" in warning
    turned = re.sub(r"(T_hand_tip: .*rpy: )\[.*?\]", r"\g<1>[3.14159265, 0, 0]", text)
    assert turned != text
    copy.yaml.path.write_text(turned)
    (warning,) = copy.load().warnings
    assert "tool.T_hand_tip: +z points back into the hand" in warning


def test_over_a_crate_the_tip_may_be_before_a_shelf(tmp_path: Path) -> None:
    folder = tmp_path / "cell"
    shutil.copytree(data_path() / "cells" / "ur5e_crates", folder)
    text = (folder / "cell.yaml").read_text()
    moved = text.replace("xyz: [0.45, -0.2, 0.753]", "xyz: [0.1, -0.6, 0.753]")
    (folder / "cell.yaml").write_text(moved)
    assert moved != text and [line for line in load_cell(folder).warnings if "shelf" in line] == []
