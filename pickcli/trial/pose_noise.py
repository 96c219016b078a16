"""Simulated perception: true poses with bounded errors, and occasional outliers.

The only interface from true to perceived poses: planning and verification use only its result, with the error
bounds. The poses of the pod and of a displaced tote are estimated once, as they are shifted before a trial
and not during it; items are perceived again in every look.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.pod_tolerance import UNMOVED, Displacement, displaced
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.seeds import derived_rng
from pickcli.simulation.places import OUTSIDE, nearest_place
from pickcli.simulation.reality import IDEAL, Reality
from pickcli.trial.pod_shift import random_displacement
from pickcli.trial.tote_shift import estimated_tote

DEFAULT_NOISE = PoseNoise(position=0.002, angle=np.deg2rad(1.0))


def perceive(true: Scene, noise: PoseNoise, seed: int, look: int, reality: Reality = IDEAL) -> Scene:
    """Perceive a scene, with errors.

    Items in places are displaced, and assigned to the place nearest to their perceived pose; items on the
    floor are not perceived. The pod is at its estimated pose, with the error bounds in ``pod_error``, and
    so is a displaced tote, in ``carriers``.

    Args:
        true: The true scene.
        noise: Bounds of item pose errors, which the result states. The share ``reality.pose_outlier_share``
            of the poses exceeds them by up to the factor ``pose_outlier_scale``.
        seed: Seed of the trial.
        look: Number of the look. An item's error depends only on seed, its id and the look, so that it does
            not change with other items.
        reality: Levels of outliers and of the errors of the poses of pod and tote.

    Returns:
        The perceived scene.
    """
    error = _pod_error(reality) if true.cell.pod.bins else UNMOVED
    off = random_displacement(error, derived_rng("pod estimate", seed))
    # The bounds refer to the pose of the true pod relative to the estimated one.
    T_world_pod = true.T_world_pod @ inverse(displaced(np.eye(4), off.x, off.y, off.yaw))
    seen = replace(true, noise=noise, T_world_pod=T_world_pod, pod_error=error)
    if TOTE in true.carriers:
        seen = replace(seen, carriers={**true.carriers, TOTE: estimated_tote(true, reality, seed)})
    items = tuple(
        _displaced(placed, noise, reality, derived_rng("pose noise", seed, placed.id, look))
        for placed in true.items
        if placed.location != OUTSIDE
    )
    placed = (replace(item, location=nearest_place(seen, item.T_world_item)) for item in items)
    return replace(seen, items=tuple(placed))


def _pod_error(reality: Reality) -> Displacement:
    """Bounds of the error of the pod's estimated pose."""
    if reality.pod_position_error == reality.pod_angle_error == 0.0:
        return UNMOVED
    return Displacement(reality.pod_position_error, reality.pod_position_error, reality.pod_angle_error)


def _displaced(
    placed: PlacedItem, noise: PoseNoise, reality: Reality, rng: np.random.Generator
) -> PlacedItem:
    """Rotate an item about its centre and shift it; both errors are drawn even if a bound is zero."""
    shift, turn = _in_ball(rng), _in_ball(rng)
    if rng.random() < reality.pose_outlier_share:
        # Outlier: between one and ``pose_outlier_scale`` times the bound, in the drawn direction.
        most = reality.pose_outlier_scale
        shift, turn = (v / np.linalg.norm(v) * rng.uniform(1.0, most) for v in (shift, turn))
    angle = float(np.linalg.norm(turn))
    R = rotation_axis_angle(turn / angle, angle * noise.angle)
    T = placed.T_world_item
    T_seen = pose(T[:3, 3] + noise.position * shift, R=R @ T[:3, :3])
    return replace(placed, T_world_item=T_seen)


def _in_ball(rng: np.random.Generator) -> Array:
    """A point (3,) uniformly distributed in the unit ball."""
    direction = rng.standard_normal(3)
    radius = rng.random() ** (1.0 / 3.0)
    return np.asarray(direction * (radius / np.linalg.norm(direction)))
