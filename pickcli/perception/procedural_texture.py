"""Textures of items, drawn from their names: panels, ellipses, lines of glyphs, a bar code; or plain.

Nothing comes from outside, and no fonts: glyphs are random bitmaps, alike in every line of a text. Another
seed gives other prints on the same item, so that what is found by one set can be tested on another. Labels
may be damaged: stuck over, scratched and faded, each copy of an item in its own way.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import Array
from pickcli.seeds import derived_rng

ColourPicture: TypeAlias = NDArray[np.uint8]

PIXELS_PER_M = 2000.0
MOST_PIXELS = 700  # along a side
_GLYPH = (7, 5)  # rows and columns of a glyph's bitmap
_N_GLYPHS = 26
_FADED, _N_SCRATCHES = (0.75, 1.0), 3  # shares of the contrast that are left, and scratches of a face at most
_STICKERS, _LARGEST_STICKER = 0.4, 0.2  # share of faces that have one, and of a face that it covers at most


def face_textures(item: Item, seed: int) -> tuple[ColourPicture, ...]:
    """Draw the faces of an item.

    Args:
        item: The item, with a colour.
        seed: Seed of the set of textures.

    Returns:
        One picture (height, width, 3) per face, in the order of the kernel's ``Looks``.
    """
    return tuple(
        _face(item, derived_rng(seed, "texture", item.name, face), size, face)
        for face, size in enumerate(_face_sizes(item))
    )


def damaged_faces(faces: Sequence[ColourPicture], seed: int, owner: str) -> tuple[ColourPicture, ...]:
    """Damage the faces of one copy of an item.

    Args:
        faces: Pictures (height, width, 3) of its faces.
        seed: Seed of the damage.
        owner: Id of the copy.

    Returns:
        The faces: faded, with up to three scratches and perhaps a sticker of up to a fifth of the face each.
    """
    return tuple(_damaged(face, derived_rng(seed, "damage", owner, k)) for k, face in enumerate(faces))


def _damaged(face: ColourPicture, rng: np.random.Generator) -> ColourPicture:
    height, width = face.shape[:2]
    picture = 128.0 + rng.uniform(*_FADED) * (face - 128.0) + rng.uniform(-10.0, 10.0)
    y, x = np.mgrid[:height, :width]
    for _ in range(rng.integers(0, _N_SCRATCHES + 1)):
        turn, at = rng.uniform(0.0, np.pi), rng.uniform(0.0, 1.0, 2) * (width, height)
        off = (x - at[0]) * np.sin(turn) - (y - at[1]) * np.cos(turn)
        along = (x - at[0]) * np.cos(turn) + (y - at[1]) * np.sin(turn)
        picture[(np.abs(off) < 1.0) & (np.abs(along) < rng.uniform(0.1, 0.4) * max(width, height))] = 225.0
    if rng.random() < _STICKERS:
        wide, high = (rng.uniform(0.2, np.sqrt(_LARGEST_STICKER)) * np.array([width, height])).astype(int)
        left, top = (rng.uniform(0.0, 1.0, 2) * (width - wide, height - high)).astype(int)
        picture[top : top + high, left : left + wide] = rng.uniform(120.0, 250.0, 3)
    return np.asarray(np.clip(np.rint(picture), 0, 255).astype(np.uint8))


def _face_sizes(item: Item) -> list[tuple[float, float]]:
    """Width and height of each face, m."""
    x, y, z = item.shape.extents.tolist()
    if item.shape.kind is ShapeKind.CYLINDER:
        return [(x, y), (x, y), (np.pi * x, z)]
    return [(y, z), (y, z), (x, z), (x, z), (x, y), (x, y)]


def _face(item: Item, rng: np.random.Generator, size: tuple[float, float], face: int) -> ColourPicture:
    scale = min(PIXELS_PER_M, MOST_PIXELS / max(size))
    width, height = (max(4, round(scale * side)) for side in size)
    base = np.array(item.colour, dtype=np.float64)
    picture = _mottled(rng, base, height, width, item.is_printed)
    if item.is_printed:
        _Print(rng, picture, _palette(item.name, base), scale).draw(has_bar_code=face % 6 in (1, 2))
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def _mottled(rng: np.random.Generator, base: Array, height: int, width: int, is_smooth: bool) -> Array:
    """A face of one colour: nearly even if it is smooth, with light and dark patches if it is cloth."""
    strength = 0.02 if is_smooth else 0.09
    coarse = rng.normal(size=(height // 12 + 2, width // 12 + 2))
    rows, columns = np.arange(height) / 12.0, np.arange(width) / 12.0
    i, j = rows.astype(int), columns.astype(int)
    a, b = (rows - i)[:, None], (columns - j)[None, :]
    upper = (1 - b) * coarse[np.ix_(i, j)] + b * coarse[np.ix_(i, j + 1)]
    lower = (1 - b) * coarse[np.ix_(i + 1, j)] + b * coarse[np.ix_(i + 1, j + 1)]
    patches = (1 - a) * upper + a * lower + 0.5 * rng.normal(size=(height, width))
    return np.asarray(base * (1.0 + strength * patches)[..., None])


def _palette(name: str, base: Array) -> Array:
    """(6, 3) colours of the prints on an item: two of its own, light and dark ones, black and white."""
    rng = derived_rng("palette", name)
    own = np.clip(base[rng.permutation(3)] * rng.uniform(0.5, 1.1), 0, 255)
    other = rng.uniform(20, 235, 3)
    return np.array([own, other, 0.35 * base, 0.5 * base + 127.0, [245.0, 244.0, 240.0], [25.0, 24.0, 28.0]])


class _Print:
    """What is printed on one face."""

    def __init__(self, rng: np.random.Generator, picture: Array, palette: Array, scale: float) -> None:
        self._rng, self._picture, self._palette, self._mm = rng, picture, palette, scale / 1000.0
        self._height, self._width = picture.shape[:2]
        self._glyphs = rng.random((_N_GLYPHS, *_GLYPH)) < 0.5
        self._glyphs[:, :, 2] |= self._glyphs[:, :, 1]  # strokes rather than dots
        self._glyphs[:, 3, :] |= self._glyphs[:, 2, :]

    def draw(self, has_bar_code: bool) -> None:
        """Draw panels and ellipses, on them a title, then small print and perhaps a bar code."""
        rng = self._rng
        for _ in range(rng.integers(2, 5)):
            self._panel()
        for _ in range(rng.integers(1, 4)):
            self._ellipse()
        top = int(rng.uniform(0.08, 0.3) * self._height)
        bottom = self._text(top, rng.uniform(9.0, 16.0), 0.06, 0.94)
        for _ in range(rng.integers(1, 4)):
            bottom = self._text(bottom, rng.uniform(2.5, 5.0), rng.uniform(0.05, 0.3), rng.uniform(0.6, 0.95))
        if has_bar_code:
            self._bar_code()

    def _colour(self) -> Array:
        return np.asarray(self._palette[self._rng.integers(len(self._palette))])

    def _panel(self) -> None:
        """A rectangle over a good part of the face; some run across all of it."""
        rng, (h, w) = self._rng, (self._height, self._width)
        y, x = rng.uniform(0, 0.8) * h, rng.uniform(-0.1, 0.7) * w
        high, wide = rng.uniform(0.1, 0.45) * h, rng.uniform(0.25, 1.2) * w
        if rng.random() < 0.35:
            x, wide = 0.0, float(w)
        self._picture[int(y) : int(y + high), max(0, int(x)) : int(x + wide)] = self._colour()

    def _ellipse(self) -> None:
        rng, (h, w) = self._rng, (self._height, self._width)
        cy, cx = rng.uniform(0.15, 0.85) * h, rng.uniform(0.15, 0.85) * w
        a, b, turn = rng.uniform(0.06, 0.3) * w, rng.uniform(0.06, 0.3) * h, rng.uniform(0, np.pi)
        y, x = np.mgrid[:h, :w]
        along = (x - cx) * np.cos(turn) + (y - cy) * np.sin(turn)
        across = (y - cy) * np.cos(turn) - (x - cx) * np.sin(turn)
        distance = (along / a) ** 2 + (across / b) ** 2
        self._picture[distance < 1.0] = self._colour()
        if rng.random() < 0.6:
            self._picture[(distance < 0.85) & (distance > 0.7)] = self._colour()

    def _text(self, top: int, glyph_mm: float, left: float, right: float) -> int:
        """A line of glyphs of a height; gives the row below it."""
        cell = max(1, round(glyph_mm * self._mm / _GLYPH[0]))
        rows, columns = _GLYPH[0] * cell, (_GLYPH[1] + 1) * cell
        start, n = int(left * self._width), int((right - left) * self._width) // columns
        if n < 1 or top + rows > self._height:
            return top
        ink = self._palette[-1 if self._picture[top : top + rows].mean() > 120 else -2]
        if self._rng.random() < 0.3:
            ink = self._colour()
        for k in range(n):
            if self._rng.random() < 0.15:
                continue  # a blank
            glyph = self._glyphs[self._rng.integers(_N_GLYPHS)]
            mask = np.kron(glyph, np.ones((cell, cell), dtype=bool))
            x = start + k * columns
            self._picture[top : top + rows, x : x + _GLYPH[1] * cell][mask] = ink
        return top + rows + max(1, rows // 2)

    def _bar_code(self) -> None:
        """30 x 18 mm in a corner, where the face is large enough."""
        high, wide = round(18 * self._mm), round(30 * self._mm)
        if high + 4 > self._height or wide + 4 > self._width or wide < 8:
            return
        bars = self._rng.random(wide // 2 + 1) < 0.5
        code = np.where(np.repeat(bars, 2)[:wide], 20.0, 250.0)
        area = self._picture[-high - 2 : -2, -wide - 2 : -2]
        area[:] = 250.0
        area[2:-4, 2:-2] = code[2:-2, None]
