"""Files from outside, read whole: regular ones only, and no more of them than is expected."""

from __future__ import annotations

import logging
import stat
from pathlib import Path

from pickcli.errors import InputError
from pickcli.files.file_kind import CELL, FileKind, kind_of, refuse_other_kind, refuse_utf_16

_log = logging.getLogger(__name__)

_ENDS = 4096  # bytes, the first in which a JSON file of this program names its format, and the last

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
        max_bytes: The most that such a file has. What is larger is not read any farther.
        what_to_do: Advice at the end of the message where the file is not there; "" for that of its kind.
        wanted: What it should be; None for any file.

    Returns:
        The whole content.

    Raises:
        InputError: There is no such file, it is a device, pipe, socket or folder, of another kind, too large
            or unreadable.
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
        max_bytes: The most that such a file has. What is larger is not read any farther.
        what_to_do: Advice at the end of the message where the file is not there; "" for that of its kind.
        wanted: What it should be; None for any file.

    Returns:
        The whole content.

    Raises:
        InputError: As ``read_bytes`` raises it, or the bytes are not UTF-8.
    """
    content = read_bytes(path, max_bytes, what_to_do, wanted)
    try:
        return content.decode("utf-8-sig")  # some editors begin a file with a mark
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: byte {error.start} is not UTF-8; save the file as UTF-8") from None


def read_kind(path: Path) -> FileKind | None:
    """Tell the kind that a file says to be, by its beginning and its end.

    Args:
        path: The file.

    Returns:
        The kind; None where the file says nothing. A YAML file that says nothing counts as a cell.

    Raises:
        InputError: It cannot be read, is no regular file, or a text in UTF-16.
    """
    try:
        refuse_special_file(path)
        with path.open("rb") as file:
            head = file.read(_ENDS)
            file.seek(max(file.tell(), path.stat().st_size - _ENDS))
            head += file.read()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    refuse_utf_16(path, head)
    return kind_of(head) or (CELL if path.suffix == ".yaml" else None)


def refuse_special_file(path: Path, what_to_do: str = "name a file") -> None:
    """Refuse a device, pipe, socket or folder: only regular files are read and replaced.

    A path where nothing is passes.

    Args:
        path: What is looked at; links are followed.
        what_to_do: Advice at the end of the message.

    Raises:
        InputError: The path is no regular file.
        OSError: That cannot be found out.
    """
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return
    if not stat.S_ISREG(mode):
        kind = _KINDS.get(stat.S_IFMT(mode), "special")
        raise InputError(f"{path}: is {kind}, not a regular file; {what_to_do}")
