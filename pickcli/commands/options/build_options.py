"""Options that the building commands share, as one value."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.operations.building import building
from pickcli.commands.options.arm_options import ArmRequest, arm_option, open_cell, standing_option
from pickcli.commands.options.common_options import (
    cell_option,
    json_option,
    output_option,
    passed_as,
    refuse_output,
    seed_option,
)
from pickcli.commands.options.option_types import NumberType
from pickcli.path_planning.planner_names import PlannerName

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.jobs.job_run import RunOptions
    from pickcli.precompute.roadmap_settings import RoadmapSettings
    from pickcli.trajopt.trajectory_settings import TrajectorySettings

F = TypeVar("F", bound=Callable[..., Any])

PLANNERS = click.Choice([planner.value for planner in PlannerName], case_sensitive=False)


@dataclass(frozen=True)
class BuildOptions:
    """The shared options of a building command.

    Attributes:
        cell_name: Name or folder of the cell.
        arm: The arm that moves; None if not stated.
        standing: Configurations of other arms, as ``ARM=NAME|q``.
        planner: Name of the planner.
        iterations: Most iterations of the planner for one search.
        jobs: Number of parallel processes; None for one per core.
        scheduler: Address of a Dask scheduler; None for processes of this machine.
        seed: Seed of all random choices.
        as_json: Whether JSON is printed.
        output: The file that is built.
        overwrite: Whether an existing file may be replaced.
    """

    cell_name: str
    arm: str | None
    standing: tuple[str, ...]
    planner: str
    iterations: int
    jobs: int | None
    scheduler: str | None
    seed: int
    as_json: bool
    output: Path
    overwrite: bool

    def cell(self) -> Cell:
        """Load the cell, after a check that the output can be written.

        Returns:
            The cell.

        Raises:
            InputError: The cell cannot be read, has no places, or the output cannot be written.
        """
        refuse_output(self.output, self.overwrite, self.cell_name)
        cell = open_cell(self.cell_name, ArmRequest(self.arm, self.standing))
        cell.require_places()
        return cell

    def building(self, label: str) -> AbstractContextManager[RunOptions]:
        """Provide the options of the build, as ``building.building``.

        Args:
            label: Name of the build, for the progress.

        Returns:
            A context with executor and observer of the build.
        """
        return building(label, self.output, self.jobs, self.as_json, self.scheduler)


def build_options(
    output: str, settings: type[RoadmapSettings] | type[TrajectorySettings], one: str
) -> Callable[[F], F]:
    """Give a command the options of every building command.

    Args:
        output: Name of the output, for the help.
        settings: Class of the settings, for the defaults.
        one: Name of what the planner searches, in the singular.

    Returns:
        A decorator that adds the options, and passes them as ``options``, a ``BuildOptions``.
    """

    def decorate(function: F) -> F:
        function = passed_as("options", BuildOptions)(function)
        for option in (  # the last is the first in the help
            output_option(output), json_option, seed_option, scheduler_option, jobs_option,
            _iterations_option(settings.max_iterations, one), _planner_option(settings.planner, one),
            standing_option, arm_option(), cell_option,
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
        help="Number of parallel processes; the result is the same.  [default: one per core]",
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
        help="Run the tasks on the workers of this Dask scheduler, e.g. tcp://host:8786; the result is the "
        "same. It must be trusted (docs/cluster.md).",
    )(function)  # fmt: skip


def _planner_option(default: PlannerName, one: str) -> Callable[[F], F]:
    return click.option(
        "--planner", type=PLANNERS, default=default.value, show_default=True, help=f"Planner of the {one}s."
    )


def _iterations_option(default: int, one: str) -> Callable[[F], F]:
    return click.option(
        "--iterations", type=NumberType(1), default=default, show_default=True,
        help=f"Maximum iterations of the planner for one {one}.",
    )  # fmt: skip
