"""The folder that a trial leaves behind. Its files are described in docs/formats/trial.md."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pickcli.errors import InputError
from pickcli.scene.scene_file import write_scene
from pickcli.trial.motion_record import write_motion
from pickcli.trial.output_file import write_output
from pickcli.trial.trial_record import write_record
from pickcli.trial.trial_result import TrialResult

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


MOTION = "motion.json.gz"

# Everything that is written into the folder, and so replaced in one that exists. The first is there only
# after a trial that can claim something.
NAMES = ("output.json", "scene.json", "after.json", "trial.json", "motion.json.gz", "before.png", "after.png")


def refuse_existing_folder(folder: Path, overwrite: bool) -> None:
    """Refuse a folder, before any work is done, in which the results could not be written in the end.

    Args:
        folder: The folder, which need not exist.
        overwrite: Whether files that are there may be replaced.

    Raises:
        InputError: It is a file, is not empty and must not be overwritten, or cannot be written.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; name a folder with -o")
    if folder.exists() and any(folder.iterdir()) and not overwrite:
        raise InputError(f"{folder}: exists already; name another folder with -o or add --overwrite")
    _refuse_unwritable(folder)


def _refuse_unwritable(folder: Path) -> None:
    """Try to make a file in what exists already of the folder's path: permissions alone do not tell."""
    there = next(parent for parent in (folder, *folder.absolute().parents) if parent.exists())
    try:
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as error:
        raise InputError(
            f"{folder}: nothing can be written in {there} ({error.strerror}); name another folder with -o"
        ) from None


def write_folder(
    folder: Path,
    result: TrialResult,
    record: Mapping[str, Any],
    pictures: Mapping[str, NDArray[np.uint8]],
    motion: Mapping[str, Any] | None = None,
    replace: bool = True,
) -> tuple[Path, ...]:
    """Write all files of a trial, each whole or not at all.

    Args:
        folder: Where to write; it is made if need be.
        result: The trial that was played.
        record: The record of the trial, as JSON values.
        pictures: (height, width, 3) RGB, by name.
        motion: Everything that moved, as JSON values; None where that was not recorded.
        replace: Whether files that are there may be replaced.

    Returns:
        Paths of the files.

    Raises:
        InputError: A file cannot be written, after all others were: it names both kinds.
    """
    from pickcli.simulation.camera import write_png

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be made: {error.strerror}; name another folder with -o"
        ) from error
    writers: dict[str, Callable[[Path], None]] = {
        "scene.json": partial(write_scene, result.before, replace=replace),
        "after.json": partial(write_scene, result.after, replace=replace),
        "trial.json": partial(write_record, record=record, replace=replace),
        **{f"{name}.png": partial(write_png, picture, replace=replace) for name, picture in pictures.items()},
    }
    if motion is not None:
        writers[MOTION] = partial(write_motion, values=motion, replace=replace)
    if (claim := result.final.claim) is not None:
        writers = {"output.json": partial(write_output, order=claim, replace=replace), **writers}
    return _write_all(folder, writers)


def _write_all(folder: Path, writers: Mapping[str, Callable[[Path], None]]) -> tuple[Path, ...]:
    """Write files by name; one that cannot be written does not keep the next from being tried."""
    written: list[Path] = []
    failed: dict[str, InputError] = {}
    for name, write in writers.items():
        try:
            write(folder / name)
            written.append(folder / name)
        except InputError as error:
            failed[name] = error
    if failed:
        there = ", ".join(path.name for path in written) or "nothing"
        raise InputError(
            f"{next(iter(failed.values()))}; in {folder} written: {there}; not written: {', '.join(failed)}; "
            "name another folder, or once there is room run the same command again with --overwrite"
        )
    return tuple(written)
