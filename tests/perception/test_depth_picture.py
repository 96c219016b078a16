"""Depth as the sensors of the package measure it, in the default cell and on walls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file, sensor_names
from pickcli.cell.sensors.material import Material
from pickcli.cell.sensors.sensor_model import DepthModel, SensorModel
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import InputError
from pickcli.geometry import Array, pose
from pickcli.perception.camera_pose import camera_pose, link_poses
from pickcli.perception.depth_picture import measure_depth
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene, RenderedSolid
from pickcli.scene.scene import PlacedItem, Scene, empty_scene

DEPTH_SENSORS = [name for name in sensor_names() if read_sensor(sensor_file(name)).depth is not None]


def wall(z: float) -> RenderedScene:
    shape = Shape(ShapeKind.BOX, (20.0, 20.0, 0.2))
    return RenderedScene((RenderedSolid(OwnerKind.CARRIER, "wall", shape, pose((0.0, 0.0, z + 0.1))),))


def sensor_named(name: str) -> tuple[SensorModel, DepthModel]:
    sensor = read_sensor(sensor_file(name))
    assert sensor.depth is not None
    return sensor, sensor.depth


@pytest.mark.parametrize("name", DEPTH_SENSORS)
@pytest.mark.parametrize("z", [0.6, 1.1])
def test_sensors_err_by_the_coefficients_of_their_files(name: str, z: float) -> None:
    """In the middle of a wall that faces the camera, by the terms of their deviation and their steps."""
    sensor, depth = sensor_named(name)
    measured = measure_depth(wall(z), sensor, np.eye(4), seed=3).depth.astype(np.float64)
    v, u = round(sensor.camera.cy), round(sensor.camera.cx)
    error = measured[v - 80 : v + 80, u - 80 : u + 80] - z
    sigma = depth.constant + depth.quadratic * (z - depth.from_depth) ** 2
    step = 0.0
    if depth.baseline:
        scale = sensor.camera.fx * depth.baseline
        sigma += depth.disparity_error * z * z / scale
        step = depth.disparity_step * z * z / scale
    assert np.isfinite(error).mean() > 0.99
    assert error.std() == pytest.approx(np.hypot(sigma, step / np.sqrt(12)), rel=0.12)
    assert abs(error.mean()) < 0.2 * sigma + 0.5 * step


def bin_scene(cell: Cell, name: str) -> tuple[Scene, PlacedItem]:
    """One item before the middle of bin E's back wall."""
    item, frame = cell.item(name), cell.T_world_place(cell.places["bin_E"])
    placed = PlacedItem(name, item, "bin_E", frame @ pose((0.15, 0.0, 0.12)))
    scene = empty_scene(cell)
    return replace(scene, items=(placed,)), placed


@pytest.mark.parametrize("material", list(Material))
def test_materials_give_back_what_the_sensor_says(cell: Cell, material: Material) -> None:
    scene, placed = bin_scene(cell, "folgers_classic_roast_coffee")
    scene = scene.moved(replace(placed, item=replace(placed.item, material=material)))
    sensor, depth = sensor_named("ensenso")
    looking = cell.configurations["cam_E"]
    rendered = RenderedScene.of(scene, looking.q, looking.tool_state)
    T = camera_pose(cell.robot, cell.cameras["hand"], looking.q, looking.tool_state)
    view = rendered.seen_by(sensor.camera, T)
    facing = (view.index == rendered.indices_of(placed.id)[0]) & (view.incidence < 0.9)
    assert facing.sum() > 5000
    lost = [np.isnan(measure_depth(rendered, sensor, T, seed).depth)[facing].mean() for seed in range(4)]
    clean = replace(sensor, depth=replace(depth, no_return={}))
    without = np.isnan(measure_depth(rendered, clean, T, 0).depth)[facing].mean()
    share = depth.no_return.get(material, 0.0)
    assert np.mean(lost) == pytest.approx(without + share * (1.0 - without), abs=0.04)


def test_same_seed_same_bytes(cell: Cell) -> None:
    scene, _ = bin_scene(cell, "dasani_water_bottle")
    looking = cell.configurations["cam_E"]
    sensor, _ = sensor_named("carmine")
    T = camera_pose(cell.robot, cell.cameras["hand"], looking.q, looking.tool_state)
    pictures = [
        measure_depth(RenderedScene.of(scene, looking.q, looking.tool_state), sensor, T, seed).depth.tobytes()
        for seed in (1, 1, 2)
    ]
    assert pictures[0] == pictures[1]
    assert pictures[0] != pictures[2]


def test_a_colour_camera_measures_no_depth() -> None:
    with pytest.raises(InputError, match="ids_wrist: is a colour camera"):
        measure_depth(wall(1.0), read_sensor(sensor_file("ids_wrist")), np.eye(4), 0)


def bins(cell: Cell) -> list[str]:
    return [name[-1] for name in cell.configurations if name.startswith("cam_")]


def test_the_hand_camera_looks_down_into_the_bin_of_each_camera_configuration(cell: Cell) -> None:
    """20 degrees down, from about 0.44 m before the shelf, to the middle of the mouth within its picture."""
    hand = cell.cameras["hand"]
    for letter in bins(cell):
        looking, place = cell.configurations[f"cam_{letter}"], cell.places[f"bin_{letter}"]
        T = camera_pose(cell.robot, hand, looking.q, looking.tool_state)
        down = np.degrees(np.arcsin(-T[2, 2]))
        assert 15.0 < down < 26.0
        assert T[:3, 1] @ [0.0, 0.0, 1.0] < -0.9  # the picture stands upright
        assert -0.55 < T[0, 3] < -0.35
        mouth = (cell.T_world_place(place) @ place.access.T_place_mouth)[:3, 3]
        column, row = hand.model.camera.project(np.linalg.inv(T)[:3] @ [*mouth, 1.0])
        assert 0 < column < hand.model.camera.width
        assert 0 < row < hand.model.camera.height


def test_the_boom_camera_sees_the_whole_floor_of_the_tote(cell: Cell) -> None:
    boom, home = cell.cameras["boom"], cell.configurations["home"]
    T = camera_pose(cell.robot, boom, home.q, home.tool_state)
    np.testing.assert_array_equal(T, boom.T_parent_camera)
    rendered = RenderedScene.of(empty_scene(cell), home.q, home.tool_state)
    view = rendered.seen_by(boom.model.camera, T)
    owners = np.array([solid.owner for solid in rendered.solids])[view.index]
    corners = np.array([[x, y, 0.58] for x in (-1.3, -0.8) for y in (-0.78, -0.45)])
    inside: Array = np.column_stack([corners, np.ones(4)]) @ np.linalg.inv(T).T
    for column, row in boom.model.camera.project(inside[:, :3]).round().astype(int):
        assert owners[row, column] == "tote"


def test_a_camera_moves_with_its_link(cell: Cell) -> None:
    hand, robot = cell.cameras["hand"], cell.robot
    for name in ("cam_A", "home"):
        at = cell.configurations[name]
        T = camera_pose(robot, hand, at.q, at.tool_state)
        np.testing.assert_allclose(
            np.linalg.inv(link_poses(robot, at.q, at.tool_state)["link_t"]) @ T,
            hand.T_parent_camera,
            atol=1e-12,
        )
