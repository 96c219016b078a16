"""One process at a time."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pickcli.errors import InputError


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Whoever wants to change a file waits until nobody else does.

    The lock is on an empty file beside it (``.NAME.lock``), for the file itself is replaced when it is
    written; the system gives it back when a process ends, however it ends. Raises InputError if that file
    cannot be made.
    """
    lock = path.with_name(f".{path.name}.lock")
    try:
        handle = os.open(lock, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise InputError(f"{lock}: cannot be made: {error.strerror}; name another place") from None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)
