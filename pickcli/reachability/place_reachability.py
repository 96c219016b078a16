"""How much of every place of a cell the arm reaches: by inverse kinematics, and from its own configuration.

What is drawn are poses of the tool inside a place that the tool by itself can take there, leaning as grasps
lean. Reached is one if the arm has a configuration for it that touches nothing: what no order of motions
mends is not reached. From the configuration that waits at the place, one straight line has to lead there.
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

N_POSES = 60  # tool poses by which a place is judged, unless stated


@dataclass(frozen=True, eq=False)
class PlaceReachability:
    """How much of one place is reached.

    Attributes:
        place: Its name.
        tips: (N, 3) positions in m, in the world, of the tool poses that were tried.
        is_reached: (N,) whether the arm can take the pose.
        configuration: Name of the configuration that waits at the place; "" where there is none.
        is_reached_in_line: (N,) whether a straight line leads there from that configuration.
        arm: Name of the arm; empty where the cell has only one.
    """

    place: str
    tips: Array
    is_reached: NDArray[np.bool_]
    configuration: str
    is_reached_in_line: NDArray[np.bool_]
    arm: str = ""

    @property
    def share(self) -> float:
        """Share of the poses that are reached; 0 where the tool fits in nowhere."""
        return float(self.is_reached.mean()) if len(self.is_reached) else 0.0

    @property
    def share_in_line(self) -> float | None:
        """Share of the poses that are reached in a line; None without a configuration."""
        if not self.configuration:
            return None
        return float(self.is_reached_in_line.mean()) if len(self.is_reached_in_line) else 0.0


@dataclass(frozen=True, eq=False)
class ReachabilityCheck:
    """Judges what the arm of a cell reaches.

    Attributes:
        cell: The cell, without items.
        tool_state: State of the tool as it goes in.
        n_poses: Tool poses by which each place is judged.
        seed: Of the poses, and of inverse kinematics.
    """

    cell: Cell
    tool_state: ToolState
    n_poses: int = N_POSES
    seed: int = 0

    def places(self) -> Iterator[PlaceReachability]:
        """Judge every place of the cell, in its order.

        Yields:
            What is reached of each.
        """
        for place in self.cell.places.values():
            yield self.judged(place)

    def judged(self, place: Place) -> PlaceReachability:
        """Judge one place.

        Args:
            place: Of the cell.

        Returns:
            What is reached of it.
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
        """Whether a free configuration puts the tip there, turned about the cup's axis as it may be."""
        turned = T_world_tip.copy()
        for roll in (0.0, np.pi):
            turned[:3, :3] = T_world_tip[:3, :3] @ rotation_rpy(0.0, 0.0, roll)
            Q = self._arm.solve_spread(turned, self.tool_state, rng)
            if any(self._checker.is_valid(q) for q in Q):
                return True
        return False

    def _leads_to(self, q: Array, T_world_goal: Array) -> bool:
        """Whether one line leads there from a configuration. The cup arrives turned as it leaves."""
        T_world_tip = self._arm.tip(q, self.tool_state)
        relative = T_world_goal[:3, :3].T @ T_world_tip[:3, :3]
        roll = np.arctan2(relative[1, 0], relative[0, 0])
        goal = T_world_goal.copy()
        goal[:3, :3] = goal[:3, :3] @ rotation_rpy(0.0, 0.0, float(roll))
        line = follow_line(self._arm, self._checker, T_world_tip, goal, self.tool_state, q, "line")
        return not isinstance(line, Failures)

    def _waiting_at(self, place: Place) -> NamedConfiguration | None:
        """The free configuration from which a place is entered, if the cell has one in this state."""
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
