"""Jobs: tasks that can be done in any order, on any process, more than once."""

from __future__ import annotations

import hashlib
from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import Protocol, TypeAlias

import pickcli
from pickcli.cell.fingerprint import digest
from pickcli.errors import InputError
from pickcli.jobs.job_result import JobResult
from pickcli.kernel import _kernel

Key: TypeAlias = tuple[str, ...]  # name of a task, unique in its build


class Job(Protocol):
    """The tasks of one build.

    A job is pickled to other processes, so it is small, and makes its helpers there when they are first used.
    The result of ``make`` depends only on the key and the job: not on earlier tasks, nor on the process, nor
    on the clock. A task may be done twice; its records are the same bytes.
    """

    @property
    def inputs(self) -> str:
        """SHA-256 over all inputs of records besides the key: records of other inputs cannot be used."""

    def make(self, key: Key) -> JobResult:
        """Run one task.

        Args:
            key: The task.

        Returns:
            Its result.
        """

    def misfit(self, key: Key, result: JobResult) -> str:
        """Tell why a result cannot be one of a task; results come from journals and from other processes.

        Args:
            key: The task.
            result: A result that was read, of whatever content.

        Returns:
            The fault, as a phrase; "" if ``make`` could have returned it.
        """

    def effort(self, key: Key) -> float:
        """Estimate the cost of a task relative to others.

        Long tasks are started first, so that no worker is left with one at the end; the remaining time is
        estimated from the costs.

        Args:
            key: The task.

        Returns:
            In any unit, always positive.
        """


# Packages whose code does not affect results of builds: they are beside or above the packages that do, which
# import none of them (checked by import-linter). So a changed help text does not invalidate journals and
# workers.
PACKAGES_WITHOUT_RESULTS = frozenset({
    "__main__.py", "api", "calibration", "cartesian", "commands", "commission", "drawing", "driving",
    "export", "grasping", "hand", "io_events", "monte_carlo", "page", "pallet_trials", "palletizing",
    "planner_benchmark", "planning", "random_scenes", "reachability", "robot_setup", "simulation",
    "strategy", "stream_trials", "trial", "verification", "watching",
})  # fmt: skip


@cache
def code_digest() -> str:
    """Compute the SHA-256 over the kernel and the sources that affect results."""
    return sources_digest(PACKAGES_WITHOUT_RESULTS)


def sources_digest(without: Collection[str] = ()) -> str:
    """Compute the SHA-256 over this package's sources and its kernel.

    Args:
        without: Folders of the package that are left out.

    Returns:
        The digest in hex.
    """
    root = Path(pickcli.__file__).parent
    paths = (path.relative_to(root) for path in root.rglob("*.py"))
    parts = {str(path): root / path for path in paths if path.parts[0] not in without}
    parts["kernel"] = Path(_kernel.__file__)  # which may be elsewhere during its development
    return digest([[name, hashlib.sha256(parts[name].read_bytes()).hexdigest()] for name in sorted(parts)])


def refuse_other_sources(sources: str) -> None:
    """Refuse a job of another version of the program, which a worker elsewhere may be given.

    Args:
        sources: ``sources_digest`` of the program that made the job.

    Raises:
        InputError: This process runs another version of the program.
    """
    if sources != sources_digest():
        raise InputError("a worker runs another version of the program; install the same one there")
