"""Toppling in a bin: the tool comes in level, presses, turns over with the item, and leaves as it came."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.errors import NoPlanError
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.planning.topple import TopplingQuery, plan_topple
from pickcli.simulation.execute import execute
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.world import World
from pickcli.verification.straightness_check import tip_points
from pickcli.verification.verify import certify
from support.on_edge import BIN, BRUSH, CELL, ball, on_edge, shelf

CONTEXT = PlanningContext(CELL)
HOME = Start(CELL.configurations["home"].q, CELL.configurations["home"].tool_state)
SCENE = shelf(on_edge())


@pytest.fixture(scope="module")
def plan() -> Plan:
    return certify(plan_topple(CONTEXT, SCENE, TopplingQuery(BIN, BRUSH), HOME), SCENE)


def test_it_comes_in_level_presses_turns_and_leaves(plan: Plan) -> None:
    kinds = [segment.kind for segment in plan.segments]
    kind = SegmentKind
    n_pushes = kinds.count(kind.PUSH)
    assert kinds == [kind.TRANSIT, kind.PREAPPROACH, *[kind.PUSH] * n_pushes, kind.DEPART, kind.DEPART]
    assert n_pushes >= 3 and all(s.tool_state == CELL.robot.tool.rolling_state for s in plan.segments[1:])
    assert [s.pushing for s in plan.segments] == [(), (), *[(BRUSH,)] * (n_pushes + 2)]


def test_it_turns_over_away_from_the_wall_and_not_towards_the_mouth(plan: Plan) -> None:
    pushes = [segment for segment in plan.segments if segment.kind is SegmentKind.PUSH]
    times = np.array([pushes[0].t_start, pushes[-1].t_end])
    begin, end = tip_points(plan, CELL.robot, pushes[0].tool_state, times)
    way = CELL.T_world_place(CELL.places[BIN])[:3, :3].T @ (end - begin)
    assert way[1] < -0.04 and abs(way[0]) < 0.2 * abs(way[1])


def test_afterwards_it_lies_on_its_side_and_can_be_picked(plan: Plan) -> None:
    query = PickQuery(BIN, BRUSH)
    with pytest.raises(NoPlanError, match="no room for the tool"):
        plan_pick(CONTEXT, SCENE, query, HOME)
    world = World(SCENE, HOME.q, HOME.tool_state)
    run = execute(plan, world)
    assert not run.stopped and not run.limit_violations
    world.wait(0.5)
    assert not world.contacts.collisions
    now = replace(world.now(), noise=SCENE.noise)
    brush = now.find(BRUSH)
    assert brush.location == BIN and brush.T_world_item[2, 2] < -0.95  # the face -z is on top
    assert plan_pick(CONTEXT, now, query, Start(world.q, world.tool_state)).grasp is not None
    world.close()


def test_what_it_would_fall_on_is_named() -> None:
    scene = shelf(on_edge(), ball(0.2, 0.13))
    with pytest.raises(NoPlanError, match="no room to fall") as refused:
        plan_topple(CONTEXT, scene, TopplingQuery(BIN, BRUSH), HOME)
    assert refused.value.in_the_way == ("rawlings_baseball",)


def test_it_stops_on_what_is_higher_than_the_bellows_take_up(plan: Plan) -> None:
    """Within its bounds an error only presses harder; 4 mm would compress the bellows to their end."""
    low = SCENE.find(BRUSH)
    T = low.T_world_item.copy()
    T[2, 3] -= 0.004
    seen = shelf(replace(low, T_world_item=T))
    deeper = plan_topple(CONTEXT, seen, TopplingQuery(BIN, BRUSH), HOME)
    world = World(SCENE, HOME.q, HOME.tool_state)
    run = execute(deeper, world)
    assert run.stop is not None and run.stop.cause is StopCause.CONTACT
    world.close()
