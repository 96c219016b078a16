"""Sampling of tool poses in front of a bin and in it, by which configurations are judged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.place import Place
from pickcli.cell.tool import IN_LINE, ToolState
from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError
from pickcli.geometry import Array, rotation_rpy
from pickcli.precompute.empty_cell_checkers import empty_scene

# Where the tip may stand while the arm waits, in the bin frame: m before the mouth, and beside its middle.
# The pod may be displaced by 50 mm: nearer than that and some room nothing should wait.
_BEFORE = (-0.32, -0.10)
_BESIDE = 0.06

_INSIDE = 0.04  # m behind the mouth where the inside begins, for a pose to be in the bin for certain
_LEAN = np.radians(30.0)  # most yaw and pitch of the lance in the bin, either way: as grasps are tried
_DRAWS = 40  # poses drawn for one that the tool can take, at most


@dataclass(frozen=True, eq=False)
class BinPoseSampler:
    """Poses of the tip around one bin, for one state of the tool.

    Attributes:
        model: The robot's collision model in its cell.
        cell_bin: The bin.
        tool_state: State of the tool.
    """

    model: CollisionModel
    cell_bin: Place
    tool_state: ToolState

    @property
    def T_world_bin(self) -> Array:
        """(4, 4) pose of the bin with the pod where it nominally stands."""
        return self.model.cell.T_world_place(self.cell_bin)

    @property
    def _R_bin_tip(self) -> Array:
        """Orientation (3, 3) of the tip, in the bin frame, of a lance that points straight in.

        The flange's x is down as in Delft's poses; a cup across the lance points down.
        """
        return self.model.robot.tool.R_tip_lance(self.tool_state).T

    def in_front(self, rng: np.random.Generator, n: int) -> Array:
        """Poses before the mouth, the lance level and straight.

        The flange of the straight cup is turned either way up, for both branches of the wrist.

        Args:
            rng: Source of random numbers.
            n: How many.

        Returns:
            (n, 4, 4) in the world.
        """
        low = np.array([_BEFORE[0], -_BESIDE, self.cell_bin.access.height / 2 - _BESIDE])
        high = np.array([_BEFORE[1], _BESIDE, self.cell_bin.access.height / 2 + _BESIDE])
        places = rng.uniform(low, high, (n, 3))
        is_turned = rng.random(n) < (
            0.5 if self.model.robot.tool.has_lance(self.tool_state, IN_LINE) else 0.0
        )
        return np.stack(
            [self._pose(p, 0.0, 0.0, np.pi * turn) for p, turn in zip(places, is_turned, strict=True)]
        )

    def inside(self, rng: np.random.Generator, n: int) -> Array:
        """Poses inside the bin that the tool by itself can take, all over it and leaning all ways.

        Args:
            rng: Source of random numbers.
            n: How many.

        Returns:
            (n, 4, 4) in the world.

        Raises:
            InputError: If there are none.
        """
        each = self.cell_bin
        low = np.array([_INSIDE, each.room.y_range[0], each.room.floor_back, -_LEAN, -_LEAN])
        high = np.array([each.room.depth, each.room.y_range[1], each.room.ceiling_front, _LEAN, _LEAN])
        drawn = rng.uniform(low, high, (_DRAWS * n, 5))
        poses = np.stack([self._pose(d[:3], d[3], d[4], 0.0) for d in drawn])
        tool = FreeToolChecker(
            self.model, empty_scene(self.model.cell), self.tool_state, self.T_world_bin[:3, :3]
        )
        free = poses[tool.are_valid(tool.displacements(poses))][:n]
        if len(free) < n:
            raise InputError(
                f"{each.name}: the tool fits in with the cup {self.tool_state} nowhere to speak of"
            )
        return np.asarray(free)

    def roll(self, T_world_tip: Array) -> float:
        """How far a pose in front of the bin is turned about the cup's axis.

        Args:
            T_world_tip: (4, 4) pose of the tip.

        Returns:
            rad.
        """
        R = (self.T_world_bin[:3, :3] @ self._R_bin_tip).T @ T_world_tip[:3, :3]
        return float(np.arctan2(R[1, 0], R[0, 0]))

    def _pose(self, place: Array, yaw: float, pitch: float, roll: float) -> Array:
        """(4, 4) in the world: the lance turned about the bin's axes, then about itself."""
        T = np.eye(4)
        T[:3, :3] = rotation_rpy(0.0, pitch, yaw) @ self._R_bin_tip @ rotation_rpy(0.0, 0.0, roll)
        T[:3, 3] = place
        return np.asarray(self.T_world_bin @ T)
