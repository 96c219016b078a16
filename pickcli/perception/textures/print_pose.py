"""Poses of an item from matches of its print: PnP by RANSAC, both planar solutions, Levenberg-Marquardt.

As KTH did (paper 000, III-B). A number of matches is no proof: on one flat face there are two poses that
show nearly the same, and prints repeat themselves. So matches have to be spread, and the depth that was
measured at them has to agree.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array, pose, transform_points
from pickcli.perception.textures.joint_pose import PrintSighting
from pickcli.perception.textures.opencv import cv2
from pickcli.perception.textures.print_features import PrintFeatures
from pickcli.perception.textures.print_matching import Matches, joined
from pickcli.perception.textures.print_model import PrintModel, surface_frames, view_poses

LEAST_MATCHES = 8
_LEAST_SPREAD = np.array([0.008, 0.0008])  # m, standard deviations of the matched points along two directions
_LEAST_AGREEING = 0.6  # of the matches with depth
_WITHOUT_DEPTH, _MOSTLY = 12, 0.5  # matches that are enough where no more than such a share has any
_OFF = 0.0016  # of the depth, across the ray, by which a match may be off
_LEAST_OFF = 1.5  # px
_OFF_IN_DEPTH = 0.006  # m
_FLAT = 0.002  # m, standard deviation across the plane of matched points
_N_ITERATIONS, _SURE = 60, 0.999
_LEAST_OF_SAMPLE = 6  # matches that are solved for
_SEED = 1
_ROUGHLY = 0.015  # m by which matches may be off a pose that one of them states
_N_GATHERED = 3  # poses by one match that are followed
_N_SETS = 4  # views of a model that are tried, the most alike first


@dataclass(frozen=True, eq=False)
class PictureFeatures:
    """The features of a picture, and where they are.

    Attributes:
        camera: Intrinsics of the picture.
        features: The features.
        points: (N, 3) m measured at each, in the camera's frame; NaN where none was.
        normals: (N, 3) of the surface there, towards the camera; NaN where they are not known.
    """

    camera: PinholeCamera
    features: PrintFeatures
    points: Array
    normals: Array

    @property
    def depth(self) -> Array:
        """(N,) m measured at each, NaN where none was."""
        return np.asarray(self.points[:, 2])


@dataclass(frozen=True, eq=False)
class PrintPose:
    """A pose of an item by its print.

    Attributes:
        sighting: The pose, and the matches that agree with it.
        spread: m, standard deviation of their points along the second direction.
        agreeing: Share of the matches with depth whose depth agrees.
    """

    sighting: PrintSighting
    spread: float
    agreeing: float

    @property
    def T_camera_item(self) -> Array:
        """(4, 4) in the camera's frame."""
        return self.sighting.T_camera_item

    @property
    def n_matches(self) -> int:
        """Number of matches that agree with it."""
        return len(self.sighting.points)


def print_poses(
    seen: PictureFeatures, model: PrintModel, matched: Sequence[Matches], most: int
) -> tuple[PrintPose, ...]:
    """Find where an item and its copies are by their print.

    Args:
        seen: The features of the picture.
        model: The model.
        matched: Matches by set of views.
        most: Number of poses at most.

    Returns:
        The poses that spread and depth allow, each by matches of its own, those with most matches first.
    """
    left, found = list(matched), []
    for _ in range(most):
        best = max(_poses_by_set(seen, model, left), key=lambda each: each[0].n_matches, default=None)
        if best is None:
            break
        found.append(best[0])
        left = [each.only(~np.isin(each.seen, best[1])) for each in left]
    return tuple(sorted(found, key=lambda each: -each.n_matches))


def _poses_by_set(
    seen: PictureFeatures, model: PrintModel, matched: Sequence[Matches]
) -> Iterator[tuple[PrintPose, NDArray[np.intp]]]:
    """Of the sets with most matches poses, and the features of the picture that agree with each."""
    every = joined(matched)
    for each in sorted(matched, key=lambda m: -len(m))[:_N_SETS]:
        if len(each) < LEAST_MATCHES:
            return
        for near in _gathered(seen, model, each):
            T = _pose_of(seen, model, near, each)
            if T is not None and len(each) < len(every):
                T = _settled(seen, model, every, T)
            judged = None if T is None else _judged(seen, model, every, T)
            if judged is not None:
                yield judged


