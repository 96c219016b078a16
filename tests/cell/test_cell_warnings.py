"""Figures that a cell may have and hardly any has, told by whatever reads it."""

from __future__ import annotations

import logging
import re

import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import cell_names, load_workcell
from pickcli.cell.checks.cell_warnings import CELL_WARNINGS
from pickcli.cell.data_path import data_path
from support.cell_copies import CellCopy


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
        ("rail: 1000,", "rail: 10000,", "rail: 10001,", "strong_motor:rail"),
        ("-0.404, 0.567]}", "-0.404, 0.584]}", "-0.404, 0.586]}", "blocked_place:table"),
        ("xyz: [0, 0, 0], rpy: [0, 0, 0]}", "xyz: [0, 0, 0], rpy: [0, 0.09, 0]}",
         "xyz: [0, 0, 0], rpy: [0, 0.11, 0]}", "tilted_pod:pod"),
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
