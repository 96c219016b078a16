"""Perception: the true poses with an error whose bound is told, and now and then one beyond it.

The only place where truth becomes belief. Planning and verification see nothing but what comes from here,
together with the bounds. The pod's pose is estimated once, as the organisers shift it before a trial and not
during it; items are seen again in every look.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.pod_tolerance import UNMOVED, Displacement, displaced
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.seeds import derived_rng
from pickcli.simulation.places import OUTSIDE, nearest_place
from pickcli.simulation.reality import IDEAL, Reality
from pickcli.trial.pod_shift import random_displacement

DEFAULT_NOISE = PoseNoise(position=0.002, angle=np.deg2rad(1.0))


def perceive(true: Scene, noise: PoseNoise, seed: int, look: int, reality: Reality = IDEAL) -> Scene:
    """Perceive a scene, with the errors of perception.

    Items in bins and tote are displaced, each in the place that its seen pose is in or nearest to; what lies
    on the floor of the hall is not seen. The pod stands where it is estimated to stand, and the bounds of
    that error are stated as ``pod_error``.

    Args:
        true: Where everything is.
        noise: Bound of the error of an item's pose, which the result states. A share of the poses,
            ``reality.pose_outlier_share``, is off by more: by up to ``pose_outlier_scale`` times as much.
        seed: Of the trial.
        look: Number of the look. The error of an item depends on seed, its id and the look alone, so that it
            does not change when other items come or go.
        reality: Levels of outliers and of the error of the pod's pose.

    Returns:
        The scene as it is perceived.
    """
    error = _pod_error(reality)
    off = random_displacement(error, derived_rng("pod estimate", seed))
    # The true pod stands off the estimated one by what the bounds speak of.
    T_world_pod = true.T_world_pod @ inverse(displaced(np.eye(4), off.x, off.y, off.yaw))
    seen = replace(true, noise=noise, T_world_pod=T_world_pod, pod_error=error)
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
    """Turned about its own centre and shifted; both errors are drawn even where a bound is zero."""
    shift, turn = _in_ball(rng), _in_ball(rng)
    if rng.random() < reality.pose_outlier_share:
        # Anywhere from the bound to so many times the bound, in the direction drawn.
        most = reality.pose_outlier_scale
        shift, turn = (v / np.linalg.norm(v) * rng.uniform(1.0, most) for v in (shift, turn))
    angle = float(np.linalg.norm(turn))
    R = rotation_axis_angle(turn / angle, angle * noise.angle)
    T = placed.T_world_item
    T_seen = pose(T[:3, 3] + noise.position * shift, R=R @ T[:3, :3])
    return replace(placed, T_world_item=T_seen)


def _in_ball(rng: np.random.Generator) -> Array:
    """A point (3,) uniform in the unit ball."""
    direction = rng.standard_normal(3)
    radius = rng.random() ** (1.0 / 3.0)
    return np.asarray(direction * (radius / np.linalg.norm(direction)))
