"""Pictures are read as they were written, and not as something else."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from pickcli.errors import InputError
from pickcli.files.png_file import read_colour, read_grey, write_png

RGB = 2  # kind of colours in the head of a PNG


def chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def deep_colour(path: Path, picture: np.ndarray) -> None:
    """Write a PNG in colour of 16 bits, which Pillow cannot."""
    height, width, _ = picture.shape
    rows = b"".join(b"\0" + row.astype(">u2").tobytes() for row in picture)
    head = struct.pack(">IIBBBBB", width, height, 16, RGB, 0, 0, 0)
    content = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + content)


def test_pictures_are_read_as_they_were_written(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    colour = rng.integers(0, 256, (7, 9, 3)).astype(np.uint8)
    grey = rng.integers(0, 65536, (7, 9)).astype(np.uint16)
    write_png(colour, tmp_path / "colour.png")
    write_png(grey, tmp_path / "grey.png")
    assert np.array_equal(read_colour(tmp_path / "colour.png"), colour)
    assert np.array_equal(read_grey(tmp_path / "grey.png"), grey)


def test_colours_of_16_bits_are_refused(tmp_path: Path) -> None:
    deep_colour(tmp_path / "deep.png", np.full((4, 5, 3), 40_000))
    with pytest.raises(
        InputError, match=r"deep\.png: expected a PNG in colour of 8 bits, got one of 16 bits; write it again"
    ):
        read_colour(tmp_path / "deep.png")
    write_png(np.zeros((4, 5), dtype=np.uint8), tmp_path / "grey.png")
    with pytest.raises(InputError, match="colour of 8 bits, got one of mode L"):
        read_colour(tmp_path / "grey.png")
