"""Reachability of every place of a cell: by inverse kinematics, and from its named configuration.

Poses inside a place that the tool without the arm can take, leaning like grasps, are sampled. A pose is
reached if the arm has a collision-free configuration for it; otherwise no sequence of motions can reach it.
From the configuration that waits at the place, one straight line must lead there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pickcli.cartesian.line_following import follow_line
from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.cell.place import Place
from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import Failures
from pickcli.geometry import Array, rotation_rpy
from pickcli.kinematics.arm import Arm
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.reachability.place_pose_sampling import PlacePoseSampler
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.seeds import derived_rng

N_POSES = 60  # default number of tool poses by which a place is judged


@dataclass(frozen=True, eq=False)
class PlaceReachability:
    """Reachability of one place.

    Attributes:
        place: Name of the place.
        tips: (N, 3) positions in m, in the world, of the sampled tool poses.
        is_reached: (N,) whether the arm can take the pose.
        configuration: Name of the configuration that waits at the place; "" if there is none.
        is_reached_in_line: (N,) whether a straight line from that configuration leads to the pose.
        arm: Name of the arm; empty in a cell with one arm.
    """

    place: str
    tips: Array
    is_reached: NDArray[np.bool_]
    configuration: str
    is_reached_in_line: NDArray[np.bool_]
    arm: str = ""

    @property
    def share(self) -> float:
        """Share of the poses that are reached; 0 if the tool fits at none of them."""
        return float(self.is_reached.mean()) if len(self.is_reached) else 0.0

    @property
    def share_in_line(self) -> float | None:
        """Share of the poses that are reached in a line; None without a configuration."""
        if not self.configuration:
            return None
        return float(self.is_reached_in_line.mean()) if len(self.is_reached_in_line) else 0.0


@dataclass(frozen=True, eq=False)
class ReachabilityCheck:
    """Check of the reachability of a cell's places.

    Attributes:
        cell: The cell, without items.
        tool_state: State of the tool when it enters.
        n_poses: Number of tool poses by which each place is judged.
        seed: Seed of the poses, and of inverse kinematics.
    """

    cell: Cell
    tool_state: ToolState
    n_poses: int = N_POSES
    seed: int = 0

    def places(self) -> Iterator[PlaceReachability]:
        """Judge every place of the cell, in its order.

        Yields:
            The reachability of each.
        """
        for place in self.cell.places.values():
            yield self.judged(place)

    def judged(self, place: Place) -> PlaceReachability:
        """Judge one place.

        Args:
            place: A place of the cell.

        Returns:
            Its reachability.
        """
        rng = derived_rng(self.seed, "reach", place.name, self.tool_state)
        poses = PlacePoseSampler(self._model, place, self.tool_state).in_mouth_prism(rng, self.n_poses)
        waiting = self._waiting_at(place)
        return PlaceReachability(
            place.name,
            poses[:, :3, 3],
            np.array([self._is_reached(T, rng) for T in poses], dtype=bool),
            "" if waiting is None else waiting.name,
            np.array([waiting is not None and self._leads_to(waiting.q, T) for T in poses], dtype=bool),
            self.cell.arm,
        )

    def _is_reached(self, T_world_tip: Array, rng: np.random.Generator) -> bool:
        """Whether a free configuration has the tip at a pose, or half a turn from it about the cup's axis."""
        turned = T_world_tip.copy()
        for roll in (0.0, np.pi):
            turned[:3, :3] = T_world_tip[:3, :3] @ rotation_rpy(0.0, 0.0, roll)
            Q = self._arm.solve_spread(turned, self.tool_state, rng)
            if any(self._checker.is_valid(q) for q in Q):
                return True
        return False

    def _leads_to(self, q: Array, T_world_goal: Array) -> bool:
        """Whether one line leads from a configuration to a pose. The cup arrives with its current roll."""
        T_world_tip = self._arm.tip(q, self.tool_state)
        relative = T_world_goal[:3, :3].T @ T_world_tip[:3, :3]
        roll = np.arctan2(relative[1, 0], relative[0, 0])
        goal = T_world_goal.copy()
        goal[:3, :3] = goal[:3, :3] @ rotation_rpy(0.0, 0.0, float(roll))
        line = follow_line(self._arm, self._checker, T_world_tip, goal, self.tool_state, q, "line")
        return not isinstance(line, Failures)

    def _waiting_at(self, place: Place) -> NamedConfiguration | None:
        """Return the free configuration that waits at a place, if the cell has one in this tool state."""
        named = self.cell.configurations.get(place.name)
        is_free = named is not None and self._checker.is_valid(named.q)
        return named if named is not None and named.tool_state == self.tool_state and is_free else None

    @cached_property
    def _model(self) -> CollisionModel:
        return CollisionModel(self.cell)

    @cached_property
    def _arm(self) -> Arm:
        return Arm(self.cell.robot)

    @cached_property
    def _checker(self) -> SceneChecker:
        return checker(self._model, self.tool_state, PayloadClass.EMPTY)
