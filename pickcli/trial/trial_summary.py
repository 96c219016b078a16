"""Rows and sentences of the summary of a trial; the command formats them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from pickcli.cell.pod_tolerance import pod_stand
from pickcli.scene.scene import TOTE
from pickcli.simulation.reality import Reality
from pickcli.trial.disturbance import Disturbance, DisturbanceKind
from pickcli.trial.order import OrderKind
from pickcli.trial.tote_shift import tote_displacement
from pickcli.trial.trial_perception import PerceptionKind
from pickcli.trial.trial_result import TargetResult, TrialResult


@dataclass(frozen=True)
class Row:
    """Row of the summary table for one target.

    Attributes:
        bin: Name of the bin.
        item: Name of the item.
        into: Name of the destination.
        outcome: Outcome as the robot perceives it.
        points: Points by the true final state.
        planning_ms: Wall time of all planning calls for it; None without calls.
        motion_s: Simulated seconds of all motion for it.
        reason: Why it failed, "" if it succeeded.
    """

    bin: str
    item: str
    into: str
    outcome: str
    points: int
    planning_ms: float | None
    motion_s: float
    reason: str


def rows(result: TrialResult) -> tuple[Row, ...]:
    """Create one row per target.

    Args:
        result: The result of the trial.

    Returns:
        The rows, in the order of the work order.
    """
    return tuple(_row(target) for target in result.targets)


def _row(target: TargetResult) -> Row:
    planning = [a.statistics["planning_ms"] for a in target.attempts if "planning_ms" in a.statistics]
    motion = math.fsum(e.duration for attempt in target.attempts for e in attempt.executions)
    # A success after a retry still reports the earlier failure.
    reason = next((f"after: {a.reason}" for a in target.attempts if a.reason), "")
    return Row(
        target.target.bin, target.target.item, target.into, str(target.outcome), target.points,
        sum(planning) if planning else None, motion, target.reason or reason,
    )  # fmt: skip


def summary(result: TrialResult) -> tuple[str, ...]:
    """Create the sentences below the table.

    Args:
        result: The result of the trial.

    Returns:
        The sentences.
    """
    lines = [
        _counted(result),
        f"{result.clock:.1f} s on the trial's clock, {result.simulated:.1f} s of them motion, looks and "
        "waits",
        f"collisions {result.n_collisions}, limit violations {result.n_limit_violations}, "
        f"drops {len(result.drops)}",
        _seen(result),
    ]
    if result.before.cell.pod.bins:
        lines.append(f"the pod stood {pod_stand(result.before.T_nominal_pod)}")
    lines += _tote(result)
    lines += [
        f"arm {arm}: {work.delivered} of {work.executed} picks delivered" for arm, work in result.arms.items()
    ]
    lines += [
        f"{line.points:+d} {line.subject}: {line.reason}" for line in result.score.lines if line.points < 0
    ]
    lines += [_described(d) for d in result.disturbed if d.kind is not DisturbanceKind.PUSHED]
    n_told = len(lines)
    lines += [line for line in (result.aborted, result.cut_short, result.strategy_stuck) if line]
    if len(lines) == n_told and result.items_in_tote < len(result.targets):
        ended = why_it_ended([(tick.node, tick.is_success) for tick in result.ticks])
        lines += [f"the trial ended as {ended}"] if ended else []
    return tuple(lines)


def why_it_ended(ticks: Sequence[tuple[str, bool]]) -> str:
    """Say why a strategy tried no more, though targets were left.

    Args:
        ticks: Node and success of all ticks of its conditions and actions.

    Returns:
        The reason; "" if the last tick does not tell.
    """
    node, is_success = ticks[-1] if ticks else ("", True)
    if is_success:
        return ""
    if node.startswith("has_time_to_plan"):
        return "no time was left to plan"
    return "nothing was left to try" if node.startswith("choose_") else ""


def _counted(result: TrialResult) -> str:
    """Main result of the order."""
    n_there, n_targets = result.items_in_tote, len(result.targets)
    if result.order.kind is OrderKind.MOVE:
        return f"{n_there} of {n_targets} items delivered"
    points = f"score {result.score.total} of {result.score.maximum} by the rules of {result.order.year}"
    if result.order.kind is OrderKind.STOW:
        return f"{points}; {n_there} of {n_targets} items in bins"
    return f"{points}; {n_there} of {n_targets} targets in the tote"


def _seen(result: TrialResult) -> str:
    """How planning saw the scene; by camera, how often it did and how often bounds did not hold."""
    if result.perception is PerceptionKind.TRUTH:
        return "planning saw poses as they were"
    if result.perception is PerceptionKind.CAMERA:
        seen = [item for look in result.looks for item in look.items]
        bounded = [item for item in seen if item.is_believed]
        broken = sum(not item.is_bound_kept for item in bounded)
        motions = [motion.duration for look in result.looks for motion in look.motions]
        return (
            f"planning saw bins by camera: {len(bounded)} of {len(seen)} poses in {len(result.looks)} looks "
            f"were believed, {broken} of these were off by more than their bounds; the arm moved "
            f"{len(motions)} times to look, {math.fsum(motions):.1f} s"
        )
    return (
        f"planning saw poses with an error of up to {1e3 * result.noise.position:g} mm and "
        f"{math.degrees(result.noise.angle):g} degrees{_outliers(result.reality)}"
    )


def _tote(result: TrialResult) -> list[str]:
    """Where a displaced tote stood, and what touches told of it."""
    lines, true, touches = [], result.before, result.tote
    if TOTE in true.carriers:
        shift = tote_displacement(true)
        lines.append(
            f"the tote stood {1e3 * shift['x']:.1f} mm, {1e3 * shift['y']:.1f} mm and "
            f"{math.degrees(shift['yaw']):.2f} degrees off its place"
        )
    if touches is not None and touches.located is None:
        told = f"touches took {touches.duration:.1f} s and did not locate the tote"
        lines.append(f"{told}: {touches.reason}")
    elif touches is not None:
        off = touches.off(true)
        lines.append(
            f"touches located the tote in {touches.duration:.1f} s, truly off by "
            f"{1e3 * math.hypot(off['x'], off['y']):.2f} mm and {math.degrees(abs(off['yaw'])):.3f} degrees"
        )
    return lines


def _outliers(reality: Reality) -> str:
    """Share and size of pose outliers."""
    if not reality.pose_outlier_share:
        return ""
    share, scale = 100 * reality.pose_outlier_share, reality.pose_outlier_scale
    return f", {share:g} % of them of up to {scale:g} times as much"


def _described(d: Disturbance) -> str:
    """Describe a disturbed neighbour."""
    where = d.out_of if d.into == d.out_of else f"{d.out_of}, now {d.into}"
    fell = f", {d.fell:.2f} m down" if d.fell > 0.01 else ""
    how_far = f"{1e3 * d.moved:.0f} mm and {math.degrees(d.turned):.0f} degrees"
    return f"{d.item} in {where}: {d.kind}, {how_far}{fell}"
