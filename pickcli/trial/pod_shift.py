"""Displacement of the pod in a trial: the organisers shifted it before each (KTH, section I)."""

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
    """Draw the displacement of the pod for a seed, within the cell's bounds.

    Args:
        cell: The cell.
        seed: The seed.

    Returns:
        The displacement from the pod's nominal pose.
    """
    return random_displacement(cell.pod.displacement, derived_rng("pod shift", seed))


def shifted_pod(cell: Cell, shift: Displacement) -> Array:
    """Compute the pose of a displaced pod.

    Args:
        cell: The cell.
        shift: The displacement.

    Returns:
        Pose (4, 4) of the pod in the world.

    Raises:
        InputError: The displacement is beyond the cell's bounds.
    """
    bounds = cell.pod.displacement
    if not cell.pod.bins and shift != UNMOVED:
        raise _no_pod(cell)
    T_world_pod = displaced(cell.T_world_pod, shift.x, shift.y, shift.yaw)
    if not bounds.allows(displaced(np.eye(4), shift.x, shift.y, shift.yaw)):
        raise InputError(
            f"--pod-shift: {_described(shift)} is beyond what the cell {cell.name} allows for, which is "
            f"{_described(bounds)} either way"
        )
    return T_world_pod


def pod_pose(shift: Displacement | str, cell: Cell, seed: int) -> Array:
    """Compute the pose of the pod for a stated or random displacement.

    Args:
        shift: A displacement, "random" or "none".
        cell: The cell.
        seed: Seed of a random shift.

    Returns:
        Pose (4, 4) of the pod in the world.

    Raises:
        InputError: The displacement is beyond the cell's bounds, or the cell has no pod.
    """
    if shift == RANDOM and not cell.pod.bins:
        raise _no_pod(cell)
    if isinstance(shift, str):
        shift = random_shift(cell, seed) if shift == RANDOM else UNMOVED
    return shifted_pod(cell, shift)


def standing(
    stated: Displacement | str | None, reality: Reality, cell: Cell, seed: int
) -> tuple[Array, Reality]:
    """Compute the pose of the pod in a trial, and whether it is random.

    Args:
        stated: A displacement, "random" or "none"; None if not stated.
        reality: Levels, used if no displacement is stated.
        cell: The cell, for its bounds.
        seed: Seed of a random displacement.

    Returns:
        Pose (4, 4) of the pod in the world, and the levels with the resulting ``pod_shift``.

    Raises:
        InputError: The displacement is beyond the cell's bounds.
    """
    shift = stated or (RANDOM if reality.pod_shift else NONE)
    is_unmoved = stated is None and not cell.pod.bins
    T_world_pod = pod_pose(NONE if is_unmoved else shift, cell, seed)
    return T_world_pod, replace(reality, pod_shift=shift == RANDOM)


def _no_pod(cell: Cell) -> InputError:
    return InputError(f"--pod-shift: the cell {cell.name} has no pod that could be shifted; leave it out")


def _described(d: Displacement) -> str:
    return f"{1e3 * d.x:g} mm, {1e3 * d.y:g} mm and {degrees(d.yaw):g} degrees"
