"""Finds vests in four pictures of a pair: bright with flash only, matched, of a vest's size and bands.

A pixel counts if it is brighter with flash than all its neighbours without: so edges that move between both
exposures do not. Connected pixels are blobs. Each pair of blobs that may correspond along a row gives a
disparity, and with it the extent of a vest around: the part of the left picture that its blobs cover is laid
over the right one for the match in whole, finer than a pixel. What has the extent of a vest, and two bright
bands at their distance, is one, if no other disparity fits as well.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from pickcli.geometry import Array
from pickcli.watching.flash_pictures import FlashPictures, GrayPicture
from pickcli.watching.nir_pair import NirPair
from pickcli.watching.retroreflection import BAND_HEIGHTS

LEAST_RISE = 7.0  # counts over the picture without flash, at least
SIGMAS = 6.0  # standard deviations of that difference, at least
SHARE_OF_PEAK, AROUND = 0.1, 25  # of the brightest difference within px around, at least
LEAST_PIXELS = 3  # of a blob
MOST_BLOBS = 120  # of a picture, the brightest
SIZE_RATIO = 2.2  # between widths of a match, at most, beside a pixel
ASIDE = (0.12, 0.32)  # m beside a blob, in which others may be of the same vest: tried one after the other
UPRIGHT = 0.5  # m above and below it, likewise
SEARCHED, SEARCHED_SHARE = 3, 0.16  # px, and of the disparity, in which that of a window is looked for
NEARBY = (1 - SEARCHED_SHARE, 1.0, 1 + SEARCHED_SHARE)
LEAST_MATCH = 0.75  # normalised cross-correlation of both pictures, at least, of what is far
LESS_MATCH = 0.6  # by which that falls with baseline over depth: from near by both see other parts of a vest
UNIQUE, ELSEWHERE = 0.02, 0.2  # of another match as good, of a depth that differs by this share
WIDTH, HEIGHT = (0.1, 0.6), (0.24, 0.9)  # m, extents of a vest's stripes; from near by they look higher
CENTRE = (0.75, 1.7)  # m above the floor of the middle of a vest
SCALES = (0.88, 0.96, 1.04, 1.12)  # of the distance of both bands, tried
LEAST_BANDS = 0.2  # of how much darker it is between both bands than on them
FAR = 1.2  # times the range that matches are looked for in
INSIDE = 0.12  # m of the axis of a body behind the middle of what is seen of its stripes
BODY_WIDTH = 0.35  # m, in which there is no room for two people
BODY_ERROR = 0.06  # m, standard deviation of that, along x and y


@dataclass(frozen=True, eq=False)
class Vest:
    """A vest that was found.

    Attributes:
        place: (3,) m: axis of the body at the height of the middle of its stripes, in the frame of the truck.
        covariance: (2, 2) m^2 of x and y.
        size: m, width and height of its stripes.
        bands: How much darker it is between its bands than on them, 0 to 1.
        match: Normalised cross-correlation of both pictures.
    """

    place: Array
    covariance: Array
    size: tuple[float, float]
    bands: float
    match: float


@dataclass(frozen=True, eq=False)
class _Blobs:
    """Blobs of one picture, each of N."""

    boxes: NDArray[np.intp]  # (N, 4): first row, end row, first column, end column
    middles: Array  # (N, 2): column and row, px, weighed by brightness

    @property
    def extents(self) -> Array:
        """(N, 2) px: columns and rows."""
        boxes = self.boxes
        return np.column_stack([boxes[:, 3] - boxes[:, 2], boxes[:, 1] - boxes[:, 0]]).astype(np.float64)


@dataclass(frozen=True)
class _Window:
    """Rows and columns of the left picture, the ends excluded."""

    top: int
    bottom: int
    left: int
    right: int

    def of(self, picture: GrayPicture, shift: int = 0) -> GrayPicture:
        """The part of a picture so many columns to the left."""
        return picture[self.top : self.bottom, self.left - shift : self.right - shift]

    def overlaps(self, other: _Window, shift: int = 0) -> bool:
        """Whether they share pixels when the other one is so many columns farther to the right."""
        is_level = self.top < other.bottom and other.top < self.bottom
        return is_level and self.left < other.right + shift and other.left + shift < self.right


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A window that has a vest's extent and bands at its disparity."""

    window: _Window
    disparity: float
    vest: Vest

    @property
    def quality(self) -> float:
        """What is compared: how well both pictures match, and a little how clear the bands are."""
        return self.vest.match + 0.1 * self.vest.bands

    def shares_left(self, other: _Candidate) -> bool:
        """Whether both have pixels of the left picture in common."""
        return self.window.overlaps(other.window)

    def shares_right(self, other: _Candidate) -> bool:
        """Whether both have pixels of the right picture in common."""
        return self.window.overlaps(other.window, round(self.disparity) - round(other.disparity))


