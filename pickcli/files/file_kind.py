"""The kinds of files that commands read, told apart by what they say of themselves.

So that a file handed in where another kind is wanted is called by its name, once, before a reader finds
that every one of its keys is unknown.
"""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass
from pathlib import Path

from pickcli.errors import InputError

HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"
STORE_END = (
    b"APCSPARE"  # the last bytes of a stored file: its spare copy may be used where its first are damaged
)
HEAD = 64  # bytes that tell how a text is encoded
UTF_16_MARKS = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
PICTURE_MAGICS = (b"\x89PNG\r\n\x1a\n", b"GIF87a", b"GIF89a", b"\xff\xd8\xff")  # PNG, GIF, JPEG


@dataclass(frozen=True)
class FileKind:
    """One kind of file.

    Attributes:
        name: With its article, as it stands in messages.
        origin: Where such a file comes from.
    """

    name: str
    origin: str


STORE = FileKind("a roadmap or trajectory database", "apc build-roadmap or apc build-trajectories makes one")
PLAN = FileKind("a plan", "apc plan-pick or apc plan-move makes one")
SCENE = FileKind("a scene", "apc make-scene makes one from an order")
ORDER = FileKind("an order", "apc make-order makes one, others are under data/tasks")
TRIAL = FileKind("the record of a trial", "apc run-trial writes one")
TRIALS = FileKind("a folder of trials", "apc run-trials makes one")
TSRS = FileKind("a file of task space regions", "KTH's .tsrs files are such lists")
CELL = FileKind("a cell", "the folder of a cell.yaml, or a name under data/cells")
ITEMS = FileKind("a file of items", "those of both years are under data/items")
REALITY = FileKind("a file of reality levels", "docs/reality.md describes it")
URDF = FileKind("a URDF file", "the robot of a cell is one")
SRDF = FileKind("an SRDF file", "MoveIt's setup assistant writes one beside the URDF")
JOINT_LIMITS = FileKind("a file of joint limits", "ROS's joint_limits.yaml")
PICTURE = FileKind("a picture", "--picture, --plot and --video make some")  # no command reads one
KINDS = (STORE, PLAN, SCENE, ORDER, TRIAL, CELL, ITEMS, REALITY, URDF, SRDF, JOINT_LIMITS)

_BY_FORMAT = {
    b"plan": PLAN,
    b"scene": SCENE,
    b"cell": CELL,
    b"items": ITEMS,
    b"reality": REALITY,
}
_KEY = rb"(?:^[ \t]*|[{,]\s*)[\"']?%s[\"']?\s*:"  # in JSON or YAML
_FORMAT = re.compile(_KEY % rb"format" + rb"\s*[\"']?apc (\w+)", re.MULTILINE)
_BY_MARK = (  # where no format is stated
    (re.compile(_KEY % rb"max_score", re.MULTILINE), TRIAL),
    (re.compile(_KEY % rb"(?:bin_contents|tote_contents|work_order|moves)", re.MULTILINE), ORDER),
    (re.compile(rb"<(?:disable_collisions|group|group_state|end_effector)\b"), SRDF),
    (re.compile(rb"<robot\b"), URDF),
    (re.compile(rb"^(?:robots?|arms|configurations)\s*:", re.MULTILINE), CELL),
    (re.compile(_KEY % rb"joint_limits", re.MULTILINE), JOINT_LIMITS),
)


def kind_of(content: bytes) -> FileKind | None:
    """Tell the kind that a file says to be.

    A roadmap or database says so with its first bytes and again with its last.

    Args:
        content: The file, or its beginning.

    Returns:
        The kind; None where the content says nothing.
    """
    if content.startswith(HDF5_MAGIC) or content.endswith(STORE_END):
        return STORE
    if content.startswith(PICTURE_MAGICS):
        return PICTURE
    if (named := _FORMAT.search(content)) is not None:
        return _BY_FORMAT.get(named[1])
    return next((kind for mark, kind in _BY_MARK if mark.search(content)), None)


def refuse_other_kind(path: Path, content: bytes, wanted: FileKind, is_whole: bool = True) -> None:
    """Refuse a file that says to be of another kind than wanted, or that is binary and of no known kind.

    Args:
        path: The file, for the message.
        content: Its content, or the beginning of it.
        wanted: The kind that it should be.
        is_whole: Whether that is all of the file.

    Raises:
        InputError: It is of another kind.
    """
    refuse_utf_16(path, content)
    found = kind_of(content)
    if found is not None:
        name = found.name
    elif b"\0" in content and not _is_utf8(content):
        name = "a binary file"
    else:
        return
    if found is not wanted:
        cut = ", cut off at its end," if is_whole and _is_cut_off(content) else ","
        raise InputError(f"{path}: is {name}{cut} but {wanted.name} is wanted here ({wanted.origin})")


def refuse_utf_16(path: Path, content: bytes) -> None:
    """Refuse a text in UTF-16, as some editors write it: with a mark, or every other byte of ASCII a zero.

    Args:
        path: The file, for the message.
        content: Its content, or the beginning of it.

    Raises:
        InputError: It is such a text.
    """
    low, high = content[:HEAD:2], content[1:HEAD:2]
    is_ascii = len(high) > 1 and any(
        not any(a) and b.isascii() and all(b) for a, b in ((low, high), (high, low))
    )
    if content.startswith(UTF_16_MARKS) or is_ascii:
        raise InputError(f"{path}: is text in UTF-16; save the file as UTF-8")


def _is_cut_off(content: bytes) -> bool:
    """Whether a JSON text lacks its end."""
    text = content.strip()
    return text.startswith(b"{") and not text.endswith(b"}")


def _is_utf8(content: bytes) -> bool:
    try:
        content.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True
