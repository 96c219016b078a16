"""Atomic writes: a file is the old one or the new one, whole, even if the writer is killed."""

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
    """Write a file so that a crash or a full disk leaves the old one untouched.

    The content goes into a temporary file beside the target, is synced, and takes the target's name in
    one step. What a kill in the middle of that leaves is removed by the next write of the same file.

    Args:
        path: Where to write. What a symbolic link points to is written, the link stays.
        content: All bytes of the file.
        replace: Whether a file that is there may be replaced; if not, one that appeared at any time before
            this one is complete is kept.

    Raises:
        InputError: The folder is missing or cannot be written, the path is no regular file, or there is a
            file that must not be replaced.
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
        raise InputError(f"{path}: cannot be written: {error.strerror}; it is left as it was") from None


def write_text(path: Path, text: str, replace: bool = True) -> None:
    """Write a text file as ``write_bytes`` does, encoded in UTF-8.

    Args:
        path: Where to write. What a symbolic link points to is written, the link stays.
        text: The whole content.
        replace: Whether a file that is there may be replaced.

    Raises:
        InputError: The folder is missing or cannot be written, the path is no regular file, or there is a
            file that must not be replaced.
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
    """Give a complete file its name. Raises FileExistsError if that is taken and must not be replaced."""
    if not replace:
        with contextlib.suppress(PermissionError, NotImplementedError):  # where there are no hard links
            os.link(part, path)
            part.unlink()
            return
        if path.exists():
            raise FileExistsError
    os.replace(part, path)


@contextlib.contextmanager
def _held(part: Path) -> Iterator[BinaryIO]:
    """A new file that is locked, so that nobody takes it for a leftover: a lock ends with its process."""
    while True:
        with open(part, "wb") as file:
            with contextlib.suppress(OSError):  # where there are no locks, nothing is taken for a leftover
                fcntl.flock(file, fcntl.LOCK_EX)
            if _is_at(part, file):  # and was not removed before it was locked
                yield file
                return


def _remove_leftovers(path: Path) -> None:
    """What killed writers of a file have left: the parts that no process holds."""
    for part in path.parent.glob(f".{glob.escape(path.name)}.[0-9]*-[0-9]*.part"):
        with contextlib.suppress(OSError), open(part, "r+b") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _is_at(part, file):
                part.unlink()


def _is_at(part: Path, file: BinaryIO) -> bool:
    """Whether an open file still lies at its place."""
    with contextlib.suppress(FileNotFoundError):
        return os.path.samestat(os.stat(part), os.fstat(file.fileno()))
    return False


def _sync_folder(folder: Path) -> None:
    """Make the new name itself durable."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
