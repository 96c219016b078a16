"""What stops a motion, what it is told of, and that nothing else does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import box
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.simulation.braking import Return
from pickcli.simulation.execute import execute
from pickcli.simulation.plan_run import STOPPED_SPEED
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.reality import DEFAULT
from pickcli.simulation.servo import Servo
from pickcli.simulation.suction import SEAL_VACUUM
from pickcli.simulation.supervision import TORQUE_NOISE, ExternalTorque, Supervisor
from pickcli.simulation.thresholds import Thresholds
from pickcli.simulation.world import ROBOT, World
from support.pallet_stacks import CARTONS, station
from support.pedestal import BuildWorld, cube, evacuate
from support.rail_pick import GAP, T_END, rail_pick
from support.tool_states import STRAIGHT

INTRUDER = "intruder"
STIFFNESS = 40e3  # N/m of a forearm, ISO/TS 15066:2016, table A.3


def sweep(cell: Cell) -> Plan:
    """0.4 m along the rail, free: the middle third of a hand-made pick, without events."""
    plan = rail_pick(cell)
    rail = np.zeros(plan.trajectory.positions.shape)
    rail[:, 0] = np.linspace(0.0, 0.4, len(rail))
    still = np.zeros(rail.shape)
    trajectory = replace(
        plan.trajectory,
        times=np.linspace(0.0, 6.0, len(rail)),
        positions=plan.trajectory.positions[0] + rail,
        velocities=still,
        accelerations=still,
    )
    segment = Segment(SegmentKind.TRANSIT, 0.0, 6.0, STRAIGHT, None)
    return replace(plan, segments=(segment,), trajectory=trajectory, events=())


def fast_sweep(cell: Cell) -> Plan:
    """0.5 m along the rail and half a turn of the arm, at speed."""
    plan = sweep(cell)
    there = plan.trajectory.positions[0].copy()
    there[:2] += (0.5, 0.5)
    x = np.linspace(0.0, 1.0, 41)[:, None]
    way, along = there - plan.trajectory.positions[0], x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    trajectory = replace(
        plan.trajectory,
        times=x[:, 0],
        positions=plan.trajectory.positions[0] + along * way,
        velocities=30.0 * x**2 * (1.0 - x) ** 2 * way,
        accelerations=60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) * way,
    )
    segment = Segment(SegmentKind.TRANSIT, 0.0, 1.0, STRAIGHT, None)
    return replace(plan, segments=(segment,), trajectory=trajectory)


def world_with_box(cell: Cell, plan: Plan, ahead: float, *, supervision: bool = True) -> World:
    """The robot at the plan's first point, a box that gives way like an arm ``ahead`` m before its tip."""
    q = plan.trajectory.positions[0]
    bare = World(Scene(cell, cell.T_world_pod, (), PoseNoise()), q)
    tip = bare.tip[:3, 3].copy()
    way = tip_after(bare, plan) - tip
    bare.close()
    at = tip + way / np.linalg.norm(way) * (ahead + 0.05)
    body = box(INTRUDER, tuple(at - 0.05), tuple(at + 0.05))
    obstacles = replace(cell.obstacles, bodies=(*cell.obstacles.bodies, body))
    scene = Scene(replace(cell, obstacles=obstacles), cell.T_world_pod, (), PoseNoise())
    world = World(scene, q, reality=replace(DEFAULT, supervision=supervision))
    world.engine.soften(INTRUDER, STIFFNESS, 200.0)
    return world


def tip_after(world: World, plan: Plan) -> Array:
    return Arm(world.robot).tip(plan.trajectory.positions[-1], STRAIGHT)[:3, 3]


def test_a_box_in_the_way_stops_the_arm_by_its_motor_torque(cell: Cell) -> None:
    plan = sweep(cell)
    world = world_with_box(cell, plan, ahead=0.1)
    forces = [0.0]
    record = execute(
        plan, world,
        on_step=lambda w: forces.append(
            sum(t.force for t in w.engine.contact_points(ROBOT) if t.b == INTRUDER)
        ),
    )  # fmt: skip
    assert record.stop_cause is StopCause.CONTACT
    assert record.stop is not None and record.stop.measured > record.stop.threshold
    assert record.stopping_time is not None and record.stopping_time < 0.1
    assert 5.0 < max(forces) < 150.0
    assert record.collisions[0].b == INTRUDER  # the truth says what it was; the robot did not need it
    assert forces[-1] < 20.0  # it went back until nothing pressed any more
    before = world.q.copy()
    world.wait(0.2)
    assert np.abs(world.q - before).max() < 1e-3
    assert record.path_time is not None  # it stands on its path, from where a recovery leads on
    assert np.abs(plan.trajectory.sample(record.path_time)[0] - world.q).max() < 1e-3
    world.close()


