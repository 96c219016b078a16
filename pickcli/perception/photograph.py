"""Photographs: colour pictures as cameras take them, of damaged labels and in light that no model knows.

What changes from hall to hall and from picture to picture follows the corruptions by which recognition is
tested (Hendrycks and Dietterich 2019): brightness, blur and noise; and the white balance of a camera.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter

from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array
from pickcli.perception.looks import HALL, LightingModel, colour_picture
from pickcli.perception.procedural_texture import ColourPicture
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.perception.surface_view import FloatPicture
from pickcli.seeds import derived_rng

_AMOUNTS = (0.75, 1.25)  # of all lights, as shares of those in the usual hall
_LAMP_SHIFTS = ((-0.8, 0.8), (-2.5, 2.5), (-0.8, 0.4))  # m, of the lamp along x, y and z
_EXPOSURES, _WHITE_BALANCE = (0.85, 1.15), 0.05
_BLUR, _GREY_NOISE = 0.5, 2.0  # px, and levels of 255; standard deviations


def photograph(
    rendered: RenderedScene, camera: PinholeCamera, T_world_camera: Array, texture_seed: int,
    hall_seed: int, seed: int,
) -> ColourPicture:  # fmt: skip
    """Take a colour picture of damaged labels in drawn light.

    Args:
        rendered: The solids.
        camera: Intrinsics of the camera.
        T_world_camera: (4, 4) its pose.
        texture_seed: Seed of the set of textures.
        hall_seed: Seed of what all pictures share: light, and damage to labels.
        seed: Seed of exposure, white balance and noise.

    Returns:
        (height, width, 3) red, green, blue; the same bytes for the same arguments.
    """
    light = drawn_light(hall_seed)
    return _exposed(colour_picture(rendered, camera, T_world_camera, texture_seed, light, hall_seed), seed)


def drawn_light(seed: int) -> LightingModel:
    """Draw the light in a hall.

    Args:
        seed: Its seed.

    Returns:
        Light of other amounts, from a lamp elsewhere.
    """
    rng = derived_rng("light", seed)
    shifts = (rng.uniform(*ends) for ends in _LAMP_SHIFTS)
    x, y, z = (float(at + shift) for at, shift in zip(HALL.lamp_position, shifts, strict=True))
    amounts = rng.uniform(*_AMOUNTS, 3) * (HALL.ambient, HALL.headlight, HALL.lamp)
    ambient, headlight, lamp = amounts.tolist()
    return replace(HALL, ambient=ambient, headlight=headlight, lamp=lamp, lamp_position=(x, y, z))


def _exposed(colour: ColourPicture, seed: int) -> ColourPicture:
    """A picture (height, width, 3) with exposure and white balance off, blurred, with noise."""
    rng = derived_rng("taken", seed)
    gains = rng.uniform(*_EXPOSURES) * rng.uniform(1.0 - _WHITE_BALANCE, 1.0 + _WHITE_BALANCE, 3)
    taken: FloatPicture = colour.astype(np.float32) * gains.astype(np.float32)
    gaussian_filter(taken, (_BLUR, _BLUR, 0.0), output=taken)
    taken += rng.normal(0.0, _GREY_NOISE, colour.shape)
    return np.asarray(np.clip(np.rint(taken, out=taken), 0, 255, out=taken).astype(np.uint8))
