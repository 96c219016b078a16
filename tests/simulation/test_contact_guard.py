"""An item that stands nearer than it was seen stops the contact before the bellows are through."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import TypeAlias, cast

import numpy as np
import pytest
from numpy.polynomial import polynomial

from pickcli.cell.cell import Cell
from pickcli.geometry import Array, rotation_axis_angle
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept
from pickcli.scene.item_stream import RidingItem
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.simulation.contact_guard import ContactGuard
from pickcli.simulation.execute import execute
from pickcli.simulation.execution import Execution
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.reality import IDEAL
from pickcli.simulation.supervision import ExternalTorque
from pickcli.simulation.world import World
from pickcli.trial.pose_noise import DEFAULT_NOISE
from support.belt_picks import belt_pick, context, home, stream
from support.belt_picks import cell as belt_cell
from support.pedestal import STATED_MASS, BuildWorld, cube, evacuate
from support.rail_pick import GAP, OVERTRAVEL, T_CONTACT, T_END, rail_pick
from support.tool_states import DOWN

TOO_NEAR = 0.006  # m: with the overtravel a millimetre more than the bellows give


@dataclass(frozen=True)
class Pressed:
    """A pick of an item that does not stand where the plan has it, and what the bellows bore in it."""

    record: Execution
    world: World
    depth: float  # m
    force: float  # N


Press: TypeAlias = Callable[..., Pressed]


def press_plan(cell: Cell) -> Plan:
    """The hand-made pick, downwards along the axis of the turned tool instead of forwards along the rail."""
    plan, arm = rail_pick(cell, distance=GAP), Arm(cell.robot)
    way = np.linspace(0.0, GAP + OVERTRAVEL, 200)
    Q = [plan.trajectory.positions[0]]
    for step in np.diff(way):
        axis = arm.tip(Q[-1], DOWN)[:3, 2]
        Q.append(Q[-1] + np.linalg.pinv(arm.jacobian(Q[-1], DOWN)) @ np.r_[step * axis, np.zeros(3)])
    along = polynomial.polyfit(way, np.array(Q), 5)
    first, second = polynomial.polyder(along), polynomial.polyder(along, 2)
    times = np.linspace(0.0, T_END, 270)
    rail, speed, acceleration = (values[:, 0] for values in plan.trajectory.states(times))
    s = rail - rail[0]
    trajectory = replace(
        plan.trajectory,
        times=times,
        positions=polynomial.polyval(s, along).T,
        velocities=(polynomial.polyval(s, first) * speed).T,
        accelerations=(
            polynomial.polyval(s, second) * speed**2 + polynomial.polyval(s, first) * acceleration
        ).T,
    )
    segments = tuple(replace(segment, tool_state=DOWN) for segment in plan.segments)
    return replace(plan, trajectory=trajectory, segments=segments)


@pytest.fixture
def press(cell: Cell, build_world: BuildWorld) -> Press:
    """Carries out the pick of an item that is so many m nearer than the plan believes."""

    def play(nearer: float, supervision: bool = True) -> Pressed:
        reality = replace(STATED_MASS, supervision=supervision)
        world = build_world(cube(mass=0.5), gap=GAP - nearer, tool_state=DOWN, reality=reality)
        world.planned = PlannedContacts()
        evacuate(world)
        touches = [(0.0, 0.0)]

        def watch(world: World) -> None:
            touches.extend((touch.depth, touch.force) for touch in world.suction.contact_points)

        record = execute(press_plan(cell), world, on_step=watch)
        depths, forces = zip(*touches, strict=True)
        return Pressed(record, world, max(depths), max(forces))

    return play


def test_what_is_too_near_stops_the_contact_before_the_bellows_are_through(press: Press, cell: Cell) -> None:
    found, cup = press(TOO_NEAR), cell.robot.tool.cup
    record, world = found.record, found.world
    assert record.stop is not None and record.stop_cause is StopCause.EARLY_CONTACT
    assert record.stopped_in is SegmentKind.CONTACT
    assert record.stop.measured == pytest.approx(TOO_NEAR + OVERTRAVEL, abs=1.5e-3)
    assert 0.5 * cup.stroke < found.depth < cup.stroke
    assert record.collisions == () and record.limit_violations == ()
    assert record.path_time is not None and record.path_time < T_CONTACT
    assert not world.suction.vacuum.is_valve_open and world.held is None
    assert "bellows" in record.stopped


def test_nobody_else_would_have_noticed(press: Press, cell: Cell) -> None:
    found, cup = press(TOO_NEAR, supervision=False), cell.robot.tool.cup
    assert found.depth > cup.stroke and found.force > cup.stiffness * cup.stroke
    assert [(c.a, c.b) for c in found.record.collisions] == [("cup", "cube")]


@pytest.mark.parametrize("nearer", [-0.001, 0.0, 0.002, 0.004])
def test_what_the_bellows_take_up_is_pressed_on_as_planned(press: Press, nearer: float) -> None:
    found = press(nearer)
    assert found.depth == pytest.approx(OVERTRAVEL + nearer, abs=5e-4)
    assert found.record.stop_cause is not StopCause.EARLY_CONTACT
    assert found.record.collisions == ()


def test_what_is_too_far_is_told_by_the_vacuum(press: Press) -> None:
    found = press(-TOO_NEAR)
    assert found.depth == 0.0
    assert found.record.stop_cause is StopCause.NOT_SEALED


def leaning_pick(leaning: float) -> Plan:
    """A pick from a belt that runs at 0.33 m/s, of an item that is seen leaning along it (deg)."""
    true, riding = stream(), stream().items[1]

    def as_seen(each: RidingItem) -> RidingItem:
        R = rotation_axis_angle(np.array([0.0, 1.0, 0.0]), np.deg2rad(leaning))
        T: Array = each.T_belt_item.copy()
        T[:3, :3] = R @ T[:3, :3]
        return replace(each, T_belt_item=T) if each is riding else each

    seen = replace(true, items=tuple(map(as_seen, true.items)), noise=DEFAULT_NOISE)
    return plan_intercept(context(), seen, InterceptQuery(riding.id, riding.stamp + 0.3), home())


def guarded(plan: Plan, pressed: float, rubbing: float) -> ProtectiveStop | None:
    """What the guard says of a contact in which all motors do exactly what they should, and the torques fit.

    pressed: m by which the bellows will be pressed in at the end of the contact
    rubbing: share of the pressing force with which the lip rubs on the face, along the belt
    """
    cell, arm, step = belt_cell(), Arm(belt_cell().robot), 0.001
    world = SimpleNamespace(robot=cell.robot, cell=cell, time_step=step, t=0.0)
    external = SimpleNamespace(value=np.zeros(len(cell.robot.joint_names)))
    guard = ContactGuard(cast(World, world), arm, plan, cast(ExternalTorque, external))
    contact = next(s for s in plan.segments if s.kind is SegmentKind.CONTACT)
    assert plan.tracking is not None
    end = arm.tip(plan.trajectory.sample(contact.t_end)[0], contact.tool_state)
    for t in np.arange(contact.t_start, contact.t_end, step):
        world.q = plan.trajectory.sample(t)[0]
        tip = arm.tip(world.q, contact.tool_state)
        z, way = tip[:3, 2], (end - tip)[:3, 3] - [plan.tracking.speed * (contact.t_end - t), 0.0, 0.0]
        force = max(0.0, pressed - float(way @ z)) * cell.robot.tool.grip.stiffness
        push = force * (z + rubbing * (np.array([1.0, 0.0, 0.0]) - z[0] * z))
        external.value = arm.jacobian(world.q, contact.tool_state)[:3].T @ push
        if (stop := guard.update(contact, float(t))) is not None:
            return stop
    return None


@pytest.mark.parametrize("rubbing", [0.0, 0.5, -0.5])
@pytest.mark.parametrize("leaning", [3.0, -3.0])
def test_neither_the_way_of_the_belt_nor_the_friction_of_the_lip_presses_a_leaning_cup_in(
    leaning: float, rubbing: float
) -> None:
    """The belt takes the cup 0.1 m along while it seals: three degrees would make 5 mm of it."""
    plan = leaning_pick(leaning)
    assert guarded(plan, 0.0065, rubbing) is None
    stop = guarded(plan, 0.015, rubbing)
    assert stop is not None and stop.cause is StopCause.EARLY_CONTACT
    assert stop.measured == pytest.approx(0.015, abs=1e-4)


def grown(scene: Scene, item: str, taller: float) -> Scene:
    """Make a box, which lies flat, taller (m) from the belt upwards."""

    def grow(placed: PlacedItem) -> PlacedItem:
        if placed.id != item:
            return placed
        size, T = np.array(placed.item.shape.size), placed.T_world_item.copy()
        size[int(np.argmax(np.abs(T[2, :3])))] += taller
        T[2, 3] += taller / 2
        shape = replace(placed.item.shape, size=tuple(size.tolist()))
        return replace(placed, item=replace(placed.item, shape=shape), T_world_item=T)

    return replace(scene, items=tuple(map(grow, scene.items)))


def test_what_is_15_mm_too_near_on_a_belt_stops_the_contact() -> None:
    """Pressed in as far, stroke and solid rubber would not be enough: the arm rests before the rigid cup."""
    pick, depths = belt_pick(), [0.0]
    assert pick.plan.grasp is not None
    item = pick.plan.grasp.item
    world = World(grown(pick.scene, item, 0.015), home().q, home().tool_state, reality=IDEAL)
    world.run_belt("belt", 0.33)

    def watch(world: World) -> None:
        depths.extend(touch.depth for touch in world.suction.contact_points)

    record = execute(pick.plan, world, on_step=watch)
    assert record.stop is not None and record.stop_cause is StopCause.EARLY_CONTACT and record.is_clear
    assert record.stop.measured > 0.012 and max(depths) < 0.012 and record.limit_violations == ()
    assert world.held is None and world.placed(item).location == "belt"
    world.close()
