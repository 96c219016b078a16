"""Figures of grasps that were played: how many were lifted, why others were not, times and forces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pickcli.hand.grasp_trial import GraspEnd, GraspTrial
from pickcli.hand.staged_execution import StageName


def grasp_figures(trials: Sequence[GraspTrial]) -> dict[str, Any]:
    """Sum grasps up.

    Args:
        trials: At least one.

    Returns:
        Numbers of grasps: all, lifted, enveloping, with a separation, and by end; s of approach and execution
        in the mean; N, the largest force on a pad.
    """
    return {
        "grasps": len(trials),
        "lifted": sum(trial.end is GraspEnd.LIFTED for trial in trials),
        "enveloping": sum(trial.is_enveloping for trial in trials),
        "separated": sum(_is_separated(trial) for trial in trials),
        "ends": {end.value: n for end in GraspEnd if (n := sum(t.end is end for t in trials))},
        "approach_time": float(np.mean([trial.approach_time for trial in trials])),
        "execution_time": float(np.mean([trial.execution_time for trial in trials])),
        "most_force": max(trial.most_force for trial in trials),
    }


def grasp_as_json(trial: GraspTrial) -> dict[str, Any]:
    """Describe a grasp as plain values.

    Args:
        trial: The grasp.

    Returns:
        Its pre-grasp in m and rad, end, and stages in s, A and rad.
    """
    return {
        "pre_grasp": [round(value, 6) for value in trial.pre_grasp.goal.tolist()],
        "end": trial.end.value,
        "enveloping": trial.is_enveloping,
        "held": list(trial.held),
        "most_force": round(trial.most_force, 3),
        "stages": [
            {
                "name": stage.name.value, "start": round(stage.start, 3), "end": round(stage.end, 3),
                "ended_by": stage.ended_by, "current": round(stage.current, 3),
                "angle": round(stage.angle, 4), "blocked": list(stage.blocked),
                "slipping": list(stage.slipping),
            }
            for stage in trial.stages
        ],
    }  # fmt: skip


def _is_separated(trial: GraspTrial) -> bool:
    return any(stage.name is StageName.SEPARATION for stage in trial.stages)