def find_vests(pair: NirPair, pictures: FlashPictures) -> list[Vest]:
    """Find the vests in the pictures of a pair.

    Args:
        pair: The pair.
        pictures: Its pictures.

    Returns:
        The vests, the most certain first.
    """
    left, of_left = _bright(pair, pictures.left_on, pictures.left_off)
    right, of_right = _bright(pair, pictures.right_on, pictures.right_off)
    if not len(of_left.boxes) or not len(of_right.boxes):
        return []
    tried: dict[tuple[_Window, int], _Candidate | None] = {}
    for window, disparity in _hypotheses(pair, of_left, of_right):
        key = window, round(disparity)
        if key not in tried:
            tried[key] = _candidate(pair, (left, right), window, key[1])
    return _unique([each for each in tried.values() if each is not None])


def _bright(pair: NirPair, on: GrayPicture, off: GrayPicture) -> tuple[GrayPicture, _Blobs]:
    """The difference picture, 0 where it is no brighter with flash; its blobs."""
    around = ndimage.maximum_filter(off, size=3)
    rise = on - around
    sigma = np.sqrt(2 * (pair.read_noise**2 + around * np.float32(pair.largest / pair.full)))
    peaks = ndimage.maximum_filter(rise, size=AROUND)
    is_bright = rise > np.maximum(np.maximum(LEAST_RISE, SIGMAS * sigma), SHARE_OF_PEAK * peaks)
    difference = np.where(is_bright, on - off, np.float32(0.0))
    labels, n = ndimage.label(is_bright, structure=np.ones((3, 3)))
    if not n:
        return difference, _Blobs(np.zeros((0, 4), dtype=np.intp), np.zeros((0, 2)))
    rows, columns = np.nonzero(labels)
    which, weight = labels[rows, columns] - 1, difference[rows, columns].astype(np.float64)
    counts, weights = np.bincount(which, minlength=n), np.bincount(which, weight, n)
    middles = np.column_stack([np.bincount(which, weight * at, n) / weights for at in (columns, rows)])
    boxes = np.array(
        [(a.start, a.stop, b.start, b.stop) for a, b in ndimage.find_objects(labels)], dtype=np.intp
    )
    large = np.flatnonzero(counts >= LEAST_PIXELS)
    kept = np.sort(large[np.argsort(-weights[large], kind="stable")[:MOST_BLOBS]])
    return difference, _Blobs(boxes[kept], middles[kept])


def _hypotheses(pair: NirPair, left: _Blobs, right: _Blobs) -> Iterator[tuple[_Window, float]]:
    """Windows of the left picture with a disparity, from blobs that may correspond."""
    f = pair.camera.fx
    off = left.middles[:, None] - right.middles[None]
    widths, others = left.extents[:, None, 0], right.extents[None, :, 0]
    least, most = (f * pair.baseline / depth for depth in (FAR * pair.farthest, pair.nearest / FAR))
    is_possible = (off[..., 0] > least) & (off[..., 0] < most)
    is_possible &= left.boxes[:, None, 0] < right.boxes[None, :, 1]  # rows in common
    is_possible &= right.boxes[None, :, 0] < left.boxes[:, None, 1]
    is_possible &= np.abs(np.log((widths + 1) / (others + 1))) < np.log(SIZE_RATIO)
    for i, j in np.argwhere(is_possible).tolist():
        disparity = float(off[i, j, 0])
        per_metre = disparity / pair.baseline
        if left.extents[i].max() > (HEIGHT[1] + 0.2) * per_metre + 2:
            continue
        near = np.abs(left.middles - left.middles[i])
        for aside in ASIDE:
            boxes = left.boxes[(near < [aside * per_metre + 1, UPRIGHT * per_metre + 1]).all(axis=1)]
            top, first = boxes[:, [0, 2]].min(axis=0).tolist()
            bottom, last = boxes[:, [1, 3]].max(axis=0).tolist()
            yield _Window(top, bottom, first, last), disparity


def _candidate(
    pair: NirPair, pictures: tuple[GrayPicture, GrayPicture], window: _Window, shift: int
) -> _Candidate | None:
    """What a window is near a disparity; None if that is no vest."""
    f = pair.camera.fx
    if not any(_has_extent(window, part * shift / pair.baseline) for part in NEARBY):
        return None
    if (found := _aligned(*pictures, window, shift)) is None:
        return None
    match, disparity = found
    depth = f * pair.baseline / disparity
    inside = window.of(pictures[0])
    if match < LEAST_MATCH - LESS_MATCH * pair.baseline / depth or not _has_extent(window, f / depth):
        return None
    weights = inside.astype(np.float64)
    column = window.left + float(weights.sum(axis=0) @ np.arange(inside.shape[1]) / weights.sum())
    row = (window.top + window.bottom - 1) / 2
    place = pair.triangulated(np.array([column, row]), np.array([column - disparity, row]))
    if not CENTRE[0] <= place[2] <= CENTRE[1] or not pair.nearest / FAR <= depth <= FAR * pair.farthest:
        return None
    bands = _bands(inside, f / depth)
    if bands < LEAST_BANDS:
        return None
    ray = place[:2] - [pair.forward, 0.0]
    place[:2] += INSIDE * ray / np.hypot(*ray)
    size = tuple(float(max(n - 1, 0.5) * depth / f) for n in inside.shape)
    covariance = pair.covariance(place) + BODY_ERROR**2 * np.eye(2)
    return _Candidate(window, disparity, Vest(place, covariance, (size[1], size[0]), bands, match))


