"""Turns of several arms: parks the arm that acted before another one moves.

As in KTH's system, one arm moves at a time while the others rest in their parking configurations. An arm that
acts again is not parked in between, nor is one that is parked already: tools on one flange share the
configuration, and take turns there without a motion.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.errors import Failures, InputError, NoPlanError
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.planning.start_state import Start
from pickcli.seeds import derived_seed
from pickcli.simulation.start_check import START_TOLERANCE
from pickcli.trial.attempt_runner import AttemptRunner
from pickcli.trial.recovery_levels import recover
from pickcli.trial.trial_interfaces import ARRIVAL
from pickcli.trial.trial_result import Attempt, Outcome


def hand_over(runner: AttemptRunner, attempt: Attempt) -> Attempt:
    """Park the arm that acted last, and switch to the arm of an attempt.

    Args:
        runner: Runs the attempts; its clock advances.
        attempt: The attempt with its certified plan, for another arm than the one that acted last.

    Returns:
        The attempt with the parking motion of the other arm, if it had to move; without its plan and with
        the reason if parking failed.
    """
    assert attempt.plan is not None
    arm = attempt.plan.arm
    parked = attempt if _is_parked(runner, arm) else _parked(runner, attempt)
    if parked.plan is None:
        return parked
    try:
        runner.let_move(arm)
    except InputError as error:
        return _given_up(parked, Outcome.NO_PLAN, str(error))
    return parked


def _is_parked(runner: AttemptRunner, arm: str) -> bool:
    """Whether the active arm stands where it is to stand while another one moves."""
    stated = next(state for state in runner.interfaces.cells[arm].others if state.arm == runner.arm)
    limits, arena = runner.interfaces.cells[runner.arm].robot.limits, runner.interfaces.arena
    off = np.abs(unwound_towards(limits, arena.q, stated.q) - stated.q)
    return arena.tool_state == stated.tool_state and float(off.max()) <= START_TOLERANCE


def _parked(runner: AttemptRunner, attempt: Attempt) -> Attempt:
    """Park the active arm; without the attempt's plan and with the reason if that fails."""
    assert attempt.plan is not None
    arm, scene, arena = runner.arm, runner.scene(), runner.interfaces.arena
    seed = derived_seed("park", runner.settings.seed, attempt.item, attempt.number)
    runner.charge()
    try:
        parking = runner.interfaces.park(scene, Start(arena.q, arena.tool_state), seed)
    except NoPlanError as error:
        return _given_up(attempt, Outcome.NO_PLAN, f"arm {arm} cannot be parked: {error.summary()}")
    certified = runner.certified(parking, scene)
    if isinstance(certified, Failures):
        return _given_up(attempt, Outcome.REJECTED, f"parking arm {arm}: {certified.summary()}")
    afterwards = attempt.plan.trajectory.duration + ARRIVAL + runner.settings.reality.look_time
    if not runner.has_time_for(certified, afterwards):
        needed = certified.trajectory.duration + afterwards
        reason = f"to park arm {arm} and to pick takes {needed:.1f} s, {runner.clock.left:.1f} s are left"
        return _given_up(attempt, Outcome.NO_TIME, reason)
    execution = runner.execute(certified)
    parked = replace(attempt, parking=execution)
    if execution.stopped:
        stopped = replace(attempt, plan=certified, execution=execution)
        parked = replace(parked, recovery=recover(runner, stopped, scene))
        return _given_up(parked, Outcome.NO_PLAN, f"parking arm {arm}: {execution.stopped}")
    return parked


def _given_up(attempt: Attempt, outcome: Outcome, reason: str) -> Attempt:
    return replace(attempt, plan=None, outcome=outcome, reason=reason)
