"""What the planning commands share: artifacts, configurations from the command line, the summary."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.options import progress
from pickcli.errors import InputError, UnknownNameError

if TYPE_CHECKING:
    from pickcli.cell.model import Cell
    from pickcli.cell.robot import PivotState
    from pickcli.geometry import Array
    from pickcli.motion.plan import Plan
    from pickcli.planning.context import Planner

F = TypeVar("F", bound=Callable[..., Any])


def artifact_options(function: F) -> F:
    """--roadmap and --trajectories; by default the cell's folder in the user's cache, if built."""
    for name, what in (("trajectories", "trajectory database"), ("roadmap", "roadmap")):
        function = click.option(
            f"--{name}", type=click.Path(path_type=Path),
            help=f"The {what} to use instead of the cell's own in the cache.",
        )(function)  # fmt: skip
    return function


def load_planner(cell: Cell, roadmap: Path | None, trajectories: Path | None) -> Planner:
    """A planner with the named artifacts, or those in the cache where they are built.

    Raises InputError for a named file that is missing, StaleError or DamagedError for one that must not
    be used.
    """
    from pickcli.planning.context import Planner
    from pickcli.precompute.artifacts import default_paths
    from pickcli.roadmap.store import read_database, read_roadmap

    default = default_paths(cell)
    roadmap = roadmap or (default.roadmap if default.roadmap.exists() else None)
    trajectories = trajectories or (default.trajectories if default.trajectories.exists() else None)
    return Planner(
        cell,
        None if roadmap is None else read_roadmap(roadmap, cell),
        None if trajectories is None else read_database(trajectories, cell),
    )


def build_missing(cell: Cell) -> None:
    """Build the cell's roadmap and database into the cache where they are missing, with progress."""
    from contextlib import ExitStack

    from pickcli.precompute.artifacts import ensure_artifacts

    with ExitStack() as bars:
        ensure_artifacts(cell, lambda what: bars.enter_context(progress(f"building the {what}")))


def parse_configuration(cell: Cell, text: str) -> tuple[Array, PivotState]:
    """A named configuration, or n numbers with commas (straight cup). Raises InputError."""
    import numpy as np

    from pickcli.cell.robot import PivotState

    if text in cell.configurations:
        named = cell.configurations[text]
        return named.q, named.pivot
    parts = text.split(",")
    try:
        q = np.array([float(part) for part in parts])
    except ValueError:
        raise UnknownNameError("configuration", text, list(cell.configurations)) from None
    names = cell.robot.joint_names
    if len(q) != len(names) or not np.all(np.isfinite(q)):
        raise InputError(
            f"configuration {text!r}: expected {len(names)} finite numbers ({' '.join(names)}), got {len(q)}"
        )
    limits = cell.robot.limits
    for name, value, low, high in zip(names, q, limits.lower, limits.upper, strict=True):
        if not low <= value <= high:
            raise InputError(f"configuration {text!r}: joint {name} = {value:g} is outside {low:g}..{high:g}")
    return q, PivotState.STRAIGHT


def report_plan(plan: Plan, path: Path) -> dict[str, Any]:
    """The summary that the planning commands print."""
    grasp = plan.grasp
    return {
        "query": plan.query,
        "duration_s": round(plan.trajectory.duration, 3),
        "segments": ", ".join(f"{s.kind} {s.t_end - s.t_start:.2f} s" for s in plan.segments),
        "grasp": None if grasp is None else f"{grasp.kind} on face {grasp.face}",
        "speed_scale": plan.speed_scale,
        "events": ", ".join(
            f"{e.device} {e.action} at {e.t_trigger:.3f} s" for e in plan.events if e.t_trigger is not None
        ),
        "certified": plan.certificate is not None,
        "statistics": {key: round(value, 2) for key, value in plan.statistics.items()},
        "plan": str(path),
    }
