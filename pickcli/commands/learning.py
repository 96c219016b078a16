"""--learn: what queries find is kept for later ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.options import refuse_unwritable
from pickcli.commands.progress import progress
from pickcli.errors import ApcError, NoPlanError

if TYPE_CHECKING:
    from pickcli.planning.context import Planner
    from pickcli.precompute.learn import Learner

F = TypeVar("F", bound=Callable[..., Any])


def learn_option(function: F) -> F:
    """--learn."""
    return click.option(
        "--learn", is_flag=True,
        help="Keep, beside roadmap and database, what is found and was not stored; use what was kept before.",
    )(function)  # fmt: skip


@contextmanager
def learning(
    planner: Planner, roadmap: Path | None, trajectories: Path | None, is_on: bool
) -> Iterator[Callable[[], None]]:
    """Let a planner use what was learned, and keep in the end what it learns, also where it finds no plan.

    What a command is asked for is to be written before that end: learning takes its time, and may fail.

    roadmap, trajectories: the files named on the command line; what is learned lies beside these, or
        beside those in the cache
    Gives what keeps edges in between, for commands that run long. Raises InputError at once where nothing
    can be kept, and like ``Learner`` in the end.
    """
    if not is_on:
        yield lambda: None
        return
    from pickcli.precompute.artifacts import default_paths
    from pickcli.precompute.learn import Learner
    from pickcli.roadmap.grow import with_polylines

    default = default_paths(planner.cell)
    learner = Learner.beside(planner.cell, roadmap or default.roadmap, trajectories or default.trajectories)
    for path in (learner.roadmap, learner.trajectories):
        folder = next(folder for folder in path.parents if folder.exists())
        refuse_unwritable(folder, path, "--roadmap and --trajectories")
    planner.roadmap = with_polylines(planner.roadmap, learner.edges())
    planner.learned, planner.lessons = learner.motions(), []
    session = _Session(planner, learner)
    try:
        yield session.keep_edges_meanwhile
    except NoPlanError:
        session.finish()
        raise
    session.finish()


class _Session:
    """What one command learns."""

    def __init__(self, planner: Planner, learner: Learner) -> None:
        self._planner, self._learner = planner, learner
        self._done = self._edges = self._unproven = 0
        self._failed: ApcError | None = None

    def keep_edges_meanwhile(self) -> None:
        """Keep edges, unless that failed before: the command goes on, and the end tells."""
        if self._failed is None:
            try:
                self.keep_edges()
            except ApcError as error:
                self._failed = error

    def keep_edges(self) -> None:
        """Keep the edges found since the last time."""
        lessons = (self._planner.lessons or [])[self._done :]
        self._done += len(lessons)
        kept = self._learner.learn_edges(lessons)
        self._edges += kept.edges
        self._unproven += kept.unproven

    def finish(self) -> None:
        """Keep the last edges, make the motions that were missed, and say what was learned."""
        if self._failed is not None:
            raise self._failed
        self.keep_edges()
        planner, learner = self._planner, self._learner
        missed = learner.missed(planner.lessons or [], planner.database, planner.learned)
        motions = 0
        if missed:
            with progress("learning motions") as report:
                for done, key in enumerate(missed):
                    report(done, len(missed), f"{key.start} to {key.goal}")
                    motions += learner.learn_motion(key).motions
        click.echo(
            f"note: learned {self._edges} edges and {motions} motions; {self._unproven} edges are not free "
            "in the empty cell and were not kept",
            err=True,
        )
