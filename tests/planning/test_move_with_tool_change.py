"""plan_move to another state of the tool: on the way, else at rest where that is free; with its event."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.motion_segment import Mode
from pickcli.errors import NoPlanError
from pickcli.motion.event import Event
from pickcli.motion.plan import Plan
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.world import World
from pickcli.verification.verify import certify, verify

SceneWith = Callable[..., Scene]
STRAIGHT, DOWN = ToolState("straight"), ToolState("down")


@pytest.fixture
def lead(cell: Cell) -> float:
    return cell.devices["cup_pivot"].lead


def states(plan: Plan) -> list[ToolState]:
    return [segment.tool_state for segment in plan.segments]


def played(plan: Plan, scene: Scene, start: Start) -> ToolState:
    world = World(scene, start.q, start.tool_state)
    try:
        run = execute(certify(plan, scene), world)
        assert run.is_clean and not run.missed
        np.testing.assert_allclose(world.q, plan.trajectory.positions[-1], atol=2e-3)
        return world.tool_state
    finally:
        world.close()


def near_something(context: PlanningContext, scene: Scene, state: ToolState) -> Iterator[np.ndarray]:
    """Yield configurations in which the tool may be in a state, and cannot change it."""
    fixed, moving = (context.checker_for(scene, Mode(s)) for s in (state, MOVING))
    rng = np.random.default_rng(3)
    Q = (context.arm.random_seeds(rng, 400) for _ in range(50))
    yield from (q for some in Q for q in some if fixed.is_valid(q) and not moving.is_valid(q))


def test_the_tool_changes_its_state_while_the_arm_moves(
    context: PlanningContext, scene_with: SceneWith, home: Start, cell: Cell, lead: float
) -> None:
    scene, goal = scene_with(), cell.configurations["bin_C"].q
    plan = plan_move(context, scene, home, MoveGoal(goal, DOWN))
    kept = plan_move(context, scene, home, MoveGoal(goal))
    assert states(plan) == [MOVING, DOWN] and states(kept) == [STRAIGHT] and not kept.events
    (event,) = plan.events
    assert (event.device, event.action, event.t_trigger, event.t_anchor) == ("cup_pivot", "down", 0.0, lead)
    assert plan.trajectory.duration < kept.trajectory.duration + 0.1, "the arm does not wait for the tool"
    assert played(plan, scene, home) == DOWN


def test_a_motion_shorter_than_the_lead_waits_for_the_tool(
    context: PlanningContext, scene_with: SceneWith, home: Start, lead: float
) -> None:
    scene, q = scene_with(), home.q.copy()
    q[1] += 0.02
    for goal, moves in ((q, True), (home.q, False)):
        plan = plan_move(context, scene, home, MoveGoal(goal, DOWN))
        assert states(plan) == [MOVING, DOWN]
        assert plan.segments[0].t_end == pytest.approx(lead)
        assert np.ptp(plan.trajectory.positions, axis=0).any() == moves
        assert played(plan, scene, home) == DOWN


def test_where_there_is_no_room_the_tool_changes_its_state_elsewhere_at_rest(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    scene = scene_with()
    n_there = n_back = 0
    for q in near_something(context, scene, STRAIGHT):
        try:
            there = plan_move(context, scene, replace(home, tool_state=DOWN), MoveGoal(q, STRAIGHT))
            back = plan_move(context, scene, Start(q, STRAIGHT), MoveGoal(home.q, DOWN))
        except NoPlanError:
            continue
        n_there += states(there) == [MOVING, STRAIGHT]  # at the start, before it moves
        n_back += states(back) == [STRAIGHT, MOVING, DOWN]
        for plan in (there, back):
            assert verify(plan, scene).reasons == ()
            k = states(plan).index(MOVING)
            t = np.linspace(plan.segments[k].t_start, plan.segments[k].t_end, 20)
            assert np.ptp(plan.trajectory.sample(t), axis=0).max() < 1e-9
        assert played(back, scene, Start(q, STRAIGHT)) == DOWN
        if n_back == 3:
            break
    assert n_there == n_back == 3


def test_without_room_anywhere_the_reason_names_what_is_in_the_way(
    context: PlanningContext, scene_with: SceneWith, cell: Cell
) -> None:
    bare = replace(cell, configurations={})
    narrow, scene = PlanningContext(bare), replace(scene_with(), cell=bare)
    q = next(near_something(context, scene, STRAIGHT))
    down = narrow.checker_for(scene, Mode(DOWN))
    goal = next(q for q in near_something(narrow, scene, DOWN) if down.is_valid(q))
    with pytest.raises(NoPlanError, match="from straight to down") as caught:
        plan_move(narrow, scene, Start(q, STRAIGHT), MoveGoal(goal, DOWN))
    assert any(reason.what == "no room to change the tool's state" for reason in caught.value.reasons)


def without_event(plan: Plan) -> Plan:
    return replace(plan, events=())


def other_way(plan: Plan) -> Plan:
    return replace(plan, events=(replace(plan.events[0], action="straight"),))


def late(plan: Plan) -> Plan:
    def later(event: Event) -> Event:
        assert event.t_anchor is not None and event.t_trigger is not None
        by, anchor = plan.segments[0].t_end - event.t_anchor + 0.01, event.anchor
        return replace(
            event, t_anchor=event.t_anchor + by, t_trigger=event.t_trigger + by,
            anchor=replace(anchor, offset=anchor.offset + by),
        )  # fmt: skip

    return replace(plan, events=tuple(later(event) for event in plan.events))


def in_one_state(plan: Plan) -> Plan:
    return replace(plan, segments=tuple(replace(s, tool_state=DOWN) for s in plan.segments))


@pytest.mark.parametrize("change", [without_event, other_way, late, in_one_state])
def test_the_verifier_derives_the_states_from_the_events(
    change: Callable[[Plan], Plan], context: PlanningContext, scene_with: SceneWith, home: Start, cell: Cell
) -> None:
    scene = scene_with()
    plan = plan_move(context, scene, home, MoveGoal(cell.configurations["bin_C"].q, DOWN))
    assert verify(plan, scene).reasons == ()
    assert "wrong tool state" in {reason.what for reason in verify(change(plan), scene).reasons}


def test_the_verifier_checks_the_room_for_the_change(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    """A change where the swept volume is not free, though both ends are."""
    scene = scene_with()
    plan = plan_move(context, scene, home, MoveGoal(home.q, DOWN))
    down = context.checker_for(scene, Mode(DOWN))
    found = (q for q in near_something(context, scene, STRAIGHT) if down.is_valid(q))
    refused: set[str] = set()
    for q in islice(found, 20):
        there = replace(plan.trajectory, positions=np.tile(q, (len(plan.trajectory.times), 1)))
        refused |= {reason.what for reason in verify(replace(plan, trajectory=there), scene).reasons}
    assert refused == {"too close"}
