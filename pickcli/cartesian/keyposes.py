"""The key waypoints of a pick: where the four segments start and end.

Sources: Delft, section 2.1 (Approach, Contact, Lift, Retreat); KTH, Fig. 5 (the pre-approach runs along
the reverted x axis of the bin frame).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cartesian.line import shifted
from pickcli.cell.shapes import Shape
from pickcli.cell.station import Bin
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse

PREAPPROACH_DISTANCE = 0.06  # m between the tip and the mouth plane where the coarse motion ends
CONTACT_DISTANCE = 0.012  # m of slow motion before the cup can meet the item
RETREAT_DISTANCE = 0.02  # m from the mouth to the nearest point of the held item at the end
LIP_DISTANCE = 0.014  # m between the held item and lip or hanging lip while it passes, where there is room
LEAST_LIP_DISTANCE = 0.006


@dataclass(frozen=True, eq=False)
class PickPoses:
    """Tool poses (4, 4) in the world, in the order in which they are passed."""

    preapproach: Array
    approach: Array
    touch: Array  # where the slow contact move begins
    contact: Array  # cup pressed on by the overtravel


@dataclass(frozen=True, eq=False)
class LiftPoses:
    """Tool poses (4, 4) in the world while the item is taken out."""

    freed: Array  # end of the first stretch, in which item and support may touch
    lift: Array
    retreat: Array


def pick_poses(
    T_world_bin: Array, T_world_item: Array, T_item_tip: Array, offset: float, overtravel: float
) -> PickPoses:
    """Poses up to contact.

    offset: m of approach along the tool axis. overtravel: m by which the cup is pressed beyond the
    surface, so that it meets an item that is farther away than its pose says.
    """
    surface = T_world_item @ T_item_tip
    axis = surface[:3, 2]
    approach = shifted(surface, -offset * axis)
    x_bin = T_world_bin[:3, 0]
    depth = float((approach[:3, 3] - T_world_bin[:3, 3]) @ x_bin)
    preapproach = shifted(approach, -max(0.0, depth + PREAPPROACH_DISTANCE) * x_bin)
    touch = shifted(surface, -min(offset, overtravel + CONTACT_DISTANCE) * axis)
    return PickPoses(preapproach, approach, touch, shifted(surface, overtravel * axis))


def lift_options(
    cell_bin: Bin, T_world_bin: Array, T_world_item: Array, shape: Shape, contact: Array, first: float
) -> tuple[LiftPoses, ...] | Reason:
    """Ways to take the item over the lip and out, the gentlest first.

    shape: of the held item, already grown by its uncertainty. contact: tool pose at contact. first: length in m of the stretch in which touching is allowed; sideways moves, away from
    walls and neighbours, happen inside it.
    """
    low, high = _bounds(inverse(T_world_bin) @ T_world_item, shape)
    spare = np.array([cell_bin.mouth_width, cell_bin.mouth_height]) - (high - low)[1:]
    if spare.min() < 2 * LEAST_LIP_DISTANCE:
        size = " x ".join(f"{e * 1e3:.0f}" for e in (high - low)[1:])
        mouth = f"{cell_bin.mouth_width * 1e3:.0f} x {cell_bin.mouth_height * 1e3:.0f}"
        return Reason("does not fit through the mouth", "lift", f"{size} mm wide and tall, mouth {mouth} mm")
    side, above = np.minimum(LIP_DISTANCE, spare / 2)
    need = above - low[2]
    most = cell_bin.mouth_height - above - high[2]
    half = cell_bin.mouth_width / 2 - side
    least = float(np.clip(0.0, -half - low[1], half - high[1]))
    R = T_world_bin[:3, :3]
    options = []
    for dz in _heights(max(need, 0.02), most):
        for dx, dy in _shifts(least, first, low, high, half):
            freed = shifted(contact, R @ _first_stretch(dx, dy, dz, first))
            lift = shifted(contact, R @ np.array([dx, dy, dz]))
            out = high[0] + dx + RETREAT_DISTANCE
            options.append(LiftPoses(freed, lift, shifted(lift, -max(0.0, out) * R[:, 0])))
    return tuple(options)


def _first_stretch(dx: float, dy: float, dz: float, first: float) -> Array:
    """The part of the lift in which touching is allowed, no longer than ``first``: up and aside at once."""
    aside = float(np.hypot(dx, dy))
    part = min(aside, 0.6 * first)
    share = part / aside if aside > 0.0 else 0.0
    return np.array([share * dx, share * dy, min(dz, float(np.sqrt(first**2 - part**2)))])


def _heights(need: float, most: float) -> list[float]:
    """Lift heights to try: over the lip, half-way, as high as the mouth allows."""
    heights = [need, (need + most) / 2, most]
    return [h for i, h in enumerate(heights) if i == 0 or h > heights[i - 1] + 0.01]


def _shifts(least: float, first: float, low: Array, high: Array, half: float) -> list[tuple[float, float]]:
    """Moves (dx, dy) during the lift: none beyond what the mouth needs, else away from what is near."""
    away = min(0.02, 0.6 * first)
    moves = [(0.0, least), (-away, least), (0.0, least + away), (0.0, least - away)]
    moves += [(-away, least + away), (-away, least - away)]
    ok = [(dx, dy) for dx, dy in moves if -half - 1e-9 <= low[1] + dy and high[1] + dy <= half + 1e-9]
    return ok or [(0.0, least)]


def _bounds(T: Array, shape: Shape) -> tuple[Array, Array]:
    """Bounds (3,), (3,) of a shape posed by T."""
    reach = shape.reach(T[:3, :3])
    return T[:3, 3] - reach, T[:3, 3] + reach
