"""Conveyors in cell files: what is read, what is refused, and that the belt is part of the fingerprint."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell, load_workcell
from pickcli.cell.data_path import data_path
from pickcli.errors import InputError
from pickcli.random_scenes.make_scene import make_scene
from pickcli.reachability.belt_reachability import HEIGHTS, reached_travel
from pickcli.reachability.cell_check import check_cell
from support.cell_copies import CellCopy

CELL = "conveyor_sia20"
SPEED = "speed: {nominal: 0.33, max: 0.50, max_acceleration: 0.5}"


@pytest.fixture
def copy(tmp_path: Path) -> CellCopy:
    shutil.copytree(data_path() / "cells" / CELL, tmp_path / "cell")
    return CellCopy(tmp_path / "cell")


def test_the_belt_runs_along_the_rail_and_its_items_lie_on_its_surface() -> None:
    cell = load_cell(CELL)
    carrier, place = cell.carriers["belt"], cell.places["belt"]
    assert carrier.conveyor is not None and carrier.conveyor.window == (1.2, 2.85)
    rail = cell.robot.joints[0]
    assert np.allclose(carrier.T_world_carrier[:3, 0], (cell.robot.T_world_base @ rail.T_parent_joint)[:3, 0])
    # The room begins at the infeed, where the frame of the belt is, and ends at the outfeed.
    assert place.T_carrier_place[0, 3] + place.room.low[0] == pytest.approx(0.0)
    assert place.T_carrier_place[0, 3] + place.room.high[0] == pytest.approx(carrier.conveyor.length)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (SPEED, SPEED.replace("0.33", "-0.33"), "speed.nominal"),
        (SPEED, SPEED.replace("0.33", ".nan"), "speed.nominal"),
        (SPEED, SPEED.replace("0.33", "0.6"), "expected nominal up to max, 0.5 m/s; got 0.6"),
        (SPEED, SPEED.replace("max_acceleration: 0.5", "max_acceleration: 0"), "max_acceleration"),
        (
            "window: [1.20, 2.85]",
            "window: [2.85, 1.20]",
            "a window within 0 to 3.1 m of travel, got 2.85 to 1.2",
        ),
        (
            "window: [1.20, 2.85]",
            "window: [1.20, 3.2]",
            "a window within 0 to 3.1 m of travel, got 1.2 to 3.2",
        ),
        (
            "length: 3.1",
            "length: 3.1\n    displacement: {x: 0.01}",
            "a conveyor is calibrated, state its pose",
        ),
        ("0.60], rpy: [0, 0, 0]}", "0.60], rpy: [0, 0.1, 0]}", "roll and pitch of 0"),
    ],
)
def test_a_belt_that_contradicts_itself_is_refused(copy: CellCopy, old: str, new: str, told: str) -> None:
    copy.yaml.replace(old, new)
    with pytest.raises(InputError) as error:
        copy.load()
    assert "places.belt" in str(error.value) and told in str(error.value)


@pytest.mark.parametrize(
    ("old", "new"), [("nominal: 0.33", "nominal: 0.30"), ("max: 0.50", "max: 0.60"), ("2.85]", "2.80]")]
)
def test_a_motion_is_for_one_belt(copy: CellCopy, old: str, new: str) -> None:
    before = copy.load().fingerprint
    copy.yaml.replace(old, new)
    assert copy.load().fingerprint != before


def test_items_lie_within_the_window() -> None:
    cell = load_cell(CELL)
    scene = make_scene({"belt": ["dove_beauty_bar"] * 8}, cell, seed=3)
    belt = cell.carriers["belt"]
    assert belt.conveyor is not None
    x = [float(placed.T_world_item[0, 3] - belt.T_world_carrier[0, 3]) for placed in scene.items]
    assert len(x) == 8 and belt.conveyor.window[0] <= min(x) and max(x) <= belt.conveyor.window[1]


def test_the_window_is_within_reach_over_the_whole_width() -> None:
    cell = load_cell(CELL)
    carrier = cell.carriers["belt"]
    assert carrier.conveyor is not None
    first, last = carrier.conveyor.window
    for height in HEIGHTS:
        reached = reached_travel(cell, carrier, height)
        assert reached is not None and reached[0] <= first + 1e-9 and last <= reached[1] + 1e-9


def unreached(copy: CellCopy) -> list[str]:
    check = check_cell(load_workcell(copy.folder), n_poses=4)
    return [line for line in check.warnings if "the arm reaches items of 30 mm" in line]


def test_a_window_beyond_reach_is_warned_of_with_what_is_reached(copy: CellCopy) -> None:
    assert unreached(copy) == []
    copy.yaml.replace("window: [1.20, 2.85]", "window: [0.30, 2.85]")
    (line,) = unreached(copy)
    assert (
        "places.belt.window" in line and "window is 0.3 to 2.85 m" in line and "from 1.10 to 3.00 m" in line
    )


def test_a_belt_that_is_too_far_away_is_reached_nowhere(copy: CellCopy) -> None:
    copy.yaml.replace("xyz: [-3.20, 0.65, 0.60]", "xyz: [-3.20, 2.65, 0.60]")
    cell = copy.load()
    assert reached_travel(cell, cell.carriers["belt"], 0.14) is None
