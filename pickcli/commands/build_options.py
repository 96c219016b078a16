"""Options that the building commands share."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.option_types import NumberType
from pickcli.commands.options import json_option, output_option, seed_option
from pickcli.path_planning.planner_names import PlannerName

if TYPE_CHECKING:
    from pickcli.precompute.roadmap_settings import RoadmapSettings
    from pickcli.trajopt.trajectory_settings import TrajectorySettings

F = TypeVar("F", bound=Callable[..., Any])

PLANNERS = click.Choice([planner.value for planner in PlannerName], case_sensitive=False)


def build_options(
    output: str, settings: type[RoadmapSettings] | type[TrajectorySettings], one: str
) -> Callable[[F], F]:
    """Add the options that both builds share besides the cell, with the defaults of their settings.

    Args:
        output: Name of the output, for the help.
        settings: Class of the settings, for the defaults.
        one: Name of what the planner searches, in the singular.

    Returns:
        A decorator that adds the options.
    """

    def decorate(function: F) -> F:
        for option in (  # the last is the first in the help
            output_option(output), json_option, seed_option, scheduler_option, jobs_option,
            _iterations_option(settings.max_iterations, one), _planner_option(settings.planner, one),
        ):  # fmt: skip
            function = option(function)
        return function

    return decorate


def jobs_option(function: F) -> F:
    """Give a command the option --jobs N.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--jobs", type=NumberType(1, 1024), metavar="N",
        help="Number of parallel processes; the bytes are the same.  [default: one per core]",
    )(function)  # fmt: skip


def scheduler_option(function: F) -> F:
    """Give a command the option --scheduler ADDRESS.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--scheduler", metavar="ADDRESS",
        help="Run the tasks on the workers of this Dask scheduler, e.g. tcp://host:8786; the bytes are the "
        "same. It is trusted: see docs/cluster.md.",
    )(function)  # fmt: skip


def _planner_option(default: PlannerName, one: str) -> Callable[[F], F]:
    return click.option(
        "--planner", type=PLANNERS, default=default.value, show_default=True, help=f"Planner of the {one}s."
    )


def _iterations_option(default: int, one: str) -> Callable[[F], F]:
    return click.option(
        "--iterations", type=NumberType(1), default=default, show_default=True,
        help=f"Most iterations of the planner for one {one}.",
    )  # fmt: skip
