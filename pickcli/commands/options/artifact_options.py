"""Artifacts of the planning commands: the options that name them, and the planning context made of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.operations.building import build_report
from pickcli.commands.options.option_types import PATH
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.planning.planning_context import PlanningContext

F = TypeVar("F", bound=Callable[..., Any])

_NOTES = f"{__name__}.notes"  # key of the notes already printed in a click context


def artifact_options(function: F) -> F:
    """Give a command the options --roadmap and --trajectories.

    By default, they are those in the cell's folder in the user's cache, if built.

    Args:
        function: The command.

    Returns:
        The command with the options.
    """
    for name, what in (("trajectories", "trajectory database"), ("roadmap", "roadmap")):
        function = click.option(
            f"--{name}", type=PATH, metavar="FILE",
            help=f"The {what} to use instead of the cell's own in the cache.",
        )(function)  # fmt: skip
    return function


def load_context(
    cell: Cell,
    roadmap: Path | None,
    trajectories: Path | None,
    build_missing: bool = False,
    jobs: int | None = None,
) -> PlanningContext:
    """Load the planning context with the named artifacts, or those in the cache if they are built.

    Args:
        cell: The cell.
        roadmap: The named roadmap; None for the one in the cache.
        trajectories: The named trajectory database; None for the one in the cache.
        build_missing: Whether to build missing artifacts in the cache; else planning works without them, and
            a note says so.
        jobs: Number of parallel processes of the build; None for one per core.

    Returns:
        The context.

    Raises:
        InputError: A named file is missing.
        StaleError: A file was made for another cell or by another version of the format.
        DamagedError: The content of a file is not what was written.
    """
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.precompute.artifact_cache import read_stored
    from pickcli.roadmap.store import read_database, read_roadmap

    if build_missing and (roadmap is None or trajectories is None):
        if roadmap is not None:  # named files are checked before anything is built
            read_roadmap(roadmap, cell)
        if trajectories is not None:
            read_database(trajectories, cell)
        _build_missing(cell, jobs)
    stored, database = read_stored(cell, roadmap, trajectories)
    if stored is None and database is None and cell.places:
        _print_once(
            "note: neither roadmap nor trajectory database is built for this cell, so every coarse motion "
            "is planned from scratch (apc run-trial builds both)"
        )
    return PlanningContext(cell, stored, database)


def _print_once(note: str) -> None:
    """Print a note only once per command, also if it applies to several arms."""
    printed = click.get_current_context().meta.setdefault(_NOTES, set())
    if note not in printed:
        printed.add(note)
        click.echo(note, err=True)


def _build_missing(cell: Cell, jobs: int | None) -> None:
    """Build the missing artifacts in the cell's cache, with progress."""
    from contextlib import ExitStack

    from pickcli.jobs.executors import available_cores, runner
    from pickcli.jobs.journal import journals
    from pickcli.precompute.artifact_cache import default_paths, ensure_artifacts

    try:
        with ExitStack() as bars:
            ensure_artifacts(
                cell,
                lambda what: bars.enter_context(build_report(f"building the {what}")),
                runner(jobs or available_cores()),
            )
    except (KeyboardInterrupt, InputError) as stop:
        paths = default_paths(cell)
        for journal in (*journals(paths.roadmap), *journals(paths.trajectories)):
            stop.add_note(f"finished tasks are kept in {journal}; run the same command again to continue")
        raise
