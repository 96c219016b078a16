"""Baxter's motors as the simulation has them: strong enough for what the real arm does."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.geometry import GRAVITY
from pickcli.kinematics.arm import Arm
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.simulation.world import World

STRETCHED = np.array([0.3, -0.1, 0.0, 0.05, 0.0, 0.0, 0.0])  # the whole arm about level
PAYLOAD = 2.2  # kg, the maker's, tool included
SAG = 1e-3  # rad


@pytest.mark.parametrize("cell_name", ["apc2016_kth", "apc2016_kth_picking"])
@pytest.mark.parametrize("arm", ["left", "right"])
def test_an_arm_that_is_stretched_out_does_not_sag(cell_name: str, arm: str) -> None:
    """In S1 motor and springs together hold the arm; without a load, and with the maker's payload."""
    cell = load_cell(cell_name, arm)
    world = World(Scene(cell, cell.T_world_pod, (), PoseNoise()), STRETCHED)
    world.wait(0.5)
    assert np.abs(world.q - STRETCHED).max() < SAG
    needed = world.inverse_dynamics(world.joints, 0.0 * world.joints, 0.0 * world.joints)[1]
    robot, names = cell.robot, [link.name for link in cell.robot.links]
    tool_mass = sum(link.inertial.mass for link in robot.links[names.index(f"{arm}_gripper_base_link") :])
    jacobian = Arm(robot).jacobian(STRETCHED, robot.tool.default_state)
    with_payload = needed + (PAYLOAD - tool_mass) * GRAVITY * jacobian[2, 1]
    assert abs(needed) > 50.0  # more than the motor alone has
    assert abs(with_payload) <= robot.motor_forces[f"{arm}_s1"]
    world.close()
