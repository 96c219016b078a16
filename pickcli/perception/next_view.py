"""From where to look next into a place: from where most is in sight of what is not known there.

Where an item is hidden, two looks from the same side are no better than one; another side is. So what is
unknown, and what was measured and not recognised, is taken as what is to be seen, and what is recognised
hides it (next best view, Connolly 1985).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array, inverse, transform_points
from pickcli.perception.items.room_sight import coarse_view
from pickcli.perception.items.unknown_voxels import VOXEL
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.perception.viewpoints import Viewpoint
from pickcli.scene.scene import Scene
from pickcli.scene.unknown_space import UnknownSpace

_SLACK = 0.005  # m by which a surface may be before a point that is on it


def next_views(viewpoints: Sequence[Viewpoint], believed: Scene, place: str, n: int) -> tuple[Viewpoint, ...]:
    """Choose from where to look next into a place.

    Args:
        viewpoints: From where it can be looked into.
        believed: The scene as it is believed to be, with what is unknown in it.
        place: Name of the place.
        n: Number of looks.

    Returns:
        So many viewpoints, or all: first the one from which most is seen of what is not known, then each time
        the one from which most is seen of the rest. Of equals the first in the list.
    """
    wanted = unknown_points([space for space in believed.unknown if space.place == place])
    in_sight = [_in_sight(each, believed, wanted) for each in viewpoints]
    left, rest = np.ones(len(wanted), dtype=bool), list(range(len(viewpoints)))
    chosen: list[Viewpoint] = []
    while rest and len(chosen) < n:
        best = max(rest, key=lambda i: int((in_sight[i] & left).sum()))
        rest.remove(best)
        chosen.append(viewpoints[best])
        left &= ~in_sight[best]
    return tuple(chosen)


def unknown_points(spaces: Sequence[UnknownSpace]) -> Array:
    """Spread points over what is not known.

    Args:
        spaces: The unknown space, with what is unrecognised in it.

    Returns:
        (N, 3) m in the world, the middles of equal parts of its boxes, a voxel wide at most.
    """
    points = [np.zeros((0, 3))]
    for space in spaces:
        for low, high in np.concatenate([space.boxes, space.unrecognised]).reshape(-1, 2, 3):
            counts = np.maximum(np.ceil((high - low) / VOXEL - 1e-6).astype(int), 1)
            shares = [(np.arange(n) + 0.5) / n for n in counts]
            grid = np.stack(np.meshgrid(*shares, indexing="ij"), axis=-1).reshape(-1, 3)
            points.append(transform_points(space.T_world_place, low + grid * (high - low)))
    return np.concatenate(points)


def _in_sight(viewpoint: Viewpoint, believed: Scene, points: Array) -> NDArray[np.bool_]:
    """Which points (N, 3) are in the picture, and before all that is recognised."""
    at = viewpoint.at
    known = RenderedScene.of(replace(believed, held=None), at.q, at.tool_state)
    view = coarse_view(viewpoint.camera.model.camera, viewpoint.T_world_camera, known)
    seen = transform_points(inverse(view.T_world_camera), points)
    is_seen = seen[:, 2] > 0.0
    columns, rows = np.rint(view.camera.project(seen[is_seen])).astype(int).T
    is_inside = (columns >= 0) & (columns < view.camera.width) & (rows >= 0) & (rows < view.camera.height)
    is_seen[is_seen] = is_inside
    depth = view.depth[rows[is_inside], columns[is_inside]]
    is_seen[is_seen] = ~(depth < seen[is_seen, 2] - _SLACK)
    return is_seen
