"""Ranking of base poses of a robot by the share of tool poses that it reaches from them.

Tool poses are sampled once; for every base pose inverse kinematics and the collision checker decide which of
them are reached. Zacharias, Sepp, Borst and Hirzinger (2009) place a robot by a map of its reachable poses
instead, which does not consider obstacles.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError, NoPlanError, Reason
from pickcli.geometry import Array, pose, rotation_rpy, to_rpy
from pickcli.kinematics.arm import Arm
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.reachability.base_solids import base_solids, overlaps
from pickcli.reachability.tool_reachability import ROUNDS, TURNS, ToolReachability, reach_ball
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.scene.scene import empty_scene
from pickcli.scene.solid_overlap import PosedSolid
from pickcli.seeds import derived_rng

AXES = ("x", "y", "z", "yaw")
DECIMALS = 4  # of a base pose in a cell file

_N_SEEDS = 4  # starting points of inverse kinematics for each turn about the tip's axis, per round


@dataclass(frozen=True)
class MountGrid:
    """Grid of base poses: every combination of evenly spaced values.

    Attributes:
        bounds: Least and greatest x, y, z in m and yaw in rad, by axis, in the world.
        steps: Number of values between the bounds, by axis.
    """

    bounds: Mapping[str, tuple[float, float]]
    steps: Mapping[str, int]

    def poses(self, T_world_base: Array) -> Iterator[Array]:
        """Yield the base poses, with the current roll and pitch.

        Args:
            T_world_base: (4, 4) current pose of the base.

        Yields:
            (4, 4) each.
        """
        roll, pitch, _ = to_rpy(T_world_base[:3, :3])
        for x, y, z, yaw in product(*(self._values(axis) for axis in AXES)):
            yield pose((x, y, z), R=rotation_rpy(roll, pitch, yaw))

    def _values(self, axis: str) -> Array:
        """Return the values of one axis; a single one is in the middle."""
        (low, high), n = self.bounds[axis], self.steps[axis]
        values = np.linspace(low, high, n) if n > 1 else np.array([(low + high) / 2])
        return np.unique(values.round(DECIMALS))


@dataclass(frozen=True)
class MountSettings:
    """Settings of the ranking of base poses.

    Attributes:
        n_first: Tool poses of each place by which all base poses are judged.
        n_poses: Tool poses of each place by which the best of them are judged again.
        n_finalists: Number of these, at least.
        seed: Seed of all random choices.
    """

    n_first: int = 4
    n_poses: int = 40
    n_finalists: int = 10
    seed: int = 0


@dataclass(frozen=True, eq=False)
class RankedMount:
    """A base pose and its reachability.

    Attributes:
        T_world_base: (4, 4).
        shares: Share of the tool poses that are reached, by the name of their group.
    """

    T_world_base: Array
    shares: Mapping[str, float]

    @property
    def share(self) -> float:
        """Mean of the shares: every place counts the same."""
        return float(np.mean(list(self.shares.values())))

    @property
    def worth(self) -> tuple[float, float]:
        """Key of the ranking: the mean share, then that of the worst place."""
        return self.share, min(self.shares.values())


@dataclass(frozen=True, eq=False)
class MountRanking:
    """Ranks base poses of a cell's robot.

    Attributes:
        cell: The cell, without items.
        targets: Poses (N, 4, 4) of the tool frame in the world that should be reached, by the name of their
            group; all base poses are judged by the first of each.
        tool_state: State of the tool.
        settings: Settings of the ranking.

    Raises:
        InputError: There are no poses to reach.
    """

    cell: Cell
    targets: Mapping[str, Array]
    tool_state: ToolState
    settings: MountSettings

    def __post_init__(self) -> None:
        if not self.targets:
            raise InputError("nothing to reach: the cell has no places; state poses of the tool")

    def suggest(self, grid: MountGrid, n: int, on_progress: ProgressObserver = nobody) -> list[RankedMount]:
        """Return the best base poses of a grid. Repeatable by seed.

        Args:
            grid: The base poses.
            n: Most base poses to return.
            on_progress: Observer of the progress, called for each base pose.

        Returns:
            At most n, the best first.

        Raises:
            NoPlanError: No base pose reaches anything, or the base would collide.
        """
        poses = list(grid.poses(self.cell.robot.T_world_base))
        first, refused = list[RankedMount](), list[Reason]()
        for i, T_world_base in enumerate(poses):
            on_progress(Progress(i, len(poses), f"base pose {i + 1}"))
            if stood_in := self._stood_in(T_world_base) - self._stood_in_now:
                refused.append(Reason("collision", "base", f"stands in {min(stood_in)}"))
                continue
            first.append(self.judged(T_world_base, self.settings.n_first))
        best = sorted(first, key=lambda each: each.worth, reverse=True)[: max(n, self.settings.n_finalists)]
        judged = [self.judged(each.T_world_base, self.settings.n_poses) for each in best if each.share > 0.0]
        if not judged:
            unreached = [Reason("no IK solution", "base", "reaches nothing")] * len(first)
            raise NoPlanError("a base pose", [*refused, *unreached])
        return sorted(judged, key=lambda each: each.worth, reverse=True)[:n]

    def judged(self, T_world_base: Array, n_poses: int) -> RankedMount:
        """Judge one base pose.

        Args:
            T_world_base: (4, 4).
            n_poses: Tool poses of each place, at most.

        Returns:
            The base pose with its reachability.
        """
        cell = mounted(self.cell, T_world_base)
        empty = checker(CollisionModel(cell), self.tool_state, PayloadClass.EMPTY)
        reach = ToolReachability(
            Arm(cell.robot), empty, self.tool_state, self._seeds, *reach_ball(cell.robot), self._seeds[:0]
        )
        return RankedMount(
            T_world_base,
            {
                name: float(np.mean([reach.has(T) for T in poses[:n_poses]]))
                for name, poses in self.targets.items()
            },
        )

    @cached_property
    def _seeds(self) -> Array:
        """(K, n) starting points of inverse kinematics, the same for all base poses."""
        rng = derived_rng(self.settings.seed, "mount", "seeds")
        return Arm(self.cell.robot).random_seeds(rng, ROUNDS * len(TURNS) * _N_SEEDS)

    @cached_property
    def _stood_in_now(self) -> frozenset[str]:
        return self._stood_in(self.cell.robot.T_world_base)

    def _stood_in(self, T_world_base: Array) -> frozenset[str]:
        """Return names of the bodies that the fixed part of the robot would overlap.

        Bodies that it overlaps now, like its pedestal or the beam of its rail, it may overlap at any base
        pose.
        """
        cell = mounted(self.cell, T_world_base)
        base = base_solids(CollisionModel(cell))
        return frozenset(
            body.name
            for body, T_world_parent in empty_scene(cell).standing
            if any(
                overlaps(solid, PosedSolid(body.shape, T_world_parent @ body.T_parent_shape))
                for solid in base
            )
        )


def mounted(cell: Cell, T_world_base: Array) -> Cell:
    """Return a cell with its robot at another base pose.

    Args:
        cell: The cell.
        T_world_base: (4, 4) pose of the robot's root link.

    Returns:
        The cell, with its old fingerprint: results for it must not be stored.
    """
    return replace(cell, robot=replace(cell.robot, T_world_base=T_world_base))
