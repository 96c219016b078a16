"""The options of a transit to grasps, --grasps, --planner and --expansions: to which, and what plans it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.options.option_types import PATH, NumberType
from pickcli.commands.options.trial_options import is_stated

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.grasping.recorded_grasp import RecordedGrasp
    from pickcli.planning.planning_context import PlanningContext

F = TypeVar("F", bound=Callable[..., Any])
USUAL, ARA_STAR = "usual", ("ara-star", "ARA*")  # the latter as apc compare-planners has it


@dataclass(frozen=True)
class TransitOptions:
    """A transit to grasps: where these come from, and what plans it.

    Attributes:
        grasps_path: File of recorded grasps; None if grasps come from elsewhere.
        planner: What plans the transit to the grasps.
        expansions: Most expansions of each search of ARA*.
    """

    grasps_path: Path | None
    planner: str
    expansions: int

    def recorded(self, cell: Cell) -> tuple[RecordedGrasp, ...] | None:
        """Read the recorded grasps, before anything else is loaded or noted.

        Args:
            cell: The cell as the arm sees it.

        Returns:
            The grasps; None if no file is named.

        Raises:
            InputError: The file cannot be read.
        """
        from pickcli.grasping.recorded_grasp_file import read_recorded_grasps

        return None if self.grasps_path is None else read_recorded_grasps(self.grasps_path, cell)

    def planned_by(
        self, context: PlanningContext, recorded: tuple[RecordedGrasp, ...] | None
    ) -> PlanningContext:
        """Return a context with these options.

        Args:
            context: The context.
            recorded: What ``recorded`` read for its cell.

        Returns:
            The context, with the recorded grasps if there are any.

        Raises:
            InputError: There is no lattice for the arm.
        """
        context = context.with_lattice_transits(self.expansions if self.planner in ARA_STAR else None)
        return context if recorded is None else replace(context, recorded=recorded)

    def refuse_beside(self, approach: str) -> None:
        """Refuse options that exclude each other.

        Args:
            approach: Where grasps come from without a file.

        Raises:
            UsageError: Grasps come from two sources, or an option is stated that another planner has.
        """
        from pickcli.planning.pick_settings import GraspApproach

        if self.planner not in ARA_STAR and is_stated("expansions"):
            raise click.UsageError(f"--expansions limits ARA*; add --planner {ARA_STAR[0]}, or leave it out")
        if self.grasps_path is not None and approach != GraspApproach.LINES:
            raise click.UsageError("--grasps and --approach both say where grasps come from; name one")


def transit_options(function: F) -> F:
    """Give a command the options --grasps, --planner and --expansions.

    Args:
        function: The command.

    Returns:
        The command with the options, whose parameters are the fields of ``TransitOptions``.
    """
    function = click.option(
        "--expansions", type=NumberType(1, 1_000_000), default=300, show_default=True,
        help="Maximum expansions of each search of ARA*; a query has one for each set of goals.",
    )(function)  # fmt: skip
    function = click.option(
        "--planner", type=click.Choice([USUAL, *ARA_STAR], case_sensitive=False), default=USUAL,
        show_default=True,
        help="What plans the transit to the grasps: stored motions, the roadmap and RRT-Connect; or ARA* on "
             "a lattice of hand poses, with a proven bound on its cost (the PR2 at its conveyor, 2013).",
    )(function)  # fmt: skip
    return click.option(
        "--grasps", "grasps_path", type=PATH, metavar="FILE",
        help="Choose from recorded grasps alone (see apc record-grasp).",
    )(function)  # fmt: skip
