"""Writes the folder of a trial. Its files are described in docs/formats/trial.md."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace as replaced
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pickcli.errors import InputError
from pickcli.motion.plan_file import write_plan
from pickcli.scene.scene_file import write_scene
from pickcli.trial.motion_record import write_motion
from pickcli.trial.output_file import write_output
from pickcli.trial.trial_record import write_record
from pickcli.trial.trial_result import Attempt, TrialResult

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from pickcli.trial.trial_perception import LookRecord

MOTION, RECORD = "motion.json.gz", "trial.json"
LOOKS = "look_*.png"
PLANS = "plan_*.json", "seen_*.json"  # of --plans
_LOOK = re.compile(r"look_\d{3,}_\w+\.png")
_NUMBERED = re.compile(rf"(plan|seen)_\d{{3,}}\.json|{_LOOK.pattern}")

# All files of the folder, which are replaced in an existing one, besides numbered ones. The first is written
# only for orders with a claim.
NAMES = ("output.json", "scene.json", "after.json", "trial.json", "motion.json.gz", "before.png", "after.png")


def pictures_of_looks(looks: Iterable[LookRecord]) -> dict[str, NDArray[np.uint8]]:
    """Collect the pictures of looks.

    Args:
        looks: The looks.

    Returns:
        (height, width, 3) RGB, by name of their files without the suffix.
    """
    return {
        look_name(look.number, place): picture for look in looks for place, picture in look.pictures.items()
    }


def look_name(number: int, place: str) -> str:
    """Return the name of the picture of a look.

    Args:
        number: Number of the look.
        place: The place that it is into.

    Returns:
        The name without a suffix.
    """
    return f"look_{number:03}_{place}"


def numbered_files(folder: Path) -> tuple[Path, ...]:
    """List the pictures of looks, plans and scenes in a folder, which a trial written there removes.

    Args:
        folder: The folder, which need not exist.

    Returns:
        Paths with such names.
    """
    there = sorted(folder.iterdir()) if folder.is_dir() else []
    return tuple(path for path in there if _NUMBERED.fullmatch(path.name))


def is_name_of_trial(name: str) -> bool:
    """Tell whether a trial of an order writes a file of a name, besides those of ``--plans``.

    Args:
        name: The name, from outside.

    Returns:
        Whether it does; false for every path with folders.
    """
    return name in NAMES or _LOOK.fullmatch(name) is not None


def refuse_existing_folder(folder: Path, overwrite: bool) -> None:
    """Refuse a folder, before any work, if the results could not be written there.

    Args:
        folder: The folder, which need not exist.
        overwrite: Whether existing files may be replaced.

    Raises:
        InputError: It is a file or a dangling link, is not empty and may not be overwritten, or cannot be
            written.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; name a folder with -o")
    if folder.is_symlink() and not folder.exists():
        raise InputError(f"{folder}: is a link to what is not there; remove it, or name a folder with -o")
    if folder.exists() and any(folder.iterdir()) and not overwrite:
        raise InputError(f"{folder}: exists already; name another folder with -o or add --overwrite")
    for path in numbered_files(folder):
        if path.is_dir():
            raise InputError(f"{path}: is a folder, where a trial has files; name another with -o")
    _refuse_unwritable(folder)


def _refuse_unwritable(folder: Path) -> None:
    """Create a temporary file in the existing part of the path, as permissions alone are not conclusive."""
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
    with_plans: bool = False,
) -> tuple[Path, ...]:
    """Write all files of a trial, none of which is in the folder before all are written.

    A new folder comes into being as a whole. In one that exists the record is replaced last, so that whatever
    interrupts this leaves no record beside files of another trial.

    Args:
        folder: The folder, created if it does not exist.
        result: The result of the trial.
        record: Record of the trial, as JSON values.
        pictures: (height, width, 3) RGB, by name.
        motion: Recorded motion as JSON values; None if not recorded.
        replace: Whether existing files may be replaced.
        with_plans: Whether to write every plan of an attempt, and the scene that it was certified for.

    Returns:
        Paths of the files.

    Raises:
        InputError: A file cannot be written; all others are, and the message lists both. Or the folder was
            filled by others meanwhile, and nothing is written.
    """
    from pickcli.files.png_file import write_png

    writers: dict[str, Callable[[Path], None]] = {
        "scene.json": partial(write_scene, result.before),
        "after.json": partial(write_scene, result.after),
        **{f"{name}.png": partial(write_png, picture) for name, picture in pictures.items()},
    }
    if with_plans:
        writers |= dict(_plans(result.attempts))
    if motion is not None:
        writers[MOTION] = partial(write_motion, values=motion)
    if (claim := result.final.claim) is not None:
        writers = {"output.json": partial(write_output, order=claim), **writers}
    writers[RECORD] = partial(write_record, record=record)
    return write_files(folder, writers, replace)


