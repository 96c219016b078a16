"""Initial configurations of a new cell: states of an SRDF, and found ones for home, parking and places."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.configuration_text import DECIMALS
from pickcli.cell.robots.srdf import Srdf
from pickcli.collision.checker import SceneChecker
from pickcli.errors import Failures, InputError, NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.reachability.configuration_ranking import ConfigurationRanking
from pickcli.reachability.ranked_configuration import RankedConfiguration, RankingSettings
from pickcli.robot_setup.cell_text import SuggestedConfiguration
from pickcli.robot_setup.coarse_motions import CoarseMotions
from pickcli.seeds import derived_rng, derived_seed
from pickcli.verification.forward_kinematics import link_poses

HOME, PARKED = "home", "parked"
N_CANDIDATES = 2000
LIMIT_MARGIN = 0.05  # share of each joint's range that configurations keep from the limits
FLOOR_TOLERANCE = 1e-6  # m, tolerance of links below the floor of the base
N_TRIED = 8  # parking configurations to which a motion is searched
# Configurations at places are judged by fewer lines than apc suggest-configurations does, as there are many.
AT_PLACES = RankingSettings(n_places=40, n_kept=5, n_poses=12)
FEW, N_KEPT = 3, 12  # with at most this many places, this many configurations of each are rated
GOOD_REACH_SHARE = 0.75  # share of the best configuration's reach, from which another one is acceptable
PARKING_DISTANCE = 0.5  # rad or m of some joint, between home and parking configuration


def states_of_srdf(
    srdf: Srdf, cell: Cell, checker: SceneChecker
) -> tuple[list[SuggestedConfiguration], list[str]]:
    """Convert the named states of an SRDF to configurations of the planned chain.

    Args:
        srdf: The SRDF.
        cell: The cell.
        checker: Checker of the empty cell.

    Returns:
        The configurations, and why other states were left out.
    """
    robot, found, left_out = cell.robot, list[SuggestedConfiguration](), list[str]()
    for state in srdf.states:
        lacking = [name for name in robot.joint_names if name not in state.positions]
        if len(lacking) == robot.n_joints:
            continue  # state of another group
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
) -> tuple[list[SuggestedConfiguration], list[str]]:
    """Suggest home and parking configurations if missing: free, away from limits, connected by a motion.

    Home has the largest manipulability of all samples (Yoshikawa) and motions to the places; in the parking
    configuration the arm is close to its base, or, if no motion leads there, it is near home. Both are
    searched above the base first, as most robots stand on something, and where coarse motions may begin:
    these keep more than the clearance.

    Args:
        cell: The cell.
        checker: Checker of the empty cell.
        known: Known configurations.
        seed: Seed of the samples.
        places: For each place (M, n) configurations in front of it.

    Returns:
        The missing configurations, fewer if no free ones were found; and advice if no motion leads from home
        to any parking configuration.
    """
    names = {each.name: np.array(each.q) for each in known}
    drawn, motions = samples(cell, seed), CoarseMotions(cell)
    Q = _free(motions.checker, drawn)
    Q = Q if len(Q) else _free(checker, drawn)
    if not len(Q):
        return [], []
    origins = link_poses(cell.robot, Q)[:, :, :3, 3]
    above = origins[..., 2].min(axis=0) >= cell.robot.T_world_base[2, 3] - FLOOR_TOLERANCE
    Q, origins = (Q[above], origins[:, above]) if above.any() else (Q, origins)
    arm, state, found = Arm(cell.robot), cell.robot.tool.default_state, []
    if HOME not in names:
        best = np.argsort([-arm.manipulability(q, state) for q in Q], kind="stable")
        names[HOME] = _most_central(motions, Q[best[:N_TRIED]], places, seed)
        found.append(SuggestedConfiguration(HOME, HOME, tuple(names[HOME]), "found: moves its tool well"))
    if PARKED in names:
        return found, []
    reach = np.linalg.norm(origins - cell.robot.T_world_base[:3, 3], axis=2).max(axis=0)
    parked = _parked(motions, names[HOME], Q[np.argsort(reach, kind="stable")], seed)
    if isinstance(parked, SuggestedConfiguration):
        return [*found, parked], []
    return found, [f"configurations: {parked}; add the one in which the arm is parked, as {PARKED}"]


def rank_at_places(cell: Cell, seed: int) -> tuple[dict[str, list[RankedConfiguration]], list[str]]:
    """Rank configurations in front of every place by their reach.

    Args:
        cell: The cell.
        seed: Of all samples.

    Returns:
        By place the configurations that reach nearly as much as the best, the best first; and advice for
        every place without a configuration, or with one that reaches nothing.
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
            reason = f"from its configuration a straight line leads to no tool pose in {name}"
            unreached.append(f"{key}: {reason}{mend}")
        found[name] = [each for each in ranked if each.reach >= GOOD_REACH_SHARE * ranked[0].reach]
    return found, unreached


