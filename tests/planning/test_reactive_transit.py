"""A controller rolls transits out: proven steps to where lines begin, or the reason and a planner instead."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.collision.motion_segment import Mode
from pickcli.control.roll_out import End
from pickcli.errors import Failures, Reason
from pickcli.motion.plan import Plan
from pickcli.planning.coarse_path import CoarsePath
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.pick_settings import GraspApproach
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages import grasp_transit
from pickcli.planning.stages.reactive_transit import roll_out_to
from pickcli.planning.start_state import Start
from pickcli.scene.scene import Scene, empty_scene
from pickcli.verification.verify import certifier

CELL = load_cell("panda_table")
CONTEXT = PlanningContext(CELL)
HOME = CELL.configurations["home"].q
STATE = CELL.robot.tool.default_state


@given(seed=st.integers(0, 10_000))
@settings(max_examples=15, deadline=None)
def test_what_is_rolled_out_is_free_all_along_and_ends_where_it_was_to(seed: int) -> None:
    checker = CONTEXT.checker_for(empty_scene(CELL), Mode(STATE))
    Q = CONTEXT.arm.random_seeds(np.random.default_rng(seed), 40)
    goals = Q[checker.are_valid(Q)][:2]
    stuck: dict[bytes, Reason] = {}
    found = roll_out_to(CONTEXT, checker, HOME, goals, STATE, seed, stuck)
    if isinstance(found, Failures):
        ends = {End.LOCAL_MINIMUM.value, End.NOT_PROVEN.value, End.OUT_OF_TIME.value}
        assert len(found.reasons) == len(goals) and {each.what for each in found.reasons} <= ends
        again = roll_out_to(CONTEXT, checker, HOME, goals[::-1], STATE, seed, stuck)
        assert isinstance(again, Failures) and set(again.reasons) == set(found.reasons)
        assert len(stuck) == len(goals)
        return
    assert isinstance(found, CoarsePath) and found.source == "controller"
    np.testing.assert_array_equal(found.waypoints[0], HOME)
    np.testing.assert_array_equal(found.waypoints[-1], goals[found.goal])
    assert checker.first_blocked_edge(found.waypoints) == -1


def test_most_goals_in_an_empty_cell_are_reached() -> None:
    checker = CONTEXT.checker_for(empty_scene(CELL), Mode(STATE))
    Q = CONTEXT.arm.random_seeds(np.random.default_rng(1), 60)
    goals = Q[checker.are_valid(Q)][:12]
    ended = [roll_out_to(CONTEXT, checker, HOME, goal[None], STATE, 1, {}) for goal in goals]
    assert sum(isinstance(each, CoarsePath) for each in ended) >= 9


def picked(context: PlanningContext, scene: Scene, home: Start) -> Plan:
    """A verified pick of crayons, whose transit a controller is to roll out."""
    reactive = context.with_approach(GraspApproach.REACTIVE)
    query = PickQuery("bin_B", "crayola_24_ct", into="bin_F")
    return plan_pick(reactive, scene, query, home, certify=certifier(scene))


def test_a_pick_is_rolled_out_verified_and_repeated(
    context: PlanningContext, scene_with: Callable[..., Scene], home: Start
) -> None:
    scene = scene_with(("crayola_24_ct", "bin_B", 0.2, 0.0))
    plan, again = (picked(context, scene, home) for _ in range(2))
    assert plan.certificate is not None and plan.statistics["transit_rolled_out"] == 1.0
    assert plan.grasp is not None and plan.grasp.envelope != ""
    np.testing.assert_array_equal(plan.trajectory.times, again.trajectory.times)


def test_where_no_roll_out_arrives_a_planner_takes_over_and_the_plan_says_so(
    context: PlanningContext, scene_with: Callable[..., Scene], home: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    stuck = Failures.of(Reason(End.LOCAL_MINIMUM.value, "controller"))
    monkeypatch.setattr(grasp_transit, "roll_out_to", lambda *_: stuck)
    plan = picked(context, scene_with(("crayola_24_ct", "bin_B", 0.2, 0.0)), home)
    assert plan.certificate is not None and plan.statistics["transit_rolled_out"] == 0.0
