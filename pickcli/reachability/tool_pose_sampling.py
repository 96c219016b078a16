"""Sampling of tool poses all over a place, by which base poses are judged."""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.place import Place
from pickcli.cell.tool import ToolState
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError
from pickcli.geometry import Array, pose
from pickcli.reachability.mount_ranking import mounted
from pickcli.reachability.place_pose_sampling import PlacePoseSampler
from pickcli.seeds import derived_rng

_AWAY = pose((0.0, 0.0, -100.0))  # of the base: its current pose must not affect where the tool fits in


def poses_by_place(cell: Cell, tool_state: ToolState, n: int, seed: int) -> dict[str, Array]:
    """Sample tool poses in every place of a cell.

    Args:
        cell: The cell.
        tool_state: State of the tool.
        n: Number of poses in each place.
        seed: Seed of the samples.

    Returns:
        (n, 4, 4) poses of the tool frame in the world, by name of the place.

    Raises:
        InputError: There are no such poses in one of the places.
    """
    return {
        name: tool_poses(cell, place, tool_state, n, derived_rng(seed, "mount", name))
        for name, place in cell.places.items()
    }


def tool_poses(cell: Cell, place: Place, tool_state: ToolState, n: int, rng: np.random.Generator) -> Array:
    """Sample poses inside a place that the tool without the arm can take, all over it and leaning all ways.

    Args:
        cell: The cell.
        place: The place.
        tool_state: State of the tool.
        n: Number of poses.
        rng: Source of random numbers.

    Returns:
        (n, 4, 4) poses of the tool frame in the world, the place at its nominal pose.

    Raises:
        InputError: There are no such poses.
    """
    sampler = PlacePoseSampler(CollisionModel(mounted(cell, _AWAY)), place, tool_state)
    free = sampler.over_floor(rng, n)
    if not len(free):
        raise InputError(
            f"{place.name}: the tool in its state {tool_state} fits at no pose in it; try another state"
        )
    return free
