"""The world: deterministic, at rest when nothing happens, a servo that trails by its lag."""

from __future__ import annotations

import numpy as np
import pytest
from pedestal import BuildWorld

from pickcli.cell.model import Cell
from pickcli.cell.robot import PivotState
from pickcli.cell.scene import PoseNoise, Scene
from pickcli.errors import UnknownNameError
from pickcli.kinematics.arm import Arm
from pickcli.simulation.places import OUTSIDE
from pickcli.simulation.servo import LAGGING, Servo
from pickcli.simulation.world import World


def swing(world: World, duration: float = 0.4) -> None:
    """All joints move, smoothly."""
    home = world.q.copy()
    start = world.t
    while world.t - start < duration:
        world.command(home + 0.1 * np.sin(np.pi * (world.t - start) / duration) ** 2)
        world.step()


def test_two_fresh_worlds_are_bit_identical(build_world: BuildWorld) -> None:
    states = []
    for _ in range(2):
        world = build_world(gap=0.01, shift=(0.015, 0.0))
        world.act("pump", "on")
        world.act("valve", "on")
        swing(world)
        states.append((world.q.tobytes(), world.tip.tobytes(), world.engine.pose("cube").tobytes()))
    assert states[0] == states[1]


def test_the_robot_holds_against_gravity(cell: Cell) -> None:
    world = World(Scene(cell, cell.T_world_pod, (), PoseNoise()), cell.configurations["bin_E"].q)
    before = world.tip.copy()
    world.wait(0.3)
    assert np.abs(world.tip - before).max() < 1e-5
    assert world.contacts.collisions == ()


@pytest.mark.parametrize("pivot", [PivotState.STRAIGHT, PivotState.DOWN])
def test_the_simulated_tip_is_where_the_kinematics_say(cell: Cell, pivot: PivotState) -> None:
    q = cell.configurations["bin_A"].q
    world = World(Scene(cell, cell.T_world_pod, (), PoseNoise()), q, pivot)
    assert np.allclose(world.tip, Arm(cell.robot).tip(q, pivot), atol=1e-6)


@pytest.mark.parametrize("servo", [Servo(), LAGGING])
def test_the_servo_trails_by_its_lag(cell: Cell, servo: Servo) -> None:
    scene = Scene(cell, cell.T_world_pod, (), PoseNoise())
    world = World(scene, cell.configurations["home"].q, servo=servo)
    speed, q = 0.5, world.q.copy()
    for _ in range(500):
        q = q + speed * world.time_step * (np.arange(8) == 0)
        world.command(q)
        world.step()
    # The set point is that of the step's end, so the lag is one step shorter.
    assert q[0] - world.q[0] == pytest.approx(speed * (servo.lag - world.time_step), rel=0.02)
    assert np.abs((q - world.q)[1:]).max() < 1e-6


def test_the_pivot_turns_within_its_lead(build_world: BuildWorld) -> None:
    world = build_world(gap=0.2)
    lead = world.scene.cell.devices["cup_pivot"].lead
    world.act("cup_pivot", "straight")
    world.wait(lead / 2)
    assert world.pivot is PivotState.MOVING
    world.wait(lead / 2 + 0.05)
    assert world.pivot is PivotState.STRAIGHT


def test_what_lies_outside_is_outside(build_world: BuildWorld) -> None:
    world = build_world()
    assert world.now().items[0].location == OUTSIDE


def test_unknown_devices_and_actions_are_named(build_world: BuildWorld) -> None:
    world = build_world()
    with pytest.raises(UnknownNameError, match="valve"):
        world.act("valv", "on")
    with pytest.raises(UnknownNameError, match="open"):
        world.act("valve", "open")
