"""Brings the cameras that an arm carries to where they look from.

Team Delft's camera is on the tool, so that looking is a motion. The nearest viewpoint comes next; the motion
to it is planned while the arm is on its way to the one before, so only the first is charged to the clock.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.errors import Failures, NoPlanError
from pickcli.geometry import Array
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.motion.plan import Plan
from pickcli.perception.viewpoints import Viewpoint
from pickcli.planning.move import MoveGoal
from pickcli.planning.start_state import Start
from pickcli.seeds import derived_seed
from pickcli.trial.trial_interfaces import ExecutionResult
from pickcli.trial.trial_perception import LOOK_FROM, ReachedViews

if TYPE_CHECKING:
    from pickcli.trial.attempt_runner import AttemptRunner


def bring_cameras(runner: AttemptRunner, viewpoints: Sequence[Viewpoint]) -> ReachedViews:
    """Bring the cameras to viewpoints one after the other, and wait for a picture at each.

    Every motion is verified before it is carried out. What is left out: viewpoints to which no certified
    motion leads, and all for which no time is left, or that come after a motion that was stopped. With
    several arms, and for cameras that stand still, pictures are taken without a motion.

    Args:
        runner: Plans and executes; its clock advances.
        viewpoints: Where to look from.

    Returns:
        Those that were reached, with the motions.
    """
    is_moved = not runner.interfaces.cells
    left = [each for each in viewpoints if is_moved and each.camera.link is not None]
    reached = [each for each in viewpoints if each not in left]
    runner.wait(len(reached) * runner.settings.reality.look_time)
    motions: list[ExecutionResult] = []
    if left:
        runner.charge()
    while left:
        limits, q = runner.last_scene.cell.robot.limits, runner.interfaces.arena.q
        viewpoint = left.pop(int(np.argmin([_travel_time(limits, q, each.at.q) for each in left])))
        plan = _planned(runner, viewpoint)
        if isinstance(plan, Failures):
            continue
        if not runner.has_time_for(plan, afterwards=runner.settings.reality.look_time):
            break
        motions.append(runner.execute(plan))
        if motions[-1].stopped:
            break
        runner.wait(runner.settings.reality.look_time)
        reached.append(viewpoint)
    return ReachedViews(tuple(reached), tuple(motions))


def _planned(runner: AttemptRunner, viewpoint: Viewpoint) -> Plan | Failures:
    """Plan the motion to a viewpoint, and have it certified."""
    scene, at, arena = runner.last_scene, viewpoint.at, runner.interfaces.arena
    seed = derived_seed("look from", runner.settings.seed, runner.n_looks, at.name)
    goal = MoveGoal(at.q, at.tool_state)
    try:
        plan = runner.interfaces.move(
            scene, Start(arena.q, arena.tool_state), goal, seed, f"{LOOK_FROM}{at.name}"
        )
    except NoPlanError as error:
        return error.failures
    return runner.certified(plan, scene)


def _travel_time(limits: Limits, q: Array, goal: Array) -> float:
    """Least time in s between two configurations (n,)."""
    return float((np.abs(unwound_towards(limits, goal, q) - q) / limits.velocity).max())
