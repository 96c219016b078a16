"""Jobs: tasks that can be done in any order, anywhere, more than once."""

from __future__ import annotations

import hashlib
from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import Protocol, TypeAlias

import pickcli
from pickcli.cell.fingerprint import digest
from pickcli.jobs.job_result import JobResult
from pickcli.kernel import _kernel

Key: TypeAlias = tuple[str, ...]  # the name of a task, unique in its build


class Job(Protocol):
    """How the tasks of one build are done.

    It travels to other processes by pickle, so it is small, and what it needs for its work it makes there
    when it is first used. What ``make`` leaves depends on the key and the job alone: not on tasks before
    it, nor on the process, nor on the clock. A task may be done twice; its records are the same bytes.
    """

    @property
    def inputs(self) -> str:
        """SHA-256 over all that records depend on besides the key: records of other inputs cannot be used."""

    def make(self, key: Key) -> JobResult:
        """Do one task.

        Args:
            key: The task.

        Returns:
            What it leaves.
        """

    def effort(self, key: Key) -> float:
        """Estimated cost of a task, compared with others.

        What takes long is begun first, so that no worker is left with it in the end; the time left is
        estimated from it.

        Args:
            key: The task.

        Returns:
            In any unit, always more than 0.
        """


# Rooms whose code makes no result of a build: they stand beside or above the room that does, which imports
# nothing of them (import-linter sees to that). A changed help text leaves every journal and worker as it is.
ROOMS_WITHOUT_RESULTS = frozenset({
    "__main__.py", "api", "commands", "drawing", "export", "page", "planner_benchmark", "planning",
    "reachability", "robot_setup", "simulation", "stowing", "trial", "verification",
})  # fmt: skip


@cache
def code_digest() -> str:
    """SHA-256 over the kernel and the sources that results follow from: others may give other bytes."""
    return sources_digest(ROOMS_WITHOUT_RESULTS)


def sources_digest(without: Collection[str] = ()) -> str:
    """SHA-256 over this package's sources and its kernel.

    Args:
        without: Rooms (folders of the package) that are left out.

    Returns:
        The digest in hex.
    """
    root = Path(pickcli.__file__).parent
    paths = (path.relative_to(root) for path in root.rglob("*.py"))
    parts = {str(path): root / path for path in paths if path.parts[0] not in without}
    parts["kernel"] = Path(_kernel.__file__)  # which may lie elsewhere while it is being developed
    return digest([[name, hashlib.sha256(parts[name].read_bytes()).hexdigest()] for name in sorted(parts)])
