"""Recovery motions from where a motion stopped, on one of several levels. See docs/recovery.md.

Delft's and KTH's systems start over from a place in front of the shelf; a robot that stopped on a proven path
gets there by lines and coarse motions that are proven again, for the current state of the tool. If the usual
rules allow no way, each level relaxes them a little more, and the plan states its level.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from pickcli.cartesian.key_waypoints import PREAPPROACH_DISTANCE
from pickcli.cartesian.line import shifted
from pickcli.cartesian.line_following import follow_line
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.planning.assembly.stitching import stitch_run
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.recovery.jog import plan_jog
from pickcli.planning.recovery.recovery_rules import RecoveryRules, rules_at
from pickcli.planning.recovery.retrace import StoppedMotion, back_to_start
from pickcli.planning.start_state import Start
from pickcli.roadmap.query_experience import ExperienceRecorder
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.seeds import derived_seed

# m up, or back along the tool, in which the cup may still touch its contacts. Up is the shortest way off a
# support; a cup that came from the side would scrape along.
FIRST_UP = (0.02,)
FIRST_BACK = (0.02, 0.04)
SEPARATION_STEP = 0.02  # m to either side, or down, on the levels that separate near pairs

RISES = (0.0, 0.02, 0.04, 0.07, 0.10)  # m up after the first step, tried in this order
MOST_WAYS_HOME = 3  # ways out from which a way home is searched: each failure costs a whole search


def plan_recovery(
    context: PlanningContext,
    scene: Scene,
    start: Start,
    seed: int = 0,
    level: RecoveryLevel = RecoveryLevel.AS_PLANNED,
    stopped: StoppedMotion | None = None,
    recorder: ExperienceRecorder | None = None,
) -> Plan:
    """Plan from rest, with the empty tool, away from where a motion stopped.

    Args:
        context: The planning context.
        scene: The current scene.
        start: Configuration (n,) and tool state of the stopped robot.
        seed: Seed of the coarse motion.
        level: Level of recovery. ``AS_PLANNED`` and ``OPENING`` lead home; ``BACKWARDS`` to where the stopped
            motion began; ``SLOWLY`` out of pod or place; ``JOG`` some millimetres away from near solids.
        stopped: The motion that stopped, which ``BACKWARDS`` follows.
        recorder: Records experience of coarse queries; None discards it.

    Returns:
        The plan, uncertified, with ``level`` as its recovery level.

    Raises:
        NoPlanError: If nothing was found on that level.
    """
    label = f"recover {level}"
    found: Plan | Failures
    if level is RecoveryLevel.BACKWARDS:
        found = Failures.of(Reason("nothing to go back along", label))
        if stopped is not None:
            back = back_to_start(stopped, start.tool_state, scene, context.arm.limits, seed)
            found = Failures.of(back) if isinstance(back, Reason) else back
    else:
        rules = rules_at(context, scene, start, level)
        if isinstance(rules, Reason):
            found = Failures.of(rules)
        elif level is RecoveryLevel.JOG:
            found = plan_jog(rules, label, seed)
        else:
            found = _out(rules, label, seed, recorder or ExperienceRecorder())
    if isinstance(found, Failures):
        raise NoPlanError(label, found)
    # The plan is for the scene as it is, even if the level's rules modified it.
    return replace(found, scene_hash=scene_hash(scene), recovery=level)


def _out(rules: RecoveryRules, label: str, seed: int, recorder: ExperienceRecorder) -> Plan | Failures:
    """Plan out by lines, then home; on the level SLOWLY only out (stricter levels continue)."""
    context, failures = rules.context, Failures()
    n_ways_home = 0
    for out in _ways_out(rules):
        if isinstance(out, Failures):
            failures += out
            continue
        segments, q = out
        if rules.level is not RecoveryLevel.SLOWLY:
            n_ways_home += 1
            way = _home(rules.after_first_line, q, derived_seed(seed, label), recorder)
            if isinstance(way, Failures):
                failures += way
                if n_ways_home == MOST_WAYS_HOME:
                    break
                continue
            segments = [*segments, way]
        plan = stitch_run(context, rules.scene, segments, label, seed)
        if isinstance(plan, Plan):
            return plan
        failures += plan
    return failures


def _home(
    rules: RecoveryRules, q: Array, seed: int, recorder: ExperienceRecorder
) -> MotionSegment | Failures:
    """Plan the coarse motion home, by the usual rules if the arm is clear by then."""
    context, mode = rules.context, Mode(rules.start.tool_state)
    if not context.checker_for(rules.scene, mode).is_valid(q):
        mode = rules.mode()
    checker = context.checker_for(rules.scene, mode)
    goal = unwound_towards(context.arm.limits, context.cell.home.q, q)
    coarse = plan_coarse(context, checker, q, goal[None], [0.0], seed, "way home")
    if isinstance(coarse, Failures):
        return coarse
    recorder.record(coarse.experience)
    if (closes := rules.closes(coarse.waypoints)) is not None:
        return Failures.of(closes)
    return coarse.segment(SegmentKind.TRANSIT, mode)


def _ways_out(rules: RecoveryRules) -> Iterator[tuple[list[MotionSegment], Array] | Failures]:
    """Yield lines up, and out along the way in, the least rise first; no lines if nothing is near."""
    context, start = rules.context, rules.start
    tip = context.arm.tip(start.q, start.tool_state)
    depth = rules.entry.depth + PREAPPROACH_DISTANCE
    if depth <= 0.0 and not rules.touching and not rules.opening_pairs:
        yield [], start.q
    for first, rise in product(_first_steps(rules, tip), RISES):
        yield _risen_and_out(rules, tip, first, rise, max(depth, 0.0))


def _first_steps(rules: RecoveryRules, tip: Array) -> list[Array]:
    """Return displacements (3,) in the world that may free the tool from near solids."""
    up, T_world_entry = rules.entry.up, rules.entry.T_world_entry
    out, left, across, back = -T_world_entry[:3, 0], T_world_entry[:3, 1], T_world_entry[:3, 2], -tip[:3, 2]
    steps = [length * up for length in FIRST_UP] + [length * back for length in FIRST_BACK]
    if rules.level is not RecoveryLevel.AS_PLANNED:
        steps += [
            SEPARATION_STEP * way
            for way in (out, left, -left, -across, out + across, out - across, out + left, out - left)
        ]
        steps.append(np.zeros(3))
    return steps


def _risen_and_out(
    rules: RecoveryRules, tip: Array, first: Array, rise: float, depth: float
) -> tuple[list[MotionSegment], Array] | Failures:
    """Follow lines: first away from near solids, then up, then out."""
    context, start, entry, after = rules.context, rules.start, rules.entry, rules.after_first_line
    freed = shifted(tip, first)
    lifted = shifted(freed, rise * entry.up)
    stages = [
        (SegmentKind.DEPART, freed, rules.mode(rules.touching)),
        (SegmentKind.RETREAT, lifted, after.mode()),
        (SegmentKind.RETREAT, shifted(lifted, -depth * entry.T_world_entry[:3, 0]), after.mode()),
    ]
    segments, q, here = list[MotionSegment](), start.q, tip
    limits = SegmentLimits(rules.scale, context.settings.lift_speed)
    for kind, there, mode in stages:
        if np.allclose(there, here):
            continue
        checker = context.checker_for(rules.scene, mode)
        line = follow_line(context.arm, checker, here, there, start.tool_state, q, "way out")
        if isinstance(line, Failures):
            return line
        if (closes := rules.closes(line)) is not None:
            return Failures.of(closes)
        segments.append(MotionSegment(kind, line, limits, mode=mode))
        q, here = segments[-1].end, there
    return segments, q
