"""Backing: a wall close behind an item, against which a cup from the side may press it.

An item that is pressed turns about the edge of its footing until its upper part meets the wall, and leans on
it. The wall has to be behind it higher than the cup presses, on either side of the press; else the item would
turn about the wall's edge.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.shapes import ShapeKind
from pickcli.cell.station import UNKNOWN
from pickcli.collision.stage_contacts import PickContacts
from pickcli.geometry import Array

MOST_LEAN = (
    0.06  # rad by which an item may lean: less than the lip of a cup follows, and friction holds its foot
)
N_HEIGHTS, N_COLUMNS = 5, 7  # lines along the press on which the wall is looked for
WITHIN = 0.98  # of the item's sides, that the outermost lines are from its middle
PARALLEL = 1e-12  # replaces components of 0 of a direction, to divide by them


def is_backed(contacts: PickContacts, edge: Array, way: Array, pressed_at: Array, lip: float) -> bool:
    """Whether a wall stops the target before it leans by more than ``MOST_LEAN``.

    Args:
        contacts: The scene, and the target in it.
        edge: (3,) m, point of the edge about which it would turn.
        way: (2,) level unit vector across that edge, outwards.
        pressed_at: (3,) m, where the axis of the cup meets the target.
        lip: m, radius of the cup's lip.

    Returns:
        True if a body of the cell is surely there. Neighbours may move, and unknown space may be empty.
    """
    scene, target = contacts.scene, contacts.target
    if target.item.shape.kind is not ShapeKind.BOX:
        return False
    T, half = target.T_world_item, target.item.shape.extents / 2
    ahead, across = np.array([*way, 0.0]), np.array([-way[1], way[0], 0.0])
    width, height = WITHIN * np.abs(across @ T[:3, :3]) @ half, WITHIN * np.abs(T[2, :3]) @ half
    columns = np.linspace(-width, width, N_COLUMNS)
    low = float(pressed_at[2] - T[2, 3]) + lip
    if low >= height:
        return False
    heights = np.linspace(low, height, N_HEIGHTS)
    starts = T[:3, 3] + columns[:, None, None] * across + heights[None, :, None] * (0.0, 0.0, 1.0)
    back = _through_box(T, half, starts, ahead)[1]  # where each line leaves the item
    own = scene.noise_of(target).bound(target.item)
    gaps = np.full(back.shape, np.inf)
    for carrier in scene.posed_carriers:
        if carrier.name == UNKNOWN:
            continue
        for body in carrier.bodies:
            if body.shape.kind is not ShapeKind.BOX:
                continue
            of_body = carrier.T_world_carrier @ body.T_parent_shape
            enters = _through_box(of_body, body.shape.extents / 2, starts, ahead)[0]
            off = own + carrier.uncertainty(body)
            gap = np.maximum(enters - back, 0.0) + off
            gaps = np.fmin(gaps, np.where(enters >= back - off, gap, np.inf))
    rise = starts[:, :, 2] - edge[2]
    with np.errstate(divide="ignore", invalid="ignore"):
        leans = np.where(rise > gaps, np.arcsin(np.minimum(gaps / rise, 1.0)), np.inf).min(axis=1)
    at = float((pressed_at - T[:3, 3]) @ across)
    sides = leans[columns <= at], leans[columns >= at]
    return all(len(side) and side.min() <= MOST_LEAN for side in sides)


def _through_box(T: Array, half: Array, starts: Array, along: Array) -> tuple[Array, Array]:
    """Return where rays from starts (..., 3) along a direction (3,) enter and leave a box, m, or NaN."""
    R = T[:3, :3]
    local, way = (starts - T[:3, 3]) @ R, along @ R
    way = np.where(np.abs(way) < PARALLEL, PARALLEL, way)
    ends = (np.array([[-1.0], [1.0]]) * half)[:, None, None] - local
    ends = ends / way
    enters, leaves = ends.min(axis=0).max(axis=-1), ends.max(axis=0).min(axis=-1)
    is_met = enters <= leaves
    return np.where(is_met, enters, np.nan), np.where(is_met, leaves, np.nan)
