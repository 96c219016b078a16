"""``plan_move``: a move of the empty tool (KTH's move primitive), which may change the state of the tool.

The tool changes its state while the arm moves, if all of the motion is free in every state. Otherwise it does
so at rest where that is free: at the start, at the goal or in a named configuration.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.motion_segment import Mode, MotionSegment, at_rest
from pickcli.collision.motion_validator import explain_each
from pickcli.errors import Failures, NoPlanError
from pickcli.geometry import Array
from pickcli.kinematics.continuous_joints import unwound_towards, ways_round
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.assembly.stitching import ToolChange, stitch_run, stitch_tool_change
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.roadmap.query_experience import ExperienceRecorder
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_seed


@dataclass(frozen=True, eq=False)
class MoveGoal:
    """Goal of a move.

    Attributes:
        q: (n,) configuration; continuous joints take the shorter way, up to whole turns.
        tool_state: State of the tool; None to keep that of the start.
    """

    q: Array
    tool_state: ToolState | None = None


def plan_move(
    context: PlanningContext,
    scene: Scene,
    start: Start,
    goal: MoveGoal,
    seed: int = 0,
    label: str = "move",
    recorder: ExperienceRecorder | None = None,
) -> Plan:
    """Plan a move of the empty tool from rest to rest.

    Args:
        context: The cell, its models and its precomputed files.
        scene: Poses as perceived; their noise bounds inflate the shapes.
        start: Configuration and tool state in which the robot is at rest.
        goal: Configuration and tool state in which it ends at rest.
        seed: Seed of all random choices.
        label: Name of the plan, also in messages.
        recorder: Records experience of coarse queries; None discards it.

    Returns:
        The plan, uncertified.

    Raises:
        NoPlanError: If the goal is not free, no motion to it was found, or there is no room on the way for
            the tool to change its state; with the reasons.
    """
    began = time.perf_counter()
    before, after = start.tool_state, goal.tool_state or start.tool_state
    checker = context.checker_for(scene, Mode(after))
    query = f"{label} with the tool {after if before == after else f'from {before} to {after}'}"
    if not checker.is_valid(goal.q):
        raise NoPlanError(query, [checker.explain(goal.q).at("goal")])
    move = _Move(context, scene, start, goal.q, after, derived_seed(seed, label), recorder)
    if before == after:
        way = move.segment(before, start.q, move.goals(start.q), "move")
        plan = way if isinstance(way, Failures) else stitch_run(context, scene, [way], label, seed)
    else:
        plan = _changing(move, label, seed)
    if isinstance(plan, Failures):
        raise NoPlanError(query, plan)
    return plan.with_statistics(planning_ms=1e3 * (time.perf_counter() - began))


@dataclass(frozen=True, eq=False)
class _Move:
    """A move in planning: ``q_goal`` is to be reached in the tool state ``after``."""

    context: PlanningContext
    scene: Scene
    start: Start
    q_goal: Array
    after: ToolState
    seed: int
    recorder: ExperienceRecorder | None

    def goals(self, q: Array) -> Array:
        """Return the goal in all ways (G, n) that continuous joints can take from a configuration."""
        return ways_round(self.context.arm.limits, self.q_goal, q)

    def segment(
        self, state: ToolState, q: Array, goals: Array, where: str, onward: Sequence[float] = ()
    ) -> MotionSegment | Failures:
        """Find a coarse motion to one of several goals in one state of the tool; onward: s after each."""
        mode, extra = Mode(state), onward or [0.0] * len(goals)
        checker = self.context.checker_for(self.scene, mode)
        coarse = plan_coarse(self.context, checker, q, goals, extra, self.seed, where)
        if isinstance(coarse, Failures):
            return coarse
        if self.recorder is not None:
            self.recorder.record(coarse.experience)
        return coarse.segment(SegmentKind.TRANSIT, mode)

    def places_to_change(self) -> Array | Failures:
        """Return configurations (K, n) in which the tool can change its state at rest, or why none can."""
        named = [each.q for each in self.context.cell.configurations.values()]
        near = unwound_towards(self.context.arm.limits, np.stack([self.q_goal, *named]), self.start.q)
        Q, checker = np.vstack([self.start.q, near]), self.context.checker_for(self.scene, Mode(MOVING))
        are_free = checker.are_valid(Q)
        if not are_free.any():
            return explain_each(checker, Q, "no room to change the tool's state", "move")
        return np.asarray(Q[are_free])

    def duration(self, q: Array, q_goal: Array) -> float:
        """Estimate the duration in s of a straight motion."""
        return estimated_duration(self.context.space, np.stack([q, q_goal]))


def _changing(move: _Move, label: str, seed: int) -> Plan | Failures:
    """Plan a move with a change of the tool's state: on the way, else at rest."""
    failures = Failures()
    for way in (_change_on_the_way, _change_at_rest):
        change = way(move)
        if not isinstance(change, Failures):
            plan = stitch_tool_change(move.context, move.scene, change, label, seed)
            if isinstance(plan, Plan):
                return plan
            change = plan
        failures += change
    return failures


def _change_on_the_way(move: _Move) -> ToolChange | Failures:
    q = move.start.q
    way = move.segment(MOVING, q, move.goals(q), "move while the tool changes its state")
    if isinstance(way, Failures):
        return way
    return ToolChange(
        at_rest(way.kind, q, Mode(move.start.tool_state)), way, at_rest(way.kind, way.end, Mode(move.after))
    )


def _change_at_rest(move: _Move) -> ToolChange | Failures:
    places = move.places_to_change()
    if isinstance(places, Failures):
        return places
    onward = [move.duration(q, move.q_goal) for q in places]
    there = move.segment(move.start.tool_state, move.start.q, places, "move to change the tool", onward)
    if isinstance(there, Failures):
        return there
    onwards = move.segment(move.after, there.end, move.goals(there.end), "move with the changed tool")
    if isinstance(onwards, Failures):
        return onwards
    return ToolChange(there, at_rest(there.kind, there.end, Mode(MOVING)), onwards)
