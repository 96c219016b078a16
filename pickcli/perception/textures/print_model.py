"""Models of prints: SIFT features of renderings of an item alone, with their points on its surface.

The renderings are taken from 46 directions all around, as KTH did (paper 000, III-B), in even light. That
takes one to three seconds, so models are kept in the user's cache, each in a file that says what it was made
from.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion

from pickcli.cell.item import Item
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.files.derived_cache import content_key, derived_arrays
from pickcli.geometry import Array, inverse, pose, transform_points
from pickcli.jobs.job import code_digest
from pickcli.perception.looks import LightingModel, colour_picture, coloured
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene, RenderedSolid
from pickcli.perception.surface_view import FloatPicture, SurfaceView
from pickcli.perception.textures.opencv import cv2
from pickcli.perception.textures.print_features import print_features, products

N_VIEWS = 46
STUDIO = LightingModel(ambient=0.8, headlight=0.3, lamp=0.0, background=(128, 128, 128))
_PIXELS_PER_M = 1400.0  # of the item's middle
_DISTANCE = 0.6  # m from the camera to the middle of the item
_N_DIRECTIONS = 32  # of 128, by which features are compared at first
_MARGIN = 8  # px around the item
_FROM_EDGE = 3  # px that features keep from its outline, beyond which another background is


@dataclass(frozen=True, eq=False)
class PrintModel:
    """What is printed on an item.

    Attributes:
        item: The item.
        points: (N, 3) m on its surface, in its frame.
        frames: (N, 3, 3) of what is printed there: the directions of the feature and across it, along the
            surface, and inwards; in its frame.
        lengths: (N,) m, diameters of what is described around them, as seen; ascending.
        views: (N,) index of the view that each feature was found in.
        descriptors: (N, 128) float32 of length 1.
        directions: (D, 128) float32 along which they differ most, of length 1.
        projected: (N, D) float32, the descriptors along these.
    """

    item: Item
    points: Array
    frames: Array
    lengths: Array
    views: NDArray[np.intp]
    descriptors: FloatPicture
    directions: FloatPicture
    projected: FloatPicture

    def __len__(self) -> int:
        return len(self.points)


@lru_cache(maxsize=40)
def print_model(item: Item, texture_seed: int) -> PrintModel:
    """Return the model of what is printed on an item, from the cache, or make and keep it.

    Args:
        item: The item, whose shape is a box, cylinder or sphere.
        texture_seed: Seed of the set of prints.

    Returns:
        The model.
    """
    name = content_key(item.name, str(item.year), str(texture_seed))  # names of items may be no file names
    found = derived_arrays(
        "prints", name, made_from(item, texture_seed), lambda: known_features(item, texture_seed)
    )
    directions = _directions(found["descriptors"])
    return PrintModel(
        item, found["points"], found["frames"], found["lengths"], found["views"], found["descriptors"],
        directions, products(found["descriptors"], directions),
    )  # fmt: skip


def made_from(item: Item, texture_seed: int) -> dict[str, Any]:
    """List all that a model depends on.

    Args:
        item: The item.
        texture_seed: Seed of the set of prints.

    Returns:
        JSON values by name: what the item looks like, the seed, and digests of this program's code and the
        version of the library that finds features.
    """
    return {
        "item": item.name,
        "shape": [item.shape.kind.value, item.shape.extents.tolist()],
        "colour": list(coloured(item).colour or ()),
        "material": item.material.value,
        "is_printed": item.is_printed,
        "texture_seed": texture_seed,
        "opencv": cv2.__version__,
        "code": code_digest(),
    }


def known_features(item: Item, texture_seed: int) -> dict[str, NDArray[Any]]:
    """Find the features of an item in renderings.

    Args:
        item: The item, whose shape is a box, cylinder or sphere.
        texture_seed: Seed of the set of prints.

    Returns:
        ``points``, ``frames``, ``lengths``, ``views`` and ``descriptors`` as of a ``PrintModel``.
    """
    solid = RenderedSolid(OwnerKind.ITEM, item.name, item.shape, pose(), item)
    rendered = RenderedScene((solid,))
    points, frames, lengths, views, descriptors = [], [], [], [], []
    for k, T_item_camera in enumerate(view_poses()):
        camera = _camera(item, T_item_camera)
        view = rendered.seen_by(camera, T_item_camera)
        colour = colour_picture(rendered, camera, T_item_camera, texture_seed, STUDIO)
        found = print_features(colour, binary_erosion(view.index >= 0, iterations=_FROM_EDGE))
        at, normals = surface_points(view, found.pixels)
        points.append(transform_points(T_item_camera, at))
        frames.append(T_item_camera[:3, :3] @ surface_frames(at, normals, found.angles))
        lengths.append(found.sizes * at[:, 2] / camera.fx)
        views.append(np.full(len(found), k))
        descriptors.append(found.descriptors)
    every = np.concatenate(lengths)
    order = np.argsort(every, kind="stable")
    return {
        "points": np.concatenate(points)[order],
        "frames": np.concatenate(frames)[order],
        "lengths": every[order],
        "views": np.concatenate(views)[order],
        "descriptors": np.concatenate(descriptors)[order],
    }


def _directions(descriptors: FloatPicture) -> FloatPicture:
    """(D, 128) eigenvectors of the second moments of descriptors with the largest eigenvalues."""
    moments = cv2.gemm(descriptors, descriptors, 1.0, None, 0.0, flags=cv2.GEMM_1_T)
    _, _, directions = cv2.eigen(moments)
    return np.ascontiguousarray(directions[:_N_DIRECTIONS])


def view_poses() -> Array:
    """Spread the views around an item.

    Returns:
        (46, 4, 4) poses of the camera in the item's frame; it looks at the middle from directions on a
        Fibonacci lattice of the sphere.
    """
    k = np.arange(N_VIEWS)
    z, turn = 1.0 - (2.0 * k + 1.0) / N_VIEWS, k * np.pi * (3.0 - np.sqrt(5.0))
    out = np.stack([np.sqrt(1.0 - z**2) * np.cos(turn), np.sqrt(1.0 - z**2) * np.sin(turn), z], axis=1)
    right = np.cross(-out, [0.0, 0.0, -1.0])
    right /= -np.linalg.norm(right, axis=1, keepdims=True)
    T = np.broadcast_to(np.eye(4), (N_VIEWS, 4, 4)).copy()
    T[:, :3, 0], T[:, :3, 1], T[:, :3, 2] = right, np.cross(-out, right), -out
    T[:, :3, 3] = _DISTANCE * out
    return T


def surface_points(view: SurfaceView, pixels: Array) -> tuple[Array, Array]:
    """Compute what is seen in places between the middles of pixels.

    Args:
        view: A view.
        pixels: (N, 2) column and row, px, in which something is seen.

    Returns:
        (N, 3) m in the camera's frame, on the plane that touches the surface in the nearest pixel's middle;
        and (N, 3) its normals.
    """
    camera = view.camera
    columns, rows = np.rint(pixels).astype(int).T
    middle = np.array([camera.cx, camera.cy])
    focal = np.array([camera.fx, camera.fy])
    near, exact = (
        np.column_stack([(at - middle) / focal, np.ones(len(at))]) for at in (np.rint(pixels), pixels)
    )
    normals = view.normals[rows, columns].astype(np.float64)
    depth = view.depth[rows, columns].astype(np.float64)
    scale = depth * (near * normals).sum(axis=1) / (exact * normals).sum(axis=1)
    return np.asarray(exact * scale[:, None]), normals


def surface_frames(points: Array, normals: Array, angles: Array) -> Array:
    """Compute directions along surfaces from directions in a picture.

    Args:
        points: (N, 3) m in the camera's frame, on the surfaces.
        normals: (N, 3) towards the camera.
        angles: (N,) rad in the picture.

    Returns:
        (N, 3, 3) rotations in the camera's frame: along the direction, across it, and inwards.
    """
    rays = points / points[:, 2:]
    step = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
    # Of the ray beside, that meets the plane through the point: the direction from there to here.
    slope = -(step * normals).sum(axis=1) / (rays * normals).sum(axis=1)
    along = step + slope[:, None] * rays
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return np.stack([along, np.cross(-normals, along), -normals], axis=2)


def _camera(item: Item, T_item_camera: Array) -> PinholeCamera:
    """Intrinsics by which the item fills the picture."""
    f = _PIXELS_PER_M * _DISTANCE
    corners = np.array(list(product((-0.5, 0.5), repeat=3))) * item.shape.extents
    seen = transform_points(inverse(T_item_camera), corners)
    pixels = f * seen[:, :2] / seen[:, 2:]
    low, high = np.floor(pixels.min(axis=0)) - _MARGIN, np.ceil(pixels.max(axis=0)) + _MARGIN
    width, height = (high - low).astype(int).tolist()
    return PinholeCamera(f, f, -float(low[0]), -float(low[1]), width, height)
