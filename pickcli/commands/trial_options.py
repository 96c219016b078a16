"""Shared by the commands that play trials: --pose-noise, and the selection of arms."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.workcell import Workcell
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.roadmap.query_experience import ExperienceRecorder
    from pickcli.scene.scene import PoseNoise
    from pickcli.trial.simulated_cell import ArmPlanner

F = TypeVar("F", bound=Callable[..., Any])
MAX_NOISE = (50.0, 45.0)  # mm, degrees: larger errors make poses meaningless
MINUTE_NOISE = (0.1, 0.05)  # mm, degrees: smaller errors are probably in m and rad


def pose_noise_option(function: F) -> F:
    """Give a command the option --pose-noise MM,DEG.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--pose-noise", metavar="MM,DEG", callback=parse_noise, default="2,1", show_default=True,
        help="Error of the poses given to planning: up to so many mm and degrees.",
    )(function)  # fmt: skip


def parse_noise(ctx: click.Context | None, param: click.Parameter | None, value: str) -> PoseNoise:
    """Parse the value of --pose-noise.

    Args:
        ctx: Context of click.
        param: The option.
        value: Millimetres and degrees with a comma, from the command line.

    Returns:
        Bounds of the error of item poses in m and rad.

    Raises:
        BadParameter: The value is not two numbers, or they are out of range.
    """
    from pickcli.scene.scene import PoseNoise

    try:
        millimetres, degrees = (float(part) for part in value.split(","))
    except ValueError:
        what = f"{value!r}: expected two numbers, millimetres and degrees, e.g. 2,1"
        raise click.BadParameter(what, ctx, param) from None
    if not (0.0 <= millimetres <= MAX_NOISE[0] and 0.0 <= degrees <= MAX_NOISE[1]):
        what = f"{value!r}: expected 0..{MAX_NOISE[0]:g} mm and 0..{MAX_NOISE[1]:g} degrees"
        raise click.BadParameter(what, ctx, param)
    if 0.0 < millimetres < MINUTE_NOISE[0] and 0.0 < degrees < MINUTE_NOISE[1]:
        click.echo(
            f"note: --pose-noise {value}: {millimetres:g} mm and {degrees:g} degrees are hardly an error; "
            "it is in mm and degrees, not in m and rad",
            err=True,
        )
    return PoseNoise(millimetres / 1000.0, math.radians(degrees))


def cells_that_play(
    workcell: Workcell, arm: str | None, roadmap: Path | None, trajectories: Path | None
) -> list[Cell]:
    """Select the arms that play.

    Args:
        workcell: The cell with all its arms.
        arm: The named arm; None for all.
        roadmap: The named roadmap, if any.
        trajectories: The named trajectory database, if any.

    Returns:
        The cell as seen by each arm that plays, the preferred one first.

    Raises:
        InputError: A stored file is named, and several arms play.
    """
    if arm is not None or not workcell.parked:
        return [workcell.cell(arm)]
    for option, path in (("--roadmap", roadmap), ("--trajectories", trajectories)):
        if path is not None:
            raise InputError(
                f"{option}: a file is of one arm, and cell {workcell.name} plays with "
                f"{' and '.join(workcell.arms)}; name one with --arm, or leave it to the cache"
            )
    return list(workcell.arms.values())


def planner_of(
    workcell: Workcell, context: PlanningContext, recorder: ExperienceRecorder | None = None
) -> ArmPlanner:
    """Make the planner for one arm of a cell.

    Args:
        workcell: The cell with all its arms.
        context: Planning context of the arm.
        recorder: Records experience of its queries; None discards it.

    Returns:
        The planner.
    """
    from pickcli.trial.simulated_cell import ArmPlanner

    arm = context.cell.arm
    return ArmPlanner(context, recorder, workcell.parked.get(arm), workcell.preferences.get(arm, 0))
