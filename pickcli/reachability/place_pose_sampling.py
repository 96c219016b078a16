"""Sampling of tool poses in front of a place and in it, by which configurations, arms and mounts are judged.

All poses are sampled in the entry frame: x points into the place, through the mouth of a bin or down into a
crate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.place import Place
from pickcli.cell.tool import IN_LINE, ToolState
from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse, rotation_rpy, transform_points
from pickcli.scene.scene import empty_scene

# Region of the tip while the arm waits: m before the mouth, and beside its middle. The pod may be displaced
# by 50 mm, so nothing should wait nearer than that plus some clearance.
_BEFORE = (-0.32, -0.10)
_BESIDE_MOUTH = 0.06

_INSIDE = 0.04  # m behind the mouth, from which on a pose is certainly in the place
_JUST_INSIDE = 0.02  # m behind the mouth, from which on a pose may be in the place
# largest yaw and pitch of the lance in the place, either way, as for grasps
_MAX_LANCE_ANGLE = np.radians(30.0)
_DRAWS = 40  # most samples per pose that the tool can take


@dataclass(frozen=True, eq=False)
class PlacePoseSampler:
    """Sampler of tip poses around one place, for one state of the tool.

    Attributes:
        model: The robot's collision model in its cell.
        place: The place.
        tool_state: State of the tool.
    """

    model: CollisionModel
    place: Place
    tool_state: ToolState

    @property
    def T_world_entry(self) -> Array:
        """(4, 4) pose of the entry frame, with its carrier at its nominal pose."""
        return np.asarray(self.model.cell.T_world_place(self.place) @ self.place.T_place_entry)

    @property
    def _R_entry_tip(self) -> Array:
        """Orientation (3, 3) of the tip in the entry frame, for a lance that points straight in.

        The flange's x points down as in Delft's poses; a cup across the lance points down.
        """
        return self.model.robot.tool.R_tip_lance(self.tool_state).T

    def in_front(self, rng: np.random.Generator, n: int) -> Array:
        """Sample poses in front of the mouth, the lance straight along the way in.

        The flange of a straight cup is rolled by 0 or half a turn, for both branches of the wrist; above a
        place with access from above it is rolled by any angle.

        Args:
            rng: Source of random numbers.
            n: Number of poses.

        Returns:
            (n, 4, 4) in the world.
        """
        low = np.array([_BEFORE[0], -_BESIDE_MOUTH, self.place.access.height / 2 - _BESIDE_MOUTH])
        high = np.array([_BEFORE[1], _BESIDE_MOUTH, self.place.access.height / 2 + _BESIDE_MOUTH])
        places = rng.uniform(low, high, (n, 3))
        is_turned = rng.random(n) < (
            0.5 if self.model.robot.tool.has_lance(self.tool_state, IN_LINE) else 0.0
        )
        rolls = np.pi * is_turned
        if self.place.access.is_from_above:
            rolls = rng.uniform(-np.pi, np.pi, n)
        return np.stack([self._pose(p, 0.0, 0.0, roll=roll) for p, roll in zip(places, rolls, strict=True)])

    def inside(self, rng: np.random.Generator, n: int) -> Array:
        """Sample poses all over the place that the tool without the arm can take, leaning all ways.

        Args:
            rng: Source of random numbers.
            n: Number of poses.

        Returns:
            (n, 4, 4) in the world.

        Raises:
            InputError: If there are too few.
        """
        low, high = room_behind_mouth(self.place, _INSIDE)
        drawn = rng.uniform(
            [*low, -_MAX_LANCE_ANGLE, -_MAX_LANCE_ANGLE],
            [*high, _MAX_LANCE_ANGLE, _MAX_LANCE_ANGLE],
            (_DRAWS * n, 5),
        )
        free = self._taken([self._pose(d[:3], d[3], d[4]) for d in drawn], n)
        if len(free) < n:
            raise InputError(
                f"{self.place.name}: the tool in its state {self.tool_state} fits at hardly any pose in it"
            )
        return free

    def in_mouth_prism(self, rng: np.random.Generator, n: int) -> Array:
        """Sample poses straight behind the mouth that the tool can take without the arm; any turn from above.

        Args:
            rng: Source of random numbers.
            n: Most poses.

        Returns:
            (N, 4, 4) in the world.
        """
        access = self.place.access
        depth = float(np.abs(access.direction) @ self.place.room.size)
        low = np.array([_JUST_INSIDE, -access.width / 2, 0.0, -_MAX_LANCE_ANGLE, -_MAX_LANCE_ANGLE, 0.0])
        turn = 2.0 * np.pi if access.is_from_above else 0.0
        high = np.array([depth, access.width / 2, access.height, _MAX_LANCE_ANGLE, _MAX_LANCE_ANGLE, turn])
        low_room, high_room = room_behind_mouth(self.place, _JUST_INSIDE)
        if high_room[0] < _JUST_INSIDE:  # over a table: nothing is beside it
            low[:3], high[:3] = low_room, high_room
        drawn = rng.uniform(low, high, (_DRAWS * n, 6))
        return self._taken([self._pose(d[:3], d[3], d[4], turn=d[5]) for d in drawn], n)

    def over_floor(self, rng: np.random.Generator, n: int) -> Array:
        """Sample poses between floor and ceiling, even if sloping, that the tool without the arm can take.

        Args:
            rng: Source of random numbers.
            n: Most poses.

        Returns:
            (N, 4, 4) in the world.
        """
        room, access = self.place.room, self.place.access
        drawn = rng.uniform(
            [*room.low, -_MAX_LANCE_ANGLE, -_MAX_LANCE_ANGLE],
            [*room.high, _MAX_LANCE_ANGLE, _MAX_LANCE_ANGLE],
            (_DRAWS * n, 5),
        )
        floor, ceiling = room.floor_at(drawn[:, 0]), room.ceiling_at(drawn[:, 0])
        drawn[:, 2] = floor + (drawn[:, 2] - room.low[2]) / room.size[2] * (ceiling - floor)
        behind_mouth = (drawn[:, :3] - access.T_place_mouth[:3, 3]) @ access.direction
        if behind_mouth.max() > 0.0:  # over a table all room is before the mouth
            drawn = drawn[behind_mouth >= _INSIDE]
        points = transform_points(inverse(self.place.T_place_entry), drawn[:, :3])
        return self._taken([self._pose(p, *lean) for p, lean in zip(points, drawn[:, 3:], strict=True)], n)

    def _taken(self, poses: list[Array], n: int) -> Array:
        """Return the first poses (N, 4, 4) that the tool without the arm can take in the empty cell."""
        axes = np.ascontiguousarray(self.T_world_entry[:3, :3])
        tool = FreeToolChecker(self.model, empty_scene(self.model.cell), self.tool_state, axes)
        tried = np.stack(poses)
        return np.asarray(tried[tool.are_valid(tool.displacements(tried))][:n])

    def roll(self, T_world_tip: Array) -> float:
        """Return how far a pose in front of the place is rolled about the cup's axis.

        Args:
            T_world_tip: (4, 4) pose of the tip.

        Returns:
            rad.
        """
        R = (self.T_world_entry[:3, :3] @ self._R_entry_tip).T @ T_world_tip[:3, :3]
        return float(np.arctan2(R[1, 0], R[0, 0]))

    def _pose(self, place: Array, yaw: float, pitch: float, turn: float = 0.0, roll: float = 0.0) -> Array:
        """Return the world pose (4, 4) of a lance turned about itself, leant, and rolled at the tip."""
        R_lance = rotation_rpy(0.0, pitch, yaw) @ rotation_rpy(turn, 0.0, 0.0)
        T = np.eye(4)
        T[:3, :3] = R_lance @ self._R_entry_tip @ rotation_rpy(0.0, 0.0, roll)
        T[:3, 3] = place
        return np.asarray(self.T_world_entry @ T)


def room_behind_mouth(place: Place, inside: float) -> tuple[Array, Array]:
    """Return the room of a place behind its mouth, in the entry frame.

    Args:
        place: The place.
        inside: m behind the mouth at which it begins. A place without walls, like a table, has no room behind
            its mouth; its room above is returned.

    Returns:
        Lower and upper corner (3,), (3,) in m.
    """
    corners = transform_points(inverse(place.T_place_entry), np.stack([place.room.low, place.room.high]))
    low, high = corners.min(axis=0), corners.max(axis=0)
    if high[0] > inside:
        low[0] = max(low[0], inside)
    return low, high
