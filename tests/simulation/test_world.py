"""The world: deterministic, at rest when nothing happens, a servo that trails by its lag."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tool import MOVING, ToolState
from pickcli.errors import UnknownNameError
from pickcli.geometry import Array, pose
from pickcli.kinematics.arm import Arm
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.simulation.places import OUTSIDE
from pickcli.simulation.reality import DEFAULT
from pickcli.simulation.scene_bodies import ground_of, true_masses
from pickcli.simulation.servo import IDEAL, Servo
from pickcli.simulation.suction import SEAL_VACUUM
from pickcli.simulation.world import ROBOT, World
from support.pedestal import BuildWorld, cube
from support.tool_states import DOWN, STRAIGHT


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


def test_a_link_is_told_anew_after_whatever_moves_it(cell: Cell) -> None:
    world = World(Scene(cell, cell.T_world_pod, (), PoseNoise()), cell.configurations["home"].q)
    engine, cup_link = world.engine, cell.robot.tool.last_link
    still = engine.pose(ROBOT, cup_link)
    engine.reset_joints(ROBOT, {world._indices[1]: world.q[1] + 0.1})
    moved = engine.pose(ROBOT, cup_link)
    assert np.abs(moved - still).max() > 0.05
    world.wait(1.0)  # the servo brings it back
    assert np.abs(engine.pose(ROBOT, cup_link) - still).max() < 1e-3
    world.close()


def test_what_stands_firm_sleeps_and_bears_what_falls_on_it(build_world: BuildWorld) -> None:
    world = build_world(gap=0.1)
    world.wait(2.5)  # long enough for the engine to let sleep whatever may
    stood = world.engine.pose("cube")
    world.engine.wake("cube")
    for _ in range(20):
        world.engine.apply_force("cube", np.array([0.0, 0.0, 40.0]), world.engine.pose("cube")[:3, 3])
        world.step()
    assert world.engine.pose("cube")[2, 3] > stood[2, 3] + 1e-3
    world.wait(0.5)
    assert abs(world.engine.pose("cube")[2, 3] - stood[2, 3]) < 5e-4
    world.close()


def test_the_robot_holds_against_gravity(cell: Cell) -> None:
    world = World(Scene(cell, cell.T_world_pod, (), PoseNoise()), cell.configurations["bin_E"].q)
    before = world.tip.copy()
    world.wait(0.3)
    assert np.abs(world.tip - before).max() < 1e-5
    assert world.contacts.collisions == ()


@pytest.mark.parametrize("tool_state", [STRAIGHT, DOWN])
def test_the_simulated_tip_is_where_the_kinematics_say(cell: Cell, tool_state: ToolState) -> None:
    q = cell.configurations["bin_A"].q
    world = World(Scene(cell, cell.T_world_pod, (), PoseNoise()), q, tool_state)
    assert np.allclose(world.tip, Arm(cell.robot).tip(q, tool_state), atol=1e-6)


def lag_behind(cell: Cell, servo: Servo, joint: int, speed: float = 0.3) -> tuple[float, World]:
    """How far a joint trails, in s, once it has moved at a constant speed for a while."""
    scene = Scene(cell, cell.T_world_pod, (), PoseNoise())
    world = World(scene, cell.configurations["home"].q, servo=servo)
    q = world.q.copy()
    for k in range(1000):
        q = q + speed * min(1.0, k / 300) * world.time_step * (np.arange(8) == joint)
        world.command(q)
        world.step()
    # The set point is that of the step's end, so the lag is one step shorter.
    return float(q[joint] - world.q[joint]) / speed + world.time_step, world


@pytest.mark.parametrize("lag", [2e-3, 20e-3])
def test_an_ideal_servo_trails_by_its_lag(cell: Cell, lag: float) -> None:
    behind, world = lag_behind(cell, replace(IDEAL, lag=lag), 0)
    assert behind == pytest.approx(lag, rel=0.02)
    assert np.abs(np.delete(world.q - cell.configurations["home"].q, 0)).max() < 1e-6


@pytest.mark.parametrize("joint", [0, 2, 4])
def test_each_joint_trails_by_its_own_lag_and_by_its_load(cell: Cell, joint: int) -> None:
    servo = Servo()
    behind, world = lag_behind(cell, servo, joint)
    own = servo.own_lags(cell.robot.joint_names)
    load = abs(world.torques[joint]) / cell.robot.motor_forces[cell.robot.joint_names[joint]]
    assert behind == pytest.approx(own[joint] * (1.0 + load), rel=0.1)
    assert np.all(np.abs(own / servo.lag - 1.0) <= servo.spread)
    assert np.ptp(own) > 0.5 * servo.spread * servo.lag


def accelerated(cell: Cell, acceleration: float, joint: int) -> tuple[float, Array]:
    """Farthest that a joint trails while its command accelerates for 0.2 s; largest torques over the
    forces."""
    scene = Scene(cell, cell.T_world_pod, (), PoseNoise())
    world = World(scene, cell.configurations["home"].q)
    forces = np.array([cell.robot.motor_forces[name] for name in cell.robot.joint_names])
    home, start, worst, shares = world.q.copy(), world.t, 0.0, np.zeros(8)
    while world.t - start < 0.2:
        q = home + 0.5 * acceleration * (world.t - start) ** 2 * (np.arange(8) == joint)
        world.command(q)
        world.step()
        worst = max(worst, float(q[joint] - world.q[joint]))
        shares = np.maximum(shares, np.abs(world.torques) / forces)
    return worst, shares


def test_torque_is_finite_and_four_times_the_acceleration_is_not_followed(cell: Cell) -> None:
    limit = cell.robot.limits.acceleration[0]
    followed, shares = accelerated(cell, limit, 0)
    assert followed < 3e-3 and shares.max() < 0.9
    lost, shares = accelerated(cell, 4 * limit, 0)
    assert lost > 10e-3 and shares[0] == pytest.approx(1.0, abs=1e-6)


def test_a_drive_has_a_ceiling_of_speed(cell: Cell) -> None:
    scene = Scene(cell, cell.T_world_pod, (), PoseNoise())
    world = World(scene, cell.configurations["home"].q)
    world.command(world.q + 0.5 * (np.arange(8) == 7))
    before, fastest = world.q.copy(), np.zeros(8)
    for _ in range(300):
        world.step()
        fastest, before = np.maximum(fastest, np.abs(world.q - before) / world.time_step), world.q.copy()
    assert np.all(fastest <= 1.06 * cell.robot.limits.velocity)


def test_the_cup_turns_within_its_lead(build_world: BuildWorld) -> None:
    world = build_world(gap=0.2)
    lead = world.scene.cell.devices["cup_pivot"].lead
    world.act("cup_pivot", "straight")
    world.wait(lead / 2)
    assert world.tool_state == MOVING
    world.wait(lead / 2 + 0.05)
    assert world.tool_state == STRAIGHT


def test_what_lies_outside_is_outside(build_world: BuildWorld) -> None:
    world = build_world()
    assert world.now().items[0].location == OUTSIDE


def world_with(cell: Cell, shape: Shape, T: Array) -> World:
    """A world with one item."""
    item = replace(cube(mass=0.3), shape=shape, seals=dict.fromkeys(shape.face_names, 1.0))
    scene = Scene(cell, cell.T_world_pod, (PlacedItem("it", item, "bin_A", T),), PoseNoise())
    return World(scene, cell.configurations["home"].q)


@pytest.mark.parametrize("off", [5e-3, -5e-3])
def test_what_topples_slowly_is_not_put_to_sleep(cell: Cell, off: float) -> None:
    """A tall box on its edge, its centre a hair beyond or short of being over it."""
    width, height = 0.06, 0.24
    lean = float(np.arctan(width / height)) + off
    # Turned about its lower edge, which lies on the floor of the hall.
    T = pose((-2.0, -2.0, 0.0), rpy=(0.0, lean, 0.0)) @ pose((-width / 2, 0.0, height / 2))
    world = world_with(cell, Shape(ShapeKind.BOX, (width, 0.06, height)), T)
    world.wait(6.0)
    up = world.engine.pose("it")[:3, :3] @ np.array([0.0, 0.0, 1.0])
    assert (abs(up[2]) < 0.1) if off > 0.0 else (up[2] > 0.99)
    assert world.engine.speed("it") == (0.0, 0.0)  # and sleeps once it lies


def test_what_rolls_off_the_floor_of_the_hall_stays_there_and_falls_no_farther(cell: Cell) -> None:
    _, high = ground_of(Scene(cell, cell.T_world_pod, (), PoseNoise()))
    edge, radius = float(high[1]), 0.04
    world = world_with(cell, Shape(ShapeKind.SPHERE, (radius,)), pose((-2.0, edge - 0.3, radius)))
    for _ in range(100):
        world.engine.apply_force("it", np.array([0.0, 4.0, 0.0]), world.engine.pose("it")[:3, 3])
        world.step()
    world.wait(1.5)
    there = world.engine.pose("it")
    assert there[1, 3] > edge and there[2, 3] > -0.2
    world.wait(1.0)
    np.testing.assert_array_equal(world.engine.pose("it"), there)
    assert world.placed("it").location == OUTSIDE


def test_the_sensor_reads_the_pressure_and_not_the_truth(build_world: BuildWorld) -> None:
    world = build_world()
    world.suction.vacuum.cup = 2.0 * SEAL_VACUUM
    assert world.held is None and world.act("vacuum_sensor", "read") is True
    world.suction.held, world.suction.vacuum.cup = "cube", 0.5 * SEAL_VACUUM
    assert world.act("vacuum_sensor", "read") is False


def test_unknown_devices_and_actions_are_named(build_world: BuildWorld) -> None:
    world = build_world()
    with pytest.raises(UnknownNameError, match="valve"):
        world.act("valv", "on")
    with pytest.raises(UnknownNameError, match="open"):
        world.act("valve", "open")


def test_links_of_the_robot_stop_each_other(cell: Cell) -> None:
    home = cell.configurations["home"].q.copy()
    home[0], home[2] = 0.6, 0.3
    world = World(Scene(cell, cell.T_world_pod, (), PoseNoise()), home)
    q = home.copy()
    for k in range(1500):  # fold the wrist until the lance lies on the upper arm
        q[6] = home[6] - 1.6 * min(1.0, k / 1200)
        world.command(q)
        world.step()
    links = {link.name for link in cell.robot.links}
    found = world.contacts.collisions
    assert found and all({c.a, c.b} <= links for c in found)
    assert world.q[6] - q[6] > 0.02


def test_links_that_may_touch_do_not_collide(cell: Cell) -> None:
    for name in ("home", "bin_A", "bin_K", "drop_00_down", "cam_L"):
        configuration = cell.configurations[name]
        world = World(
            Scene(cell, cell.T_world_pod, (), PoseNoise()), configuration.q, configuration.tool_state
        )
        world.wait(0.02)
        assert world.contacts.collisions == ()
        world.close()


def test_true_masses_are_off_by_no_more_than_the_error_and_follow_the_seed(build_world: BuildWorld) -> None:
    scene = build_world().scene
    reality = replace(DEFAULT, mass_error=0.1)
    stated = scene.items[0].item.mass
    masses = [true_masses(scene, reality, seed)["cube"] for seed in range(50)]
    assert masses == [true_masses(scene, reality, seed)["cube"] for seed in range(50)]
    assert 0.9 * stated <= min(masses) < 0.95 * stated < 1.05 * stated < max(masses) <= 1.1 * stated
    assert true_masses(scene, replace(DEFAULT, mass_error=0.0), 3)["cube"] == stated


def test_an_item_comes_into_a_running_world_and_is_taken_out_of_it(cell: Cell) -> None:
    """Time, arm and the other items go on as they were."""
    home = cell.configurations["home"]
    world = World(Scene(cell, cell.T_world_pod, (), PoseNoise()), home.q, home.tool_state, seed=2)
    crayons = cell.item("crayola_24_ct")
    floor = cell.T_world_place(cell.places["tote"])[:3, 3]

    def lying(name: str, x: float) -> PlacedItem:
        up = float(crayons.shape.extents[2]) / 2
        return PlacedItem(name, crayons, "tote", pose(floor + np.array([x, 0.0, up])))

    world.wait(0.1)
    q = world.q.copy()
    world.bring_in(lying("first", -0.1))
    world.bring_in(lying("second", 0.1))
    world.wait(0.3)
    assert world.t == pytest.approx(0.4) and np.abs(world.q - q).max() < 1e-3
    assert {placed.id: placed.location for placed in world.now().items} == {"first": "tote", "second": "tote"}
    masses = {name: world.engine.mass(name) for name in ("first", "second")}
    assert masses == true_masses(world.scene, world.reality, 2)
    rested = world.engine.pose("second")
    world.take_out("first")
    world.wait(0.2)
    assert [placed.id for placed in world.now().items] == ["second"]
    assert np.abs(world.engine.pose("second") - rested).max() < 1e-4
    assert not world.engine.has_body("first") and not world.contacts.collisions
    world.close()
