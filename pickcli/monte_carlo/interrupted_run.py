"""Folder of a Monte Carlo run that was interrupted: it has a journal, and no summary yet."""

from __future__ import annotations

from pathlib import Path

from pickcli.errors import InputError
from pickcli.jobs.journal import journals

SUMMARY = "trials.json"


def is_interrupted(folder: Path) -> bool:
    """Whether a folder is that of a run that was interrupted, perhaps as it wrote the folders of its trials.

    Args:
        folder: The folder, which need not exist.

    Returns:
        Whether the journal of a run is in it.
    """
    return folder.is_dir() and bool(journals(folder / SUMMARY))


def refuse_interrupted(folder: Path) -> None:
    """Refuse the folder of a run that was interrupted before all of its trials were played.

    Args:
        folder: The folder, which need not exist.

    Raises:
        InputError: It is such a folder.
    """
    if is_interrupted(folder) and not (folder / SUMMARY).is_file():
        raise InputError(
            f"{folder}: its run was interrupted, and has no {SUMMARY} yet; give the same apc run-trials "
            "again to continue it"
        )
