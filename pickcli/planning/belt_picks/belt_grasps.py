"""Grasps of an item on a belt with clearance for the tool, found once for wherever the belt takes it.

Relative to the belt, its items and the ways of the tool between them are the same everywhere. They are found
with the belt at one place and displaced along it. What stands in the hall is checked there, and where the
lines are tried, for the arm with the tool.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pickcli.cartesian.corridor import LiftPoses
from pickcli.cartesian.key_waypoints import PickPoses
from pickcli.errors import Failures
from pickcli.geometry import Array
from pickcli.grasping.search import Search
from pickcli.motion.plan import Grasp
from pickcli.planning.pick_motion import ToolLines
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.region_query import RegionSearch
from pickcli.planning.stages.extraction import CorridorSet
from pickcli.planning.stages.grasp_selection import candidates_of, ways_out_of
from pickcli.planning.stages.tool_clearance import tool_lines, with_room_beside, with_tool_clearance
from pickcli.seeds import derived_rng


@dataclass(frozen=True, eq=False)
class BeltGrasps:
    """Grasps with clearance for the tool, best first.

    Attributes:
        problem: The pick, with the belt where they were found.
        grasps: The grasps.
        ways_out: Displacements (K, 4, 4) of each way out for the target as a free flyer.
        failures: Reasons against others.
    """

    problem: PickProblem
    grasps: tuple[Grasp, ...]
    ways_out: tuple[Array, ...]
    failures: Failures

    @classmethod
    def of(
        cls, problem: PickProblem, search: Search | RegionSearch, corridors: CorridorSet, deviation: Array
    ) -> BeltGrasps:
        """Search the grasps of a pick.

        Args:
            problem: The pick, with the belt at a place at which no stationary thing is in the way.
            search: How candidates are found.
            corridors: Ways out that they choose from.
            deviation: (3,) m in the world, by which the belt may be ahead of the plan, or behind it.

        Returns:
            The grasps; none if the target cannot be taken at all.
        """
        rng = derived_rng(problem.seed, "grasps", problem.target.id)
        ways_out = ways_out_of(problem, corridors)
        if isinstance(ways_out, Failures):
            return cls(problem, (), (), ways_out)
        found = candidates_of(problem, search, corridors, rng)
        if isinstance(found, Failures):
            return cls(problem, (), ways_out, found)
        told = Failures(tuple(found.rejected))
        if not found.batches:
            return cls(problem, (), ways_out, told)
        grasps, against = with_tool_clearance(problem, found, ways_out)
        grasps, beside = with_room_beside(problem, grasps, deviation)
        return cls(problem, grasps, ways_out, told + against + beside)

    @cached_property
    def _lines(self) -> dict[int, ToolLines | Failures]:
        """Ways of the tool that were found, by index of the grasp."""
        return {}

    def contact(self, k: int) -> Array:
        """Return the pose of the tool at a grasp, with the belt where the grasps were found.

        Args:
            k: Index of the grasp.

        Returns:
            (4, 4) in the world.
        """
        return np.asarray(self.problem.target.T_world_item @ self.grasps[k].T_item_tip)

    def lines(self, k: int, problem: PickProblem) -> ToolLines | Failures:
        """Return the ways of the tool for a grasp, with the belt elsewhere.

        Args:
            k: Index of the grasp.
            problem: The pick, with the belt there.

        Returns:
            Ways in and out, displaced along the belt; or the obstacles.
        """
        if k not in self._lines:
            self._lines[k] = tool_lines(self.problem, self.grasps[k], self.ways_out)
        lines = self._lines[k]
        if isinstance(lines, Failures):
            return lines
        by = problem.target.T_world_item[:3, 3] - self.problem.target.T_world_item[:3, 3]
        modes = problem.context.method.modes(problem.contacts, lines.grasp, problem.context.model.tip_excess)
        inward = tuple(_displaced_in(poses, by) for poses in lines.inward)
        outward = tuple(_displaced_out(poses, by) for poses in lines.outward)
        return replace(lines, modes=modes, inward=inward, outward=outward)


def _displaced_in(poses: PickPoses, by: Array) -> PickPoses:
    """Return poses displaced by a vector (3,)."""
    given = poses.preapproach, poses.approach, poses.touch, poses.contact
    return PickPoses(*_displaced(given, by))


def _displaced_out(poses: LiftPoses, by: Array) -> LiftPoses:
    """Return poses displaced by a vector (3,)."""
    return LiftPoses.of(_displaced((poses.first_stretch, poses.lift, *poses.retreat), by))


def _displaced(poses: Sequence[Array], by: Array) -> Array:
    """Return poses (K, 4, 4) displaced by a vector (3,)."""
    moved = np.stack(poses)
    moved[:, :3, 3] += by
    return moved
