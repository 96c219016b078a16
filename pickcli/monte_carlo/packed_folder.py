"""The files of a trial's folder as the result of a job.

Results come back from journals and from other machines, and their files are written under the names that they
state: so these are checked before any is.
"""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from pickcli.errors import InputError, StaleError
from pickcli.jobs.job_result import JobResult
from pickcli.name_suggestion import shortened
from pickcli.trial.record_kind import RecordKind
from pickcli.trial.trial_folder import RECORD


def packed_folder(write: Callable[[Path], Iterable[Path]]) -> JobResult:
    """Return the files of a trial's folder as a result.

    Args:
        write: Writes them into a folder, and returns their paths.

    Returns:
        The files (base64, by name).
    """
    with tempfile.TemporaryDirectory() as folder:
        files = {path.name: base64.b64encode(path.read_bytes()).decode() for path in write(Path(folder))}
    return JobResult({"files": files})


def files_of(result: JobResult) -> dict[str, bytes]:
    """Return the files of a trial's folder.

    Args:
        result: Result of a trial that was played.

    Returns:
        Contents by name.
    """
    return {
        name: base64.b64decode(content, validate=True) for name, content in result.values["files"].items()
    }


def misfit_of_folder(
    result: JobResult, is_name: Callable[[str], bool], records: RecordKind, made_from: Mapping[str, Any]
) -> str:
    """Tell why a result cannot be the folder of a trial.

    Args:
        result: A result that was read, of whatever content.
        is_name: Whether a trial of the kind writes a file of a name; false for every path with folders.
        records: Kind of its record.
        made_from: What the record has to state that it was made from: the task and the seed.

    Returns:
        The fault, as a phrase; "" if there is none.
    """
    if result.reason is not None:
        return f"it has the reason {result.reason} instead of files"
    if not isinstance(files := result.values.get("files"), dict):
        return "it has no files"
    if others := [name for name in files if not is_name(name)]:
        return f"it has the file {shortened(others[0])!r}, which no such trial writes"
    if RECORD not in files:
        return f"it has no {RECORD}"
    try:
        content = files_of(result)[RECORD]
        record = records.parsed(content.decode(), f"its {RECORD}")
    except (ValueError, TypeError):
        return f"its files are not in base64, or its {RECORD} is no text"
    except (InputError, StaleError) as error:
        return str(error)
    stated = record["made_from"]
    faults = [f"{key} {stated.get(key)!r} and not {value!r}" for key, value in made_from.items()
              if stated.get(key) != value]  # fmt: skip
    return f"its {RECORD} is of {', '.join(faults)}" if faults else ""
