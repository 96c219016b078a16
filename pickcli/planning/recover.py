"""A safe way out from wherever a motion stopped: out of the bin along its axis, then home.

Delft's and KTH's systems start over from a place in front of the shelf; a robot that stopped on a proven
path gets there by lines and coarse motions that are proven again, for the tool as it is now.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from pickcli.cartesian.follow import follow_line
from pickcli.cartesian.keyposes import PREAPPROACH_DISTANCE
from pickcli.cartesian.line import shifted
from pickcli.cell.scene import Scene
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.assemble import assemble_pieces
from pickcli.planning.coarse import plan_coarse
from pickcli.planning.context import Planner
from pickcli.planning.pick import Start
from pickcli.planning.pieces import COARSE_BLEND, Piece
from pickcli.seeds import derived_seed

SAFE = "home"

# m up, or back along the tool, in which the cup may still touch what it touches. Up over what it lies on is
# the shortest; a cup that came from the side would scrape along.
FIRST_UP = (0.02,)
FIRST_BACK = (0.02, 0.04)

RISES = (0.0, 0.02, 0.04, 0.07, 0.10)  # m from there, tried in this order


def plan_recovery(planner: Planner, scene: Scene, start: Start, seed: int = 0) -> Plan:
    """Plan from rest at ``start``, with the empty tool, out of any bin and home.

    What the cup touches where it stopped (an item that slipped, a wall within the clearance) it may touch
    over the first 20 mm upwards, or 40 mm backwards, and nothing else may. Raises NoPlanError.
    """
    label = f"recover to {SAFE}"
    out = _out_of_the_pod(planner, scene, start)
    if isinstance(out, Reason):
        raise NoPlanError(label, [out])
    pieces, q = out
    checker = planner.checker(scene, start.pivot)
    goal = planner.cell.configurations[SAFE].q
    coarse = plan_coarse(planner, checker, q, goal[None], [0.0], derived_seed(seed, label), "way home")
    if isinstance(coarse, Reason):
        raise NoPlanError(label, [coarse])
    pieces.append(Piece(SegmentKind.TRANSIT, coarse.waypoints, start.pivot, checker, blend=COARSE_BLEND))
    plan = assemble_pieces(planner, scene, pieces, label, seed)
    if isinstance(plan, Reason):
        raise NoPlanError(label, [plan])
    return plan


def _out_of_the_pod(planner: Planner, scene: Scene, start: Start) -> tuple[list[Piece], Array] | Reason:
    """Lines up and out along the pod's axis, by the least rise that is free; none where nothing is near."""
    tip = planner.arm.tip(start.q, start.pivot)
    depth = float((inverse(scene.T_world_pod) @ tip)[0, 3]) + PREAPPROACH_DISTANCE
    touching = _near(planner, scene, start)
    if isinstance(touching, Reason):
        return touching
    if depth <= 0.0 and not touching:
        return [], start.q
    reason = Reason("no way out", "where the robot stopped")
    for first, rise in product(_first_steps(tip, scene.T_world_pod), RISES):
        out = _risen_and_out(planner, scene, start, tip, first, rise, max(depth, 0.0), touching)
        if not isinstance(out, Reason):
            return out
        reason = out
    return reason


def _first_steps(tip: Array, T_world_pod: Array) -> list[Array]:
    """Ways (3,) in the world that may free the cup from what it touches."""
    up, back = T_world_pod[:3, 2], -tip[:3, 2]
    return [length * up for length in FIRST_UP] + [length * back for length in FIRST_BACK]


def _risen_and_out(
    planner: Planner,
    scene: Scene,
    start: Start,
    tip: Array,
    first: Array,
    rise: float,
    depth: float,
    touching: frozenset[str],
) -> tuple[list[Piece], Array] | Reason:
    """First away from what is touched, then up, then out."""
    free, T_world_pod = planner.checker(scene, start.pivot), scene.T_world_pod
    freed = shifted(tip, first)
    lifted = shifted(freed, rise * T_world_pod[:3, 2])
    stages = [
        (SegmentKind.DEPART, freed, planner.checker(scene, start.pivot, touching=touching), touching),
        (SegmentKind.RETREAT, lifted, free, frozenset[str]()),
        (SegmentKind.RETREAT, shifted(lifted, -depth * T_world_pod[:3, 0]), free, frozenset[str]()),
    ]
    pieces, q, here = [], start.q, tip
    for kind, there, checker, allowed in stages:
        if kind is SegmentKind.RETREAT and np.allclose(there, here):
            continue
        line = follow_line(planner.arm, checker, here, there, start.pivot, q, "way out")
        if isinstance(line, Reason):
            return line
        speed = planner.settings.lift_speed
        pieces.append(
            Piece(kind, line.waypoints, start.pivot, checker, touching=allowed, max_tool_speed=speed)
        )
        q, here = np.asarray(line.waypoints[-1]), there
    return pieces, q


def _near(planner: Planner, scene: Scene, start: Start) -> frozenset[str] | Reason:
    """What is within the clearance of the cup where the robot stopped."""
    touching: frozenset[str] = frozenset()
    for _ in range(8):
        checker = planner.checker(scene, start.pivot, touching=touching)
        if checker.is_free(start.q):
            return touching
        near = checker.clearance(start.q)
        if near.b in touching:
            break
        touching |= {near.b}
    reason = planner.checker(scene, start.pivot, touching=touching).explain(start.q)
    return reason.at("where the robot stopped")
