"""Bounded reading of whole files: only regular files, up to a maximum size."""

from __future__ import annotations

import logging
import stat
from pathlib import Path

from pickcli.errors import InputError
from pickcli.files.file_kind import CELL, FileKind, kind_of, refuse_encoded, refuse_other_kind

_log = logging.getLogger(__name__)

_ENDS = 4096  # bytes at the beginning and at the end, in which this program's JSON files state their format

_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
}


def read_bytes(
    path: Path, max_bytes: int, what_to_do: str = "", wanted: FileKind | None = None
) -> bytes:  # fmt: skip
    """Read a regular file of at most ``max_bytes``.

    Args:
        path: The file, or a link to it.
        max_bytes: Largest size of such a file. No more than this is read.
        what_to_do: Advice in the message for a missing file; "" for that of its kind.
        wanted: Expected kind of file; None for any.

    Returns:
        The whole content.

    Raises:
        InputError: There is no such file, or it is a device, pipe, socket or folder, of another kind, too
            large or unreadable.
    """
    what_to_do = what_to_do or "check the name" + ("" if wanted is None else f" ({wanted.origin})")
    try:
        refuse_special_file(path, what_to_do)
        with open(path, "rb") as file:
            content = file.read(max_bytes + 1)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; {what_to_do}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if wanted is not None:
        refuse_other_kind(path, content, wanted, is_whole=len(content) <= max_bytes)
    if len(content) > max_bytes:
        raise InputError(f"{path}: at most {max_bytes} bytes are read, it has more; is it the right file?")
    _log.info("read %s: %d bytes", path, len(content))
    return content


def read_text(
    path: Path, max_bytes: int, what_to_do: str = "", wanted: FileKind | None = None
) -> str:  # fmt: skip
    """Read a regular UTF-8 text file of at most ``max_bytes``.

    Args:
        path: The file, or a link to it.
        max_bytes: Largest size of such a file. No more than this is read.
        what_to_do: Advice in the message for a missing file; "" for that of its kind.
        wanted: Expected kind of file; None for any.

    Returns:
        The whole content.

    Raises:
        InputError: As for ``read_bytes``, or the bytes are not UTF-8.
    """
    content = read_bytes(path, max_bytes, what_to_do, wanted)
    try:
        return content.decode("utf-8-sig")  # without a byte order mark
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: byte {error.start} is not UTF-8; save the file as UTF-8") from None


def read_kind(path: Path) -> FileKind | None:
    """Determine the kind of a file from its beginning and end.

    Args:
        path: The file.

    Returns:
        The kind; None if unknown. A YAML file of unknown kind counts as a cell.

    Raises:
        InputError: It cannot be read, is not a regular file, or is a text in UTF-16.
    """
    try:
        refuse_special_file(path)
        with path.open("rb") as file:
            head = file.read(_ENDS)
            file.seek(max(file.tell(), path.stat().st_size - _ENDS))
            head += file.read()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    refuse_encoded(path, head)
    if not head:
        raise InputError(f"{path}: is empty; check the name")
    return kind_of(head) or (CELL if path.suffix == ".yaml" else None)


def refuse_special_file(path: Path, what_to_do: str = "name a file") -> None:
    """Refuse a device, pipe, socket or folder: only regular files are read and replaced.

    A path that does not exist is accepted.

    Args:
        path: The path; links are followed.
        what_to_do: Advice at the end of the message.

    Raises:
        InputError: The path is not a regular file.
        OSError: The kind cannot be determined.
    """
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return
    if not stat.S_ISREG(mode):
        kind = _KINDS.get(stat.S_IFMT(mode), "special")
        raise InputError(f"{path}: is {kind}, not a regular file; {what_to_do}")
