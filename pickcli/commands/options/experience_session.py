"""Option --learn: experience of queries is kept for later ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.options.common_options import refuse_unwritable
from pickcli.commands.output.progress_bar import progress
from pickcli.errors import ApcError, NoPlanError
from pickcli.progress import Progress

if TYPE_CHECKING:
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.precompute.experience import ExperienceFiles
    from pickcli.roadmap.query_experience import ExperienceRecorder

F = TypeVar("F", bound=Callable[..., Any])


def learn_option(function: F) -> F:
    """Give a command the option --learn.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--learn", is_flag=True,
        help="Store new motions beside roadmap and database, and reuse stored ones.",
    )(function)  # fmt: skip


@contextmanager
def experience_session(
    context: PlanningContext, roadmap: Path | None, trajectories: Path | None, is_on: bool
) -> Iterator[ExperienceSession]:
    """Add stored experience to a planning context, and store new experience at the end, even without a plan.

    The command's output should be written before that end: learning takes time, and may fail.

    Args:
        context: The context as loaded.
        roadmap: The roadmap named on the command line, if any; learned edges are stored beside it, or beside
            the one in the cache.
        trajectories: The trajectory database named on the command line, if any; learned motions are stored
            likewise.
        is_on: Whether experience is used and stored.

    Yields:
        The session, with the context to be used.

    Raises:
        InputError: At once if nothing can be stored; at the end as raised by ``ExperienceFiles``.
    """
    session = ExperienceSession.of(context, roadmap, trajectories) if is_on else ExperienceSession(context)
    try:
        yield session
    except NoPlanError:
        session.finish()
        raise
    session.finish()


class ExperienceSession:
    """Experience of one command.

    Args:
        context: The context to be used, with stored experience.
        learner: The files of the experience; None to store none.
        recorder: Recorder of new experience; None to store none.

    Attributes:
        context: The context to be used, with stored experience.
        recorder: Recorder to be passed to every query; None to store none.
    """

    def __init__(
        self,
        context: PlanningContext,
        learner: ExperienceFiles | None = None,
        recorder: ExperienceRecorder | None = None,
    ) -> None:
        """Start a session; without a learner, it stores nothing."""
        self.context, self._learner, self.recorder = context, learner, recorder
        self._edges = self._unproven = 0
        self._failed: ApcError | None = None

    @classmethod
    def of(
        cls, context: PlanningContext, roadmap: Path | None, trajectories: Path | None
    ) -> ExperienceSession:
        """Start a session with files beside the roadmap and the trajectory database.

        Args:
            context: The context as loaded.
            roadmap: The named roadmap; None for the one in the cache.
            trajectories: The named trajectory database; None for the one in the cache.

        Returns:
            The session.

        Raises:
            InputError: Nothing can be stored there.
        """
        from pickcli.precompute.artifact_cache import default_paths
        from pickcli.precompute.experience import ExperienceFiles
        from pickcli.roadmap.merge_edges import with_polylines
        from pickcli.roadmap.query_experience import ExperienceRecorder

        default = default_paths(context.cell)
        beside = roadmap or default.roadmap, trajectories or default.trajectories
        learner = ExperienceFiles.beside(context.cell, *beside)
        for path in (learner.roadmap, learner.trajectories):
            folder = next(folder for folder in path.parents if folder.exists())
            refuse_unwritable(folder, path, "--roadmap and --trajectories")
        known = with_polylines(context.roadmap, learner.edges())
        learning = replace(context, stored_roadmap=known, learned=learner.motions())
        return cls(learning, learner, ExperienceRecorder())

    def keep_edges(self) -> None:
        """Store new edges. On failure continue; the error is raised when the command ends."""
        if self._failed is None:
            try:
                self._keep_edges()
            except ApcError as error:
                self._failed = error

    def _keep_edges(self) -> None:
        if self._learner is not None and self.recorder is not None:
            kept = self._learner.learn_edges(self.recorder.take())
            self._edges += kept.edges
            self._unproven += kept.unproven

    def finish(self) -> None:
        """Store the last edges and the missing motions, and print what was learned.

        Raises:
            ApcError: Something could not be stored, now or before.
        """
        if self._failed is not None:
            raise self._failed
        self._keep_edges()
        if self._learner is not None:
            motions = self._learn_motions(self._learner)
            click.echo(
                f"note: learned {self._edges} edges and {motions} motions; {self._unproven} edges are not "
                "free in the empty cell and were not kept",
                err=True,
            )

    def _learn_motions(self, learner: ExperienceFiles) -> int:
        """Make the motions between named configurations that were missing; return their number."""
        context = self.context
        queried = () if self.recorder is None else self.recorder.recorded
        missed = learner.missed(queried, context.database, context.learned)
        motions = 0
        if missed:
            with progress("learning motions") as report:
                for done, key in enumerate(missed):
                    report(Progress(done, len(missed), f"{key.start} to {key.goal}"))
                    motions += learner.learn_motion(key).motions
        return motions
