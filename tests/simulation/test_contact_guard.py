"""An item that stands nearer than it was seen stops the contact before the bellows are through."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import pytest
from numpy.polynomial import polynomial

from pickcli.cell.cell import Cell
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.simulation.execute import execute
from pickcli.simulation.execution import Execution
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.world import World
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
