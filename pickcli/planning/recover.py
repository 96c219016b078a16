"""A safe way out from wherever a motion stopped: out of the bin along its axis, then home.

Delft's and KTH's systems start over from a place in front of the shelf; a robot that stopped on a proven
path gets there by lines and coarse motions that are proven again, for the tool as it is now.
"""

from __future__ import annotations

import numpy as np

from pickcli.cartesian.follow import follow_line
from pickcli.cartesian.keyposes import PREAPPROACH_DISTANCE
from pickcli.cartesian.line import shifted
from pickcli.cell.scene import Scene
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.assemble import COARSE_BLEND, Piece, assemble_pieces
from pickcli.planning.coarse import plan_coarse
from pickcli.planning.context import Planner, derived_seed
from pickcli.planning.pick import Start

SAFE = "home"


def plan_recovery(planner: Planner, scene: Scene, start: Start, seed: int = 0) -> Plan:
    """Plan from rest at ``start``, with the empty tool, out of any bin and home.

    What the tool touches where it stopped (an item that slipped, a wall within the clearance) may be
    touched by the cup along the line out, and by nothing else. Raises NoPlanError.
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
    """Lines up and out along the pod's axis; none where the tool is outside already."""
    tip = planner.arm.tip(start.q, start.pivot)
    depth = float((inverse(scene.T_world_pod) @ tip)[0, 3]) + PREAPPROACH_DISTANCE
    touching = _near(planner, scene, start)
    if isinstance(touching, Reason):
        return touching
    if depth <= 0.0 and not touching:
        return [], start.q
    checker = planner.checker(scene, start.pivot, touching=touching)
    out = shifted(tip, -max(depth, 0.03) * scene.T_world_pod[:3, 0])
    line = follow_line(planner.arm, checker, tip, out, start.pivot, start.q, "way out")
    if isinstance(line, Reason):
        return line
    piece = Piece(
        SegmentKind.RETREAT, line.waypoints, start.pivot, checker, touching=touching,
        max_tool_speed=planner.settings.lift_speed,
    )  # fmt: skip
    return [piece], np.asarray(line.waypoints[-1])


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
    return Reason(reason.what, "where the robot stopped", reason.detail)
