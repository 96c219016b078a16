"""apc plan-drive: files, output, and mistakes."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from pickcli.driving.driving_area import FloorBox
from pickcli.driving.driving_area_file import read_driving_area
from pickcli.driving.steering_path import SteeringPath, seen_from, wrapped
from pickcli.driving.tricycle import Tricycle
from support.command_line import apc, misused, refused
from support.driving_hall import HALL


@pytest.fixture
def hall(tmp_path: Path) -> Path:
    path = tmp_path / "hall.yaml"
    path.write_text(HALL)
    return path


def test_a_drive_is_planned_told_and_written_alike_each_time(hall: Path, tmp_path: Path) -> None:
    drive, again = tmp_path / "drive.json", tmp_path / "again.json"
    told = apc("plan-drive", hall, "-o", drive)
    assert told.code == 0 and told.err == ""
    assert " m from everything: " in told.out
    answer = apc("plan-drive", hall, "--drives", 5, "--seed", 4, "--json", "-o", again)
    assert drive.read_bytes() == again.read_bytes()
    figures = json.loads(answer.out)
    assert figures["drives"]["number"] == figures["drives"]["within"] == 5
    written = json.loads(drive.read_text())
    assert figures["travel"] == written["figures"]["travel"]
    refused(apc("plan-drive", hall, "-o", drive), 3, "--overwrite")


def test_a_picture_shows_walls_boxes_truck_and_both_directions(hall: Path, tmp_path: Path) -> None:
    hall.write_text(
        HALL.replace("straight: 0.3", "straight: -0.3").replace("name: rack", 'name: "<rack {1}>"')
    )
    picture = tmp_path / "drive.svg"
    assert apc("plan-drive", hall, "--picture", picture, "-o", tmp_path / "drive.json").code == 0
    root = ElementTree.parse(picture).getroot()
    kinds = [element.tag.rpartition("}")[2] for element in root.iter()]
    assert kinds.count("polyline") >= 2 and kinds.count("polygon") > 5
    assert [element.text for element in root.iter() if element.tag.endswith("title")] == ["<rack {1}>"]
    width, height = float(root.attrib["width"]), float(root.attrib["height"])
    for element in root:
        points = [tuple(map(float, point.split(","))) for point in element.attrib.get("points", "").split()]
        assert all(0 <= x <= width and 0 <= y <= height for x, y in points)
    wrong = apc("plan-drive", hall, "--picture", tmp_path / "drive.png", "-o", tmp_path / "other.json")
    refused(wrong, 3, "drive.png", ".svg")
    assert not (tmp_path / "other.json").exists()


def test_the_actions_of_a_file_lead_to_its_poses_and_to_the_goal(hall: Path, tmp_path: Path) -> None:
    drive = tmp_path / "drive.json"
    assert apc("plan-drive", hall, "-o", drive).code == 0
    written = json.loads(drive.read_text())
    steps, steering = (np.array(written["actions"][key]) for key in ("steps", "steering"))
    path = SteeringPath(Tricycle(**written["truck"]), np.array(written["start"]), steps, steering)
    rows = np.array([[row[key] for key in ("travel", "x", "y", "yaw")] for row in written["poses"]])
    poses = path.poses_at(rows[:, 0])
    poses[:, 2] = wrapped(poses[:, 2])
    np.testing.assert_allclose(rows[:, 1:], poses, atol=1e-7)
    assert np.diff(rows[:, 0]).max() <= 0.1 + 1e-9
    np.testing.assert_allclose(seen_from(np.array(written["goal"]), path.end), 0.0, atol=1e-7)
    profile = written["profile"]
    assert profile["travel"][-1] == pytest.approx(path.length, abs=1e-8)
    assert profile["speed"][0] == profile["speed"][-1] == 0
    assert written["poses"][-1]["time"] == pytest.approx(written["figures"]["duration"], abs=1e-6)


def test_an_area_is_read_with_its_figures_and_their_defaults(hall: Path) -> None:
    hall.write_text(HALL + "truck: {width: 0.9}\n")
    found = read_driving_area(hall)
    assert found.boxes == (FloorBox("rack", (4.0, 4.0), (2.0, 1.0), 0.3),)
    assert (found.low, found.high, found.straight, found.margin) == ((0.0, 0.0), (8.0, 8.0), 0.3, 0.05)
    assert (found.start.tolist(), found.goal.tolist()) == ([1.5, 1.5, 0.0], [5.5, 1.7, 0.2])
    assert found.truck == Tricycle(width=0.9)


@pytest.mark.parametrize(
    ("right", "wrong", "told"),
    [
        ("position: [5.5, 1.7]", "position: [4.0, 4.2]", ":7:1: goal: the truck at the goal overlaps rack"),
        ("position: [1.5, 1.5]", "position: [3.0, 4.0]", ":6:1: start: the truck at the start overlaps rack"),
        ("position: [1.5, 1.5]", "position: [0.1, 1.5]", "the truck at the start is not within the walls"),
        ("position: [1.5, 1.5]", "position: [0.33, 1.5]", "is 0.030 m from the walls; keep the margin of"),
        ("yaw: 0.2", "yaw: .nan", "goal.yaw: expected a finite number, got .nan"),
        ("yaw: 0.2", "yaw: 90", "goal.yaw"),
        ("high: [8, 8]", "high: [8000, 8000]", "walls.high"),
        ("high: [8, 8]", "high: [80, 80]", "80 m from wall to wall, at most 40 m"),
        ("high: [8, 8]", "high: [-1, 8]", "low is not below high"),
        ("size: [2, 1]", "size: [2, -1]", "boxes[0].size"),
        ("straight: 0.3", "straigth: 0.3", "straight"),
        ("version: 1", "version: 2", "version"),
        ("goal: {", "margin: 5\ngoal: {", "margin"),
        ("goal: {", "truck: {steering: 85}\ngoal: {", "truck.steering"),
        ("goal: {", "truck: {wheelbase: 1.2}\ngoal: {", "wheel_base"),
        ("start: {position: [1.5, 1.5], yaw: 0}\n", "", "start"),
        ("apc driving area", "apc drive", "is a plan of a drive"),
    ],
)  # fmt: skip
def test_mistakes_are_told(hall: Path, tmp_path: Path, right: str, wrong: str, told: str) -> None:
    assert HALL.count(right) == 1
    hall.write_text(HALL.replace(right, wrong))
    refused(apc("plan-drive", hall, "-o", tmp_path / "drive.json"), 3, hall, told)
    assert not (tmp_path / "drive.json").exists()


def test_an_area_without_a_way_has_the_reason(hall: Path, tmp_path: Path) -> None:
    fence = "boxes:\n  - {name: fence, centre: [4, 4], size: [0.1, 8]}\n"
    hall.write_text(HALL.replace("boxes:\n", fence))
    refused(apc("plan-drive", hall, "-o", tmp_path / "drive.json"), 5, "walls and boxes part start and goal")
    assert not (tmp_path / "drive.json").exists()


def test_a_truck_at_its_goal_and_wrong_numbers_are_refused(hall: Path, tmp_path: Path) -> None:
    hall.write_text(HALL.replace("[5.5, 1.7], yaw: 0.2, straight: 0.3", "[1.5, 1.5], yaw: 0"))
    refused(apc("plan-drive", hall, "-o", tmp_path / "drive.json"), 3, "at the goal already")
    misused(apc("plan-drive", hall, "--drives", -1, "-o", tmp_path / "drive.json"), "--drives")
    refused(apc("plan-drive", tmp_path / "no.yaml", "-o", tmp_path / "drive.json"), 3, "no.yaml")
