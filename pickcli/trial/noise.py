"""Perception as it could be at best: the true poses with a bounded error.

The only place where truth becomes belief. Planning and verification see nothing but what comes from here,
together with the bound that the error keeps.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.scene import PlacedItem, PoseNoise, Scene
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.seeds import derived_rng
from pickcli.simulation.places import OUTSIDE

DEFAULT_NOISE = PoseNoise(position=0.002, angle=np.deg2rad(1.0))


def perceive(true: Scene, noise: PoseNoise, seed: int, look: int) -> Scene:
    """The scene as it is perceived: every item off by at most ``noise``, which the result states.

    What lies neither in a bin nor in the tote is not seen: nobody looks at the floor of the hall.

    The error of an item depends on ``seed``, its id and ``look`` (the number of the look) alone, so that it
    does not change when other items come or go.
    """
    items = tuple(
        _displaced(placed, noise, derived_rng("pose noise", seed, placed.id, look))
        for placed in true.items
        if placed.location != OUTSIDE
    )
    return replace(true, items=items, noise=noise)


def _displaced(placed: PlacedItem, noise: PoseNoise, rng: np.random.Generator) -> PlacedItem:
    """Turned about its own centre and shifted; both errors are drawn even where a bound is zero."""
    shift, turn = _in_ball(rng), _in_ball(rng)
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
