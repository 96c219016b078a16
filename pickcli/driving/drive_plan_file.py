"""Writes plans of drives as JSON. See docs/formats/drive.md."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.driving.drive_plan import DrivePlan
from pickcli.driving.drive_smoothing import DECIMALS
from pickcli.driving.steering_path import wrapped
from pickcli.files.atomic_write import write_text

POSE_STEP = 0.1  # m of travel between poses in a file, at most


def write_drive_plan(path: Path, plan: DrivePlan, replace: bool = True) -> None:
    """Write a plan as JSON.

    Args:
        path: The file.
        plan: The plan.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written, or exists.
    """
    write_text(path, json.dumps(drive_to_dict(plan), indent=1) + "\n", replace)


def drive_to_dict(plan: DrivePlan) -> dict[str, Any]:
    """Return the content of a file.

    Args:
        plan: The plan.

    Returns:
        Plain values.
    """
    area, path, profile = plan.area, plan.path, plan.profile
    return {
        "format": "apc drive",
        "version": 1,
        "truck": asdict(area.truck),
        "margin": area.margin,
        "start": area.start.tolist(),
        "goal": area.goal.tolist(),
        "straight": area.straight,
        "figures": figures(plan),
        "actions": {"steps": _rounded(path.steps), "steering": _rounded(path.steering)},
        "profile": {"travel": _rounded(profile.travel), "speed": _rounded(profile.speeds)},
        "poses": _poses(plan),
    }


def figures(plan: DrivePlan) -> dict[str, Any]:
    """Return the figures of a plan that people ask for.

    Args:
        plan: The plan.

    Returns:
        Plain values.
    """
    return {
        "travel": round(plan.path.length, 6),
        "duration": round(plan.profile.duration, 6),
        "cusps": len(plan.path.cusps),
        "clearance": round(plan.clearance, 6),
        "lattice_travel": round(plan.lattice.path.length, 6),
        "lattice_cost": round(plan.lattice.cost, 6),
        "lattice_states": plan.lattice.n_expanded,
    }


def _poses(plan: DrivePlan) -> list[dict[str, float]]:
    n = max(2, int(np.ceil(plan.path.length / POSE_STEP)) + 1)
    travel = np.linspace(0.0, plan.path.length, n)
    poses = plan.path.poses_at(travel)
    rows = np.column_stack([
        np.interp(travel, plan.profile.travel, plan.profile.times), travel, poses[:, :2],
        wrapped(poses[:, 2]), plan.path.steering_at(travel),
    ])  # fmt: skip
    names = ("time", "travel", "x", "y", "yaw", "steering")
    return [dict(zip(names, _rounded(row), strict=True)) for row in rows]


def _rounded(values: Any) -> list[float]:
    return [round(float(value), DECIMALS) + 0.0 for value in values]
