"""Colours of items as labels, and how likely each label is on an item under any amount of light.

A label is a cell of a histogram over chromaticity, which does not change with the amount of light, and
coarsely over brightness, which tells white from black.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from pickcli.cell.item import Item
from pickcli.geometry import Array
from pickcli.perception.looks import coloured
from pickcli.perception.procedural_texture import face_textures

N_CHROMATICITY, N_BRIGHTNESS = 14, 4
N_LABELS = N_CHROMATICITY**2 * N_BRIGHTNESS
_GAINS = np.sqrt(np.linspace(0.2, 1.1, 8))  # amounts of light; bytes go with their roots
_ANY_LIGHT = np.sqrt(np.linspace(0.12, 1.6, 12))  # the same, from deep shade to a lamp that faces it
_HIGHLIGHTS = (0.0, 0.25, 0.5, 0.75)  # shares of white in what lamps show of a shiny surface
_TEXEL = 4  # px of a texture's side that a pixel of a camera sees together
_SMOOTHING = (0.8, 0.8, 0.5)  # cells
_OTHER = 0.03  # share of pixels of any colour: highlights, stickers
_OFTEN = 10.0  # times as often as any colour is seen on any surface, a label is one of a surface's own
WEIGHT = 0.25  # of a pixel: neighbours on a label are alike
LARGEST = 2.5  # nats, of a pixel's ratio


def colour_labels(colour: Array) -> NDArray[np.int32]:
    """Give each colour the label of its cell.

    Args:
        colour: (..., 3) red, green, blue, 0 to 255.

    Returns:
        (...) labels below ``N_LABELS``.
    """
    total = colour.sum(axis=-1) + 3.0
    # Chromaticities between 0.1 and 0.7, in equal cells; what is beyond belongs to the outer ones.
    cells = ((colour[..., :2] + 1.0) / total[..., None] - 0.1) / 0.6 * N_CHROMATICITY
    red, green = np.clip(cells, 0, N_CHROMATICITY - 1).astype(np.int32).transpose(-1, *range(colour.ndim - 1))
    brightness = np.clip(colour.max(axis=-1) / 256.0 * N_BRIGHTNESS, 0, N_BRIGHTNESS - 1).astype(np.int32)
    return np.asarray((red * N_CHROMATICITY + green) * N_BRIGHTNESS + brightness, dtype=np.int32)


def item_colours(item: Item, texture_seed: int) -> Array:
    """Sample the colours of an item's faces.

    Args:
        item: The item.
        texture_seed: Seed of the prints that its model was made from.

    Returns:
        (N, 3) red, green, blue, each of an equal area.
    """
    found = []
    for texture in face_textures(coloured(item), texture_seed):
        height, width = (n // _TEXEL * _TEXEL for n in texture.shape[:2])
        blocks = texture[:height, :width].astype(np.float64)
        blocks = blocks.reshape(height // _TEXEL, _TEXEL, width // _TEXEL, _TEXEL, 3).mean(axis=(1, 3))
        found.append(blocks.reshape(-1, 3))
    return np.concatenate(found)


def label_shares(colours: Array) -> Array:
    """Compute how often each label is seen on a surface.

    Args:
        colours: (N, 3) colours of equal areas under full light.

    Returns:
        (``N_LABELS``,) shares, their sum is 1.
    """
    shares = _smoothed_shares(np.clip(colours[None] * _GAINS[:, None, None], 0.0, 255.0), _SMOOTHING)
    return np.asarray((1.0 - _OTHER) * shares / shares.sum() + _OTHER / N_LABELS)


def own_labels(colours: Array, has_highlights: bool) -> NDArray[np.bool_]:
    """Tell the labels that a surface shows itself, in any light.

    Chromaticities are blurred as shares are. Brightness is not: between the darkest label and the next one
    lies what tells white in the shade from black.

    Args:
        colours: (N, 3) colours of equal areas under full light.
        has_highlights: Whether lamps show in it, which are white.

    Returns:
        (``N_LABELS``,) whether each is its own.
    """
    lit = np.clip(colours[None] * _ANY_LIGHT[:, None, None], 0.0, 255.0)
    mixed = [lit + share * (255.0 - lit) for share in (_HIGHLIGHTS if has_highlights else (0.0,))]
    shares = _smoothed_shares(np.concatenate(mixed), (*_SMOOTHING[:2], 0.0))
    return np.asarray(shares / shares.sum() > _OFTEN * _OTHER / N_LABELS)


def _smoothed_shares(colours: Array, smoothing: tuple[float, float, float]) -> Array:
    """How often each label (``N_LABELS``,) is among colours (..., 3), blurred by cells of its histogram."""
    counts = np.bincount(colour_labels(colours).ravel(), minlength=N_LABELS).astype(np.float64)
    shaped = counts.reshape(N_CHROMATICITY, N_CHROMATICITY, N_BRIGHTNESS)
    return np.asarray(gaussian_filter(shaped, smoothing, mode="nearest").ravel())


def colour_costs(shares: Sequence[Array]) -> list[Array]:
    """Compute what a label costs on each of several surfaces, beside their average.

    Args:
        shares: (``N_LABELS``,) each.

    Returns:
        Costs (``N_LABELS``,) for each, in nats, negative where the label speaks for the surface.
    """
    average = np.mean(shares, axis=0)
    return [WEIGHT * np.clip(np.log(average / own), -LARGEST, LARGEST) for own in shares]
