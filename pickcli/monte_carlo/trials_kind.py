"""Kinds of trials that a folder of many may hold: which one it holds, and what it has of each trial."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pickcli.errors import InputError
from pickcli.monte_carlo.trials_folder import read_records, record_paths
from pickcli.trial.record_kind import RecordKind


@dataclass(frozen=True)
class TrialsKind:
    """Folders with trials of one kind.

    Attributes:
        played: What is played, in the plural, for messages.
        records: Kind of the records of its trials.
        task_file: Name of the file in the folder of a trial that has what was played.
        refuse_other_task: Refuses, with a ``StaleError``, such a file that is not the one of a record.
    """

    played: str
    records: RecordKind
    task_file: str
    refuse_other_task: Callable[[Path, Mapping[str, Any]], None]

    def is_of(self, folder: Path) -> bool:
        """Tell whether the trials in a folder are of this kind.

        Args:
            folder: A folder with one folder per trial.

        Returns:
            Whether they are.

        Raises:
            InputError: It is no folder with trials, a record cannot be read, or there are trials of this kind
                and others.
        """
        paths = record_paths(folder)
        ours = [path for path in paths if self.records.is_of(path)]
        if ours and len(ours) < len(paths):
            other = next(path for path in paths if path not in ours)
            raise InputError(
                f"{folder}: has trials of {self.played} ({ours[0].parent.name}) and others "
                f"({other.parent.name}), which have other figures; keep each kind in a folder of its own"
            )
        return bool(ours)

    def read(self, folder: Path) -> dict[str, dict[str, Any]]:
        """Read the records of all trials in a folder of this kind.

        Args:
            folder: The folder, of which ``is_of`` is true.

        Returns:
            Content of each ``trial.json``, by the name of its folder, sorted.

        Raises:
            InputError: A record cannot be read.
            StaleError: It has another version of the format, is of another seed than is listed, or is beside
                the file of another task.
        """
        return read_records(folder, self._read)

    def _read(self, path: Path) -> dict[str, Any]:
        """Read a record, and refuse one beside the file of another task. Raises InputError and StaleError."""
        record = self.records.read(path)
        played = path.with_name(self.task_file)
        if played.is_file():
            self.refuse_other_task(played, record)
        return record
