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

_AWAY = pose((0.0, 0.0, -100.0))  # of the base: where it stands now must not decide where the tool fits in


def poses_by_place(cell: Cell, tool_state: ToolState, n: int, seed: int) -> dict[str, Array]:
    """Draw tool poses in every place of a cell.

    Args:
        cell: The cell.
        tool_state: State of the tool.
        n: How many in each place.
        seed: Seed of the draws.

    Returns:
        (n, 4, 4) poses of the tool frame in the world, by name of the place.

    Raises:
        InputError: There are none in one of the places.
    """
    return {
        name: tool_poses(cell, place, tool_state, n, derived_rng(seed, "mount", name))
        for name, place in cell.places.items()
    }


def tool_poses(cell: Cell, place: Place, tool_state: ToolState, n: int, rng: np.random.Generator) -> Array:
    """Draw poses inside a place that the tool by itself can take, all over it and leaning all ways.

    Args:
        cell: The cell.
        place: The place.
        tool_state: State of the tool.
        n: How many.
        rng: Source of random numbers.

    Returns:
        (n, 4, 4) poses of the tool frame in the world, the place where it nominally stands.

    Raises:
        InputError: There are none.
    """
    sampler = PlacePoseSampler(CollisionModel(mounted(cell, _AWAY)), place, tool_state)
    free = sampler.over_floor(rng, n)
    if not len(free):
        raise InputError(f"{place.name}: the tool fits in nowhere in its state {tool_state}; try another one")
    return free
