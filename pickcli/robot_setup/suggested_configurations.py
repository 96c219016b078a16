"""Configurations that a new cell begins with: the named states of an SRDF, and two that are found."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.configuration_text import DECIMALS
from pickcli.cell.robots.srdf import Srdf
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import Failures, InputError, NoPlanError
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.planning.planning_context import RESERVE, PlanningContext
from pickcli.planning.stages.transit import CoarsePath, plan_coarse
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.reachability.configuration_ranking import ConfigurationRanking
from pickcli.reachability.ranked_configuration import RankedConfiguration, RankingSettings
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.robot_setup.cell_text import SuggestedConfiguration
from pickcli.seeds import derived_rng, derived_seed
from pickcli.verification.forward_kinematics import link_poses

HOME, PARKED = "home", "parked"
N_CANDIDATES = 2000
MARGIN = 0.05  # of each joint's range, that it keeps from the limits
LEVEL = 1e-6  # m by which what stands on the floor of the base may be below it
N_TRIED = 8  # configurations to be parked in, to which a motion is looked for
# Configurations at places are judged by fewer lines than apc suggest-configurations does, as there are many.
AT_PLACES = RankingSettings(n_places=40, n_kept=5, n_poses=12)
FEW, N_KEPT = 3, 12  # places, and how many configurations of each are judged where there are no more
NEARLY = 0.75  # of the reach of the best, from which another one will do as well
APART = 0.5  # rad or m of some joint, between home and where the arm is parked


def states_of_srdf(
    srdf: Srdf, cell: Cell, checker: SceneChecker
) -> tuple[list[SuggestedConfiguration], list[str]]:
    """The named states of an SRDF that are configurations of the planned chain.

    Args:
        srdf: The SRDF.
        cell: The cell.
        checker: Of the cell with nothing in it.

    Returns:
        The configurations; and why every other state was left out.
    """
    robot, found, left_out = cell.robot, list[SuggestedConfiguration](), list[str]()
    for state in srdf.states:
        lacking = [name for name in robot.joint_names if name not in state.positions]
        if len(lacking) == robot.n_joints:
            continue  # of another group
        q = np.array([state.positions.get(name, 0.0) for name in robot.joint_names])
        name = _plain(state.name, [each.name for each in found])
        if lacking:
            left_out.append(f"state {state.name} says nothing of {', '.join(lacking)}")
        elif (out := np.flatnonzero((q < robot.limits.lower) | (q > robot.limits.upper))).size:
            left_out.append(f"state {state.name} is beyond the limits of {robot.joint_names[out[0]]}")
        elif not checker.is_valid(q):
            left_out.append(f"state {state.name} is not free: {checker.explain(q)}")
        else:
            kind = HOME if name == HOME else "midway"
            found.append(SuggestedConfiguration(name, kind, tuple(q), f"state {state.name} of the SRDF"))
    return found, left_out


def suggest(
    cell: Cell,
    checker: SceneChecker,
    known: Sequence[SuggestedConfiguration],
    seed: int,
    places: Sequence[Array] = (),
) -> list[SuggestedConfiguration]:
    """Suggest home and parked where the SRDF has none: free, away from limits, and with a way between them.

    Home moves its tool best of what was sampled (Yoshikawa) and has motions to the places; parked keeps the
    arm nearest to its base. Both are sought above the base first, as most robots stand on something.

    Args:
        cell: The cell.
        checker: Of the cell with nothing in it.
        known: Configurations that there are.
        seed: Of the samples.
        places: For each place (M, n) configurations in front of it.

    Returns:
        What is missing of the two; less where nothing free was found.
    """
    names = {each.name: np.array(each.q) for each in known}
    Q = np.array([q for q in samples(cell, seed) if checker.is_valid(q)])
    if not len(Q):
        return []
    origins = link_poses(cell.robot, Q)[:, :, :3, 3]
    above = origins[..., 2].min(axis=0) >= cell.robot.T_world_base[2, 3] - LEVEL
    Q, origins = (Q[above], origins[:, above]) if above.any() else (Q, origins)
    arm, state, found = Arm(cell.robot), cell.robot.tool.default_state, []
    if HOME not in names:
        best = np.argsort([-arm.manipulability(q, state) for q in Q], kind="stable")
        names[HOME] = _most_central(cell, Q[best[:N_TRIED]], places, seed)
        found.append(SuggestedConfiguration(HOME, HOME, tuple(names[HOME]), "found: moves its tool well"))
    if PARKED not in names:
        reach = np.linalg.norm(origins - cell.robot.T_world_base[:3, 3], axis=2).max(axis=0)
        parked = _reached(cell, names[HOME], Q[np.argsort(reach, kind="stable")], seed)
        if parked is not None:
            found.append(
                SuggestedConfiguration(PARKED, "midway", tuple(parked), "found: the arm near its base")
            )
    return found


def rank_at_places(cell: Cell, seed: int) -> tuple[dict[str, list[RankedConfiguration]], list[str]]:
    """Rank configurations in front of every place, over what is reached from above.

    Args:
        cell: The cell.
        seed: Of all samples.

    Returns:
        By place those that reach nearly as much as the best, the best first; and of every place without one,
        or into which nothing is reached from it, what is to be done.
    """
    found, unreached = dict[str, list[RankedConfiguration]](), list[str]()
    for name, place in cell.places.items():
        key = "pod" if name in cell.pod.bins else f"places.{place.carrier}"
        mend = f"; move it, or the base, then add what apc suggest-configurations --bin {name} finds"
        try:
            ranked = _ranked_at(cell, name, seed)
        except (NoPlanError, InputError) as error:
            unreached.append(f"{key}: {error}{mend}")
            continue
        if not ranked[0].reach:
            told = f"from its configuration a straight line leads to no tool pose in {name}"
            unreached.append(f"{key}: {told}{mend}")
        found[name] = [each for each in ranked if each.reach >= NEARLY * ranked[0].reach]
    return found, unreached


def choose_at_places(
    cell: Cell, ranked: Mapping[str, Sequence[RankedConfiguration]], home: Array | None, seed: int
) -> tuple[list[SuggestedConfiguration], list[str]]:
    """Choose the configuration at every place: the one that is reached from home the fastest.

    Args:
        cell: The cell.
        ranked: By place, the best first.
        home: (n,) where motions begin; None where there is no such configuration.
        seed: Of the search for motions.

    Returns:
        The configurations; and of every place to which no motion from home is found, what is to be done.
    """
    chosen, unreached = list[SuggestedConfiguration](), list[str]()
    for name, candidates in ranked.items():
        goals, best = np.stack([each.configuration.q for each in candidates]), candidates[0]
        way = None if home is None else _motion(cell, home, goals, derived_seed(seed, name))
        if isinstance(way, Failures):
            why = NoPlanError(f"a motion from home to {name}", way.reasons)
            unreached.append(f"configurations: {why}; add one that is midway, or move the place")
        elif way is not None:
            best = candidates[way.goal]
        told = f"found: straight lines lead to {best.reach:.0%} of {AT_PLACES.n_poses} tool poses in {name}"
        chosen.append(SuggestedConfiguration(name, "bin", tuple(best.configuration.q), told))
    return chosen, unreached


def samples(cell: Cell, seed: int) -> Array:
    """Draw configurations, each joint away from its limits and within half a turn of 0 where that may be.

    Args:
        cell: The cell.
        seed: Of the draws.

    Returns:
        (N, n) configurations, free or not.
    """
    (low, high), rng = cell.robot.limits.window, derived_rng(seed, "suggested configurations")
    turns = np.array([unit == "rad" for unit in cell.robot.units]) & (low < np.pi) & (high > -np.pi)
    lower = np.where(turns, np.maximum(low, -np.pi), low)
    upper = np.where(turns, np.minimum(high, np.pi), high)
    margin = MARGIN * (upper - lower)
    size = (N_CANDIDATES, len(lower))
    return np.asarray(rng.uniform(lower + margin, upper - margin, size=size).round(DECIMALS))


def _reached(cell: Cell, home: Array, candidates: Array, seed: int) -> Array | None:
    """The first of configurations (N, n) to which a motion is found from home; None if there is none."""
    away = candidates[np.abs(candidates - home).max(axis=1) >= APART]
    for k, q in enumerate(away[:N_TRIED]):
        if not isinstance(_motion(cell, home, q[None], derived_seed(seed, f"parked {k}")), Failures):
            return np.asarray(q)
    return None


def _most_central(cell: Cell, candidates: Array, places: Sequence[Array], seed: int) -> Array:
    """The first of configurations (N, n) with motions to the most places, of which some are tried.

    Of each place any of several configurations (M, n) will do.
    """
    n_reached = []
    for k, q in enumerate(candidates if places else candidates[:1]):
        ways = [_motion(cell, q, goals, derived_seed(seed, f"home {k}")) for goals in places[:N_TRIED]]
        n_reached.append(sum(not isinstance(way, Failures) for way in ways))
        if n_reached[-1] == len(ways):
            break
    return np.asarray(candidates[int(np.argmax(n_reached))])


def _motion(cell: Cell, home: Array, goals: Array, seed: int) -> CoarsePath | Failures:
    """A coarse motion of the empty tool from home to any of several configurations (G, n), or why none."""
    empty = checker(CollisionModel(cell), cell.robot.tool.default_state, PayloadClass.EMPTY, RESERVE)
    return plan_coarse(PlanningContext(cell), empty, home, goals, [0.0] * len(goals), seed, "from home")


def _ranked_at(cell: Cell, place: str, seed: int) -> list[RankedConfiguration]:
    """The configurations at a place, the best first. Raises NoPlanError."""
    settings = replace(AT_PLACES, seed=seed)
    if len(cell.places) <= FEW:
        settings = replace(settings, n_kept=N_KEPT)
    return ConfigurationRanking(cell, place, cell.robot.tool.default_state, settings).suggest(N_TRIED)


def _plain(name: str, taken: Sequence[str]) -> str:
    """A name as cells have it: letters, digits and _, a letter first, and unique."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    plain = plain if re.match("[A-Za-z]", plain) else f"state_{plain}"
    return next(n for n in (plain, *(f"{plain}_{k}" for k in range(2, len(taken) + 3))) if n not in taken)
