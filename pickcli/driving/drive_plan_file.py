"""Reads and writes plans of drives as JSON. See docs/formats/drive.md."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Len
from pydantic import Field

from pickcli.driving.drive_plan import DrivePlan
from pickcli.driving.drive_smoothing import DECIMALS
from pickcli.driving.driving_area_file import TruckModel
from pickcli.driving.steering_path import wrapped
from pickcli.driving.tricycle import Tricycle
from pickcli.files.atomic_write import write_text
from pickcli.files.file_kind import DRIVE
from pickcli.files.schema import Coordinate, FileModel, Number, validate
from pickcli.files.source import Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array

POSE_STEP = 0.1  # m of travel between poses in a file, at most
POSE_KEYS = ("time", "travel", "x", "y", "yaw", "steering")
MOST_ACTIONS, MOST_POINTS = 10_000, 100_000  # in a file
Step = Annotated[float, Field(ge=-100.0, le=100.0)]  # m of travel
Steering = Annotated[float, Field(ge=-1.6, le=1.6)]  # rad
Travel = Annotated[float, Field(ge=0.0, le=10_000.0)]  # m
Speed = Annotated[float, Field(ge=0.0, le=10.0)]  # m/s


@dataclass(frozen=True, eq=False)
class StatedDrive:
    """What a file says of a drive.

    Attributes:
        truck: The truck.
        margin: m that it keeps from everything.
        start: (3,) m, m, rad.
        goal: (3,) m, m, rad.
        straight: m of the straight end, negative backwards.
        steps: (K,) m of travel from knot to knot, negative backwards.
        steering: (K + 1,) rad at each knot.
        travel: (N,) m, points of the speed profile.
        speeds: (N,) m/s at them.
        poses: (M, 6) the drive as a table, columns as in ``POSE_KEYS``.
        duration: s, from start to goal.
        length: m of travel, as ``figures`` tells.
        n_cusps: Changes between forwards and backwards, likewise.
        clearance: m, least distance from everything at samples, likewise.
    """

    truck: Tricycle
    margin: float
    start: Array
    goal: Array
    straight: float
    steps: Array
    steering: Array
    travel: Array
    speeds: Array
    poses: Array
    duration: float
    length: float
    n_cusps: int
    clearance: float


class _Figures(FileModel):
    travel: Number
    duration: Number
    cusps: int
    clearance: Number
    lattice_travel: Number
    lattice_cost: Number
    lattice_states: int


class _Actions(FileModel):
    steps: Annotated[tuple[Step, ...], Len(1, MOST_ACTIONS)]
    steering: Annotated[tuple[Steering, ...], Len(2, MOST_ACTIONS + 1)]


class _Profile(FileModel):
    travel: Annotated[tuple[Travel, ...], Len(2, MOST_POINTS)]
    speed: Annotated[tuple[Speed, ...], Len(2, MOST_POINTS)]


class _Pose(FileModel):
    time: Number
    travel: Number
    x: Number
    y: Number
    yaw: Number
    steering: Number


_Pose3 = Annotated[tuple[Coordinate, ...], Len(3, 3)]


class _Drive(FileModel):
    format: Literal["apc drive"]
    version: Literal[1]
    truck: TruckModel
    margin: Annotated[float, Field(ge=0, le=0.5)]
    start: _Pose3
    goal: _Pose3
    straight: Annotated[float, Field(ge=-5, le=5)]
    figures: _Figures
    actions: _Actions
    profile: _Profile
    poses: Annotated[tuple[_Pose, ...], Len(2, MOST_POINTS)]


def read_drive(path: Path) -> StatedDrive:
    """Read a plan of a drive.

    Args:
        path: The file.

    Returns:
        What it says.

    Raises:
        InputError: The file cannot be read, is of another kind or has mistakes.
    """
    source = read_yaml(path, DRIVE)
    model = validate(source, _Drive)
    _check_lengths(source, model)
    poses = np.array([[getattr(row, key) for key in POSE_KEYS] for row in model.poses])
    told = model.figures
    return StatedDrive(
        Tricycle(**dict(model.truck)), model.margin, np.array(model.start), np.array(model.goal),
        model.straight, np.array(model.actions.steps), np.array(model.actions.steering),
        np.array(model.profile.travel), np.array(model.profile.speed), poses, told.duration,
        told.travel, told.cusps, told.clearance,
    )  # fmt: skip


def _check_lengths(source: Source, model: _Drive) -> None:
    """Refuse lists that do not belong to each other, and steps that lead nowhere. Raises InputError."""
    actions, profile = model.actions, model.profile
    n_steps, n_angles = len(actions.steps), len(actions.steering)
    if n_angles != n_steps + 1:
        told = f"{n_angles} angles for {n_steps} steps; state one more than steps"
        source.add(("actions", "steering"), told)
    if 0.0 in actions.steps:
        source.add(("actions", "steps", actions.steps.index(0.0)), "a step of no travel; leave it out")
    if len(profile.speed) != len(profile.travel):
        told = f"{len(profile.speed)} speeds at {len(profile.travel)} points; state one at each"
        source.add(("profile", "speed"), told)
    if (np.diff(profile.travel) <= 0.0).any():
        source.add(("profile", "travel"), "does not increase from point to point")
    source.check()


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
        plan.profile.times_at(travel), travel, poses[:, :2],
        wrapped(poses[:, 2]), plan.path.steering_at(travel),
    ])  # fmt: skip
    return [dict(zip(POSE_KEYS, _rounded(row), strict=True)) for row in rows]


def _rounded(values: Any) -> list[float]:
    return [round(float(value), DECIMALS) + 0.0 for value in values]
