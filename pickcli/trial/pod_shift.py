"""Where the pod stands in a trial: the organisers shifted it before each (KTH, section I)."""

from __future__ import annotations

from dataclasses import replace
from math import degrees

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import UNMOVED, Displacement, displaced
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.seeds import derived_rng
from pickcli.simulation.reality import Reality

RANDOM, NONE = "random", "none"  # words for a shift


def random_displacement(bounds: Displacement, rng: np.random.Generator) -> Displacement:
    """Draw a displacement of the pod, uniform within bounds.

    Args:
        bounds: The largest displacement either way.
        rng: Source of the random numbers.

    Returns:
        The displacement.
    """
    x, y, yaw = (float(v) for v in rng.uniform(-1.0, 1.0, 3) * [bounds.x, bounds.y, bounds.yaw])
    return Displacement(x, y, yaw)


def random_shift(cell: Cell, seed: int) -> Displacement:
    """Draw where a seed puts the pod, within what its cell allows for.

    Args:
        cell: The cell.
        seed: The seed.

    Returns:
        The displacement from the pod's nominal place.
    """
    return random_displacement(cell.pod.displacement, derived_rng("pod shift", seed))


def shifted_pod(cell: Cell, shift: Displacement) -> Array:
    """Move the pod from its nominal place.

    Args:
        cell: The cell.
        shift: The displacement.

    Returns:
        Pose (4, 4) of the pod in the world.

    Raises:
        InputError: The shift is beyond what the cell allows for.
    """
    bounds = cell.pod.displacement
    if not cell.pod.bins and shift != UNMOVED:
        raise InputError(f"--pod-shift: the cell {cell.name} has no pod that could be shifted; leave it out")
    T_world_pod = displaced(cell.T_world_pod, shift.x, shift.y, shift.yaw)
    if not bounds.allows(displaced(np.eye(4), shift.x, shift.y, shift.yaw)):
        raise InputError(
            f"--pod-shift: {_told(shift)} is beyond what the cell {cell.name} allows for, which is "
            f"{_told(bounds)} either way"
        )
    return T_world_pod


def pod_pose(shift: Displacement | str, cell: Cell, seed: int) -> Array:
    """Tell where the pod stands.

    Args:
        shift: A displacement, "random" or "none".
        cell: The cell.
        seed: Seed of a random shift.

    Returns:
        Pose (4, 4) of the pod in the world.

    Raises:
        InputError: The shift is beyond the cell's bounds.
    """
    if isinstance(shift, str):
        shift = random_shift(cell, seed) if shift == RANDOM else UNMOVED
    return shifted_pod(cell, shift)


def standing(
    asked: Displacement | str | None, reality: Reality, cell: Cell, seed: int
) -> tuple[Array, Reality]:
    """Tell where the pod stands in a trial, and whether that is at random.

    Args:
        asked: A displacement, "random" or "none"; None where nothing was said.
        reality: Levels, whose own shift counts then.
        cell: Whose bounds hold.
        seed: Of a random shift.

    Returns:
        Pose (4, 4) of the pod in the world, and the levels with what holds of the shift.

    Raises:
        InputError: The shift is beyond the cell's bounds.
    """
    shift = asked or (RANDOM if reality.pod_shift else NONE)
    return pod_pose(shift, cell, seed), replace(reality, pod_shift=shift == RANDOM)


def _told(d: Displacement) -> str:
    return f"{1e3 * d.x:g} mm, {1e3 * d.y:g} mm and {degrees(d.yaw):g} degrees"
