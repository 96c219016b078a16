"""The last level of recovery: a jog of some millimetres that separates near pairs. See docs/recovery.md."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import MotionSegment
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.assembly.stitching import stitch_run
from pickcli.planning.recovery.recovery_rules import RecoveryRules

JOG = 0.012  # m that the fastest link or the tool moves in a jog
JOG_STEP = 1e-4  # rad or m, of the finite differences that give the direction of a jog
JOG_GAIN = 0.001  # m by which a jog must increase the smallest distance


def plan_jog(rules: RecoveryRules, label: str, seed: int) -> Plan | Failures:
    """Plan a short straight edge in joint space that increases the smallest distance most.

    Args:
        rules: Rules of the level and state of the robot.
        label: Name of the plan.
        seed: Seed recorded in the plan.

    Returns:
        The plan, or why none of the edges is accepted.
    """
    q, all_pairs = rules.start.q, rules.all_pairs
    before = all_pairs.clearance(q)
    ranked = []
    for step in _jogs(rules, all_pairs):
        there = q + step
        gain = all_pairs.clearance(there).distance - before.distance
        if gain >= JOG_GAIN:
            ranked.append((-gain, tuple(there.tolist())))
    none = Reason("no jog", "where the robot stopped", f"none takes {before} apart", before.item)
    failures = Failures.of(none)
    checker = rules.checker()
    for _, end in sorted(ranked):
        edge = np.stack([q, np.array(end)])
        if not checker.is_valid_edge(edge[0], edge[1]):
            failures += checker.explain_path(edge)
        elif (closes := rules.closes(edge)) is not None:
            failures += closes
        else:
            segment = MotionSegment(SegmentKind.TRANSIT, edge, mode=rules.mode()).scaled(rules.scale)
            plan = stitch_run(rules.context, rules.scene, [segment], label, seed)
            if isinstance(plan, Plan):
                return plan
            failures += plan
    return failures


def _jogs(rules: RecoveryRules, all_pairs: SceneChecker) -> Iterator[Array]:
    """Yield joint steps (n,) within the limits: along the distance gradient, tool directions and joints."""
    arm, q, tool_state = rules.context.arm, rules.start.q, rules.start.tool_state
    unit = np.eye(arm.n)
    ahead = np.array([all_pairs.clearance(q + JOG_STEP * e).distance for e in unit])
    behind = np.array([all_pairs.clearance(q - JOG_STEP * e).distance for e in unit])
    jacobian = np.linalg.pinv(arm.jacobian(q, tool_state), rcond=1e-3)
    axes = rules.entry.T_world_entry[:3, :3]
    ways = [sign * axes[:, k] for k in range(3) for sign in (1.0, -1.0)]
    ways.append(-arm.tip(q, tool_state)[:3, 2])
    directions = [ahead - behind, *(jacobian @ np.concatenate([way, np.zeros(3)]) for way in ways)]
    directions += [sign * e for e in unit for sign in (1.0, -1.0)]
    for direction in directions:
        farthest = _farthest(rules, direction * JOG_STEP / max(float(np.abs(direction).max()), 1e-12))
        if farthest <= 1e-9:
            continue
        step = direction * JOG_STEP / float(np.abs(direction).max()) * JOG / farthest
        if ((q + step > arm.limits.lower) & (q + step < arm.limits.upper)).all():
            yield step


def _farthest(rules: RecoveryRules, step: Array) -> float:
    """Return the largest distance (m) that a small joint step (n,) moves any link frame or the tool."""
    arm, q, tool_state = rules.context.arm, rules.start.q, rules.start.tool_state
    chain = arm.chain(tool_state)
    moved = np.asarray(chain.fk(q + step))[:, :3, 3] - np.asarray(chain.fk(q))[:, :3, 3]
    tool = arm.tip(q + step, tool_state)[:3, 3] - arm.tip(q, tool_state)[:3, 3]
    return float(np.linalg.norm(np.vstack([moved, tool]), axis=1).max())
