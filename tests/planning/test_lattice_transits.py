"""Transits by ARA* on request: certified as any, repeatable, with a bound; and picks by the rules of 2013."""

from __future__ import annotations

from functools import cache
from unittest import mock

import numpy as np
import pytest

from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures, InputError
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.motion.plan import Plan
from pickcli.path_planning import lattice_planner
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept
from pickcli.planning.coarse_motion import plan_on_hand_lattice
from pickcli.planning.coarse_path import CoarsePath
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import COARSE_RESERVE, PlanningContext
from pickcli.planning.start_state import Start
from pickcli.stream_trials.stream_rules import StreamRule
from pickcli.verification.verify import certifier
from support import belt_picks
from support.pr2_picks import context, home, stream

EXPANSIONS = 300
ENDS = ("belt", "bin_left")
FIGURES = {"transit_cost_m", "transit_cost_bound", "transit_expansions"}


@cache
def by_lattice(most: int = EXPANSIONS) -> PlanningContext:
    return context().with_lattice_transits(most)


def over_the_bin() -> Start:
    named = context().cell.configurations["bin_left"]
    return Start(named.q, named.tool_state)


def met(rule: StreamRule, most: int = EXPANSIONS, start: Start | None = None) -> Plan:
    """The pick of the second item that comes, 0.2 s after it is on the belt."""
    items = stream()
    place = rule.meeting_place(context(), items.carrier)
    query = InterceptQuery(items.items[1].id, items.items[1].stamp + 0.2, "bin_left", place)
    return plan_intercept(by_lattice(most), items, query, start or over_the_bin())


@pytest.mark.parametrize("rule", StreamRule)
def test_the_verifier_accepts_a_pick_whose_transit_ara_star_planned(rule: StreamRule) -> None:
    plan = met(rule)
    assert plan.tracking is not None
    assert isinstance(certifier(stream().scene_at(plan.tracking.t_stream))(plan), Plan)
    assert set(plan.statistics) > FIGURES
    assert plan.statistics["transit_cost_m"] > 0.0 and plan.statistics["transit_cost_bound"] >= 1.0
    assert 0.0 < plan.statistics["transit_expansions"] <= EXPANSIONS


def test_by_the_rules_of_2013_contact_is_made_where_they_say() -> None:
    plan, items = met(StreamRule.PR2_2013), stream()
    place = StreamRule.PR2_2013.meeting_place(context(), items.carrier)
    assert plan.tracking is not None and place is not None
    t = next(s.t_end - 0.43 for s in plan.segments if str(s.kind) == "contact")
    met_at = items.travel_at(items.items[1], plan.tracking.t_stream + t)
    assert met_at == pytest.approx(place, abs=0.005)


def test_the_same_query_gives_the_same_motion_and_bound() -> None:
    first, again = (met(StreamRule.PR2_2013) for _ in range(2))
    assert first.trajectory.positions.tobytes() == again.trajectory.positions.tobytes()
    assert all(first.statistics[key] == again.statistics[key] for key in FIGURES)


def transit(most: int) -> CoarsePath:
    named = context().cell.configurations
    mode = Mode(home().tool_state, reserve=COARSE_RESERVE)
    checker = context().checker_for(stream().scene_at(0.0), mode)
    goals = unwound_towards(context().arm.limits, np.array([named[name].q for name in ENDS]), home().q)
    found = plan_on_hand_lattice(context(), checker, home().q, goals, most, "transit")
    assert not isinstance(found, Failures)
    return found


def test_more_expansions_lower_the_bound_and_never_raise_the_cost() -> None:
    few, many = (transit(most).searched for most in (EXPANSIONS, 3 * EXPANSIONS))
    assert few is not None and many is not None
    assert many.cost <= few.cost + 1e-12 and many.cost_bound <= few.cost_bound + 1e-12
    assert many.cost >= few.found[-1].lower_bound - 1e-12  # what was proven before holds


def test_it_ends_in_one_of_the_goals_to_the_last_turn() -> None:
    found = transit(EXPANSIONS)
    goal = context().cell.configurations[ENDS[found.goal]].q
    ends = unwound_towards(context().arm.limits, goal, home().q)
    assert np.array_equal(found.waypoints[-1], ends) and found.source == "lattice"
    assert np.array_equal(found.waypoints[0], home().q)


def test_a_belt_that_stands_gives_the_static_pick() -> None:
    items = stream(0.0, seed=5, one_by_one=True)
    first = items.items[0]
    items = items.presenting(first.id)
    query = InterceptQuery(first.id, 0.0, "bin_left")
    scene, place = items.scene_at(0.0), next(iter(items.carrier.places))
    plan = plan_intercept(by_lattice(), items, query, home())
    static = plan_pick(by_lattice(), scene, PickQuery(place, first.id, "bin_left"), home())
    assert plan.tracking is None and set(plan.statistics) > FIGURES
    assert plan.trajectory.positions.tobytes() == static.trajectory.positions.tobytes()
    assert isinstance(certifier(scene)(plan), Plan)


def test_an_arm_on_a_rail_is_planned_alike() -> None:
    items = belt_picks.stream()
    query = InterceptQuery(items.items[1].id, items.items[1].stamp + 0.3)
    on_rail = belt_picks.context().with_lattice_transits(EXPANSIONS)
    plan = plan_intercept(on_rail, items, query, belt_picks.home())
    assert plan.tracking is not None and set(plan.statistics) > FIGURES
    assert isinstance(certifier(items.scene_at(plan.tracking.t_stream))(plan), Plan)


def test_what_is_not_found_in_the_expansions_has_a_reason() -> None:
    checker = context().checker_for(stream().scene_at(0.0), Mode(home().tool_state))
    goal = context().cell.configurations["bin_left"].q[None]
    found = plan_on_hand_lattice(context(), checker, home().q, goal, 1, "transit")
    assert isinstance(found, Failures)
    told = "transit: no path: ARA* found none on its lattice in the 1 expansions that it may take"
    assert [str(reason) for reason in found] == [told]


def test_an_arm_without_a_lattice_is_refused_before_any_work() -> None:
    told = "cell pr2_belt: a lattice of hand poses needs an arm with 8 joints at least, not 7"
    with mock.patch.object(lattice_planner, "POSE_SIZE", 8):
        assert context().with_lattice_transits(None).settings.expansions is None
        with pytest.raises(InputError, match=told):
            context().with_lattice_transits(EXPANSIONS)
