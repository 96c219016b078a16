"""Kinds of files read by commands, recognised by their content.

A file of a wrong kind is reported once with its kind, instead of as a file with only unknown keys.
"""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass
from pathlib import Path

from pickcli.errors import InputError
from pickcli.name_suggestion import shortened, suggestion

HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"
STORE_END = (
    b"APCSPARE"  # last bytes of a stored file, whose header backup can be used if its beginning is damaged
)
HEAD = 64  # bytes used to recognise the encoding of a text
GZIP_MAGIC = b"\x1f\x8b\x08"
UTF_16_MARKS = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
PICTURE_MAGICS = (b"\x89PNG\r\n\x1a\n", b"GIF87a", b"GIF89a", b"\xff\xd8\xff")  # PNG, GIF, JPEG


@dataclass(frozen=True)
class FileKind:
    """One kind of file.

    Attributes:
        name: Name with its article, for messages.
        origin: Source of such files.
    """

    name: str
    origin: str


STORE = FileKind("a roadmap or trajectory database", "apc build-roadmap or apc build-trajectories makes one")
PLAN = FileKind("a plan", "apc plan-pick or apc plan-move makes one")
SCENE = FileKind("a scene", "apc make-scene makes one from an order")
STREAM = FileKind("a stream of items", "apc make-stream makes one")
ORDER = FileKind("an order", "apc make-order makes one, others are under data/tasks")
TRIAL = FileKind("the record of a trial", "apc run-trial writes one")
TRIALS = FileKind("a folder of trials", "apc run-trials makes one")
TSRS = FileKind("a file of task space regions", "KTH's .tsrs files are such lists")
CELL = FileKind("a cell", "the folder of a cell.yaml, or a name under data/cells")
ITEMS = FileKind("a file of items", "those of both years are under data/items")
SENSOR = FileKind("a sensor", "those of data/sensors are examples")
PERCEIVED = FileKind("a file of perceived items", "apc perceive writes one")
TOTE = FileKind("a located tote", "apc locate-tote writes one")
RECORDING = FileKind("a recording", "apc render --recording writes one")
REALITY = FileKind("a file of reality levels", "docs/reality.md describes it")
STRATEGY = FileKind("a strategy", "those of data/strategies are examples")
STACK = FileKind("a stack of tasks", "those of data/stacks are examples")
HAND = FileKind("a hand", "those of data/hands are examples")
PALLET = FileKind("an order of a pallet", "apc make-pallet-order draws one")
STACKED = FileKind("a stacked pallet", "apc plan-pallet writes one")
GRASPS = FileKind("a file of recorded grasps", "apc record-grasp writes one")
DRIVING_AREA = FileKind("a driving area", "docs/formats/drive.md describes it")
DRIVE = FileKind("a plan of a drive", "apc plan-drive writes one")
COMMISSION = FileKind("a commission", "that of data/tasks is an example")
WATCH = FileKind("a watch of a truck", "those of data/watches are examples")
WATCHED_SCENE = FileKind("a watched scene", "docs/formats/watch.md describes it")
WATCHED_DRIVE = FileKind("a watched drive", "apc watch-zone writes one")
DETECTED = FileKind("a detected pallet", "apc detect-pallet writes one")
URDF = FileKind("a URDF file", "the robot of a cell is one")
SRDF = FileKind("an SRDF file", "MoveIt's setup assistant writes one beside the URDF")
JOINT_LIMITS = FileKind("a file of joint limits", "ROS's joint_limits.yaml")
PICTURE = FileKind("a picture", "apc render --depth writes one of depth")
KINDS = (
    STORE,
    PLAN,
    SCENE,
    STREAM,
    ORDER,
    TRIAL,
    CELL,
    ITEMS,
    SENSOR,
    PERCEIVED,
    TOTE,
    RECORDING,
    REALITY,
    STRATEGY,
    STACK,
    HAND,
    PALLET,
    STACKED,
    GRASPS,
    DRIVING_AREA,
    DRIVE,
    COMMISSION,
    WATCH,
    WATCHED_SCENE,
    WATCHED_DRIVE,
    DETECTED,
    URDF,
    SRDF,
    JOINT_LIMITS,
)

