"""After a stop with an item between the fingers: back with it, let go, and out the way that they came."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pickcli.cell.cell import Cell
from pickcli.geometry import pose
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.recovery.retrace import ItemRecovery, StoppedMotion, back_to_start, bring_item
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.supervision import Supervisor
from pickcli.trial.simulated_cell import SimulatedArena
from pickcli.verification.verify import verify
from support.gripper_cell import OPEN

ERASER = "expo_dry_erase_board_eraser"


@pytest.fixture(scope="module")
def scene(gripper_cell: Cell) -> Scene:
    place, item = gripper_cell.places["tote"], gripper_cell.item(ERASER)
    T = gripper_cell.T_world_place(place) @ pose((0.1, 0.0, item.shape.extents[2] / 2), rpy=(0.0, 0.0, 0.3))
    return Scene(gripper_cell, gripper_cell.T_world_pod, (PlacedItem(ERASER, item, "tote", T),), PoseNoise())


@pytest.fixture(scope="module")
def plan(gripper_cell: Cell, scene: Scene) -> Plan:
    start = Start(gripper_cell.configurations["home"].q, OPEN)
    found = plan_pick(PlanningContext(gripper_cell), scene, PickQuery("tote", ERASER), start, seed=1)
    return certified(found, scene)


def certified(plan: Plan, scene: Scene, stopped: Plan | None = None) -> Plan:
    verdict = verify(plan, scene, None if stopped is None else stopped.trajectory)
    assert verdict.certificate is not None, [str(reason) for reason in verdict.reasons]
    return replace(plan, certificate=verdict.certificate)


def with_item(scene: Scene, stopped: StoppedMotion) -> Scene:
    return replace(scene, items=(), held=stopped.held_item(scene.cell.robot, scene.find(ERASER)))


def middle_of(plan: Plan, kind: SegmentKind) -> float:
    segment = next(s for s in plan.segments if s.kind is kind and s.held is not None)
    return (segment.t_start + segment.t_end) / 2


@pytest.mark.parametrize("bringing", ItemRecovery)
@pytest.mark.parametrize("kind", [SegmentKind.LIFT, SegmentKind.RETREAT, SegmentKind.TRANSFER])
def test_what_fingers_held_at_a_stop_is_brought_on_or_back_by_certified_plans(
    plan: Plan, scene: Scene, kind: SegmentKind, bringing: ItemRecovery
) -> None:
    stopped = StoppedMotion(plan, middle_of(plan, kind))
    held, limits = with_item(scene, stopped), scene.cell.robot.limits
    brought = certified(bring_item(stopped, bringing, held, limits, 0), held, plan)
    assert {segment.held for segment in brought.segments} == {ERASER}


def test_fingers_that_were_opened_go_back_open(plan: Plan, scene: Scene) -> None:
    stopped = StoppedMotion(plan, middle_of(plan, SegmentKind.LIFT))
    back = back_to_start(stopped, OPEN, replace(scene, items=()), scene.cell.robot.limits, 0)
    assert isinstance(back, Plan)
    assert {segment.tool_state for segment in back.segments} == {OPEN}
    certified(back, replace(scene, items=()), plan)


def test_a_stop_in_the_lift_ends_where_it_began_without_a_contact(
    plan: Plan, scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    def motion(self: Supervisor, command: object, segment: Segment) -> ProtectiveStop | None:
        if segment.kind is SegmentKind.LIFT and not provoked:
            provoked.append(segment)
            return ProtectiveStop(StopCause.CONTACT, "provoked", 1.0, 0.0, "Nm", 0.0)
        return None

    provoked: list[Segment] = []
    monkeypatch.setattr(Supervisor, "motion", motion)
    arena, limits = SimulatedArena(scene), scene.cell.robot.limits
    done = arena.execute(plan)
    assert done.stop_cause is StopCause.CONTACT and done.path_time is not None and arena.is_holding()
    stopped = StoppedMotion(plan, done.path_time)
    assert stopped.taken_at is not None
    if done.path_time > stopped.taken_at:  # it may have yielded as far back as to where it lifted off
        held = with_item(scene, stopped)
        brought = bring_item(stopped, ItemRecovery.BACK, held, limits, 0)
        assert arena.execute(certified(brought, held, plan)).stopped == ""
        stopped = StoppedMotion(plan, stopped.taken_at)
    assert plan.grasp is not None
    arena.release(plan.grasp.tool_state)
    assert arena.held is None and not arena.is_holding() and arena.tool_state == plan.grasp.tool_state
    now = arena.now()
    back = back_to_start(stopped, arena.tool_state, now, limits, 0)
    assert isinstance(back, Plan)
    assert arena.execute(certified(back, now, plan)).stopped == ""
    assert arena.collisions == ()
    arena.close()