def choose_at_places(
    cell: Cell, ranked: Mapping[str, Sequence[RankedConfiguration]], home: Array | None, seed: int
) -> tuple[list[SuggestedConfiguration], list[str]]:
    """Choose the configuration of every place that is reached fastest from home.

    Args:
        cell: The cell.
        ranked: By place, the best first.
        home: (n,) start of the motions; None without a home configuration.
        seed: Seed of the search for motions.

    Returns:
        The configurations; and advice for every place without a motion from home.
    """
    chosen, unreached, motions = list[SuggestedConfiguration](), list[str](), CoarseMotions(cell)
    for name, candidates in ranked.items():
        goals, best = np.stack([each.configuration.q for each in candidates]), candidates[0]
        way = None if home is None else motions.find(home, goals, derived_seed(seed, name))
        if isinstance(way, Failures):
            why = NoPlanError(f"a motion from home to {name}", way.reasons)
            unreached.append(f"configurations: {why}; add one that is midway, or move the place")
        elif way is not None:
            best = candidates[way.goal]
        comment = (
            f"found: straight lines lead to {best.reach:.0%} of {AT_PLACES.n_poses} tool poses in {name}"
        )
        chosen.append(SuggestedConfiguration(name, "bin", tuple(best.configuration.q), comment))
    return chosen, unreached


def samples(cell: Cell, seed: int) -> Array:
    """Draw configurations with each joint away from its limits, and within half a turn of 0 if possible.

    Args:
        cell: The cell.
        seed: Seed of the samples.

    Returns:
        (N, n) configurations, free or not.
    """
    (low, high), rng = cell.robot.limits.window, derived_rng(seed, "suggested configurations")
    turns = np.array([unit == "rad" for unit in cell.robot.units]) & (low < np.pi) & (high > -np.pi)
    lower = np.where(turns, np.maximum(low, -np.pi), low)
    upper = np.where(turns, np.minimum(high, np.pi), high)
    margin = LIMIT_MARGIN * (upper - lower)
    size = (N_CANDIDATES, len(lower))
    return np.asarray(rng.uniform(lower + margin, upper - margin, size=size).round(DECIMALS))


def _free(checker: SceneChecker, Q: Array) -> Array:
    """The configurations (F, n) of Q (N, n) that are free."""
    return np.array([q for q in Q if checker.is_valid(q)])


def _parked(
    motions: CoarseMotions, home: Array, candidates: Array, seed: int
) -> SuggestedConfiguration | NoPlanError:
    """First of configurations (N, n) with a motion from home; else the nearest to home with one."""
    away = candidates[np.abs(candidates - home).max(axis=1) >= PARKING_DISTANCE]
    near = away[np.argsort(np.abs(away - home).max(axis=1), kind="stable")]
    reasons = list[Reason]()
    for source, tried in (("the arm near its base", away), ("a motion leads there from home", near)):
        for k, q in enumerate(tried[:N_TRIED]):
            way = motions.find(home, q[None], derived_seed(seed, f"parked {k}"))
            if not isinstance(way, Failures):
                return SuggestedConfiguration(PARKED, "midway", tuple(q), f"found: {source}")
            reasons += way.reasons
    if not len(away):
        reasons.append(Reason("no candidate", HOME, "no other free configuration was found"))
    return NoPlanError(f"a motion from home to any of {2 * min(N_TRIED, len(away))} configurations", reasons)


def _most_central(motions: CoarseMotions, candidates: Array, places: Sequence[Array], seed: int) -> Array:
    """The configuration (n,) with motions to most of the tried places; the first if equal.

    For each place a motion to any of several configurations (M, n) counts.
    """
    n_reached = []
    for k, q in enumerate(candidates if places else candidates[:1]):
        ways = [motions.find(q, goals, derived_seed(seed, f"home {k}")) for goals in places[:N_TRIED]]
        n_reached.append(sum(not isinstance(way, Failures) for way in ways))
        if n_reached[-1] == len(ways):
            break
    return np.asarray(candidates[int(np.argmax(n_reached))])


def _ranked_at(cell: Cell, place: str, seed: int) -> list[RankedConfiguration]:
    """Ranked configurations of a place, the best first. Raises NoPlanError."""
    settings = replace(AT_PLACES, seed=seed)
    if len(cell.places) <= FEW:
        settings = replace(settings, n_kept=N_KEPT)
    return ConfigurationRanking(cell, place, cell.robot.tool.default_state, settings).suggest(N_TRIED)


def _plain(name: str, taken: Sequence[str]) -> str:
    """Convert to a valid unique name: letters, digits and _, beginning with a letter."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    plain = plain if re.match("[A-Za-z]", plain) else f"state_{plain}"
    return next(n for n in (plain, *(f"{plain}_{k}" for k in range(2, len(taken) + 3))) if n not in taken)