def test_a_heavy_item_that_is_held_off_its_middle_turns_the_last_joint_and_is_no_contact(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    cell, carton = station().cell, CARTONS[0]
    home, item = cell.home, station().items[carton.id]
    scene = replace(station().empty(0), items=(station().presented(carton),))
    world = World(scene, home.q, home.tool_state)
    swung = 1.5 * np.linalg.eigvalsh(item.inertia)[-1] * cell.robot.limits.acceleration[-1]
    weight, least = 1.5 * 9.81 * item.mass, 0.06 * cell.robot.motor_forces["joint_t"]
    holding = Segment(SegmentKind.TRANSFER, 0.0, 1.0, home.tool_state, carton.id)
    for off, torque, is_stopped in ((0.0, 1.0, True), (0.06, -1e-3, False), (0.06, 1e-3, True)):
        supervisor = Supervisor(world, Arm(cell.robot), p_tip_item=np.array([off, 0.0, 0.1]))
        felt = np.zeros(cell.robot.n_joints)
        felt[-1] = least + swung + weight * off + torque
        monkeypatch.setattr(supervisor.external, "update", lambda *_, felt=felt: felt)
        assert (supervisor.motion(home.q, holding) is not None) is is_stopped
    world.close()


def test_after_a_contact_no_joint_drives_on_while_another_still_brakes(cell: Cell) -> None:
    plan = fast_sweep(cell)
    world = world_with_box(cell, plan, ahead=0.3)
    speeds, before = [], [world.q]

    def watch(w: World) -> None:
        speeds.append(np.abs(w.q - before[0]) / w.time_step)
        before[0] = w.q

    record = execute(plan, world, on_step=watch)
    assert record.stop is not None and record.stop_cause is StopCause.CONTACT
    first = round(record.stop.t / world.time_step)
    rail, arm = plan.trajectory.joint_names.index("rail"), plan.trajectory.joint_names.index("joint_s")
    stood = {
        j: next(k for k in range(first, len(speeds)) if speeds[k][j] < STOPPED_SPEED) for j in (rail, arm)
    }
    assert stood[arm] < stood[rail]
    braking = np.array(speeds[first : stood[rail]])
    assert (np.diff(braking[:, rail]) < 1e-3).all()
    world.close()


def test_the_way_back_begins_where_the_robot_stands_and_ends_on_its_path(cell: Cell) -> None:
    trajectory = fast_sweep(cell).trajectory
    q = trajectory.sample(0.5)[0] + 0.01 * np.linspace(-1.0, 1.0, len(trajectory.joint_names))
    led = Return(trajectory, 0.45, q, 0.3)
    points = [q]
    while not led.is_on_path:
        points.append(led.advance(1e-3))
    assert len(points) == 301
    assert np.abs(points[-1] - trajectory.sample(led.path_time)[0]).max() < 1e-12
    assert np.abs(points[-1] - q).max() < 0.0101
    assert np.abs(np.diff(points, axis=0)).max() < 2.0 * 0.01 / 300
    before = led.path_time
    assert np.abs(led.back(1e-3, 0.1) - trajectory.sample(before - 1e-4)[0]).max() < 1e-12


def test_without_supervision_the_same_box_is_pushed_on(cell: Cell) -> None:
    plan = sweep(cell)
    world = world_with_box(cell, plan, ahead=0.1, supervision=False)
    record = execute(plan, world)
    assert record.stop is None
    assert max(c.force for c in record.collisions) > 300.0
    world.close()


def test_an_arm_that_does_not_follow_is_stopped(cell: Cell) -> None:
    plan = sweep(cell)
    world = World(
        Scene(cell, cell.T_world_pod, (), PoseNoise()), plan.trajectory.positions[0], servo=Servo(lag=0.5)
    )
    record = execute(plan, world)
    assert record.stop_cause is StopCause.FOLLOWING_ERROR
    assert record.stop is not None and record.stop.where in ("rail", "tool")
    world.close()


@pytest.fixture
def ready(build_world: BuildWorld) -> World:
    world = build_world(cube(), gap=GAP, tool_state=STRAIGHT)
    world.planned = PlannedContacts()
    evacuate(world)
    return world


def test_a_seal_that_never_comes_stops_the_lift(cell: Cell, ready: World) -> None:
    record = execute(rail_pick(cell, valve_shift=0.4), ready)
    assert record.stop_cause is StopCause.NOT_SEALED
    assert record.stop is not None and record.stop.measured < SEAL_VACUUM / 1e3
    assert record.has_item is False


def test_what_each_cause_says_of_the_item() -> None:
    """Fingers like cups: what was carried falls; what was never held does not; a sensor is believed least."""
    lost = {cause for cause in StopCause if cause.has_lost_item}
    measured = {cause for cause in StopCause if cause.is_measured_empty}
    assert lost == {StopCause.SEAL_LOST, StopCause.GRASP_LOST}
    assert measured == lost | {StopCause.NOT_SEALED, StopCause.NOT_GRASPED}
    assert {cause for cause in StopCause if cause.is_empty} == measured | {StopCause.SENSOR}


def test_a_seal_that_breaks_stops_the_carry_and_is_known_by_the_gauge_alone(cell: Cell, ready: World) -> None:
    plan = rail_pick(cell)

    def leak(world: World) -> None:
        if world.t - t_start > 2.0:
            world.suction.vacuum.line = world.suction.vacuum.cup = 1e3  # as through a hole in the hose

    t_start = ready.t
    record = execute(plan, ready, on_step=leak)
    assert record.stop_cause is StopCause.SEAL_LOST
    assert record.has_item is False


def test_a_pick_that_goes_well_trips_nothing(cell: Cell, ready: World) -> None:
    record = execute(rail_pick(cell), ready)
    assert record.stop is None and record.duration > T_END
    assert record.stopping_time is None


def test_unexplained_torque_is_what_pushes_and_else_less_than_the_noise(cell: Cell) -> None:
    world = World(Scene(cell, cell.T_world_pod, (), PoseNoise()), cell.configurations["home"].q)
    names = world.robot.joint_names
    forces = np.array([world.robot.motor_forces[name] for name in names])
    external = ExternalTorque(world.inverse_dynamics, forces, world.time_step, 0)
    quiet = []
    for _ in range(300):
        world.step()
        quiet.append(np.abs(external.update(world.joints, world.torques)) / forces)
    assert np.max(quiet[50:]) < TORQUE_NOISE < Thresholds().torque
    push = np.array([0.0, 30.0, 0.0])
    expected = Arm(world.robot).jacobian(world.q, world.tool_state)[:3].T @ push
    for _ in range(100):
        world.engine.apply_force(ROBOT, push, world.tip[:3, 3], world.robot.tool.last_link)
        world.step()
        external.update(world.joints, world.torques)
    assert np.abs(external.value + expected).max() < TORQUE_NOISE * forces.max()
    world.close()


def test_a_large_item_that_is_swung_turns_the_last_joint_and_is_no_contact(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """1.5 times its largest moment of inertia times the limit of the joint's acceleration, more than 6 %."""
    cell, carton = station().cell, CARTONS[2]
    home, item = cell.home, station().items[carton.id]
    scene = replace(station().empty(0), items=(station().presented(carton),))
    world = World(scene, home.q, home.tool_state)
    swung = 1.5 * np.linalg.eigvalsh(item.inertia)[-1] * cell.robot.limits.acceleration[-1]
    least = 0.06 * cell.robot.motor_forces["joint_t"]
    holding = Segment(SegmentKind.TRANSFER, 0.0, 1.0, home.tool_state, carton.id)
    alone = replace(holding, held=None)
    for segment, torque, is_stopped in (
        (holding, least + swung - 1e-3, False),
        (holding, least + swung + 1e-3, True),
        (alone, least + 1e-3, True),
    ):
        supervisor = Supervisor(world, Arm(cell.robot))
        felt = np.zeros(cell.robot.n_joints)
        felt[-1] = torque
        monkeypatch.setattr(supervisor.external, "update", lambda *_, felt=felt: felt)
        stop = supervisor.motion(home.q, segment)
        assert (stop is not None and stop.where == "joint_t") is is_stopped
    world.close()
