"""Files of a located tote: written and read alike, and refused with their mistakes."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.calibration.tote_file import read_tote, tote_values, write_tote
from pickcli.calibration.tote_fit import TouchedPoint, fit_tote
from pickcli.calibration.tote_location import LocatedTote, Touch
from pickcli.calibration.tote_shape import tote_shape
from pickcli.calibration.touch_points import touch_points
from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.errors import InputError, StaleError
from pickcli.geometry import pose
from pickcli.scene.scene import TOTE, Scene, empty_scene
from pickcli.simulation.guarded_move import GuardedMove

MOVED = pose((0.01, -0.02, 0.001), rpy=(0.0, 0.0, 0.02))


@pytest.fixture(scope="module")
def cell() -> Cell:
    return load_cell("apc2016_delft")


@pytest.fixture(scope="module")
def located(cell: Cell) -> LocatedTote:
    shape = tote_shape(cell)
    T = shape.T_world_tote @ MOVED
    points = [
        TouchedPoint(aim, (T @ [*aim.point, 1.0])[:3], 1e-4, 2e-4) for aim in touch_points(shape, 8, 0.015)
    ]
    record = GuardedMove(None, np.zeros((1, 8)), np.zeros(1), 0.2, 0.012, 5.0, 1e-3)
    touches = tuple(Touch(point, record) for point in points)
    return LocatedTote(fit_tote(points, shape.T_world_tote), touches, 38.0, ())


@pytest.fixture
def path(located: LocatedTote, cell: Cell, tmp_path: Path) -> Path:
    write_tote(located, cell, 7, tmp_path / "tote.json")
    return tmp_path / "tote.json"


def test_it_is_written_and_read_alike(path: Path, located: LocatedTote, cell: Cell) -> None:
    stated = read_tote(path, cell)
    np.testing.assert_allclose(stated.T_world_tote, located.estimate.T_world_tote, atol=1e-12)
    bounds = [located.estimate.bound(name) for name in ("x", "y", "yaw")]
    assert [stated.error.x, stated.error.y, stated.error.yaw] == bounds
    assert json.loads(path.read_text()) == json.loads(json.dumps(tote_values(located, cell, 7)))


def test_a_scene_takes_the_tote_from_it(path: Path, cell: Cell) -> None:
    scene: Scene = empty_scene(cell)
    at = read_tote(path, cell).carrier_pose(cell)
    moved = Scene(cell, scene.T_world_pod, (), scene.noise, carriers={TOTE: at})
    place = cell.places[TOTE]
    np.testing.assert_allclose(moved.T_world_place(place), cell.T_world_place(place) @ MOVED, atol=1e-9)


def put(*key: str | int, value: Any) -> Callable[[Any], None]:
    def change(data: Any) -> None:
        for part in key[:-1]:
            data = data[part]
        data[key[-1]] = value

    return change


@pytest.mark.parametrize(
    ("change", "told"),
    [(put("pose", "quaternion", value=[0, 0, 0, 2]), "pose.quaternion: expected a length of 1"),
     (put("error", "x", value=-1), "error.x"), (put("error", "yaw", value=0.2), "error.yaw"),
     (put("error", "z", value=float("nan")), "NaN is not JSON"), (put("touches", value=[]), "touches"),
     (put("further", value=1), "further"), (put("version", value=2), "version"),
     (put("touches", 0, "point", value=[0, 1]), "point"), (put("seed", value=-1), "seed")],
)  # fmt: skip
def test_mistakes_are_told(path: Path, cell: Cell, change: Callable[[Any], None], told: str) -> None:
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))
    with pytest.raises(InputError) as refusal:
        read_tote(path, cell)
    assert str(path) in str(refusal.value) and told in str(refusal.value)


@pytest.mark.parametrize(
    ("index", "off", "told"),
    [(0, 0.1, "pose: x is"), (1, -0.1, "pose: y is"), (2, 0.12, "pose: z is 12")],
)
def test_a_tote_where_no_touch_can_find_it_is_refused(
    path: Path, cell: Cell, index: int, off: float, told: str
) -> None:
    data = json.loads(path.read_text())
    data["pose"]["position"][index] += off
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match=told):
        read_tote(path, cell)


@pytest.mark.parametrize(
    ("quaternion", "told"),
    [([1, 0, 0, 0], "leans by 180 degrees"), ([0, 0, 0.7071068, 0.7071068], "pose: yaw is")],
)
def test_a_tote_that_leans_or_is_turned_away_is_refused(
    path: Path, cell: Cell, quaternion: list[float], told: str
) -> None:
    data = json.loads(path.read_text())
    data["pose"]["quaternion"] = quaternion
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match=told):
        read_tote(path, cell)


def test_that_of_another_cell_is_refused(path: Path) -> None:
    with pytest.raises(StaleError, match=r"made for cell apc2016_delft .*, but this is conveyor_sia20"):
        read_tote(path, load_cell("conveyor_sia20"))
