"""Repair of a damaged file: intact results are kept, and only lost ones are computed again."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from pickcli.cell.cell import Cell
from pickcli.errors import StaleError
from pickcli.jobs.job_run import RunOptions
from pickcli.precompute.artifact_files import versions
from pickcli.precompute.provenance import configurations_digest
from pickcli.precompute.recovered_results import make_again, stored_records
from pickcli.storage.integrity_scan import IntegrityReport
from pickcli.storage.table_reader import stored_file


@dataclass(frozen=True)
class Repair:
    """Result of a repair.

    Attributes:
        n_kept: Number of tasks whose results were intact.
        n_done: Number of tasks that were done again.
        is_same: Whether the file is now byte-identical to the original.
    """

    n_kept: int
    n_done: int
    is_same: bool


def repair(path: Path, found: IntegrityReport, cell: Cell, run_options: RunOptions | None = None) -> Repair:
    """Write a damaged file again, like the build that made it, computing only lost results.

    Args:
        path: The file.
        found: Result of ``surveyed`` for the same file.
        cell: The cell that it was made for.
        run_options: Executor of the tasks and observer of their progress; None for this process, unobserved.

    Returns:
        Result, with what was kept and what was computed.

    Raises:
        StaleError: The result could not be the same file: another cell, other named configurations or
            versions.
    """
    _check(path, found, cell)
    run_options = replace(run_options or RunOptions(), kept=stored_records(found, cell))
    n_kept, n_done = make_again(path, found, cell, run_options)
    with stored_file(path, found.kind) as file:
        return Repair(n_kept, n_done, file.seal == found.seal)


def _check(path: Path, found: IntegrityReport, cell: Cell) -> None:
    """Raise StaleError if program or cell would not give the same file."""
    made = found.made
    for what, then, now in (
        ("a cell with fingerprint", found.fingerprint, cell.fingerprint),
        ("named configurations with SHA-256", made.get("configurations"), configurations_digest(cell)),
        ("versions", made.get("by"), versions()),
    ):
        if then != now:
            raise StaleError(
                f"{path}: was made for {what} {then}, in use: {now}; it cannot be repaired, build it again"
            )