def _has_extent(window: _Window, per_metre: float) -> bool:
    """Whether a window is as wide and high as a vest, with px a metre; blur and sampling take a pixel."""
    sides = (window.right - window.left - 1, window.bottom - window.top - 1)
    return all(
        low * per_metre - 1 <= side <= high * per_metre + 1.5
        for side, (low, high) in zip(sides, (WIDTH, HEIGHT), strict=True)
    )


def _aligned(
    left: GrayPicture, right: GrayPicture, window: _Window, shift: int
) -> tuple[float, float] | None:
    """The best match of a window near a shift, and its disparity, finer than a pixel; None without one."""
    reach = SEARCHED + int(SEARCHED_SHARE * shift)
    shifts = [
        each for each in range(shift - reach, shift + reach + 1)
        if each > 0 and window.left - each >= 0
    ]  # fmt: skip
    if len(shifts) < 3:
        return None
    here = window.of(left)
    norm = float(np.sqrt((here**2).sum()))
    scores = np.array([_correlation(here, norm, window.of(right, each)) for each in shifts])
    k = int(scores.argmax())
    if not 0 < k < len(scores) - 1:
        return None
    before, best, after = scores[k - 1 : k + 2].tolist()
    bend = before - 2 * best + after
    return best, shifts[k] + (0.5 * (before - after) / bend if bend < 0 else 0.0)


def _correlation(here: GrayPicture, norm: float, there: GrayPicture) -> float:
    """Normalised cross-correlation of two difference pictures, 0 to 1."""
    other = float(np.sqrt((there**2).sum()))
    return float((here * there).sum()) / (norm * other) if other else 0.0


def _bands(window: GrayPicture, per_metre: float) -> float:
    """How much darker rows are between two that are as far from each other as the bands, at best."""
    profile = window.astype(np.float64).sum(axis=1)
    grid = np.arange(len(profile), dtype=float)
    best, most = 0.0, profile.max()
    low, high = BAND_HEIGHTS
    for scale in SCALES:
        apart = scale * (high - low) * per_metre
        starts = np.arange(0.0, len(profile) - 1 - apart + 0.51, 0.5)
        if not len(starts):
            continue
        peaks = np.minimum(np.interp(starts, grid, profile), np.interp(starts + apart, grid, profile))
        inner = np.mean([np.interp(starts + part * apart, grid, profile) for part in (0.4, 0.5, 0.6)], axis=0)
        darker = np.where(peaks > 0.4 * most, 1 - inner / np.maximum(peaks, 1e-9), 0.0)
        best = max(best, float(darker.max()))
    return best


def _unique(candidates: list[_Candidate]) -> list[Vest]:
    """The best candidates that share no pixels of either picture, if they fit nowhere else as well."""
    taken: list[_Candidate] = []
    for each in sorted(candidates, key=lambda one: -one.quality):
        if not any(each.shares_left(other) or each.shares_right(other) for other in taken):
            taken.append(each)
    vests: list[Vest] = []
    for each in taken:
        is_own = not any(_is_same_body(each.vest, other) for other in vests)
        if is_own and not _has_rival(each, candidates, taken):
            vests.append(each.vest)
    return vests


def _is_same_body(vest: Vest, other: Vest) -> bool:
    """Whether two parts, between which an arm hides the rest, are of one body."""
    off = np.abs(vest.place[:2] - other.place[:2])
    deviation = np.sqrt(vest.covariance[0, 0] + other.covariance[0, 0])
    return bool(off[1] < BODY_WIDTH and off[0] < BODY_WIDTH + 2 * deviation)


def _has_rival(each: _Candidate, candidates: list[_Candidate], taken: list[_Candidate]) -> bool:
    """Whether a candidate fits as well at another depth, to pixels of the right picture that no other has."""
    return any(
        other.shares_left(each)
        and abs(other.disparity / each.disparity - 1) > ELSEWHERE
        and other.quality > each.quality - UNIQUE
        and not any(third is not each and other.shares_right(third) for third in taken)
        for other in candidates
    )
