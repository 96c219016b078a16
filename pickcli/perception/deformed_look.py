"""What cloth, bags and plush look like: a rumpled surface inside of the box that stands for them.

Physics, planner and the models of perception have the box. A picture may show another surface: both large
faces sink towards the edges like those of a cushion, and are rumpled by random heights; the outline is drawn
in. No point is outside of the box, nor deeper in it than the item's file states.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.item import Item
from pickcli.geometry import Array
from pickcli.seeds import derived_rng

PATCH = 0.035  # m, about the length of a part of the surface that is flat
N_PATCHES = (2, 7)  # least and largest number along a side
# Shares of the stated depth: of a cushion at its edges, of random heights, by which the outline is drawn in,
# and by which its edges are rounded. As patches are flat, up to a quarter of the first and half of the second
# come on top.
CUSHION, RUMPLED, DRAWN_IN, EDGE = 0.45, 0.25, 0.5, 0.5
STEEPNESS = 3  # power of the distance from the middle with which a cushion sinks


def deformed_pieces(item: Item, *key: object) -> list[Array]:
    """Compute convex pieces that together look like an item.

    Args:
        item: The item, a box that deforms.
        *key: Seed of the random heights, and what else distinguishes the instance.

    Returns:
        Planes (P, 4) of each piece in the item frame, normal and offset, besides the faces of the box.
    """
    rng = derived_rng("deformed look", item.name, *key)
    half = item.shape.extents / 2
    order = np.argsort(-half, kind="stable")  # along u and v its large faces are, across them w
    u, v = (_knots(half[axis]) for axis in order[:2])
    upper, lower = (_heights(item, u, v, half[order[2]], rng) for _ in range(2))
    # How far each end of u is drawn in, at the knots of v, and each end of v at those of u.
    drawn_in = [item.deformation * DRAWN_IN * rng.random((2, len(knots))) for knots in (v, u)]
    pieces = []
    for i in range(len(u) - 1):
        for j in range(len(v) - 1):
            patch = (slice(i, i + 2), slice(j, j + 2))
            above = _face(u[patch[0]], v[patch[1]], upper[patch])
            below = _face(u[patch[0]], v[patch[1]], lower[patch]) * [1.0, 1.0, -1.0, 1.0]
            outline = [
                *_outline(u, i, v[patch[1]], drawn_in[0][:, patch[1]]),
                *(side[[1, 0, 2, 3]] for side in _outline(v, j, u[patch[0]], drawn_in[1][:, patch[0]])),
            ]
            edges = [
                _edge(side, face, EDGE * item.deformation) for side in outline for face in (above, below)
            ]
            bounds = [[1.0, 0.0, 0.0, u[i + 1]], [-1.0, 0.0, 0.0, -u[i]]]
            bounds += [[0.0, 1.0, 0.0, v[j + 1]], [0.0, -1.0, 0.0, -v[j]]]
            planes = np.array([above, below, *bounds, *outline, *edges])
            turned = np.zeros_like(planes)
            turned[:, order], turned[:, 3] = planes[:, :3], planes[:, 3]
            pieces.append(turned)
    return pieces


def _knots(half: float) -> Array:
    """Ends of the patches along a side, m."""
    n = int(np.clip(round(2 * half / PATCH), *N_PATCHES))
    return np.linspace(-half, half, n + 1)


def _heights(item: Item, u: Array, v: Array, half: float, rng: np.random.Generator) -> Array:
    """Heights (U, V) in m of a large face above the middle of the item, at the corners of patches."""
    from_middle = np.maximum(np.abs(u / u[-1])[:, None], np.abs(v / v[-1])[None, :])
    sunk = CUSHION * from_middle**STEEPNESS + RUMPLED * rng.random((len(u), len(v)))
    return np.asarray(half - item.deformation * sunk)


def _face(u: Array, v: Array, heights: Array) -> Array:
    """Plane (4,) of a patch, by least squares through its corners, (2, 2) m."""
    slope_u = (heights[1].mean() - heights[0].mean()) / (u[1] - u[0])
    slope_v = (heights[:, 1].mean() - heights[:, 0].mean()) / (v[1] - v[0])
    offset = heights.mean() - slope_u * u.mean() - slope_v * v.mean()
    return _plane(np.array([-slope_u, -slope_v, 1.0]), offset)


def _outline(knots: Array, i: int, across: Array, drawn_in: Array) -> list[Array]:
    """Planes (4,) of those ends of a patch along one direction that are at the outline.

    drawn_in: (2, 2) m at both ends of the item, at both ends ``across`` of the patch.
    """
    planes = []
    for sign, is_outline, (first, last) in (
        (-1.0, i == 0, drawn_in[0]),
        (1.0, i + 2 == len(knots), drawn_in[1]),
    ):
        if is_outline:
            slope = (last - first) / (across[1] - across[0])
            planes.append(_plane(np.array([sign, slope, 0.0]), knots[-1] - first + slope * across[0]))
    return planes


def _edge(side: Array, face: Array, depth: float) -> Array:
    """Plane (4,) that rounds the edge between a side and a face, so many m inside of both together."""
    return _plane(side[:3] + face[:3], side[3] + face[3] - depth)


def _plane(normal: Array, offset: float) -> Array:
    """A plane (4,) with a normal of length 1."""
    return np.asarray(np.array([*normal, offset]) / np.linalg.norm(normal))
