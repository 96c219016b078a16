"""A body that floats freely: to the kernel a robot of three prismatic joints and three turning ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.robot import PivotState
from pickcli.collision.model import CollisionModel
from pickcli.geometry import Array, inverse, pose
from pickcli.kernel import Chain

N_FREE = 6  # x, y, z along the axes, then yaw about z, pitch about the turned y, roll about the turned x
LANCE, CUP = 5, 6  # frames that move with all six: two, as only the cup may touch what is touched


def floating_chain(origin: Array, R_world_axes: Array) -> Chain:
    """The chain whose frames LANCE and CUP stand at ``origin`` (3,), along the axes, at displacement 0."""
    kinds = np.array([1, 1, 1, 0, 0, 0, 2], np.int32)
    frames = np.stack([pose(origin, R=R_world_axes), *[np.eye(4)] * N_FREE])
    z, y, x = np.eye(3)[::-1]
    axes = np.vstack([np.eye(3), z, y, x, z])
    return Chain(kinds, frames, axes, np.array([*range(N_FREE), -1], np.int32))


def tool_spheres(
    model: CollisionModel, pivot: PivotState, T_frame_tip: Array
) -> tuple[Array, Array, NDArray[np.int32]]:
    """Centres (S, 3), radii (S,) and frames (S,) of lance and cup, whose tip is at a pose in the frames."""
    state, tool = model.state(pivot), model.robot.tool
    links = state.chain.fk(np.zeros(state.chain.n))
    T_frame_world = T_frame_tip @ inverse(links[-1] @ tool.T_cup_tip)
    centers, frames = np.empty((0, 3)), np.empty(0, np.int32)
    radii = np.empty(0)
    for frame, name in ((LANCE, tool.lance_link), (CUP, tool.cup_link)):
        k = model.frame_names.index(name)
        is_of_link = state.frames == k
        T = T_frame_world @ links[k]
        centers = np.vstack([centers, state.centers[is_of_link] @ T[:3, :3].T + T[:3, 3]])
        radii = np.append(radii, state.radii[is_of_link])
        frames = np.append(frames, np.full(int(is_of_link.sum()), frame, np.int32))
    return centers, radii, frames
