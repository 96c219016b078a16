"""Writes pictures as PNG."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pickcli.files.atomic_write import write_bytes


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
