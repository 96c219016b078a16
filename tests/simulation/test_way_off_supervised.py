"""The way off a running belt is supervised as the plan is: contacts, joints that stay behind, the hold."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from pickcli.geometry import Array
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.simulation.contact_guard import ContactGuard
from pickcli.simulation.execute import execute
from pickcli.simulation.execution import Execution
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.reality import IDEAL
from pickcli.simulation.world import ROBOT, World
from support.belt_picks import belt_pick, home

BACK, ON = 4.2, 4.5  # s at which the belt runs away: the arm goes back along its lines, or on with the item
Provoke = Callable[[World], None]


def nothing(at: World) -> None:
    pass


def running_away(t_change: float, provoke: Provoke = nothing) -> tuple[Execution, World]:
    """A pick from a belt that becomes faster than the plan can follow; what happens after every step."""
    pick, start = belt_pick(), home()
    world = World(pick.scene, start.q, start.tool_state, reality=IDEAL)
    world.run_belt("belt", 0.33)

    def after_step(at: World) -> None:
        if at.t == pytest.approx(t_change):
            at.belts["belt"].change_speed(0.5, 0.5)
        provoke(at)

    run = execute(pick.plan, world, on_step=after_step)
    assert run.stop is not None and run.stop.cause is StopCause.BELT
    return run, world


@cache
def undisturbed(t_change: float) -> tuple[float, float]:
    """When the way off begins and ends if nothing happens on it, s."""
    run, world = running_away(t_change)
    world.close()
    assert run.stops_on_way_off == () and run.is_clear and run.stop is not None
    return run.stop.t, run.t_end


@pytest.mark.parametrize("t_change", [BACK, ON])
def test_a_push_on_the_way_off_brakes_the_arm_at_once(t_change: float) -> None:
    begins, _ = undisturbed(t_change)
    t_push = begins + 0.1

    def push(at: World) -> None:
        if t_push <= at.t < t_push + 0.1:
            tip = at.tip[:3, 3]
            at.engine.apply_force(ROBOT, np.array([0.0, -250.0, 0.0]), tip, at.robot.tool.last_link)

    run, world = running_away(t_change, push)
    (why,) = run.stops_on_way_off
    assert why.cause is StopCause.CONTACT and t_push < why.t < t_push + 0.1
    assert run.is_clear is False and "on the way off the conveyor: unexpected contact" in run.trouble
    stood_at = world.q
    world.wait(0.1)
    assert np.allclose(world.q, stood_at, atol=2e-3)
    world.close()


@pytest.mark.parametrize("t_change", [BACK, ON])
def test_a_joint_that_stays_behind_on_the_way_off_brakes_the_others(
    t_change: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    begins, _ = undisturbed(t_change)
    t_stuck, command, stuck = begins + 0.05, World.command, list[float]()

    def without_rail(self: World, q: Array) -> None:
        held = q.copy()
        if self.t >= t_stuck:
            stuck.append(stuck[0] if stuck else float(self.q[0]))
            held[0] = stuck[0]
        command(self, held)

    monkeypatch.setattr(World, "command", without_rail)
    run, world = running_away(t_change)
    (why,) = run.stops_on_way_off
    assert why.cause is StopCause.FOLLOWING_ERROR and t_stuck < why.t < t_stuck + 0.3
    assert run.is_clear is False
    world.close()


def test_a_seal_that_breaks_on_the_way_off_lets_go_of_the_item_and_the_arm_leaves_the_belt() -> None:
    begins, ends = undisturbed(ON)
    open_valves: dict[float, bool] = {}
    t_leak = ends - 0.6

    def leak(at: World) -> None:
        if at.t >= t_leak:
            at.suction.vacuum.line = at.suction.vacuum.cup = 1e3  # as through a hole in the hose
        open_valves[at.t] = at.suction.vacuum.is_valve_open

    run, world = running_away(ON, leak)
    (why,) = run.stops_on_way_off
    assert why.cause is StopCause.SEAL_LOST and begins < t_leak <= why.t < t_leak + 0.05
    assert run.is_clear and run.has_item is False and world.held is None
    assert open_valves[min(open_valves, key=lambda t: abs(t - t_leak))]
    assert not any(is_open for t, is_open in open_valves.items() if t > why.t + 0.1)
    world.close()


def test_an_item_that_is_met_too_early_on_the_way_off_turns_that_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    begins, _ = undisturbed(ON)
    feels, heights = ContactGuard.update, list[float]()

    def too_early(self: ContactGuard, segment: Segment, t_plan: float) -> ProtectiveStop | None:
        stop = feels(self, segment, t_plan)
        if segment.kind is SegmentKind.CONTACT and heights and len(heights) > 20:
            return ProtectiveStop(StopCause.EARLY_CONTACT, "bellows", 0.02, 0.01, "m", begins)
        return stop

    def look(at: World) -> None:
        if at.t > begins:
            heights.append(float(at.tip[2, 3]))

    monkeypatch.setattr(ContactGuard, "update", too_early)
    run, world = running_away(ON, look)
    assert [why.cause for why in run.stops_on_way_off] == [StopCause.EARLY_CONTACT]
    assert run.is_clear and run.collisions == () and run.limit_violations == () and world.held is None
    assert not world.suction.vacuum.is_valve_open and heights[-1] > heights[0] + 0.03
    assert run.path_time is not None and run.path_time < begins  # where its lines begin
    world.close()


def test_an_item_that_never_seals_is_left_on_the_belt_when_it_is_lifted() -> None:
    begins, _ = undisturbed(ON)

    def leak(at: World) -> None:
        at.suction.vacuum.line = at.suction.vacuum.cup = 0.0

    run, world = running_away(ON, leak)
    (why,) = run.stops_on_way_off
    assert why.cause is StopCause.NOT_SEALED and why.t > begins
    assert run.is_clear and world.held is None
    world.close()
