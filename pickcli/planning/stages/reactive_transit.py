"""Transit that a controller rolls out: prioritized control to where the lines to a grasp begin.

The controller knows no future (Krug et al., RA-L 2016, section III-B). Each step of it is proven as it is
made; what it rolls out is shortened, timed and certified as any path. Where it ends in a local minimum for
every grasp, a planner takes over.
"""

from __future__ import annotations

import logging
from functools import cache

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.control.roll_out import ControlScene, RollOut, roll_out
from pickcli.control.stack_file import GIVEN, ControlledArm, StackFile, read_stack, stack_file
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.path_planning.shortcutting import shorten
from pickcli.planning.coarse_path import CoarsePath
from pickcli.planning.planning_context import PlanningContext

STACK = "reach"  # under data/stacks
# rad or m that each joint may be off, from where the rest is straight, if that is proven: where lines begin,
# something may be nearer than the controller wants.
NEAR = 0.2
MOST_SECONDS = 20.0  # of a roll-out
CONTROLLER = "controller"  # source of its paths

_log = logging.getLogger(__name__)


def roll_out_to(
    context: PlanningContext,
    checker: SceneChecker,
    q_start: Array,
    goals: Array,
    state: ToolState,
    seed: int,
    stuck: dict[bytes, Reason],
) -> CoarsePath | Failures:
    """Let the controller run from the start to the nearest of several configurations, or the next one.

    Args:
        context: The cell and its models.
        checker: Checker that proves each step.
        q_start: (n,) configuration at the start.
        goals: (G, n) configurations.
        state: State of the tool there.
        seed: Seed of the shortcuts.
        stuck: How roll-outs with this start and checker ended short of their goal, by its bytes; these are
            not repeated, and new ones are added.

    Returns:
        The motion; or how each roll-out ended.
    """
    if not checker.is_valid(q_start):
        return Failures.of(checker.explain(q_start).at("transit"))
    failures, file = Failures(), _stack()
    nearest = np.argsort(np.linalg.norm(goals - q_start, axis=1), kind="stable")
    for k in nearest[checker.are_valid(goals[nearest])].tolist():
        goal = goals[k].tobytes()
        if goal in stuck:
            failures += stuck[goal]
            continue
        controlled = ControlledArm(context.arm, state, checker, {GIVEN: goals[k]})
        run = _run(ControlScene(file.stack(controlled), checker), q_start, file.period)
        is_near = float(run.errors["posture"][-1]) <= NEAR
        if is_near and checker.is_valid_edge(run.Q[-1], goals[k]):
            rolled = JointPath(context.arm.names, np.vstack([run.Q, goals[k]]))
            short = shorten(
                checker, context.space, rolled, seed=seed, iterations=context.settings.shortcuts
            ).waypoints
            return CoarsePath(short, k, estimated_duration(context.space, short), CONTROLLER)
        detail = f"after {run.duration:.2f} s, a joint off by {float(run.errors['posture'][-1]):.3g}"
        stuck[goal] = Reason(run.end.value, "controller", detail)
        failures += stuck[goal]
    _log.info(
        "no roll-out reached a grasp, a planner takes over: %s", [str(each) for each in failures.reasons]
    )
    return failures


def _run(now: ControlScene, q_start: Array, period: float) -> RollOut:
    return roll_out(lambda _: now, q_start, MOST_SECONDS, period)


@cache
def _stack() -> StackFile:
    return read_stack(stack_file(STACK))
