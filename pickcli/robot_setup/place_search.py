"""Searches the pose of a shelf, box or table that the arm reaches best without collisions.

Candidate poses are around the arm's first joint: first straight ahead, then to either side, then higher and
lower. Each is rated by the number of tool poses in and in front of the place that the arm can reach, by
inverse kinematics and collision checks, as in the search for a base pose (`reachability.mount_ranking`),
where the robot is moved instead.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.place import Place
from pickcli.cell.station import NO_POD, POD, Carrier, Obstacles
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array, inverse, pose
from pickcli.kinematics.arm import Arm
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.reachability.base_solids import base_solids, overlaps
from pickcli.reachability.place_pose_sampling import PlacePoseSampler
from pickcli.reachability.tool_pose_sampling import tool_poses
from pickcli.reachability.tool_reachability import ToolReachability, reach_ball
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.scene.scene import empty_scene
from pickcli.scene.solid_overlap import PosedSolid
from pickcli.seeds import derived_rng

GOOD_RATING = 0.85  # rating, mean of the overall share and that of the worst place, at which the search ends
MIN_IMPROVEMENT = 0.05  # least improvement over an earlier pose
CARRIER_CLEARANCE = 0.02  # m between the carrier and anything else

_TURNS = np.radians([0, 30, -30, 60, -60, 90, -90, 120, -120, 150, -150, 180])
_FROM_ABOVE = (0.4, 0.3, 0.5)  # distances of the centre, as shares of the arm's reach
_FROM_FRONT = (0.45, 0.55, 0.65)  # of the front face
_HEIGHTS = (0.0, 0.2, -0.2)  # of the centre above the arm's first joint, as shares of its reach
_N_POSES = 12  # tool poses in all places by which a pose is rated, with as many in front of them
_MOST_TRIED = 48
_N_LEAST = 2  # least number of these per place
_N_SEEDS = 64


@dataclass(frozen=True, eq=False)
class PlacedCarrier:
    """Best pose found for a carrier.

    Attributes:
        T_world_carrier: (4, 4).
        share: Share of the tool poses that the arm reaches there; 0 if it reaches none at any pose.
        n_poses: Number of tool poses.
        n_tried: Number of candidate poses rated, without those in collision.
    """

    T_world_carrier: Array
    share: float
    n_poses: int
    n_tried: int


@dataclass(frozen=True, eq=False)
class PlaceSearch:
    """Search of the pose of one carrier of a cell.

    Attributes:
        cell: The cell with everything at its final pose, and the carrier at any pose.
        carrier: The carrier.
        level: m, height of its frame above the robot's base if both stand on the same level; None to skip
            that candidate.
        keeps_free: (M, n) configurations that must stay free.
        seed: Seed of tool poses and inverse kinematics.

    Raises:
        InputError: The tool does not fit anywhere in one of its places.
    """

    cell: Cell
    carrier: Carrier
    level: float | None
    keeps_free: Array
    seed: int

    def best(self) -> PlacedCarrier:
        """Find the pose with the most reachable tool poses, also in the worst of its places.

        Of equally good poses the first is chosen.

        Returns:
            The pose; arbitrary if nothing is reached.
        """
        best, worth, n_poses = PlacedCarrier(np.eye(4), 0.0, 0, 0), 0.0, sum(map(len, self._tools))
        n_tried = 0
        for T in self._poses():
            checker = self._checker_at(T)
            if checker is None:
                continue
            n_tried += 1
            shares = self._shares(T, checker)
            now = float(shares.mean() + shares.min()) / 2
            if now > worth + (MIN_IMPROVEMENT if worth else 0.0):
                best, worth = PlacedCarrier(T, float(shares.mean()), n_poses, n_tried), now
            if worth >= GOOD_RATING or n_tried == _MOST_TRIED:
                break
        return replace(best, n_tried=n_tried, n_poses=n_poses)

    def _poses(self) -> Iterator[Array]:
        """Candidate poses (4, 4): on the level of the base first, and straight ahead first."""
        center, radius = reach_ball(self.cell.robot)
        away = _FROM_ABOVE if self._places[0].access.is_from_above else _FROM_FRONT
        for z in self._heights(float(center[2]), radius):
            for turn, share in product(_TURNS.tolist(), away):
                x, y = center[:2] + share * radius * np.array([np.cos(turn), np.sin(turn)])
                yield pose((x, y, z), rpy=(0.0, 0.0, turn))

    def _heights(self, center: float, radius: float) -> Iterator[float]:
        """Candidate heights in m: the level of the base, then around that of the arm's first joint."""
        if self.level is not None:
            yield float(self.cell.robot.T_world_base[2, 3]) + self.level
        middles = [place.T_carrier_place[2, 3] + place.room.size[2] / 2 for place in self._places]
        for share in _HEIGHTS:
            yield center + share * radius - float(np.mean(middles))

    def _shares(self, T: Array, empty: SceneChecker) -> Array:
        """Share (P,) of the reachable tool poses of each place, with the carrier at a pose (4, 4)."""
        robot = self.cell.robot
        reach = ToolReachability(
            self._arm, empty, robot.tool.default_state, self._seeds, *reach_ball(robot), self._seeds[:0]
        )
        return np.array([np.mean([reach.has(T @ T_tool) for T_tool in tools]) for tools in self._tools])

    def _checker_at(self, T: Array) -> SceneChecker | None:
        """Checker of the cell with the carrier at a pose (4, 4); None if it is in collision there."""
        moved = replace(self.carrier, T_world_carrier=T)
        solids = [
            PosedSolid(body.shape.inflated(CARRIER_CLEARANCE), T @ body.T_parent_shape)
            for body in moved.bodies
        ]
        if any(overlaps(solid, other) for solid in solids for other in self._standing):
            return None
        cell = with_carrier(self.cell, moved)
        found = checker(CollisionModel(cell), cell.robot.tool.default_state, PayloadClass.EMPTY)
        return found if all(found.is_valid(q) for q in self.keeps_free) else None

    @cached_property
    def _places(self) -> list[Place]:
        return list(self.carrier.places.values())

    @cached_property
    def _arm(self) -> Arm:
        return Arm(self.cell.robot)

    @cached_property
    def _seeds(self) -> Array:
        """Seeds (K, n) of inverse kinematics, the same for all poses."""
        return self._arm.random_seeds(derived_rng(self.seed, "place", "seeds"), _N_SEEDS)

    @cached_property
    def _tools(self) -> list[Array]:
        """Tool poses (N, 4, 4) in and in front of each place, in the carrier's frame."""
        alone = replace(
            self.cell,
            pod=self.cell.pod if self.carrier.name == POD else NO_POD,
            tote=None,
            own_carriers=() if self.carrier.name == POD else (self.carrier,),
            obstacles=Obstacles(()),
        )
        state, n = self.cell.robot.tool.default_state, max(_N_LEAST, _N_POSES // len(self._places))
        model, drawn = CollisionModel(alone), []
        for place in self._places:
            rng = derived_rng(self.seed, "place", place.name)
            inside = tool_poses(alone, place, state, n, rng)
            before = PlacePoseSampler(model, place, state).in_front(rng, n)
            drawn.append(inverse(self.carrier.T_world_carrier) @ np.concatenate([inside, before]))
        return drawn

    @cached_property
    def _standing(self) -> list[PosedSolid]:
        """All other stationary solids: the robot's base and its surroundings."""
        own = {body.name for body in self.carrier.bodies}
        around = empty_scene(self.cell).standing
        return [
            *base_solids(CollisionModel(self.cell)),
            *(PosedSolid(b.shape, T @ b.T_parent_shape) for b, T in around if b.name not in own),
        ]


def with_carrier(cell: Cell, carrier: Carrier) -> Cell:
    """Return a cell with one carrier moved.

    Args:
        cell: The cell.
        carrier: The carrier at its new pose.

    Returns:
        The cell, with its old fingerprint: it must not be stored.
    """
    if carrier.name == POD:
        return replace(cell, T_world_pod=carrier.T_world_carrier)
    own = tuple(carrier if each.name == carrier.name else each for each in cell.own_carriers)
    return replace(cell, own_carriers=own)
