"""Inter-process lock for changing a file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pickcli.errors import InputError


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Lock a file for changing it: other processes wait until the context ends.

    The lock is on an empty file beside it (``.NAME.lock``), as the file itself is replaced when written. The
    system releases it when the process ends, in any way.

    Args:
        path: The file to be changed; it need not exist.

    Yields:
        Nothing, once the lock is held.

    Raises:
        InputError: The lock file cannot be created.
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
