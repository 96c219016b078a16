"""How far an arm can take a camera is bounded by the lengths of its links."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell_file import cell_names, load_workcell
from pickcli.perception.camera_pose import camera_pose, farthest_camera

SEEING = [
    (name, arm, camera)
    for name in cell_names()
    for arm, cell in load_workcell(name).arms.items()
    for camera in cell.cameras
    if cell.cameras[camera].link is not None
]


@pytest.mark.parametrize(("name", "arm", "camera"), SEEING)
def test_no_configuration_takes_a_camera_farther_than_its_links_reach(
    name: str, arm: str, camera: str
) -> None:
    cell = load_workcell(name).arms[arm]
    robot, mounted, rng = cell.robot, cell.cameras[camera], np.random.default_rng(0)
    low, high = robot.limits.window
    drawn = rng.uniform(low, high, (50, robot.n_joints))
    stated = [at.q for at in cell.configurations.values()]
    state = next(iter(cell.configurations.values())).tool_state
    base, most = robot.T_world_base[:3, 3], farthest_camera(robot, mounted)
    away = [
        float(np.linalg.norm(camera_pose(robot, mounted, q, state)[:3, 3] - base)) for q in (*drawn, *stated)
    ]
    assert len(away) > 50 and max(away) <= most < 10.0
    assert max(away) > 0.2 * most, "a bound that tells something"


def test_nothing_is_said_of_a_camera_on_a_link_of_another_arm() -> None:
    cell = load_workcell("apc2016_kth_picking").arms["right"]
    camera = replace(next(iter(cell.cameras.values())), link="left_w2")
    assert farthest_camera(cell.robot, camera) == np.inf


def test_some_cells_have_cameras_on_links() -> None:
    assert len(SEEING) >= 3
