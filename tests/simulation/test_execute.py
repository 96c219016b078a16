"""Executing plans: where it begins, when events fire, what stops it, what the record says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.paces import LAGGING, paused, slowed
from pickcli.cell.cell import Cell
from pickcli.cell.tools.lip_leak import FULL_VACUUM
from pickcli.commands.output.execution_report import trouble
from pickcli.errors import StaleError
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import SegmentKind
from pickcli.simulation.execute import execute
from pickcli.simulation.plan_run import SEAL_TIME
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.servo import IDEAL, Servo
from pickcli.simulation.simulated_cup import SEALED_VACUUM_SHARE
from pickcli.simulation.start_check import StartError
from pickcli.simulation.stream import Pace, full_speed
from pickcli.simulation.world import ROBOT, World
from support.pedestal import BuildWorld, cube, evacuate
from support.rail_pick import GAP, T_LIFT, rail_pick
from support.tool_states import STRAIGHT

BuildReady = BuildWorld


@pytest.fixture
def build_ready(build_world: BuildWorld) -> BuildReady:
    """The item 40 mm in front of the cup, the line evacuated."""

    def build(item: object = None, servo: Servo | None = None) -> World:
        world = build_world(item, gap=GAP, tool_state=STRAIGHT, servo=servo)
        world.planned = PlannedContacts()
        evacuate(world)
        return world

    return build


@pytest.mark.parametrize(
    ("servo", "pace"),
    [
        (None, full_speed),
        (LAGGING, full_speed),
        (None, slowed(0.4)),
        (None, paused(0.7, 0.5)),
        (LAGGING, paused(1.5, 0.3)),
    ],
    ids=["nominal", "lagging", "slowed", "paused", "lagging and paused"],
)  # fmt: skip
def test_events_fire_once_in_order_and_where_they_belong(
    cell: Cell, build_ready: BuildReady, servo: Servo | None, pace: Pace
) -> None:
    plan = rail_pick(cell)
    record = execute(plan, build_ready(servo=servo), pace=pace)
    assert [fired.event for fired in record.events] == list(plan.events)
    assert max(fired.distance for fired in record.events) < 2e-3
    assert record.missed == () and record.collisions == ()
    assert record.stopped == ""


def test_a_whole_pick_is_clean_and_releases_the_item(cell: Cell, build_ready: BuildReady) -> None:
    world = build_ready(servo=IDEAL)
    record = execute(rail_pick(cell), world)
    assert record.is_clean, record.trouble
    assert record.has_item is True
    (release,) = record.releases
    assert release.is_wanted and release.item == "cube"
    assert 0.0 < record.max_load < 1.0
    assert record.max_lag == pytest.approx(1e-3 * 0.5625, rel=0.1)  # peak speed times the net lag


def test_a_valve_that_opens_too_late_ends_without_the_item(cell: Cell, build_ready: BuildReady) -> None:
    record = execute(rail_pick(cell, valve_shift=0.4), build_ready())
    assert record.has_item is False
    assert record.stop_cause is StopCause.NOT_SEALED
    assert record.stopped_in in (SegmentKind.RETREAT, SegmentKind.TRANSFER)
    assert record.releases == ()


@pytest.mark.parametrize(("late", "seal"), [(0.26, 1.0), (0.28, 1.0), (0.1, 0.35)])
def test_the_lift_waits_for_the_vacuum_that_the_face_is_to_keep(
    cell: Cell, build_ready: BuildReady, late: float, seal: float
) -> None:
    plan = with_grasp(rail_pick(cell, valve_shift=late))
    world = build_ready(replace(cube(), seals=dict.fromkeys(cube().seals, seal)))
    at_lift: list[float] = []

    def watch(world: World) -> None:
        if world.q[0] < plan.trajectory.sample(T_LIFT)[0, 0] - 1e-3 and world.held:
            at_lift.append(world.suction.vacuum.cup)

    record = execute(plan, world, on_step=watch)
    assert record.stop is None and record.has_item is True
    assert at_lift[0] >= SEALED_VACUUM_SHARE * seal * FULL_VACUUM
    assert [fired.event for fired in record.events] == list(plan.events)
    assert record.limit_violations == () and record.collisions == ()
    usual = execute(with_grasp(rail_pick(cell)), build_ready())
    waited = record.duration - usual.duration
    assert 0.0 < waited < SEAL_TIME if seal == 1.0 else waited == pytest.approx(0.0, abs=1e-9)


def test_the_lift_does_not_wait_for_ever(cell: Cell, build_ready: BuildReady) -> None:
    plan = rail_pick(cell, valve_shift=0.4)
    hasty, patient = execute(plan, build_ready()), execute(with_grasp(plan), build_ready())
    assert hasty.stop_cause is patient.stop_cause is StopCause.NOT_SEALED
    assert patient.stop is not None and hasty.stop is not None
    waited = (patient.stop.t - patient.t_start) - (hasty.stop.t - hasty.t_start)
    assert waited == pytest.approx(SEAL_TIME, abs=2e-3)


def test_what_is_met_while_the_lift_waits_stops_the_motion(cell: Cell, build_ready: BuildReady) -> None:
    world = build_ready()
    t_lift = world.t + T_LIFT

    def push(world: World) -> None:
        if world.t > t_lift + 0.1:
            tip = world.tip[:3, 3]
            world.engine.apply_force(ROBOT, np.array([0.0, 300.0, 0.0]), tip, world.robot.tool.last_link)

    record = execute(with_grasp(rail_pick(cell, valve_shift=0.4)), world, on_step=push)
    assert record.stop_cause is StopCause.CONTACT and record.stopped_in is SegmentKind.CONTACT
    assert record.stop is not None and record.stop.t < t_lift + 0.2
    assert trouble([record]) == "1 protective stop"


def with_grasp(plan: Plan) -> Plan:
    """A plan that says on which face the cup seals, as those of the planner do."""
    grasp = Grasp("cube", "frontal", "-z", STRAIGHT, np.eye(4), *[0.1] * 6)
    return replace(plan, grasp=grasp)


def test_an_item_that_breaks_away_stops_the_robot_within_its_limits(
    cell: Cell, build_ready: BuildReady
) -> None:
    world = build_ready(cube(mass=2.6))  # its weight exceeds the shear that the cup holds
    record = execute(rail_pick(cell), world)
    assert record.stop_cause is StopCause.SEAL_LOST
    assert record.has_item is False
    assert trouble([record]) == ""  # a lost item is a result
    assert record.stopped_in is SegmentKind.RETREAT
    assert record.limit_violations == ()
    assert record.held is None
    (fall,) = record.falls
    assert not fall.is_wanted and fall.height > 0.1
    before = world.q.copy()
    world.wait(0.1)
    assert np.abs(world.q - before).max() < 1e-6


def test_it_refuses_to_start_elsewhere(cell: Cell, build_ready: BuildReady) -> None:
    world = build_ready()
    plan = rail_pick(cell)
    trajectory = replace(plan.trajectory, positions=plan.trajectory.positions + 0.02 * (np.arange(8) == 3))
    with pytest.raises(StartError, match=r"joint_e is 0\.0200") as caught:
        execute(replace(plan, trajectory=trajectory), world)
    assert caught.value.exit_code == 3
    near = replace(plan.trajectory, positions=plan.trajectory.positions + 0.009 * (np.arange(8) == 3))
    assert execute(replace(plan, trajectory=near), world).duration > 0.0


def test_it_refuses_plans_of_another_cell(cell: Cell, build_ready: BuildReady) -> None:
    with pytest.raises(StaleError, match="plan again"):
        execute(replace(rail_pick(cell), cell_fingerprint="0" * 64), build_ready())


def test_commands_beyond_a_limit_are_reported(cell: Cell, build_ready: BuildReady) -> None:
    record = execute(rail_pick(cell, distance=0.4), build_ready())
    assert {(v.joint, v.what) for v in record.limit_violations} == {("rail", "acceleration")}
    assert "limit violations" in record.trouble


def test_two_executions_give_the_same_record(cell: Cell, build_ready: BuildReady) -> None:
    records = [execute(rail_pick(cell), build_ready()) for _ in range(2)]
    assert [(f.t, f.distance) for f in records[0].events] == [(f.t, f.distance) for f in records[1].events]
    poses = [record.releases[0].T_world_item.tobytes() for record in records]
    assert poses[0] == poses[1]