_BY_FORMAT = {
    b"plan": PLAN,
    b"scene": SCENE,
    b"stream": STREAM,
    b"cell": CELL,
    b"items": ITEMS,
    b"sensor": SENSOR,
    b"perceived": PERCEIVED,
    b"tote": TOTE,
    b"recording": RECORDING,
    b"reality": REALITY,
    b"strategy": STRATEGY,
    b"stack": STACK,
    b"hand": HAND,
    b"pallet": PALLET,
    b"stacked": STACKED,
    b"grasps": GRASPS,
    b"driving": DRIVING_AREA,
    b"drive": DRIVE,
    b"commission": COMMISSION,
    b"watch": WATCH,
    b"watched scene": WATCHED_SCENE,
    b"watched drive": WATCHED_DRIVE,
    b"detected": DETECTED,
}
_KEY = rb"(?:^[ \t]*|[{,]\s*)[\"']?%s[\"']?\s*:"  # in JSON or YAML
_FORMAT = re.compile(_KEY % rb"format" + rb"\s*[\"']?apc (watched \w+|\w+)", re.MULTILINE)
_FULL_NAMES = {"stacked": "stacked pallet", "driving": "driving area", "detected": "detected pallet"}
_FORMATS = tuple(f"apc {_FULL_NAMES.get(name.decode(), name.decode())}" for name in _BY_FORMAT)
_ANY_FORMAT = re.compile(_KEY % rb"format" + rb"[ \t]*[\"']?([^\"'\r\n,}]*)", re.MULTILINE)
_BY_KEYS = (  # what a file without a format is, if it has all of these keys
    ("apc commission", COMMISSION, ("products", "delivery")),
    ("apc driving area", DRIVING_AREA, ("walls", "start", "goal")),
    ("apc stream", STREAM, ("conveyor", "speed", "items")),
    ("apc pallet", PALLET, ("pallet", "cartons")),
    ("apc stacked pallet", STACKED, ("pallet", "placements")),
)
_BY_PATTERN = (  # if no format is stated
    (re.compile(_KEY % rb"(?:max_score|boxes_per_hour|items_ordered|presented)", re.MULTILINE), TRIAL),
    (re.compile(_KEY % rb"(?:bin_contents|tote_contents|work_order|moves)", re.MULTILINE), ORDER),
    (re.compile(rb"<(?:disable_collisions|group|group_state|end_effector)\b"), SRDF),
    (re.compile(rb"<robot\b"), URDF),
    (re.compile(rb"^(?:robots?|arms|configurations)\s*:", re.MULTILINE), CELL),
    (re.compile(_KEY % rb"joint_limits", re.MULTILINE), JOINT_LIMITS),
)


def kind_of(content: bytes) -> FileKind | None:
    """Determine the kind of a file from its content.

    Roadmaps and databases are recognised by their first or last bytes.

    Args:
        content: The file, or its beginning.

    Returns:
        The kind; None if unknown.
    """
    content = content.removeprefix(codecs.BOM_UTF8)
    if content.startswith(HDF5_MAGIC) or content.endswith(STORE_END):
        return STORE
    if content.startswith(PICTURE_MAGICS):
        return PICTURE
    if (named := _FORMAT.search(content)) is not None:
        return _BY_FORMAT.get(named[1])
    return next((kind for pattern, kind in _BY_PATTERN if pattern.search(content)), None)


def refuse_other_kind(path: Path, content: bytes, wanted: FileKind, is_whole: bool = True) -> None:
    """Refuse a file of another kind than expected, or a binary file of unknown kind.

    Orders of the challenges state no format. Where one is expected, a file that states an unknown format, or
    none although it has the keys of a kind that must, is refused, too.

    Args:
        path: The file, for messages.
        content: Its content or the beginning of it.
        wanted: The expected kind.
        is_whole: Whether ``content`` is the whole file.

    Raises:
        InputError: It is of another kind.
    """
    refuse_encoded(path, content)
    found = kind_of(content)
    if found is not None:
        name = found.name
    elif b"\0" in content and not _is_utf8(content):
        name = "a binary file"
    else:
        if wanted is ORDER:
            _refuse_misnamed(path, content.removeprefix(codecs.BOM_UTF8))
        return
    if found is not wanted:
        cut = ", cut off at its end," if is_whole and _is_cut_off(content) else ","
        raise InputError(f"{path}: is {name}{cut} but {wanted.name} is expected here ({wanted.origin})")


def refuse_encoded(path: Path, content: bytes) -> None:
    """Refuse what has to be changed to be read: an archive of gzip, or a text in UTF-16.

    The latter is one with a byte order mark, or with every other byte zero.

    Args:
        path: The file, for messages.
        content: Its content or the beginning of it.

    Raises:
        InputError: It is such a file.
    """
    if content.startswith(GZIP_MAGIC):
        raise InputError(f"{path}: is compressed by gzip; unpack it, and name what was in it")
    low, high = content[:HEAD:2], content[1:HEAD:2]
    is_ascii = len(high) > 1 and any(
        not any(a) and b.isascii() and all(b) for a, b in ((low, high), (high, low))
    )
    if content.startswith(UTF_16_MARKS) or is_ascii:
        raise InputError(f"{path}: is text in UTF-16; save the file as UTF-8")


def _refuse_misnamed(path: Path, content: bytes) -> None:
    """Refuse a file without the keys of an order whose format is unknown, or missing."""
    if (stated := _ANY_FORMAT.search(content)) is not None:
        name = stated[1].decode("utf-8", "replace").strip()
        raise InputError(f"{path}: format: unknown {shortened(name)!r}; {suggestion(name, _FORMATS)}")
    for name, kind, keys in _BY_KEYS:
        if all(re.search(_KEY % key.encode(), content, re.MULTILINE) for key in keys):
            have = ", ".join(map(repr, keys))
            raise InputError(f"{path}: format: missing; with {have} it is {kind.name}: add format: {name!r}")


def _is_cut_off(content: bytes) -> bool:
    """Whether a JSON text has no end."""
    text = content.strip()
    return text.startswith(b"{") and not text.endswith(b"}")


def _is_utf8(content: bytes) -> bool:
    try:
        content.decode("utf-8")
    except UnicodeDecodeError:
        return False
    return True
