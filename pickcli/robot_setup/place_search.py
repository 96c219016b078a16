"""Where a shelf, a box or a table stands so that the arm reaches best into it, and hits nothing there.

Around the arm's first joint, poses are tried from straight ahead on to either side, then higher and
lower. At each, inverse kinematics and the collision checker say how many tool poses in the place and before
it the arm can take, as they do where a base is mounted (`reachability.mount_ranking`): there the robot is
moved, here what stands before it.
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
from pickcli.precompute.empty_cell_checkers import checker, empty_scene
from pickcli.reachability.base_solids import base_solids, overlaps
from pickcli.reachability.place_pose_sampling import PlacePoseSampler
from pickcli.reachability.tool_pose_sampling import tool_poses
from pickcli.reachability.tool_reachability import ToolReachability, reach_ball
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.scene.solid_overlap import PosedSolid
from pickcli.seeds import derived_rng

ENOUGH = 0.85  # mean of the share of all tool poses and that of the worst place, which ends the search
SAME = 0.05  # by which a pose has to be better than one that was tried before
ROOM = 0.02  # m between what is placed and anything else that stands there

_TURNS = np.radians([0, 30, -30, 60, -60, 90, -90, 120, -120, 150, -150, 180])
_FROM_ABOVE = (0.4, 0.3, 0.5)  # distances of the middle, as shares of the arm's reach
_FROM_FRONT = (0.45, 0.55, 0.65)  # of the front face
_HEIGHTS = (0.0, 0.2, -0.2)  # of the middle over the arm's first joint, as shares of its reach
_N_POSES = 12  # tool poses in all places by which a pose is judged, with as many before them
_MOST_TRIED = 48
_N_LEAST = 2  # of these in each place
_N_SEEDS = 64


@dataclass(frozen=True, eq=False)
class PlacedCarrier:
    """Where something that holds items is best placed.

    Attributes:
        T_world_carrier: (4, 4).
        share: Share of the tool poses in it that the arm takes there; 0 where it reaches nothing anywhere.
        n_poses: Number of these.
        n_tried: Number of poses that were tried, those in which it would stand in something left out.
    """

    T_world_carrier: Array
    share: float
    n_poses: int
    n_tried: int


@dataclass(frozen=True, eq=False)
class PlaceSearch:
    """Seeks the pose of one carrier of a cell.

    Attributes:
        cell: The cell with everything that stands where it is to stay, and the carrier anywhere.
        carrier: The carrier.
        level: m that its frame is over the robot's base where both stand on one level; None where that is no
            pose of its own.
        keeps_free: (M, n) configurations that it must leave free.
        seed: Of tool poses and of inverse kinematics.

    Raises:
        InputError: The tool fits into one of its places nowhere.
    """

    cell: Cell
    carrier: Carrier
    level: float | None
    keeps_free: Array
    seed: int

    def best(self) -> PlacedCarrier:
        """The pose at which most tool poses are reached, also in the worst of its places.

        Of poses that are as good it is the first.

        Returns:
            The pose; of no use where nothing is reached.
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
            if now > worth + (SAME if worth else 0.0):
                best, worth = PlacedCarrier(T, float(shares.mean()), n_poses, n_tried), now
            if worth >= ENOUGH or n_tried == _MOST_TRIED:
                break
        return replace(best, n_tried=n_tried, n_poses=n_poses)

    def _poses(self) -> Iterator[Array]:
        """Poses (4, 4) that are tried: on the level of the base first, and there straight ahead first."""
        center, radius = reach_ball(self.cell.robot)
        away = _FROM_ABOVE if self._places[0].access.is_from_above else _FROM_FRONT
        for z in self._heights(float(center[2]), radius):
            for turn, share in product(_TURNS.tolist(), away):
                x, y = center[:2] + share * radius * np.array([np.cos(turn), np.sin(turn)])
                yield pose((x, y, z), rpy=(0.0, 0.0, turn))

    def _heights(self, center: float, radius: float) -> Iterator[float]:
        """Heights in m: on the level of the base, then its middle about that of the arm's first joint."""
        if self.level is not None:
            yield float(self.cell.robot.T_world_base[2, 3]) + self.level
        middles = [place.T_carrier_place[2, 3] + place.room.size[2] / 2 for place in self._places]
        for share in _HEIGHTS:
            yield center + share * radius - float(np.mean(middles))

    def _shares(self, T: Array, empty: SceneChecker) -> Array:
        """(P,) share of the tool poses of each place that the arm takes, the carrier at a pose (4, 4)."""
        robot = self.cell.robot
        reach = ToolReachability(
            self._arm, empty, robot.tool.default_state, self._seeds, *reach_ball(robot), self._seeds[:0]
        )
        return np.array([np.mean([reach.has(T @ T_tool) for T_tool in tools]) for tools in self._tools])

    def _checker_at(self, T: Array) -> SceneChecker | None:
        """The checker of the cell with the carrier at a pose (4, 4); None where something is in its way."""
        moved = replace(self.carrier, T_world_carrier=T)
        solids = [PosedSolid(body.shape.inflated(ROOM), T @ body.T_parent_shape) for body in moved.bodies]
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
        """(K, n) starting points of inverse kinematics, the same for all poses."""
        return self._arm.random_seeds(derived_rng(self.seed, "place", "seeds"), _N_SEEDS)

    @cached_property
    def _tools(self) -> list[Array]:
        """For each place of the carrier (N, 4, 4) tool poses in it and before its mouth, in its frame."""
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
        """Everything else that stands: the robot's base, and what is around it."""
        own = {body.name for body in self.carrier.bodies}
        around = empty_scene(self.cell).standing
        return [
            *base_solids(CollisionModel(self.cell)),
            *(PosedSolid(b.shape, T @ b.T_parent_shape) for b, T in around if b.name not in own),
        ]


def with_carrier(cell: Cell, carrier: Carrier) -> Cell:
    """A cell in which a carrier stands elsewhere.

    Args:
        cell: The cell.
        carrier: The carrier, where it is to stand.

    Returns:
        The cell, under its old fingerprint: nothing of it is to be stored.
    """
    if carrier.name == POD:
        return replace(cell, T_world_pod=carrier.T_world_carrier)
    own = tuple(carrier if each.name == carrier.name else each for each in cell.own_carriers)
    return replace(cell, own_carriers=own)
