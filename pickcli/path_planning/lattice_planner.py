"""Coarse motions of an arm by ARA* on the workspace lattice: the planner of the PR2 conveyor system of 2013.

All goals are one set, and the search chooses among them. Nothing is random, and effort is limited by
expansions: the same arguments give the same bytes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pickcli.collision.checker import SceneChecker
from pickcli.errors import InputError, Reason
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.motion.path import JointPath
from pickcli.path_planning.ara_star import AraStarPath, AraStarResult, AraStarSettings, ara_star
from pickcli.path_planning.lattice_cost import LatticeResolution
from pickcli.path_planning.shortcutting import shorten
from pickcli.path_planning.state_space import JointSpace
from pickcli.path_planning.workspace_lattice import POSE_SIZE, HandGoals, WorkspaceLattice

NO_PATH = "no path"


@dataclass(frozen=True)
class LatticePlannerSettings:
    """Settings of the planner.

    Attributes:
        search: Effort of the search.
        resolution: Steps and costs of the lattice.
    """

    search: AraStarSettings = field(default_factory=AraStarSettings)
    resolution: LatticeResolution = field(default_factory=LatticeResolution)


@dataclass(frozen=True, eq=False)
class LatticePlan:
    """A proven path to one of the goals.

    Attributes:
        path: The path, along the lattice.
        goal: Index of the goal in which it ends.
        found: What the search knew of the path after each of its rounds, the path's own last: its cost is the
            length of the path of the hand in m, with turns and redundant joints as the resolution counts
            them, and is proven to be at most ``found[-1].cost_bound`` times the least on the lattice.
        n_expanded: Expansions of the search.
    """

    path: JointPath
    goal: int
    found: tuple[AraStarPath, ...]
    n_expanded: int

    @property
    def cost(self) -> float:
        """Cost of the path, m."""
        return self.found[-1].cost

    @property
    def cost_bound(self) -> float:
        """The proven bound: the least cost on the lattice is at least the cost over this."""
        return self.found[-1].cost_bound

    @property
    def figures(self) -> dict[str, float]:
        """What the search knows of the path: its cost in m, the bound, and its expansions, by name."""
        return {
            "transit_cost_m": self.cost,
            "transit_cost_bound": self.cost_bound,
            "transit_expansions": float(self.n_expanded),
        }


def why_no_lattice(n_joints: int) -> str:
    """Say why there is no lattice of hand poses for an arm.

    Args:
        n_joints: Number of its joints.

    Returns:
        One clause; empty if there is one.
    """
    few = f"a lattice of hand poses needs an arm with {POSE_SIZE} joints at least, not {n_joints}"
    return few if n_joints < POSE_SIZE else ""


def plan_on_lattice(
    arm: Arm,
    checker: SceneChecker,
    q_start: Array,
    goals: HandGoals,
    settings: LatticePlannerSettings | None = None,
) -> LatticePlan | Reason:
    """Plan a proven path of the arm to any of several goals.

    Args:
        arm: The arm, of at least six joints.
        checker: Proves edges, in its tool state.
        q_start: (n,) start.
        goals: The goals, at least one; poses, or configurations in them.
        settings: Effort and lattice.

    Returns:
        The path; or why there is none: the start is not free, the expansions ran out, or no goal is connected
        to the start.

    Raises:
        InputError: The arm has fewer joints than a pose needs, or no goal is given.
    """
    if few := why_no_lattice(arm.n):
        raise InputError(few)
    if len(goals.T_world_tip) == 0:
        raise InputError("no goal is given")
    settings = settings or LatticePlannerSettings()
    q_start = np.asarray(q_start, dtype=float)
    if not (JointSpace.of(arm.robot).holds(q_start) and checker.is_valid(q_start)):
        return Reason(NO_PATH, "start", "it is not free, or beyond a limit")
    lattice = WorkspaceLattice(arm, checker, q_start, goals, settings.resolution)
    result = ara_star(lattice, settings.search)
    if result.best is None:
        return Reason(NO_PATH, detail=_why_none(result))
    waypoints, goal = lattice.configurations(result.best.nodes)
    return LatticePlan(JointPath(arm.names, waypoints), goal, result.paths, result.n_expanded)


def _why_none(result: AraStarResult) -> str:
    """Say why a search found no path."""
    if result.ran_out:
        return f"ARA* found none on its lattice in the {result.n_expanded} expansions that it may take"
    return (
        f"ARA* found none on its lattice: after {result.n_expanded} expansions no state is left that may "
        "lead to a goal, so more of them do not help"
    )


def shortcut_once(checker: SceneChecker, space: JointSpace, path: JointPath) -> JointPath:
    """Shorten a path in one pass that tries nothing at random: waypoints that are not needed are left out.

    Args:
        checker: Proves edges.
        space: Metric of the cost.
        path: A proven path.

    Returns:
        The path, proven.
    """
    return shorten(checker, space, path, seed=0, iterations=0)
