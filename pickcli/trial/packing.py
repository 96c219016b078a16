"""Where items can go in one bin: candidates dropped onto a height map of what lies there already."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.station import Bin
from pickcli.geometry import Array, pose, rotation_rpy
from pickcli.trial.stances import Stance, stances

CELL = 0.004  # m, grid of the height map
WALL_GAP = 0.004  # m kept from walls
FRONT_GAP = 0.030  # m kept behind the mouth: the lips are 20 mm deep at most
ITEM_GAP = 0.004  # m kept between neighbours
CEILING_GAP = 0.008  # m
DROP = 0.002  # m over what it will lie on
LEVEL = 0.006  # m within which heights support together
MIN_SUPPORT = 0.35  # share of the footprint that must be supported when lying on other items
TOSSED = 5.0  # cost of a spot without support: only when there is no other
TOSS_FROM = 0.1  # tidiness; before that, better layouts are looked for
SQUARE_SHARE = 0.8  # of the items that lie roughly parallel to a wall
SQUARE_SPREAD = np.radians(6.0)
N_CANDIDATES = 120


@dataclass(frozen=True, eq=False)
class Spot:
    """A place found for an item, in the bin frame."""

    T_bin_item: Array
    stance: Stance
    mask: NDArray[np.bool_]
    bottom: float  # m, bin frame
    is_on_floor: bool
    is_supported: bool  # else it is tossed on top and finds its own rest


class BinMap:
    """Height of the highest thing over each cell of a bin's floor, bin frame, m."""

    def __init__(self, cell_bin: Bin) -> None:
        self._bin = cell_bin
        self._x = np.arange(FRONT_GAP, cell_bin.depth, CELL)
        self._y = np.arange(cell_bin.y_range[0], cell_bin.y_range[1], CELL)
        self._floor = np.repeat(self._floor_height(self._x)[:, None], len(self._y), axis=1)
        self._height = self._floor.copy()
        self._lower = np.array([FRONT_GAP, cell_bin.y_range[0] + WALL_GAP])
        self._upper = np.array([cell_bin.depth - WALL_GAP, cell_bin.y_range[1] - WALL_GAP])
        self._ceiling = cell_bin.ceiling_back
        self._is_bare = np.ones_like(self._height, dtype=bool)
        self._is_level = np.ones_like(self._height, dtype=bool)

    def _floor_height(self, x: Array) -> Array:
        b = self._bin
        return np.interp(x, [0.0, b.floor_flat_from], [b.floor_front, b.floor_back])

    @property
    def slope(self) -> float:
        """How far the front part of the floor is pitched, rad, positive down towards the back."""
        b = self._bin
        return float(np.arctan2(b.floor_front - b.floor_back, b.floor_flat_from))

    def find(self, item: Item, rng: np.random.Generator, tidiness: float) -> Spot | None:
        """The best of many random spots, or None if none fits.

        tidiness: 0 takes any spot on the floor, 1 the one closest to a corner, which leaves most room
        """
        choices = stances(item.shape)
        # Whoever must save room stands things up.
        weights = [(1.0 - tidiness) * weight + tidiness / len(choices) for _, weight in choices]
        best: tuple[float, Spot] | None = None
        for _ in range(N_CANDIDATES):
            stance = choices[int(rng.choice(len(choices), p=weights))][0]
            spot = self._try(stance, _yaw(rng, tidiness), _place(rng, tidiness))
            cost = self._cost(spot, tidiness, float(rng.random())) if spot else np.inf
            if spot and (best is None or cost < best[0]):
                best = cost, spot
        if best is None or (tidiness < TOSS_FROM and not best[1].is_supported):
            return None
        return best[1]

    def occupy(self, spot: Spot) -> None:
        """Note that an item lies there now."""
        self._height[spot.mask] = np.maximum(self._height[spot.mask], spot.bottom + spot.stance.height)
        self._is_level[spot.mask] = spot.stance.is_level
        self._is_bare[spot.mask] = False

    def _try(self, stance: Stance, yaw: float, where: Array) -> Spot | None:
        """The spot at a place (2,) in [0, 1] of the room that is left for the turned footprint."""
        half = np.array(stance.footprint) / 2
        c, s = np.cos(yaw), np.sin(yaw)
        reach = np.abs([[c, s], [s, c]]) @ half
        room = self._upper - self._lower - 2 * reach
        if np.any(room < 0.0):
            return None
        centre = self._lower + reach + where * room
        dx, dy = self._x[:, None] - centre[0], self._y[None, :] - centre[1]
        off = np.maximum(np.abs(c * dx + s * dy) - half[0], np.abs(c * dy - s * dx) - half[1])
        mask = off <= ITEM_GAP
        bottom = float(self._height[mask].max()) + DROP
        if bottom + stance.height > self._ceiling - CEILING_GAP:
            return None
        is_on_floor = bool(self._is_bare[mask].all())
        is_supported = is_on_floor or self._is_supported(off <= 0.0, centre, bottom - DROP)
        pitch = self.slope if is_on_floor and centre[0] + reach[0] < self._bin.floor_flat_from else 0.0
        R = rotation_rpy(0.0, pitch, 0.0) @ rotation_rpy(0.0, 0.0, yaw) @ stance.R_world_item
        # Pitched about its front edge's height, the item's centre lies lower by its share of the slope.
        z = bottom + stance.height / 2 - np.sin(pitch) * reach[0]
        return Spot(pose((centre[0], centre[1], z), R=R), stance, mask, bottom, is_on_floor, is_supported)

    def _is_supported(self, under: NDArray[np.bool_], centre: Array, top: float) -> bool:
        """Whether level tops carry enough of a footprint, on all sides of its centre."""
        carries = under & self._is_level & (self._height >= top - LEVEL)
        if carries.sum() < MIN_SUPPORT * under.sum():
            return False
        ix, iy = np.nonzero(carries)
        x, y = self._x[ix], self._y[iy]
        return bool(x.min() < centre[0] < x.max() and y.min() < centre[1] < y.max())

    def _cost(self, spot: Spot, tidiness: float, noise: float) -> float:
        """The floor first, then what lies low; corners as far as tidiness asks for them."""
        share = (spot.T_bin_item[:2, 3] - self._lower) / (self._upper - self._lower)
        from_corner = (1.0 - share[0]) + 0.5 - abs(share[1] - 0.5)
        tossed = 0.0 if spot.is_supported else TOSSED
        raised = 0.0 if spot.is_on_floor else 1.0 + 10.0 * (spot.bottom - self._bin.floor_back)
        return float(tossed + raised + tidiness * from_corner + (1.0 - tidiness) * noise)


def _yaw(rng: np.random.Generator, tidiness: float) -> float:
    """Mostly parallel to the walls, give or take; exactly so when there is no room to waste."""
    square = float(rng.integers(4)) * np.pi / 2
    if rng.random() < tidiness:
        return square
    if rng.random() < SQUARE_SHARE:
        return square + float(rng.normal(0.0, SQUARE_SPREAD))
    return float(rng.uniform(-np.pi, np.pi))


def _place(rng: np.random.Generator, tidiness: float) -> Array:
    """Anywhere (2,) in the room that is left; against its edges when there is no room to waste."""
    where = rng.random(2)
    return np.where(rng.random(2) < tidiness, np.round(where), where)
