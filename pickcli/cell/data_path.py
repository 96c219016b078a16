"""Location of the data folder: beside the package in a checkout, inside it in an installed wheel."""

from __future__ import annotations

from pathlib import Path

import pickcli
from pickcli.errors import UnknownNameError


def data_path() -> Path:
    """Return the folder that contains cells/, items/ and tasks/.

    Returns:
        Its path.
    """
    package = Path(pickcli.__file__).resolve().parent
    beside = package.parent / "data"
    return beside if (beside / "cells").is_dir() else package / "data"


def task_names() -> list[str]:
    """List the names of the tasks under data/tasks.

    Returns:
        Their names, sorted.
    """
    return sorted(path.stem for path in data_path().glob("tasks/*.json"))


def task_file(name_or_path: Path) -> Path:
    """Return the file that a name or a path of a task means: of an order, a stream, a commission or a pallet.

    Args:
        name_or_path: A name under data/tasks without its suffix, or the path of a file, which comes first.

    Returns:
        The file, which need not exist if there is no task of that name.
    """
    if name_or_path.exists() or name_or_path.suffix or len(name_or_path.parts) != 1:
        return name_or_path
    packaged = data_path() / "tasks" / f"{name_or_path}.json"
    return packaged if packaged.is_file() else name_or_path


def data_file(kind: str, folder: str, name: str) -> Path:
    """Return the file that a name or a path means.

    Args:
        kind: Kind of the file in messages, e.g. "hand".
        folder: Folder under data that has files of this kind.
        name: A name in that folder without its suffix, or the path of a file.

    Returns:
        The file; a path need not exist.

    Raises:
        UnknownNameError: The folder has no file of that name, and it is no path.
    """
    known = {path.stem: path for path in sorted((data_path() / folder).glob("*.yaml"))}
    if name in known:
        return known[name]
    if Path(name).suffix or len(Path(name).parts) > 1 or Path(name).exists():
        return Path(name)
    raise UnknownNameError(kind, name, list(known))
