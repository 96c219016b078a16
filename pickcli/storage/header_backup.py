"""Header backup: a second copy of a file's structure, so that no single damage makes the file unreadable.

The part of an HDF5 file that is not data (superblock, headers, attributes) is some kB; with one flipped bit
there, HDF5 cannot open the file. So a compressed copy of it is stored behind the end of the HDF5 file, where
HDF5 does not look:

    compressed copy | SHA-256 of it, 32 bytes | its length, 8 bytes | "APCSPARE"
"""

from __future__ import annotations

import hashlib
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

from pickcli.files.file_kind import HDF5_MAGIC, STORE_END

Place = tuple[int, int]  # first byte, number of bytes

MAX_FILE = 512 * 2**20  # bytes
_MAGIC = STORE_END
_TAIL = struct.Struct("<32sQ8s")
_PLACE = struct.Struct("<QQ")
_MAX_COPY = 2**26  # bytes, uncompressed
_END_IN_SUPERBLOCK = slice(28, 36)  # file length in superblocks of version 2 and 3


@dataclass(frozen=True)
class RestoredFile:
    """A file restored from its header backup.

    Attributes:
        image: The HDF5 file with its original structure; data are as found.
        has_directory: Whether the structure in the file is undamaged.
        has_backup: Whether the backup is undamaged.
    """

    image: bytes
    has_directory: bool
    has_backup: bool


def with_backup(image: bytes, data: Sequence[Place]) -> bytes:
    """Append a header backup to a file.

    Args:
        image: Bytes of the HDF5 file.
        data: Places (first byte, number of bytes) of data, which are not copied.

    Returns:
        The bytes of both.
    """
    places = _between(sorted(data), len(image))
    copied = b"".join(image[first : first + count] for first, count in places)
    header = struct.pack("<Q", len(places)) + b"".join(_PLACE.pack(*place) for place in places)
    backup = zlib.compress(header + copied, 9)
    return image + backup + _TAIL.pack(hashlib.sha256(backup).digest(), len(backup), _MAGIC)


def restored(content: bytes) -> RestoredFile:
    """Restore the structure of a file from its backup.

    Without a backup the structure is unchanged; a truncated file is filled with zeros.

    Args:
        content: Bytes of the file.

    Returns:
        The restored file.
    """
    backup = _backup(content)
    if backup is None:
        return RestoredFile(_filled_up(content), len(content) >= _length(content), False)
    image = bytearray(content[: len(content) - _TAIL.size - backup.size])
    return RestoredFile(bytes(backup.put_into(image)), backup.is_in(image), True)


@dataclass(frozen=True)
class _Backup:
    places: tuple[Place, ...]
    copied: bytes
    size: int  # size in the file

    def parts(self) -> list[tuple[slice, bytes]]:
        at, found = 0, []
        for first, count in self.places:
            found.append((slice(first, first + count), self.copied[at : at + count]))
            at += count
        return found

    def is_in(self, image: bytearray) -> bool:
        return all(image[where] == part for where, part in self.parts())

    def put_into(self, image: bytearray) -> bytearray:
        whole = bytearray(image)
        for where, part in self.parts():
            whole[where] = part
        return whole


def _between(data: Sequence[Place], length: int) -> list[Place]:
    """The places between the given ones."""
    ends = [0, *(first + count for first, count in data if count)]
    starts = [*(first for first, count in data if count), length]
    return [(end, start - end) for end, start in zip(ends, starts, strict=True) if start > end]


def _backup(content: bytes) -> _Backup | None:
    """The backup at the end of a file if it is intact, else None."""
    if len(content) < _TAIL.size:
        return None
    digest, size, magic = _TAIL.unpack(content[-_TAIL.size :])
    end = len(content) - _TAIL.size
    packed = content[end - size : end] if size <= end else b""
    if magic != _MAGIC or hashlib.sha256(packed).digest() != digest:
        return None
    return _parsed(packed, end - size)


def _parsed(packed: bytes, length: int) -> _Backup | None:
    """Unpack a backup if it is consistent with a file of that length, as checksums can be forged."""
    try:
        text = zlib.decompressobj().decompress(packed, _MAX_COPY)
        (n_places,) = struct.unpack_from("<Q", text)
        places = tuple(_PLACE.unpack_from(text, 8 + 16 * i) for i in range(min(n_places, len(text))))
    except (zlib.error, struct.error):
        return None
    copied = text[8 + 16 * len(places) :]
    if sum(count for _, count in places) != len(copied) or any(sum(place) > length for place in places):
        return None
    return _Backup(places, copied, len(packed))


def full_length(content: bytes) -> int | None:
    """Return the original length of a truncated file.

    Args:
        content: Bytes of the file.

    Returns:
        Least number of bytes that it had; None if it is not truncated, or its beginning does not state it.
    """
    length = _length(content)
    is_stated = content.startswith(HDF5_MAGIC) and len(content) < length <= MAX_FILE
    return length if is_stated else None


def _length(content: bytes) -> int:
    """Length of the HDF5 file according to its superblock."""
    return int.from_bytes(content[_END_IN_SUPERBLOCK], "little")


def _filled_up(content: bytes) -> bytes:
    missing = _length(content) - len(content)
    return content + bytes(missing) if 0 < missing <= _MAX_COPY else content
