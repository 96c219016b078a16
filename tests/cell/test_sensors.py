"""Sensors in cells and in files of their own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.data_path import data_path
from pickcli.cell.fingerprint import fingerprint
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file, sensor_names
from pickcli.cell.sensors.material import Material
from pickcli.geometry import is_pose, pose
from support.cell_copies import CellCopy

Refused = Callable[[Callable[[], object]], str]

LINK = "    link: link_t\n"
SENSOR = data_path() / "sensors" / "carmine.yaml"


def test_the_default_cell_has_a_camera_on_the_gripper_and_one_over_the_tote(cell: Cell) -> None:
    hand, boom = cell.cameras["hand"], cell.cameras["boom"]
    assert (hand.model.name, hand.link) == ("ensenso", "link_t")
    assert (boom.model.name, boom.link) == ("carmine", None)
    assert is_pose(hand.T_parent_camera)
    expected = pose((-1.045, -0.754, 2.11), rpy=(3.2378, 0.0, 0.0))
    np.testing.assert_array_equal(boom.T_parent_camera, expected)
    assert (hand.error.position, hand.error.angle) == (0.001, 0.0035)


def test_cameras_do_not_change_the_fingerprint(cell: Cell) -> None:
    assert fingerprint(replace(cell, cameras={})) == cell.fingerprint


def test_a_cell_without_sensors_has_no_cameras(cell_copy: CellCopy) -> None:
    text = cell_copy.yaml.path.read_text()
    cell_copy.yaml.path.write_text(text[: text.index("sensors:\n")])
    assert cell_copy.load().cameras == {}


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            "model: ensenso",
            "model: ensenzo",
            "sensors.hand.model: no sensor is named 'ensenzo'; did you mean",
        ),
        ("model: ensenso", "model: none.yaml", "no such file in the cell's folder"),
        ("model: ensenso", "model: ../a.yaml", "expected a path inside the cell's folder"),
        (LINK, "    link: link_x\n", "sensors.hand.link: no link is named 'link_x'; known: arm_base"),
        (
            LINK,
            "    link: world\n",
            "no link is named 'world'; leave link out for a camera fixed in the world",
        ),
        (LINK, "    links: link_t\n", "sensors.hand.links: unknown key; did you mean 'link'?"),
        ("position: 0.001", "position: 1", "sensors.hand.error.position: expected m, 0 to 0.1"),
        ("position: 0.001, ", "", "sensors.hand.error.position: expected m, 0 to 0.1, got nothing"),
        ("0.34906585, 0", "20, 0", "sensors.hand.T_parent_camera.rpy[0]: expected"),
    ],
)
def test_a_mistake_about_a_camera_is_told(
    cell_copy: CellCopy, refused: Refused, old: str, new: str, told: str
) -> None:
    line = cell_copy.yaml.replace(old, new)
    message = refused(cell_copy.load)
    assert told in message
    number = int(message.split(":")[1])
    assert abs(number - line) <= 1 + new.count("\n")


def test_a_sensor_may_lie_in_the_folder_of_the_cell(cell_copy: CellCopy) -> None:
    (cell_copy.folder / "mine.yaml").write_text(SENSOR.read_text().replace("name: carmine", "name: mine"))
    cell_copy.yaml.replace("model: ensenso", "model: mine.yaml")
    assert cell_copy.load().cameras["hand"].model.name == "mine"


@pytest.mark.parametrize(
    ("old", "taken", "told", "subject", "advice"),
    [
        ("fx: 570", "fx: 36666", "fx: 36670", "hand.fx", "sees 1 degrees; is its fx in px, not mm?"),
        ("fy: 570", "fy: 21", "fy: 20.9", "hand.fy", "in px"),
        ("fx: 570", "fx: 28", "fx: 0.006", "hand.fx", "sees 180 degrees"),
    ],
)
def test_a_field_of_view_that_no_lens_has_is_odd(
    cell_copy: CellCopy, old: str, taken: str, told: str, subject: str, advice: str
) -> None:
    mine = cell_copy.folder / "mine.yaml"
    text = SENSOR.read_text().replace("baseline: 0.075", "baseline: 0.0001")
    cell_copy.yaml.replace("model: ensenso", "model: mine.yaml")
    mine.write_text(text.replace(old, taken))
    assert cell_copy.load().warnings == ()
    mine.write_text(text.replace(old, told))
    (warning,) = cell_copy.load().warnings
    assert advice in warning
    assert f"add odd_camera:{subject} to accepted_warnings" in warning


def test_sensors_of_the_package_are_read_by_their_names() -> None:
    assert set(sensor_names()) >= {"ensenso", "carmine", "kinect_v2", "realsense_f200", "ids_wrist"}
    for name in sensor_names():
        sensor = read_sensor(sensor_file(name))
        assert sensor.name == name
        assert 0.0 <= sensor.camera.cx <= sensor.camera.width
        assert 0.0 <= sensor.camera.cy <= sensor.camera.height


def test_figures_of_a_sensor_are_those_of_its_file() -> None:
    sensor = read_sensor(SENSOR)
    camera, depth = sensor.camera, sensor.depth
    assert (camera.width, camera.height, camera.fx, camera.cy) == (640, 480, 570.0, 239.5)
    assert depth is not None
    assert (depth.least, depth.greatest, depth.baseline) == (0.35, 3.0, 0.075)
    assert (depth.constant, depth.quadratic, depth.from_depth) == (0.0012, 0.0019, 0.4)
    assert (depth.disparity_error, depth.disparity_step) == (0.0, 0.125)
    assert depth.no_return[Material.CLEAR] == 0.85
    assert not depth.mixes_edges
    assert read_sensor(sensor_file("ids_wrist")).depth is None
    kinect = read_sensor(sensor_file("kinect_v2")).depth
    assert kinect is not None
    assert kinect.mixes_edges
    assert kinect.baseline == 0.0


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("fx: 570", "fx: 0", "picture.fx: expected focal length in px"),
        ("width: 640", "width: 640.5", "picture.width: expected"),
        ("width: 640, ", "", "picture.width: expected px, got nothing"),
        ("range: [0.35, 3.0]", "range: [3.0, 0.35]", "expected range as [smaller, larger]"),
        ("incidence: [1.134, 1.431]", "incidence: [65, 82]", "depth.incidence[0]: expected"),
        ("  baseline: 0.075\n", "", "expected the baseline of the disparity"),
        ("baseline: 0.075", "baseline: 75", "depth.baseline: expected m to the second eye"),
        (
            "height: 480, fx: 570", "height: 4800, fx: 99000",
            "expected a second eye whose disparities are not as large as",
        ),
        ("width: 640", "width: 64000", "picture.width: expected px"),
        ("correlation: 1.0", "correlation: 5.0", "depth.correlation: expected px, 0.5 to 2"),
        ("clear: 0.85", "clear: 1.85", "depth.no_return.clear: expected"),
        ("clear: 0.85", "glass: 0.85", "depth.no_return.glass"),
        ("axial: {constant", "axiel: {constant", "depth.axiel: unknown key; did you mean 'axial'?"),
        ('  baseline: "public simulators"\n', "", "expected a source of baseline"),
        ("sources:\n", 'sources:\n  colour: "seen"\n', "expected sources of picture, axial"),
        ("format: apc sensor", "format: apc items", "is a file of items, but a sensor is expected here"),
        ("version: 1", "version: 2", "version: expected 1"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_file_of_a_sensor_is_told(
    cell_copy: CellCopy, refused: Refused, old: str, new: str, told: str
) -> None:
    text = SENSOR.read_text()
    assert text.count(old) == 1
    path = cell_copy.folder / "mine.yaml"
    path.write_text(text.replace(old, new))
    message = refused(lambda: read_sensor(path))
    assert told in message
    assert message.startswith(str(path))
