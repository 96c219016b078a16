"""Writes pictures as PNG, and reads them."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pickcli.errors import InputError
from pickcli.files.atomic_write import write_bytes
from pickcli.files.bounded_reading import read_bytes
from pickcli.files.file_kind import PICTURE

MOST_BYTES = 100_000_000
MOST_PIXELS = 50_000_000
_AT_BITS = 24  # byte of a PNG that tells the bits of its values: of three times 16 Pillow keeps 8 unasked
_COLOUR_BITS = 8


def write_png(picture: NDArray[np.uint8] | NDArray[np.uint16], path: Path, replace: bool = True) -> None:
    """Write a picture atomically: after a crash or with a full disk the old file is intact.

    Args:
        picture: (height, width, 3) in colour, or (height, width) grey, of 8 or 16 bits.
        path: The file.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
    """
    from PIL import Image

    content = BytesIO()
    Image.fromarray(picture).save(content, format="PNG")
    write_bytes(path, content.getvalue(), replace)


def read_grey(path: Path) -> NDArray[np.uint16]:
    """Read a grey picture of 16 bits.

    Args:
        path: The file.

    Returns:
        (height, width).

    Raises:
        InputError: The file cannot be read, or is no such picture.
    """
    mode, _, values = _read(path)
    if values.ndim != 2 or not mode.startswith("I"):
        raise InputError(f"{path}: expected a grey PNG of 16 bits, got one of mode {mode}; record it again")
    return values.astype(np.uint16)


def read_colour(path: Path) -> NDArray[np.uint8]:
    """Read a colour picture of 8 bits.

    Args:
        path: The file.

    Returns:
        (height, width, 3) red, green and blue.

    Raises:
        InputError: The file cannot be read, or is no such picture.
    """
    mode, bits, values = _read(path)
    if mode != "RGB" or bits != _COLOUR_BITS:
        got = f"one of mode {mode}" if mode != "RGB" else f"one of {bits} bits"
        raise InputError(f"{path}: expected a PNG in colour of 8 bits, got {got}; write it again")
    return values.astype(np.uint8)


def _read(path: Path) -> tuple[str, int, NDArray[np.generic]]:
    """Mode of a picture in Pillow's words, bits of a value, and its pixels; decoded if its size is sane."""
    from PIL import Image

    content = read_bytes(path, MOST_BYTES, wanted=PICTURE)
    try:
        with Image.open(BytesIO(content), formats=("PNG",)) as picture:
            if picture.width * picture.height > MOST_PIXELS:
                size = f"{picture.width} x {picture.height} px"
                raise InputError(f"{path}: has {size}, more than any camera here; record it again")
            picture.load()
            return picture.mode, content[_AT_BITS], np.array(picture)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise InputError(f"{path}: is no whole PNG; record it again") from error
