"""Configurations that a new cell begins with: the named states of an SRDF, and two that are found."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.configuration_text import DECIMALS
from pickcli.cell.srdf import Srdf
from pickcli.collision.checker import SceneChecker
from pickcli.errors import Failures, InputError, NoPlanError
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.transit import plan_coarse
from pickcli.precompute.empty_cell_checkers import RESERVE
from pickcli.reachability.configuration_ranking import ConfigurationRanking
from pickcli.reachability.ranked_configuration import RankedConfiguration, RankingSettings
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
        The configurations; and of every other state why it is none.
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
    cell: Cell, checker: SceneChecker, known: Sequence[SuggestedConfiguration], seed: int
) -> list[SuggestedConfiguration]:
    """Suggest home and parked where the SRDF has none: free, away from limits, and with a way between them.

    Home moves its tool best of what was sampled (Yoshikawa), parked keeps the arm nearest to its base. Both
    are sought above the base first, as most robots stand on something.

    Args:
        cell: The cell.
        checker: Of the cell with nothing in it.
        known: Configurations that there are.
        seed: Of the samples.

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
        names[HOME] = Q[np.argmax([arm.manipulability(q, state) for q in Q])]
        found.append(SuggestedConfiguration(HOME, HOME, tuple(names[HOME]), "found: moves its tool well"))
    if PARKED not in names:
        reach = np.linalg.norm(origins - cell.robot.T_world_base[:3, 3], axis=2).max(axis=0)
        parked = _reached(cell, checker, names[HOME], Q[np.argsort(reach, kind="stable")], seed)
        if parked is not None:
            found.append(
                SuggestedConfiguration(PARKED, "midway", tuple(parked), "found: the arm near its base")
            )
    return found


def configurations_at_places(cell: Cell, seed: int) -> tuple[list[SuggestedConfiguration], list[str]]:
    """Find a configuration in front of every place, over what is reached from above.

    Args:
        cell: The cell.
        seed: Of all samples.

    Returns:
        The configurations, by reach and manipulability; and of every place without one, or into which
        nothing is reached from it, what is to be done.
    """
    found, unreached = list[SuggestedConfiguration](), list[str]()
    for name, place in cell.places.items():
        key = "pod" if name in cell.pod.bins else f"places.{place.carrier}"
        mend = f"; move it, or the base, then add what apc suggest-configurations --bin {name} finds"
        try:
            best = _best_at(cell, name, seed)
        except (NoPlanError, InputError) as error:
            unreached.append(f"{key}: {error}{mend}")
            continue
        share = f"{best.reach:.0%} of {AT_PLACES.n_poses} tool poses in {name}"
        if not best.reach:
            unreached.append(f"{key}: from its configuration a straight line leads to {share}{mend}")
        told = f"found: straight lines lead to {share}"
        found.append(SuggestedConfiguration(name, "bin", tuple(best.configuration.q), told))
    return found, unreached


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
    lower, upper = (
        np.where(turns, np.maximum(low, -np.pi), low),
        np.where(turns, np.minimum(high, np.pi), high),
    )
    margin = MARGIN * (upper - lower)
    size = (N_CANDIDATES, len(lower))
    return np.asarray(rng.uniform(lower + margin, upper - margin, size=size).round(DECIMALS))


def _reached(cell: Cell, checker: SceneChecker, home: Array, candidates: Array, seed: int) -> Array | None:
    """The first of configurations (N, n) to which a motion is found from home; None if there is none."""
    context = PlanningContext(cell)
    away = candidates[np.abs(candidates - home).max(axis=1) >= APART]
    for k, q in enumerate(away[:N_TRIED]):
        coarse = plan_coarse(
            context, checker, home, q[None], [0.0], derived_seed(seed, f"parked {k}"), "parked"
        )
        if not isinstance(coarse, Failures):
            return np.asarray(q)
    return None


def _best_at(cell: Cell, place: str, seed: int) -> RankedConfiguration:
    """The best configuration at a place. Raises NoPlanError.

    It keeps farther from everything than it has to, where it can: some links are never that far apart.
    """
    roomy = replace(AT_PLACES, seed=seed)
    close = replace(roomy, clearance=cell.clearance + RESERVE)
    state = cell.robot.tool.default_state
    try:
        (best,) = ConfigurationRanking(cell, place, state, roomy).suggest(1)
    except NoPlanError:
        (best,) = ConfigurationRanking(cell, place, state, close).suggest(1)
    return best


def _plain(name: str, taken: Sequence[str]) -> str:
    """A name as cells have it: letters, digits and _, a letter first, and unique."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    plain = plain if re.match("[A-Za-z]", plain) else f"state_{plain}"
    return next(n for n in (plain, *(f"{plain}_{k}" for k in range(2, len(taken) + 3))) if n not in taken)
