"""Pictures of a trial's looks, small enough to be part of its page."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from io import BytesIO

import numpy as np
from numpy.typing import NDArray

from pickcli.page.page_document import PagePicture

MOST_BYTES = 600_000  # of all pictures of a page
_WIDTHS = (480, 400, 320, 240, 160)  # px, the widest first
_QUALITY = 60


def look_pictures(pictures: Mapping[tuple[int, str], NDArray[np.uint8]]) -> tuple[PagePicture, ...]:
    """Make pictures of looks as small as is needed for all of them to be on one page.

    Args:
        pictures: (height, width, 3) RGB, by number of the look and place.

    Returns:
        The pictures, in the order of the looks: as many of the first as fit.
    """
    ordered = sorted(pictures.items())
    for width in _WIDTHS:
        encoded = [_jpeg(picture, width) for _, picture in ordered]
        if sum(map(len, encoded)) <= MOST_BYTES:
            break
    fit = np.cumsum([len(each) for each in encoded]) <= MOST_BYTES if ordered else ()
    return tuple(
        PagePicture(f"{number}: {place}", "data:image/jpeg;base64," + base64.b64encode(content).decode())
        for ((number, place), _), content, fits in zip(ordered, encoded if ordered else (), fit, strict=True)
        if fits
    )


def _jpeg(picture: NDArray[np.uint8], width: int) -> bytes:
    """The picture as JPEG, as wide as that at most."""
    from PIL import Image

    whole, content = Image.fromarray(picture), BytesIO()
    small = whole.resize((width, round(whole.height * width / whole.width))) if width < whole.width else whole
    small.save(content, format="JPEG", quality=_QUALITY)
    return content.getvalue()
