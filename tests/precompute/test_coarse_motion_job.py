"""Records of stored motions and edges: what cannot be one of their task is told before it is used."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pickcli.errors import Reason
from pickcli.jobs.job_result import JobResult
from pickcli.precompute.coarse_motion_job import CoarseMotionJob
from pickcli.precompute.roadmap_edge_job import RoadmapEdgeJob
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.trajopt.trajectory_settings import TrajectorySettings
from support.small_cell import small_cell

CELL = small_cell("home", "bin_A")
N = CELL.robot.n_joints
VALUES = {
    "tool_state": "straight", "duration": 1.0, "lower_bound": 0.5, "clearance": 0.01,
    "pod_poses": "displaced", "why_nominal": "",
}  # fmt: skip
ARRAYS = {
    "waypoints": np.zeros((2, N)), "times": np.array([0.0, 0.5, 1.0]),
    **{name: np.zeros((3, N)) for name in ("positions", "velocities", "accelerations")},
}  # fmt: skip


def motion_fault(values: dict[str, Any], arrays: dict[str, np.ndarray]) -> str:
    job = CoarseMotionJob(CELL, TrajectorySettings())
    return job.misfit(("home", "bin_A", "empty"), JobResult(values, arrays))


def edge_fault(values: dict[str, Any], arrays: dict[str, np.ndarray]) -> str:
    return RoadmapEdgeJob(CELL, RoadmapSettings()).misfit(("bin_A", "home"), JobResult(values, arrays))


def test_what_a_task_returns_fits() -> None:
    assert motion_fault(VALUES, ARRAYS) == edge_fault(VALUES, ARRAYS) == ""
    nothing = JobResult(reason=Reason("no path"))
    assert CoarseMotionJob(CELL, TrajectorySettings()).misfit(("home", "bin_A", "empty"), nothing) == ""
    assert RoadmapEdgeJob(CELL, RoadmapSettings()).misfit(("bin_A", "home"), nothing) == ""


@pytest.mark.parametrize("name", sorted(VALUES))
def test_a_motion_without_a_field_is_refused(name: str) -> None:
    assert name in motion_fault({key: value for key, value in VALUES.items() if key != name}, ARRAYS)


@pytest.mark.parametrize("name", sorted(ARRAYS))
def test_a_motion_of_another_shape_is_refused(name: str) -> None:
    assert motion_fault(VALUES, ARRAYS | {name: np.zeros((4, N + 1))})
    assert name in motion_fault(VALUES, {key: array for key, array in ARRAYS.items() if key != name})


@pytest.mark.parametrize("change", [{"duration": "long"}, {"pod_poses": "anywhere"}])
def test_a_motion_of_other_values_is_refused(change: dict[str, Any]) -> None:
    assert motion_fault(VALUES | change, ARRAYS)


def test_an_edge_without_a_path_is_refused() -> None:
    assert "waypoints" in edge_fault(VALUES, {})
    assert "pod_poses" in edge_fault({"why_nominal": ""}, ARRAYS)
    for shape in ((1, N), (2, N + 1), (2,)):
        assert "no path" in edge_fault(VALUES, {"waypoints": np.zeros(shape)})