def write_files(
    folder: Path, writers: Mapping[str, Callable[[Path], None]], replace: bool = True
) -> tuple[Path, ...]:
    """Write files of a trial, none of which is in the folder before all are written.

    Args:
        folder: The folder, created if it does not exist.
        writers: Functions that write a file, by its name.
        replace: Whether existing files may be replaced.

    Returns:
        Paths of the files.

    Raises:
        InputError: A file cannot be written; all others are, and the message lists both. Or the folder was
            filled by others meanwhile, and nothing is written.
    """
    with _prepared(folder) as prepared:
        failed = _write_all(prepared, writers)
        failed = {name: why.replace(str(prepared), str(folder)) for name, why in failed.items()}
        if failed or not _became(prepared, folder):
            folder.mkdir(exist_ok=True)
            failed |= _put(prepared, folder, replace)
    _raise_for(failed, folder, writers)
    return tuple(folder / name for name in writers)


def _plans(attempts: Iterable[Attempt]) -> Iterator[tuple[str, Callable[[Path], None]]]:
    """Yield the files of the attempts that have a plan, by name, and what writes them; without wall times."""
    for k, attempt in enumerate(attempts, start=1):
        if attempt.plan is not None and attempt.seen is not None:
            yield f"plan_{k:03}.json", partial(write_plan, replaced(attempt.plan, statistics={}))
            yield f"seen_{k:03}.json", partial(write_scene, attempt.seen)


@contextmanager
def _prepared(folder: Path) -> Iterator[Path]:
    """Make a folder, on the same file system, for files that are to be moved into another one."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        where = folder / ".new" if folder.is_dir() else folder.parent / f".{folder.name}.new"
        prepared = Path(tempfile.mkdtemp(prefix=f"{where.name}.", dir=where.parent))
        prepared.chmod(0o777 & ~_umask())
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be made: {error.strerror}; name another folder with -o"
        ) from error
    try:
        yield prepared
    finally:
        shutil.rmtree(prepared, ignore_errors=True)


def _became(prepared: Path, folder: Path) -> bool:
    """Rename prepared files to a new folder; return False if there is one already."""
    if folder.exists():
        return False
    try:
        prepared.rename(folder)
    except OSError:  # somebody else has just made it
        return False
    return True


def _umask() -> int:
    """Return the mask of permissions of new files, which can only be read by setting it."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _put(prepared: Path, folder: Path, replace: bool) -> dict[str, str]:
    """Move prepared files into a folder that exists, the record last; return why some could not be moved."""
    others = [path for path in folder.iterdir() if path != prepared]
    if others and not replace:
        raise InputError(f"{folder}: exists by now; name another folder with -o or add --overwrite")
    names = sorted((path.name for path in prepared.iterdir()), key=lambda name: name == RECORD)
    failed: dict[str, str] = {}
    put: list[Path] = []
    try:
        if not (folder / RECORD).is_dir():
            (folder / RECORD).unlink(missing_ok=True)
        for path in numbered_files(folder):  # of a trial before, which may have more
            path.unlink(missing_ok=True)
        for name in names:
            try:
                (prepared / name).replace(folder / name)
                put.append(folder / name)
            except OSError as error:
                why = "is a folder" if (folder / name).is_dir() else error.strerror
                failed[name] = f"{folder / name}: {why}"
    except BaseException:
        if not others:
            for path in put:
                path.unlink(missing_ok=True)
        raise
    return failed


def read_look_pictures(
    folder: Path, looks: Iterable[Mapping[str, Any]]
) -> dict[tuple[int, str], NDArray[np.uint8]]:
    """Read the pictures of looks that are in the folder of a trial.

    Args:
        folder: The folder.
        looks: The looks, as its record lists them.

    Returns:
        (height, width, 3) RGB, by number of the look and place.

    Raises:
        InputError: A file is no such picture.
    """
    from pickcli.files.png_file import read_colour

    found = {}
    for look in looks:
        for place in look["cameras"]:
            path = folder / f"{look_name(look['number'], place)}.png"
            if path.exists():
                found[look["number"], place] = read_colour(path)
    return found


def _write_all(folder: Path, writers: Mapping[str, Callable[[Path], None]]) -> dict[str, str]:
    """Write files by name, each though others fail; return why those failed."""
    failed: dict[str, str] = {}
    for name, write in writers.items():
        try:
            write(folder / name)
        except InputError as error:
            failed[name] = str(error)
    return failed


def _raise_for(failed: Mapping[str, str], folder: Path, names: Iterable[str]) -> None:
    if failed:
        there = ", ".join(name for name in names if name not in failed) or "nothing"
        raise InputError(
            f"{next(iter(failed.values()))}; in {folder} written: {there}; not written: {', '.join(failed)}; "
            "name another folder, or once there is room run the same command again with --overwrite"
        )
