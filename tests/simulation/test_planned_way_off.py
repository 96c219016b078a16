"""The way off a belt for an arm whose joints all follow it: on along the plan, to rest after the lift."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.motion.segment import SegmentKind
from pickcli.simulation.belt_clock import BeltClock
from pickcli.simulation.execute import execute
from pickcli.simulation.planned_way_off import PlannedWayOff
from pickcli.simulation.reality import IDEAL
from pickcli.simulation.world import World
from support.pr2_picks import arm_pick, context, home

STEP = 1e-3


class Belt:
    """A belt at one speed until it stops at once, read without a delay."""

    def __init__(self, stops: float = np.inf) -> None:
        self.t, self.stops = 0.0, stops

    def belt_travel(self, conveyor: str) -> float | None:
        return 0.33 * min(self.t, self.stops)

    def encoder_latency(self, conveyor: str) -> float:
        return 0.0


def begun(belt: Belt, t_plan: float) -> PlannedWayOff:
    plan = arm_pick().plan
    clock = BeltClock(plan, context().cell, belt, STEP)
    while clock.scaling.t < t_plan and belt.t < 10.0:
        belt.t += STEP
        clock.next()
    return PlannedWayOff(plan, clock, STEP)


def test_it_goes_on_along_the_plan_and_ends_at_rest_and_clear() -> None:
    belt, plan = Belt(), arm_pick().plan
    off = begun(belt, 2.0)
    while not off.is_at_rest:
        belt.t += STEP
        q = off.next()
        assert q == pytest.approx(plan.trajectory.sample(off.t)[0])
    assert off.is_clear and not plan.trajectory.sample(off.t, 1).round(9).any()


def test_over_a_belt_that_has_stopped_the_arm_rests_where_it_is() -> None:
    belt = Belt(stops=2.0)
    off = begun(belt, 1.9)
    for _ in range(4000):
        belt.t += STEP
        off.next()
        if off.is_at_rest:
            break
    assert off.is_at_rest and not off.is_clear


def test_an_operators_stop_before_the_contact_ends_clear_of_the_belt() -> None:
    pick = arm_pick()
    contact = next(s for s in pick.plan.segments if s.kind is SegmentKind.CONTACT)
    t_stop = contact.t_start - 0.2
    world = World(pick.scene, home().q, home().tool_state, reality=IDEAL)
    world.run_belt("belt", 0.33)
    run = execute(pick.plan, world, operator=lambda t: t_stop <= t < t_stop + 0.5)
    assert run.stop is not None and run.is_clear
    assert not run.collisions and not run.limit_violations
    world.close()


def test_the_pick_is_executed_without_contact_or_violation() -> None:
    pick = arm_pick("right")
    world = World(pick.scene, home("right").q, home("right").tool_state, reality=IDEAL)
    world.run_belt("belt", 0.33)
    run = execute(pick.plan, world)
    assert run.stop is None and not run.collisions and not run.limit_violations
    assert pick.plan.grasp is not None and world.placed(pick.plan.grasp.item).location == "bin_right"
    world.close()