def _gathered(seen: PictureFeatures, model: PrintModel, matches: Matches) -> Iterator[Matches]:
    """Matches that agree roughly with the pose that one of them states by itself.

    It does by its point, the normal of the surface there and its direction.
    """
    T = _poses_by_one(seen, model, matches)
    n = len(T)
    if n < 1:
        return
    points, measured = model.points[matches.known], seen.points[matches.seen]
    pixels = seen.features.pixels[matches.seen]
    at = points @ T[:, :3, :3].swapaxes(1, 2) + T[:, None, :3, 3]
    with np.errstate(invalid="ignore", divide="ignore"):
        off = np.linalg.norm(seen.camera.project(at) - pixels, axis=2) / seen.camera.fx * at[..., 2]
        is_near = (off < _ROUGHLY) & ~(np.abs(at[..., 2] - measured[:, 2]) > _ROUGHLY) & (at[..., 2] > 0.0)
    left = np.ones(len(matches), dtype=bool)
    for _ in range(_N_GATHERED):
        counts = (is_near & left).sum(axis=1)
        best = int(counts.argmax())
        if counts[best] < LEAST_MATCHES:
            return
        near = is_near[best] & left
        yield matches.only(near)
        left &= ~near


def _poses_by_one(seen: PictureFeatures, model: PrintModel, matches: Matches) -> Array:
    """(K, 4, 4) poses by single matches.

    Where no normal of the surface is known, it is taken to be seen as in the view of the model; where no
    depth was measured, the size of the feature tells it.
    """
    points, normals = seen.points[matches.seen], seen.normals[matches.seen]
    pixels, angles = seen.features.pixels[matches.seen], seen.features.angles[matches.seen]
    camera = seen.camera
    rays = np.column_stack([(pixels - [camera.cx, camera.cy]) / [camera.fx, camera.fy], np.ones(len(pixels))])
    depth = model.lengths[matches.known] * camera.fx / seen.features.sizes[matches.seen]
    points = np.where(np.isfinite(points), points, rays * depth[:, None])
    frames = _frames_as_in_view(model, matches, rays, angles)
    is_known = np.isfinite(normals).all(axis=1)
    frames[is_known] = surface_frames(points[is_known], normals[is_known], angles[is_known])
    T = np.broadcast_to(np.eye(4), (len(matches), 4, 4)).copy()
    T[:, :3, :3] = frames @ model.frames[matches.known].swapaxes(1, 2)
    T[:, :3, 3] = points - np.einsum("nij,nj->ni", T[:, :3, :3], model.points[matches.known])
    return T


def _frames_as_in_view(model: PrintModel, matches: Matches, rays: Array, angles: Array) -> Array:
    """(M, 3, 3) frames of features in the camera's frame, as aslant to the rays as in the model's views."""
    T_camera_item = np.linalg.inv(view_poses())[model.views[matches.known]]
    known = T_camera_item[:, :3, :3] @ model.frames[matches.known]
    at = np.einsum("nij,nj->ni", T_camera_item[:, :3, :3], model.points[matches.known])
    along = _from_axis(at + T_camera_item[:, :3, 3]).swapaxes(1, 2) @ known
    turns = angles - np.arctan2(along[:, 1, 0], along[:, 0, 0])
    c, s, o = np.cos(turns), np.sin(turns), np.zeros(len(turns))
    about = np.stack([np.stack([c, -s, o]), np.stack([s, c, o]), np.stack([o, o, o + 1.0])]).transpose(
        2, 0, 1
    )
    return np.asarray(_from_axis(rays) @ about @ along)


def _from_axis(rays: Array) -> Array:
    """(N, 3, 3) least rotations from the optical axis to rays (N, 3) before the camera."""
    x, y, z = (rays / np.linalg.norm(rays, axis=1, keepdims=True)).T
    k = 1.0 / (1.0 + z)
    rows = [[1.0 - k * x * x, -k * x * y, x], [-k * x * y, 1.0 - k * y * y, y], [-x, -y, z]]
    return np.stack([np.stack(row) for row in rows]).transpose(2, 0, 1)


def _pose_of(seen: PictureFeatures, model: PrintModel, near: Matches, matches: Matches) -> Array | None:
    """The pose (4, 4) that most of some matches, and then most of all matches of their set agree with."""
    points, pixels = model.points[near.known], seen.features.pixels[near.seen]
    K = seen.camera.K
    cv2.setRNGSeed(_SEED)
    is_found, turn, shift, inliers = cv2.solvePnPRansac(
        points, pixels, K, None, iterationsCount=_N_ITERATIONS, reprojectionError=_off(seen),
        confidence=_SURE, flags=cv2.SOLVEPNP_AP3P,
    )  # fmt: skip
    if not is_found or inliers is None or len(inliers) < _LEAST_OF_SAMPLE:
        return None
    best = _pose(turn, shift)
    starts = [best, *_aligned(points, seen.points[near.seen])]
    return _settled(seen, model, matches, _best(seen, model, matches, starts))


def _settled(seen: PictureFeatures, model: PrintModel, matches: Matches, T: Array) -> Array | None:
    """A pose (4, 4) solved again, twice, by the matches that agree with it; None if these are too few."""
    points, pixels = model.points[matches.known], seen.features.pixels[matches.seen]
    measured = seen.points[matches.seen]
    for _ in range(2):
        kept = _agree(seen, model, matches, T)
        if kept.sum() < _LEAST_OF_SAMPLE:
            return None
        solved = _solutions(points[kept], pixels[kept], seen.camera.K, T)
        T = _best(seen, model, matches, [T, *solved, *_aligned(points[kept], measured[kept])])
    return T


