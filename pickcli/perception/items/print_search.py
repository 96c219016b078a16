"""Where items are by what is printed on them: candidates for the decision about all items of a place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.geometry import Array
from pickcli.perception.items.place_view import PlaceView
from pickcli.perception.items.rgbd_picture import RgbdPicture
from pickcli.perception.textures.joint_pose import PrintSighting
from pickcli.perception.textures.print_features import NO_FEATURES, PrintFeatures, print_features
from pickcli.perception.textures.print_matching import matches_of
from pickcli.perception.textures.print_model import print_model
from pickcli.perception.textures.print_pose import PictureFeatures, print_poses
from pickcli.perception.textures.sift_views import SiftViews

_BEFORE = 0.003  # m before what is known: something of an item
_PIXELS_PER_M = 1400.0  # of what is looked at, at most
_AROUND = 2  # px around a feature, whose depth stands for it
_MORE = 1  # poses of an item beyond the number of its copies


def prints_in(
    rgbd: RgbdPicture,
    view: PlaceView,
    items: Sequence[Item],
    views: Mapping[Item, SiftViews],
    texture_seed: int,
) -> dict[Item, tuple[PrintSighting, ...]]:
    """Find printed items in the picture of a place.

    Args:
        rgbd: The picture.
        view: What it shows of the place.
        items: The listed items, copies too.
        views: Which views of a model are compared with at once, by item; prints of others are not looked for.
        texture_seed: Seed of the set of prints that models are made from.

    Returns:
        Where each was recognised, by item, those with most matches first; without items that were not.
    """
    if not views:
        return {}
    seen = picture_features(rgbd, view)
    depth = np.where(np.isfinite(seen.depth), seen.depth, np.nanmedian(view.known.depth))
    lengths = seen.features.sizes * depth / seen.camera.fx
    found = {}
    for item in dict.fromkeys(items):
        if item not in views:
            continue
        model = print_model(item, texture_seed)
        matched = matches_of(seen.features, lengths, model, views[item])
        poses = print_poses(seen, model, matched, items.count(item) + _MORE)
        if poses:
            found[item] = tuple(each.sighting for each in poses)
    return found


def picture_features(rgbd: RgbdPicture, view: PlaceView) -> PictureFeatures:
    """Find features of what is in a place.

    Args:
        rgbd: The picture.
        view: What it shows of the place.

    Returns:
        The features where something was measured before what is known, or nothing was measured.
    """
    full, blocks = rgbd.sensor.camera, view.camera
    size = round(full.fx / blocks.fx)
    u0, v0 = (
        round(of_full - size * of_blocks - (size - 1) / 2)
        for of_full, of_blocks in ((full.cx, blocks.cx), (full.cy, blocks.cy))
    )
    rows, columns = slice(v0, v0 + size * blocks.height), slice(u0, u0 + size * blocks.width)
    known = view.known.depth.repeat(size, axis=0).repeat(size, axis=1)
    depth = rgbd.depth[rows, columns]
    with np.errstate(invalid="ignore"):
        mask = np.isfinite(known) & ~(depth > known - _BEFORE)
    rows_in, columns_in = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    if not len(rows_in):
        return PictureFeatures(full, NO_FEATURES, np.zeros((0, 3)), np.zeros((0, 3)))
    inside = slice(rows_in[0], rows_in[-1] + 1), slice(columns_in[0], columns_in[-1] + 1)
    colour, corner = rgbd.colour[rows, columns][inside], np.array([columns_in[0], rows_in[0]])
    share = min(1.0, _PIXELS_PER_M * float(np.nanmedian(view.known.depth)) / full.fx)
    found = print_features(colour, mask[inside], share)
    of_blocks = (found.pixels + corner - (size - 1) / 2) / size
    pixels = found.pixels + corner + [u0, v0]
    features = PrintFeatures(pixels, found.sizes, found.angles, found.descriptors)
    rays = np.column_stack([(pixels - [full.cx, full.cy]) / [full.fx, full.fy], np.ones(len(pixels))])
    points = rays * _depth_at(depth, found.pixels + corner)[:, None]
    return PictureFeatures(full, features, points, _normals_at(view, of_blocks))


def _normals_at(view: PlaceView, pixels: Array) -> Array:
    """(N, 3) normals in the camera's frame of what was measured in the nearest pixels of a view."""
    height, width = view.depth.shape
    columns, rows = np.rint(pixels).astype(int).T
    normals = view.normals[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
    return np.asarray(normals @ view.T_camera_place[:3, :3].T)


def _depth_at(depth: NDArray[np.float32], pixels: Array) -> Array:
    """(N,) medians of what was measured around pixels."""
    around = np.arange(-_AROUND, _AROUND + 1)
    columns, rows = np.rint(pixels).astype(int).T
    rows = np.clip(rows[:, None] + around, 0, depth.shape[0] - 1)
    columns = np.clip(columns[:, None] + around, 0, depth.shape[1] - 1)
    near = np.sort(depth[rows[:, :, None], columns[:, None, :]].reshape(len(pixels), -1), axis=1)  # NaN last
    counts = np.isfinite(near).sum(axis=1)
    return np.asarray(near[np.arange(len(near)), np.maximum(counts - 1, 0) // 2], dtype=np.float64)
