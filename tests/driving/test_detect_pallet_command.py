"""apc detect-pallet, and apc plan-drive with what it says: files, output, and mistakes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pickcli.driving.area_view import take_picture
from pickcli.driving.driving_area_file import read_driving_area
from pickcli.driving.truck_camera import floor_pose
from pickcli.files.png_file import write_png
from support.command_line import apc, misused, refused

DOCK = """\
format: apc driving area
version: 1
walls: {low: [0, 0], high: [9, 7]}
start: {position: [6.5, 2.2], yaw: 0.3}
pallet: {position: [2, 3.5], yaw: 0.1, load: 0.5, off: [0.03, -0.05, 0.04]}
"""
AT = ("--at", "4.0", "3.6", "0.1")


@pytest.fixture
def dock(tmp_path: Path) -> Path:
    path = tmp_path / "dock.yaml"
    path.write_text(DOCK)
    return path


def test_a_pallet_is_told_and_written_alike_each_time(dock: Path, tmp_path: Path) -> None:
    one, again = tmp_path / "one.json", tmp_path / "again.json"
    told = apc("detect-pallet", dock, *AT, "--seed", 3, "-o", one)
    assert told.code == 0 and told.out.startswith("full pallet at 2.0")
    answer = apc("detect-pallet", dock, *AT, "--seed", 3, "--json", "-o", again)
    assert one.read_bytes() == again.read_bytes()
    values = json.loads(answer.out)
    area = read_driving_area(dock)
    assert area.pallet is not None
    off = np.array(values["in_area"]) - area.pallet.real[0].pose
    assert np.abs(off).max() < 0.015
    refused(apc("detect-pallet", dock, *AT, "-o", one), 3, "--overwrite")


def test_no_pallet_is_an_answer_with_a_reason(dock: Path, tmp_path: Path) -> None:
    dock.write_text(DOCK.replace("off: [0.03, -0.05, 0.04]", "there: false"))
    refused(apc("detect-pallet", dock, *AT, "-o", tmp_path / "one.json"), 3, dock, "no pallet here")
    assert not (tmp_path / "one.json").exists()


def test_a_recorded_picture_is_read_with_where_the_truck_was(dock: Path, tmp_path: Path) -> None:
    area, truck = read_driving_area(dock), np.array([4.0, 3.6, 0.1])
    assert area.camera is not None and area.pallet is not None
    seen = take_picture(area, area.camera, truck, area.pallet.real, 3)
    write_png(seen.in_steps, tmp_path / "depth.png")
    T = floor_pose(truck) @ seen.T_world_camera
    values = {
        "format": "apc recording", "version": 1, "cell": "dock", "camera": "truck", "sensor": "carmine",
        "at": "4,3.6,0.1", "size": [640, 480], "K": seen.camera.K.tolist(), "T_world_camera": T.tolist(),
        "colour": "colour.png", "depth": "depth.png", "depth_step": 1e-4,
    }  # fmt: skip
    look = tmp_path / "look.json"
    look.write_text(json.dumps(values))
    recorded = apc("detect-pallet", dock, "--recorded", look, "--json", "-o", tmp_path / "recorded.json")
    simulated = apc("detect-pallet", dock, *AT, "--seed", 3, "--json", "-o", tmp_path / "simulated.json")
    one, other = (np.array(json.loads(each.out)["in_area"]) for each in (recorded, simulated))
    np.testing.assert_allclose(one, other, atol=1e-3)
    for key, wrong, word in (
        ("camera", "hand", "of camera hand"), ("sensor", "ensenso", "of sensor ensenso"),
        ("at", "home", "state the pose of the truck"), ("at", "5,3.6,0.1", "from where the camera is"),
    ):  # fmt: skip
        look.write_text(json.dumps({**values, key: wrong}))
        refused(apc("detect-pallet", dock, "--recorded", look, "-o", tmp_path / "x.json"), 3, look, word)
    misused(apc("detect-pallet", dock, *AT, "--recorded", look, "-o", tmp_path / "x.json"), "--at")


@pytest.mark.parametrize(
    ("at", "told"),
    [
        ((4.0, 3.6, 180), "angles are in rad"),
        ((4000, 3600, 0.1), "is not within the walls"),
        ((-1.0, 3.6, 0.1), "is not within the walls"),
    ],
)  # fmt: skip
def test_a_truck_that_cannot_be_there_is_refused(
    dock: Path, tmp_path: Path, at: tuple[float, float, float], told: str
) -> None:
    misused(apc("detect-pallet", dock, "--at", *at, "-o", tmp_path / "x.json"), told)


@pytest.mark.parametrize(
    ("right", "wrong", "told"),
    [
        ("pallet: {", "camera: {sensor: carmin}\npallet: {", "camera.sensor: no sensor is named 'carmin'"),
        ("pallet: {", "camera: {sensor: ids_wrist}\npallet: {", "measures no depth"),
        ("pallet: {", "camera: {sensor: none.yaml}\npallet: {", "no such file beside this one"),
        ("yaw: 0.1,", "yaw: 0.1, kind: quarter,", "pallet.kind"),
        ("yaw: 0.1,", "yaw: 0.1, tolerance: [0, 0.1, 0.1],", "pallet.tolerance"),
        ("yaw: 0.1,", "yaw: 0.1, load: -1,", "pallet.load"),
        ("position: [6.5, 2.2]", "position: [2.6, 3.5]", "the truck at the start overlaps the pallet"),
        ("pallet: {", "palet: {", "palet"),
    ],
)  # fmt: skip
def test_mistakes_of_the_area_are_told(dock: Path, tmp_path: Path, right: str, wrong: str, told: str) -> None:
    dock.write_text(DOCK.replace(right, wrong))
    refused(apc("detect-pallet", dock, "-o", tmp_path / "one.json"), 3, dock, told)
    assert not (tmp_path / "one.json").exists()


def test_a_drive_leads_into_the_detected_pallet(dock: Path, tmp_path: Path) -> None:
    found, drive = tmp_path / "found.json", tmp_path / "drive.json"
    assert apc("detect-pallet", dock, *AT, "-o", found).code == 0
    told = apc("plan-drive", dock, "--detected", found, "-o", drive)
    assert told.code == 0, told.err
    written, seen = json.loads(drive.read_text()), json.loads(found.read_text())
    np.testing.assert_allclose(written["goal"][2], seen["in_area"][2], atol=1e-6)
    assert written["straight"] < -1.0
    other = tmp_path / "other.json"
    dock.write_text(DOCK.replace("yaw: 0.1,", "yaw: 0.1, kind: half,"))
    refused(apc("plan-drive", dock, "--detected", found, "-o", other), 3, "expects a half pallet")
    dock.write_text(DOCK.replace("position: [2, 3.5]", "position: [2, 3.9]"))
    refused(apc("plan-drive", dock, "--detected", found, "-o", other), 3, "beyond its tolerance")
    dock.write_text(DOCK + "goal: {position: [6.5, 4.5], yaw: 0}\n")
    refused(apc("plan-drive", dock, "--detected", found, "-o", other), 3, "leave goal out")
    dock.write_text(DOCK)
    found.write_text(json.dumps({**seen, "in_area": [0.0, 0.0, 0.0]}))
    refused(apc("plan-drive", dock, "--detected", found, "-o", other), 3, found, "in_area")
    assert not other.exists()
