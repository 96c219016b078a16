"""Writes pictures as PNG, and reads those of 16 bits."""

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
    from PIL import Image

    content = read_bytes(path, MOST_BYTES, wanted=PICTURE)
    try:
        with Image.open(BytesIO(content), formats=("PNG",)) as picture:
            picture.load()
            mode, values = picture.mode, np.array(picture)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise InputError(f"{path}: is no whole PNG; record it again") from error
    if values.ndim != 2 or not mode.startswith("I"):
        raise InputError(f"{path}: expected a grey PNG of 16 bits, got one of mode {mode}; record it again")
    return values.astype(np.uint16)
