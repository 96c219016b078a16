"""From where to look next into a place, or what to take out of it first: what is not known shall be in sight.

Where an item is hidden, two looks from the same side are no better than one; another side is. So what is
unknown, and what was measured and not recognised, is taken as what is to be seen, and what is recognised
hides it (next best view, Connolly 1985). What no look shows is behind what hides most of it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array, inverse, transform_points
from pickcli.perception.items.room_sight import coarse_view
from pickcli.perception.items.unknown_voxels import VOXEL
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene
from pickcli.perception.surface_view import SurfaceView
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


def hiding_items(viewpoints: Sequence[Viewpoint], believed: Scene, place: str) -> tuple[str, ...]:
    """Find the items of a place that hide what is not known in it.

    Args:
        viewpoints: From where it is looked into.
        believed: The scene as it is believed to be, with what is unknown in it.
        place: Name of the place.

    Returns:
        Their ids, first that which hides most from all the viewpoints together; of equals in their order.
    """
    wanted = unknown_points([space for space in believed.unknown if space.place == place])
    hidden: Counter[str] = Counter()
    for each in viewpoints:
        known, view = _view(each, believed)
        rows, columns, z, _ = _pixels(view, wanted)
        index = view.index[rows, columns][view.depth[rows, columns] < z - _SLACK]
        for i, n in enumerate(np.bincount(index, minlength=len(known.solids)).tolist()):
            if known.solids[i].kind is OwnerKind.ITEM:
                hidden[known.solids[i].owner] += n
    here = [placed.id for placed in believed.in_location(place)]
    return tuple(sorted((name for name in here if hidden[name]), key=lambda name: -hidden[name]))


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
    _, view = _view(viewpoint, believed)
    rows, columns, z, is_seen = _pixels(view, points)
    is_seen[is_seen] = ~(view.depth[rows, columns] < z - _SLACK)
    return is_seen


def _view(viewpoint: Viewpoint, believed: Scene) -> tuple[RenderedScene, SurfaceView]:
    """What is recognised as it is seen from a viewpoint."""
    at = viewpoint.at
    known = RenderedScene.of(replace(believed, held=None), at.q, at.tool_state)
    return known, coarse_view(viewpoint.camera.model.camera, viewpoint.T_world_camera, known)


def _pixels(
    view: SurfaceView, points: Array
) -> tuple[NDArray[np.intp], NDArray[np.intp], Array, NDArray[np.bool_]]:
    """Rows, columns and depths of those of the points (N, 3) that are in the picture, and which these are."""
    seen = transform_points(inverse(view.T_world_camera), points)
    is_in = seen[:, 2] > 0.0
    columns, rows = np.rint(view.camera.project(seen[is_in])).astype(np.intp).T
    is_within = (columns >= 0) & (columns < view.camera.width) & (rows >= 0) & (rows < view.camera.height)
    is_in[is_in] = is_within
    return rows[is_within], columns[is_within], seen[is_in, 2], is_in
