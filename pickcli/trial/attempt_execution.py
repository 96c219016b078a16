"""Executes a planned attempt and determines its outcome. See docs/recovery.md."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.scene.scene import TOTE, Scene
from pickcli.simulation.places import OUTSIDE
from pickcli.simulation.protective_stop import StopCause
from pickcli.trial.arm_turns import hand_over
from pickcli.trial.attempt_runner import AttemptRunner
from pickcli.trial.disturbance import MIN_TOPPLING_ANGLE
from pickcli.trial.final_state import HELD
from pickcli.trial.recovery_levels import recover
from pickcli.trial.trial_interfaces import ExecutionResult
from pickcli.trial.trial_result import Attempt, Outcome

MIN_SHIFT = 0.01  # m from which on a pushed item counts as moved: more than two pose errors


def carry_out(runner: AttemptRunner, attempt: Attempt) -> Attempt:
    """Execute a planned attempt.

    Args:
        runner: Runs the attempts; its clock advances.
        attempt: The attempt with its certified plan.

    Returns:
        The attempt with its execution; rejected if the arm that acted before cannot be parked.
    """
    assert attempt.plan is not None
    if attempt.plan.arm != runner.arm:
        attempt = hand_over(runner, attempt)
    return attempt if attempt.plan is None else _executed(runner, attempt)


def _executed(runner: AttemptRunner, attempt: Attempt) -> Attempt:
    assert attempt.plan is not None
    if not runner.has_time_for(attempt.plan, afterwards=runner.settings.reality.look_time):
        duration = attempt.plan.trajectory.duration
        reason = f"the motion takes {duration:.1f} s and a look, {runner.clock.left:.1f} s are left"
        return replace(attempt, outcome=Outcome.NO_TIME, reason=reason)
    runner.say(attempt, "moving")
    before = runner.scene()
    execution = runner.execute(attempt.plan)
    attempt = replace(attempt, execution=execution)
    if execution.stopped or runner.interfaces.arena.is_holding():
        runner.say(attempt, "recovering")
        attempt = replace(attempt, recovery=recover(runner, attempt, before))
    if attempt.topples:
        return _judged_toppling(runner, attempt, before)
    return _judged(runner, attempt, execution)


def _judged_toppling(runner: AttemptRunner, attempt: Attempt, before: Scene) -> Attempt:
    """Determine whether an item is perceived to lie on another side than before, or elsewhere."""
    assert attempt.execution is not None
    stopped = attempt.execution.stopped
    attempt = replace(attempt, truly_in=_true_place(runner, attempt.item))
    seen = next((placed for placed in runner.scene().items if placed.id == attempt.item), None)
    if not runner.is_current:
        return replace(attempt, outcome=Outcome.NO_TIME, reason="the time was over before a look")
    if seen is None:
        return replace(attempt, outcome=Outcome.LOST, reason="the item is not seen again")
    stood = before.find(attempt.item).T_world_item
    up = stood[2, :3]  # the vertical in the item's axes
    turned = float(np.arccos(np.clip(up @ seen.T_world_item[2, :3], -1.0, 1.0)))
    attempt = replace(attempt, seen_in=seen.location)
    if turned >= MIN_TOPPLING_ANGLE:
        return replace(attempt, outcome=Outcome.TOPPLED)
    shifted = float(np.linalg.norm(seen.T_world_item[:3, 3] - stood[:3, 3]))
    if shifted >= MIN_SHIFT:
        return replace(attempt, outcome=Outcome.MOVED)
    cause = f"{stopped}; " if stopped else ""
    reason = f"{cause}it is tilted by {np.degrees(turned):.0f} degrees, and {1e3 * shifted:.0f} mm away"
    return replace(attempt, outcome=Outcome.NOT_TOPPLED, reason=reason)


def _judged(runner: AttemptRunner, attempt: Attempt, execution: ExecutionResult) -> Attempt:
    """Determine the outcome as the robot perceives it, with the stop and the sensor as reasons."""
    seen = {placed.id: placed.location for placed in runner.scene().items}
    attempt = replace(attempt, truly_in=_true_place(runner, attempt.item))
    if not runner.is_current:
        reason = f"{execution.stopped or 'it was moved'}; the time was over before a look"
        return replace(attempt, outcome=Outcome.NO_TIME, reason=reason)
    attempt = replace(attempt, seen_in=seen.get(attempt.item, ""))
    has_stayed = attempt.out_of == attempt.into and not execution.has_item
    if attempt.seen_in == attempt.into and not has_stayed:
        there = Outcome.IN_TOTE if attempt.into == TOTE else Outcome.DELIVERED
        return replace(attempt, outcome=Outcome.MOVED if attempt.is_aside else there)
    where = f"the item is seen in {attempt.seen_in}" if attempt.seen_in else "the item is not seen again"
    missed = f"never reached: {', '.join(execution.missed)}" if execution.missed else ""
    cause = execution.stopped or missed or "it was let go"
    if execution.stop_cause is StopCause.WRONG_WEIGHT and attempt.seen_in == attempt.out_of:
        return replace(attempt, outcome=Outcome.WRONG_ITEM, reason=f"{cause}; brought back")
    if not execution.has_item and attempt.seen_in == attempt.out_of:
        return replace(attempt, outcome=Outcome.NOT_PICKED, reason=f"{cause}; {where}")
    return replace(attempt, outcome=Outcome.LOST, reason=f"{cause}; {where}")


def _true_place(runner: AttemptRunner, item: str) -> str:
    """Return the true place of an item, for the record only."""
    arena = runner.interfaces.arena
    if arena.held == item:
        return HELD
    return next((p.location for p in arena.now().items if p.id == item), OUTSIDE)
