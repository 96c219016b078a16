"""A run of a job: tasks kept from before, tasks done now, and the progress."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

from pickcli.errors import DamagedError, InputError
from pickcli.jobs.executors import Executor, SerialExecutor
from pickcli.jobs.job import Job, Key
from pickcli.jobs.job_result import JobResult
from pickcli.jobs.journal import Journal
from pickcli.progress import Progress


@dataclass(frozen=True)
class BuildProgress(Progress):
    """Progress of a run: number of tasks done and in total, and the last finished one.

    Attributes:
        n_kept: Finished tasks that were found in a journal or file.
        n_failed: Finished tasks that ended with a reason instead of a result.
        effort_done: Estimated cost of the tasks that were done in this run.
        effort_total: Estimated cost of the tasks that this run has to do.
        journal: Journal of the finished tasks during the run; None if there is none.
        tells_coverage: Whether the text tells failures and coverage; else failures alone, if there are any.
    """

    n_kept: int = 0
    n_failed: int = 0
    effort_done: float = 0.0
    effort_total: float = 0.0
    journal: Path | None = None
    tells_coverage: bool = True

    @property
    def n_done_now(self) -> int:
        """Number of tasks that were done in this run."""
        return int(self.done) - self.n_kept

    @property
    def coverage(self) -> float:
        """Share of all tasks that have their result."""
        return (self.done - self.n_failed) / max(self.total, 1)

    @property
    def share(self) -> float | None:
        """Share of the estimated cost that is done; None before the first task of this run is."""
        return self.effort_done / self.effort_total if self.effort_done > 0.0 else None

    @property
    def detail(self) -> str:
        """Failures, coverage, kept tasks and the last task, as a text."""
        figures = []
        if self.tells_coverage or self.n_failed:
            figures.append(f"{self.n_failed} failed")
        if self.tells_coverage:
            figures.append(f"coverage {100 * self.coverage:.0f} %")
        if self.n_kept:
            figures.append(f"{self.n_kept} kept from before")
        return ": ".join(part for part in (", ".join(figures), self.what) if part)


BuildObserver: TypeAlias = Callable[[BuildProgress], None]  # a ProgressObserver is accepted


@dataclass(frozen=True)
class RunOptions:
    """Options of a run; none of them changes a byte of its result.

    Attributes:
        runner: Executor of the tasks.
        output: The file to be written; finished tasks are kept in a journal beside it during the run.
        kept: Valid records from another source, by key.
        report: Called whenever a task is finished.
        tells_coverage: As of the progress.
    """

    runner: Executor = field(default_factory=SerialExecutor)
    output: Path | None = None
    kept: Mapping[Key, JobResult] = field(default_factory=dict)
    report: BuildObserver | None = None
    tells_coverage: bool = True


class Build:
    """Run of the tasks of one job, each done once.

    Args:
        job: The job of the tasks.
        run_options: Options; a serial run without a journal if None.
    """

    def __init__(self, job: Job, run_options: RunOptions | None = None) -> None:
        self.job, self.run_options = job, run_options or RunOptions()
        output = self.run_options.output
        self.journal = None if output is None else Journal(output, job.inputs)
        self._journaled = {} if self.journal is None else self.journal.read()  # not yet checked, by key
        self._records = dict(self.run_options.kept)
        self.progress = BuildProgress(0, 0)
        self._efforts: dict[Key, float] = {}

    def records(self, keys: Sequence[Key]) -> list[JobResult]:
        """Return the records of tasks; tasks without a kept record are done now.

        It can be called again with tasks that follow from the records; these are added to the progress.

        Args:
            keys: The tasks.

        Returns:
            Records, in the order of the keys.

        Raises:
            DamagedError: The journal has a record that cannot be a result of its task.
            InputError: A worker returned such a record.
        """
        self._take_from_journal(keys)
        missing = self._longest_first([key for key in keys if key not in self._records])
        self._begin_round(keys, missing)
        with closing(self.run_options.runner.run(self.job, missing)) as finished:
            for key, content in finished:
                self._records[key] = self._from_worker(key, content)
                if self.journal is not None:
                    self.journal.append(key, content)
                self._count(key)
        return [self._records[key] for key in keys]

    def _longest_first(self, keys: Sequence[Key]) -> list[Key]:
        self._efforts = {key: self.job.effort(key) for key in keys}
        return sorted(keys, key=lambda key: -self._efforts[key])

    def finish(self) -> None:
        """Delete the journal, after the output is written."""
        if self.journal is not None:
            self.journal.remove()

    def _take_from_journal(self, keys: Sequence[Key]) -> None:
        """Add the records that the journal has of tasks. Raises DamagedError for one that does not fit."""
        if self.journal is None:
            return
        for key in keys:
            if (content := self._journaled.pop(key, None)) is not None:
                try:
                    self._records[key] = self._checked(key, content)
                except ValueError as error:
                    name = ", ".join(key)
                    raise DamagedError(
                        f"{self.journal.path}: its record of the task {name} is not a result of it: {error}; "
                        "delete this journal and run the same command again"
                    ) from None

    def _from_worker(self, key: Key, content: bytes) -> JobResult:
        """Read the record that a worker returned. Raises InputError if it does not fit."""
        try:
            return self._checked(key, content)
        except ValueError as error:
            raise InputError(
                f"the task {', '.join(key)}: its worker returned what is not a result of it: {error}; "
                "install the same version everywhere"
            ) from None

    def _checked(self, key: Key, content: bytes) -> JobResult:
        """Read a record. Raises ValueError if it is none, or cannot be of this task."""
        result = JobResult.of_bytes(content)
        if fault := self.job.misfit(key, result):
            raise ValueError(fault)
        return result

    def _begin_round(self, keys: Sequence[Key], missing: Sequence[Key]) -> None:
        so_far, kept = self.progress, [self._records[key] for key in keys if key in self._records]
        self._tell(
            BuildProgress(
                so_far.done + len(kept),
                so_far.total + len(kept) + len(missing),
                n_kept=so_far.n_kept + len(kept),
                n_failed=so_far.n_failed + sum(record.reason is not None for record in kept),
                effort_done=so_far.effort_done,
                effort_total=so_far.effort_total + sum(self._efforts.values()),
                journal=None if self.journal is None else self.journal.path,
                tells_coverage=self.run_options.tells_coverage,
            )
        )

    def _count(self, key: Key) -> None:
        p, failed = self.progress, self._records[key].reason is not None
        effort = p.effort_done + self._efforts[key]
        self._tell(
            replace(p, done=p.done + 1, n_failed=p.n_failed + failed, effort_done=effort, what=", ".join(key))
        )

    def _tell(self, progress: BuildProgress) -> None:
        self.progress = progress
        if self.run_options.report is not None:
            self.run_options.report(progress)
