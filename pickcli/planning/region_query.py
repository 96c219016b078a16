"""Region query: configurations in an envelope of grasps that are near to where the arm stands.

Instead of a choice among given grasps, solutions of inverse kinematics for poses of the envelope are
projected onto what of it is nearest in joint space. Source of the envelope: Krug et al., RA-L 2016, section
III-A; of goal regions: Berenson, Srinivasa and Kuffner, "Task Space Regions", IJRR 2011.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.tool import ToolState
from pickcli.collision.motion_validator import MotionValidator
from pickcli.geometry import Array
from pickcli.grasping.envelope import Envelope
from pickcli.kinematics.arm import Arm, ToolGoal
from pickcli.motion.path import JointPath
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.shortcutting import shorten
from pickcli.path_planning.state_space import JointSpace

SEEDS_PER_POSE = 2  # configurations from which inverse kinematics starts
MOST_ITERATIONS = 15  # of a projection: in 40 they come nearer by less than a hundredth


@dataclass(frozen=True)
class RegionSearch:
    """How much is tried.

    Attributes:
        n_poses: Of each envelope, whose room for the tool is checked.
        n_seeds: Of those with room, to which inverse kinematics is applied.
    """

    n_poses: int
    n_seeds: int


SEARCHES = (
    RegionSearch(48, 6),
    RegionSearch(200, 12),
    RegionSearch(1000, 60),
    RegionSearch(4000, 1000),
)  # one after the other, until a motion is found


@dataclass(frozen=True, eq=False)
class RegionProblem:
    """What a region query asks.

    Attributes:
        envelopes: Of which any will do.
        T_world_object: (4, 4) pose of the object.
        tool_state: State of the tool in the envelope.
        start: (n,) configuration to which the answers are to be near.
    """

    envelopes: Sequence[Envelope]
    T_world_object: Array
    tool_state: ToolState
    start: Array


@dataclass(frozen=True, eq=False)
class RegionGoals:
    """Configurations in envelopes.

    Attributes:
        Q: (G, n) free configurations, the nearest to the start first.
        envelope: (G,) index of the envelope that each is in.
    """

    Q: Array
    envelope: Array


@dataclass(frozen=True, eq=False)
class RegionChecks:
    """What checks configurations in envelopes.

    Attributes:
        has_room: Tells (N,) for poses (N, 4, 4) of the tool in the world whether it has room there without
            the arm, before inverse kinematics.
        arm: The whole arm.
    """

    has_room: Callable[[Array], NDArray[np.bool_]]
    arm: MotionValidator


def plan_to_region(
    arm: Arm, space: JointSpace, problem: RegionProblem, checks: RegionChecks, seed: int
) -> JointPath | None:
    """Plan a proven path from the start into any envelope.

    The straight line to the nearest configuration that has a proven one is taken, else a path by sampling;
    where neither leads to any of a few configurations, more of them are sought.

    Args:
        arm: The arm.
        space: Its joints within their limits.
        problem: What is asked.
        checks: What checks configurations.
        seed: Seed of all random choices.

    Returns:
        The path; None if no search finds one.
    """
    rng = np.random.default_rng(seed)
    for search in SEARCHES:
        goals = region_query(arm, problem, checks, rng, search)
        if len(goals.Q) == 0:
            continue
        path = plan(checks.arm, space, problem.start, goals.Q, seed=seed)
        if path is not None:
            return shorten(checks.arm, space, path, seed=seed)
    return None


def region_query(
    arm: Arm,
    problem: RegionProblem,
    checks: RegionChecks,
    rng: np.random.Generator,
    search: RegionSearch = SEARCHES[0],
) -> RegionGoals:
    """Find free configurations in envelopes, near to a start.

    Args:
        arm: The arm.
        problem: What is asked.
        checks: What checks configurations.
        rng: Source of the sampled poses and seeds.
        search: How much is tried.

    Returns:
        Projections, and solutions of inverse kinematics whose projections are not free; none if no pose of
        the envelopes has room, is reached, or is free.
    """
    goals, of_envelope = [np.empty((0, arm.n))], [np.empty(0, dtype=int)]
    for k, envelope in enumerate(problem.envelopes):
        seeds = _seeds(arm, envelope, problem, checks, rng, search)
        if len(seeds) == 0:
            continue
        goal = ToolGoal(envelope.constraints, problem.T_world_object, envelope.T_tip_palm)
        projected, _ = arm.nearest(goal, problem.tool_state, seeds, problem.start, MOST_ITERATIONS)
        candidates = np.concatenate([projected, seeds])
        goals.append(candidates[checks.arm.are_valid(candidates)])
        of_envelope.append(np.full(len(goals[-1]), k))
    Q, envelopes = np.concatenate(goals), np.concatenate(of_envelope)
    order = np.argsort(np.linalg.norm((Q - problem.start) * np.sqrt(arm.weights), axis=1), kind="stable")
    return RegionGoals(Q[order], envelopes[order])


def _seeds(
    arm: Arm,
    envelope: Envelope,
    problem: RegionProblem,
    checks: RegionChecks,
    rng: np.random.Generator,
    search: RegionSearch,
) -> Array:
    """Return configurations (K, n) for poses of an envelope at which the tool has room."""
    T = problem.T_world_object @ envelope.sample(rng, search.n_poses)
    with_room = T[checks.has_room(T)][: search.n_seeds]
    found = [np.empty((0, arm.n))]
    for pose in with_room:
        seeds = np.vstack([problem.start, arm.random_seeds(rng, SEEDS_PER_POSE - 1)])
        found.append(arm.solve(pose, problem.tool_state, seeds))
    return np.concatenate(found)
