r"""Journal of finished tasks on disk during a build, so that a kill loses only the tasks in progress.

The journal is a file beside the output to which records are appended:

    "APCTASK\n" | length, 8 bytes | SHA-256 of the body, 32 bytes | body: key as JSON, newline, record

A record is appended in one write under a lock and synced. A record that is incomplete after a kill or on a
full disk, or has a flipped bit, is skipped and its task done again. Because records of one key are the same
bytes, two builds of the same file may write the same journal at once. The journal's name contains the digest
of the build's inputs, so that a build with other inputs has another journal.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import glob
import hashlib
import json
import os
import struct
from collections.abc import Iterator
from pathlib import Path

from pickcli.errors import InputError
from pickcli.jobs.job import Key

_MAGIC = b"APCTASK\n"
_HEAD = struct.Struct("<8sQ32s")
_DISK_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # a full disk, a quota, a limit of the size of files


class Journal:
    """The finished tasks of one run. The file is created with the first record.

    Args:
        output: The file that the run will write; the journal is beside it.
        inputs: SHA-256 over all inputs of records, which is part of the journal's name.
    """

    def __init__(self, output: Path, inputs: str) -> None:
        self.path = output.with_name(f"{output.name}.{inputs[:12]}.journal")

    def read(self) -> dict[Key, bytes]:
        """Read all complete records.

        Returns:
            Bytes by key; none if there is no journal.

        Raises:
            InputError: If the journal cannot be read.
        """
        try:
            content = self.path.read_bytes() if self.path.exists() else b""
        except OSError as error:
            raise InputError(f"{self.path}: cannot be read: {error.strerror}; delete it") from None
        return dict(_records(content))

    def append(self, key: Key, record: bytes) -> None:
        """Append one record.

        Args:
            key: The task.
            record: Its bytes.

        Raises:
            InputError: If the journal cannot be written.
        """
        body = json.dumps(key).encode() + b"\n" + record
        head = _HEAD.pack(_MAGIC, len(body), hashlib.sha256(body).digest())
        try:
            self._write(head + body)
        except FileNotFoundError:
            raise InputError(
                f"{self.path.parent}: was removed during the run, and with it the tasks that were finished; "
                "run the same command again"
            ) from None
        except OSError as error:
            cure = "make room" if error.errno in _DISK_FULL else "mend that"
            raise InputError(
                f"{self.path}: cannot be written: {error.strerror}; {cure} and run the same command again"
            ) from None

    def remove(self) -> None:
        """Delete the journal, after the output is written."""
        with contextlib.suppress(OSError):
            self.path.unlink()

    def _write(self, content: bytes) -> None:
        handle = os.open(self.path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX)
            while content:
                content = content[os.write(handle, content) :]
            os.fsync(handle)
        finally:
            os.close(handle)


def journals(output: Path) -> list[Path]:
    """Return the journals of runs with this output, for any inputs.

    Args:
        output: The file that the runs write.

    Returns:
        Paths.
    """
    return sorted(output.parent.glob(f"{glob.escape(output.name)}.*.journal"))


def _records(content: bytes) -> Iterator[tuple[Key, bytes]]:
    """Yield every complete record of a journal, also after damaged ones."""
    at = content.find(_MAGIC)
    while at >= 0:
        body = _body(content, at)
        if body is not None:
            name, _, record = body.partition(b"\n")
            if (key := _key(name)) is not None:
                yield key, record
        at = content.find(_MAGIC, at + (_HEAD.size + len(body) if body is not None else 1))


def _key(name: bytes) -> Key | None:
    """Return the task of a record from its name, if that is one."""
    try:
        parts = json.loads(name)
    except (ValueError, RecursionError):
        return None
    is_key = isinstance(parts, list) and all(isinstance(part, str) for part in parts)
    return tuple(parts) if is_key else None


def _body(content: bytes, at: int) -> bytes | None:
    """Return the body of the record at a position, if it is complete."""
    if at + _HEAD.size > len(content):
        return None
    _, length, digest = _HEAD.unpack_from(content, at)
    body = content[at + _HEAD.size : at + _HEAD.size + length]
    return body if len(body) == length and hashlib.sha256(body).digest() == digest else None
