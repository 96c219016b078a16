"""Atomic writes: a file has either its old or its new content, even if the writer is killed."""

from __future__ import annotations

import contextlib
import fcntl
import glob
import logging
import os
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from pickcli.errors import InputError
from pickcli.files.bounded_reading import refuse_special_file

_log = logging.getLogger(__name__)


def write_bytes(path: Path, content: bytes, replace: bool = True) -> None:
    """Write a file such that a crash or a full disk leaves the old one intact.

    The content is written to a temporary file in the same folder, synced, and renamed to the target.
    Leftovers of killed writers are removed by the next write of the same file.

    Args:
        path: The file. If it is a symbolic link, its target is written and the link stays.
        content: The whole content.
        replace: Whether an existing file may be replaced; if not, a file that another process creates before
            this write is complete is kept.

    Raises:
        InputError: The folder is missing or not writable, the path is not a regular file, or an existing file
            may not be replaced.
    """
    try:
        target = Path(os.path.realpath(path))
        refuse_special_file(target)
        _put(target, content, replace)
    except FileExistsError:
        raise InputError(
            f"{path}: exists by now, written by another command meanwhile; nothing was changed: choose "
            "another name or add --overwrite"
        ) from None
    except OSError as error:
        kept = "it is left as it was" if os.path.lexists(path) else "nothing was written"
        raise InputError(f"{path}: cannot be written: {error.strerror}; {kept}") from None


def write_text(path: Path, text: str, replace: bool = True) -> None:
    """Write a text file as ``write_bytes`` does, encoded in UTF-8.

    Args:
        path: The file. If it is a symbolic link, its target is written and the link stays.
        text: The whole content.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The folder is missing or not writable, the path is not a regular file, or an existing file
            may not be replaced.
    """
    write_bytes(path, text.encode("utf-8"), replace)


def _put(path: Path, content: bytes, replace: bool) -> None:
    part = path.with_name(f".{path.name}.{os.getpid()}-{threading.get_ident()}.part")
    try:
        with _held(part) as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
            _take_name(part, path, replace)
        _sync_folder(path.parent)
    except BaseException:
        with contextlib.suppress(OSError):
            part.unlink()
        raise
    _remove_leftovers(path)
    _log.info("wrote %s: %d bytes", path, len(content))


def _take_name(part: Path, path: Path, replace: bool) -> None:
    """Rename a complete file. Raises FileExistsError if the name is taken and may not be replaced."""
    if not replace:
        with contextlib.suppress(PermissionError, NotImplementedError):  # if hard links are not supported
            os.link(part, path)
            part.unlink()
            return
        if path.exists():
            raise FileExistsError
    os.replace(part, path)


@contextlib.contextmanager
def _held(part: Path) -> Iterator[BinaryIO]:
    """Open a new locked file; the lock, which ends with the process, shows that it is not a leftover."""
    while True:
        with open(part, "wb") as file:
            with contextlib.suppress(OSError):  # without locks, nothing is treated as a leftover
                fcntl.flock(file, fcntl.LOCK_EX)
            if _is_at(part, file):  # not removed before it was locked
                yield file
                return


def _remove_leftovers(path: Path) -> None:
    """Remove the temporary files of killed writers, which no process has locked."""
    for part in path.parent.glob(f".{glob.escape(path.name)}.[0-9]*-[0-9]*.part"):
        with contextlib.suppress(OSError), open(part, "r+b") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _is_at(part, file):
                part.unlink()


def _is_at(part: Path, file: BinaryIO) -> bool:
    """Whether an open file is still at its path."""
    with contextlib.suppress(FileNotFoundError):
        return os.path.samestat(os.stat(part), os.fstat(file.fileno()))
    return False


def _sync_folder(folder: Path) -> None:
    """Sync the folder, so that the new name is durable."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
