"""Guarded moves: what is felt, what is not, and that the arm is back where it began."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from pickcli.calibration.tote_location import TOLERANCE, shifted_tote, simulated_tote_world
from pickcli.calibration.tote_shape import tote_shape
from pickcli.calibration.touch_planning import PlannedTouch, ToteBelief, plan_touch
from pickcli.calibration.touch_points import touch_points
from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import UNMOVED, Displacement
from pickcli.kinematics.arm import Arm
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import empty_scene
from pickcli.simulation.guarded_move import TouchSensing, guarded_move
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.world import World

pytestmark = pytest.mark.slow

CELL = load_cell("apc2016_delft")
NEAR = Displacement(0.004, 0.004, 0.005)  # so that lines are short


@pytest.fixture(scope="module")
def touch() -> PlannedTouch:
    """A touch of the wall at greater y from inside."""
    shape = tote_shape(CELL)
    aim, home = touch_points(shape, 6, CELL.robot.tool.grip.tip_radius)[0], CELL.home
    belief = ToteBelief(shape.T_world_tote, NEAR, 0.002)
    start = Start(home.q, home.tool_state)
    return plan_touch(PlanningContext(CELL), empty_scene(CELL), belief, aim, start, 3)


def world_at(touch: PlannedTouch, shift: Displacement = UNMOVED) -> Iterator[World]:
    """The world with the tote displaced, and the arm at the start of the line."""
    made = simulated_tote_world(empty_scene(CELL), shifted_tote(CELL, shift), 5)
    made.close()
    world = World(made.scene, touch.line.trajectory.positions[0], touch.tool_state, seed=5)
    yield world
    world.close()


def test_a_wall_is_felt_gently_and_the_arm_goes_back(touch: PlannedTouch) -> None:
    (world,) = [next(world_at(touch))]
    bodies, sensing = frozenset(touch.aim.face.bodies), TouchSensing()
    record = guarded_move(touch.line, world, bodies, sensing)
    assert record.is_felt and record.stop is not None and record.stop.cause is StopCause.CONTACT
    assert record.stop.measured >= sensing.threshold
    assert sensing.threshold - 0.5 < record.most_force < sensing.threshold + 2.0
    assert 0.0 < record.overshoot < 1e-3
    assert world.contacts.collisions == ()
    np.testing.assert_allclose(world.q, touch.line.trajectory.positions[0], atol=1e-4)
    assert len(record.positions) == len(record.forces) > 200
    assert abs(float(record.forces[:100].mean())) < 0.5 < float(record.forces[-20:].mean())
    tips = Arm(CELL.robot).tips(record.positions[[0, -1]], touch.tool_state)
    pressed = float((tips[1] - tips[0])[:3, 3] @ tips[0, :3, 2])
    assert 0.005 < pressed < 0.03


def test_nothing_is_felt_where_nothing_is(touch: PlannedTouch) -> None:
    (world,) = [next(world_at(touch, Displacement(0.0, TOLERANCE.y, 0.0)))]
    record = guarded_move(touch.line, world, frozenset(touch.aim.face.bodies))
    assert not record.is_felt and record.stop is None and record.most_force == 0.0
    np.testing.assert_allclose(world.q, touch.line.trajectory.positions[0], atol=1e-4)


def test_a_contact_that_is_not_to_be_is_logged_as_one(touch: PlannedTouch) -> None:
    (world,) = [next(world_at(touch))]
    guarded_move(touch.line, world, frozenset({"tote_wall_far"}))
    assert {each.b for each in world.contacts.collisions} <= set(touch.aim.face.bodies)
    assert world.contacts.collisions


def test_a_higher_threshold_presses_more(touch: PlannedTouch) -> None:
    forces = []
    for threshold in (3.0, 6.0):
        (world,) = [next(world_at(touch))]
        sensing = replace(TouchSensing(), threshold=threshold)
        forces.append(guarded_move(touch.line, world, frozenset(touch.aim.face.bodies), sensing).most_force)
    assert forces[1] > forces[0] + 2.0
