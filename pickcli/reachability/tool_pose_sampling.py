"""Sampling of tool poses all over a place, by which base poses are judged."""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.place import Place
from pickcli.cell.tool import ToolState
from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError
from pickcli.geometry import Array, pose, rotation_rpy, transform_points
from pickcli.precompute.empty_cell_checkers import empty_scene
from pickcli.reachability.mount_ranking import mounted
from pickcli.seeds import derived_rng

_INSIDE = 0.04  # m behind the mouth where the inside begins, for a pose to be in the place for certain
_LEAN = np.radians(30.0)  # most that the tool leans off the way in, about either axis: as grasps are tried
_DRAWS = 40  # poses drawn for one that the tool can take, at most
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
    T_world_place, room, access = cell.T_world_place(place), place.room, place.access
    drawn = rng.uniform([*room.low, -_LEAN, -_LEAN], [*room.high, _LEAN, _LEAN], (_DRAWS * n, 5))
    floor, ceiling = room.floor_at(drawn[:, 0]), room.ceiling_at(drawn[:, 0])
    drawn[:, 2] = floor + (drawn[:, 2] - room.low[2]) / room.size[2] * (ceiling - floor)
    behind_mouth = (drawn[:, :3] - access.T_place_mouth[:3, 3]) @ access.direction
    if behind_mouth.max() > 0.0:  # over a table all room is before the mouth
        drawn = drawn[behind_mouth >= _INSIDE]
    # x of these axes leads into the place, and the lance points along it.
    R_world_axes = T_world_place[:3, :3] @ access.T_place_mouth[:3, :3]
    R_axes_tip = cell.robot.tool.R_tip_lance(tool_state).T
    turned = [R_world_axes @ rotation_rpy(0.0, pitch, yaw) @ R_axes_tip for pitch, yaw in drawn[:, 3:]]
    points = transform_points(T_world_place, drawn[:, :3])
    poses = np.stack([pose(point, R=R) for point, R in zip(points, turned, strict=True)])
    away = mounted(cell, _AWAY)
    tool = FreeToolChecker(CollisionModel(away), empty_scene(away), tool_state, R_world_axes)
    free = poses[tool.are_valid(tool.displacements(poses))][:n]
    if not len(free):
        raise InputError(f"{place.name}: the tool fits in nowhere in its state {tool_state}; try another one")
    return np.asarray(free)
