"""One process at a time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pickcli.errors import InputError


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold a file for changing it: other processes that want to change it wait until the context ends.

    The lock is on an empty file beside it (``.NAME.lock``), for the file itself is replaced when it is
    written; the system gives it back when a process ends, however it ends.

    Args:
        path: The file that is to be changed; it need not exist.

    Yields:
        Nothing, as soon as the lock is held.

    Raises:
        InputError: The file beside it cannot be made.
    """
    from filelock import FileLock

    lock = FileLock(path.with_name(f".{path.name}.lock"))
    try:
        lock.acquire()
    except OSError as error:
        raise InputError(f"{lock.lock_file}: cannot be made: {error.strerror}; name another place") from None
    try:
        yield
    finally:
        lock.release()