def _best(seen: PictureFeatures, model: PrintModel, matches: Matches, poses: Sequence[Array]) -> Array:
    """The first of the poses (4, 4) that most matches agree with."""
    return max(poses, key=lambda T: int(_agree(seen, model, matches, T).sum()))


def _solutions(points: Array, pixels: Array, K: Array, T: Array) -> list[Array]:
    """Poses (4, 4) by all matches: from one, and both that a flat face allows."""
    starts = [T]
    middle = points.mean(axis=0)
    _, sizes, axes = np.linalg.svd(points - middle, full_matrices=False)
    if sizes[2] / np.sqrt(len(points)) < _FLAT:
        axes = axes * np.linalg.det(axes)
        flat = np.ascontiguousarray((points - middle) @ axes.T)
        flat[:, 2] = 0.0
        _, turns, shifts, _ = cv2.solvePnPGeneric(flat, pixels, K, None, flags=cv2.SOLVEPNP_IPPE)
        T_flat_item = pose(-axes @ middle, R=axes)
        starts += [_pose(*each) @ T_flat_item for each in zip(turns, shifts, strict=True)]
    refined = []
    for start in starts:
        turn, _ = cv2.Rodrigues(start[:3, :3])
        turn, shift = cv2.solvePnPRefineLM(points, pixels, K, None, turn, start[:3, 3:].copy())
        refined.append(_pose(turn, shift))
    return refined


def _aligned(points: Array, measured: Array) -> list[Array]:
    """The pose (4, 4) that brings points nearest to what was measured, if enough was (Kabsch 1976)."""
    is_measured = np.isfinite(measured).all(axis=1)
    if is_measured.sum() < _LEAST_OF_SAMPLE:
        return []
    own, there = points[is_measured], measured[is_measured]
    U, _, Vt = np.linalg.svd((there - there.mean(axis=0)).T @ (own - own.mean(axis=0)))
    R = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
    return [pose(there.mean(axis=0) - R @ own.mean(axis=0), R=R)]


def _judged(
    seen: PictureFeatures, model: PrintModel, matches: Matches, T: Array
) -> tuple[PrintPose, NDArray[np.intp]] | None:
    """The pose (4, 4) with how much speaks for it, and the features that do; None if that is too little."""
    is_near, is_elsewhere = _compared(seen, model, matches, T)
    _, first = np.unique(matches.seen[is_near & ~is_elsewhere], return_index=True)
    own = matches.only(np.flatnonzero(is_near & ~is_elsewhere)[first])
    n_measured = int(np.isfinite(seen.depth[own.seen]).sum())
    enough = LEAST_MATCHES if n_measured > _MOSTLY * len(own) else _WITHOUT_DEPTH
    if len(own) < enough:
        return None
    points = model.points[own.known]
    sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    spread = sizes[:2] / np.sqrt(len(points))
    n_elsewhere = len(np.unique(matches.seen[is_near & is_elsewhere]))
    agreeing = 1.0 - n_elsewhere / (n_measured + n_elsewhere) if n_elsewhere else 1.0
    if agreeing < _LEAST_AGREEING or (spread < _LEAST_SPREAD).any():
        return None
    sighting = PrintSighting(seen.camera, T, points, seen.features.pixels[own.seen])
    return PrintPose(sighting, float(spread[1]), agreeing), own.seen


def _agree(seen: PictureFeatures, model: PrintModel, matches: Matches, T: Array) -> NDArray[np.bool_]:
    """(M,) which matches agree with a pose (4, 4), in the picture and in depth."""
    is_near, is_elsewhere = _compared(seen, model, matches, T)
    return np.asarray(is_near & ~is_elsewhere)


def _compared(
    seen: PictureFeatures, model: PrintModel, matches: Matches, T: Array
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(M,) which matches agree with a pose (4, 4) in the picture, and at which another depth was measured."""
    at = transform_points(T, model.points[matches.known])
    with np.errstate(divide="ignore", invalid="ignore"):
        off = np.linalg.norm(seen.camera.project(at) - seen.features.pixels[matches.seen], axis=1)
        is_elsewhere = np.abs(at[:, 2] - seen.depth[matches.seen]) > _OFF_IN_DEPTH
    return np.asarray((at[:, 2] > 0.0) & (off < _off(seen))), np.asarray(is_elsewhere)


def _off(seen: PictureFeatures) -> float:
    """By how many pixels a match may be off."""
    return max(_LEAST_OFF, _OFF * seen.camera.fx)


def _pose(turn: Array, shift: Array) -> Array:
    return pose(np.asarray(shift).ravel(), R=cv2.Rodrigues(turn)[0])
