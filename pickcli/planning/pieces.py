"""The pieces of a motion before they have a time: each one's path, how fast it may go, what proves it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cartesian.line_following import Line
from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.geometry import Array
from pickcli.motion.segment import SegmentKind
from pickcli.planning.bin_query import BinQuery
from pickcli.planning.landing import Landing, Step
from pickcli.planning.stages.grasp_motion import InBin
from pickcli.planning.stages.transit import Coarse

FINE = 0.002  # joint units: blends inside the bin stay this close to the lines
COARSE_BLEND = 0.05
SLOWER_THAN_ALLOWED = 0.98  # of a limit of the tool's speed: timing bounds it between points, nearly
STANDING = 1e-6  # joint units of path below which a piece does not move at all


@dataclass(frozen=True, eq=False)
class PickMotion:
    """The geometry of a whole pick."""

    in_bin: InBin
    transit: Coarse
    transit_tool_state: ToolState  # MOVING where the cup turns on the way
    transfer: Coarse
    landing: Landing


@dataclass(frozen=True, eq=False)
class Piece:
    """One segment before it has a time.

    waypoints: (N, n). held: id of the item in the cup. touching: names that cup and held item may touch.
    max_tool_speed: m/s. blend: joint units, how far corners may be rounded. scale: of all limits.
    """

    kind: SegmentKind
    waypoints: Array
    tool_state: ToolState
    checker: SceneChecker
    held: str | None = None
    touching: frozenset[str] = frozenset()
    max_tool_speed: float | None = None
    blend: float = FINE
    scale: float = 1.0


def way_in(query: BinQuery, motion: PickMotion) -> list[Piece]:
    """From where the robot is to the cup pressed on the item."""
    planner, settings, in_bin = query.planner, query.planner.settings, motion.in_bin
    tool_state, kind = in_bin.grasp.tool_state, SegmentKind
    pressed = query.contacts.while_pressing(in_bin.press)
    empty = planner.checker(query.scene, tool_state, contacts=query.contacts.while_approaching())
    meeting = planner.checker(query.scene, tool_state, contacts=pressed)
    transit = planner.checker(query.scene, motion.transit_tool_state)
    contact_speed = SLOWER_THAN_ALLOWED * planner.cell.robot.tool.contact_speed

    def line(kind: SegmentKind, path: Line, speed: float) -> Piece:
        return Piece(kind, path.waypoints, tool_state, empty, max_tool_speed=speed)

    contact = line(kind.CONTACT, in_bin.contact, contact_speed)
    return [
        Piece(kind.TRANSIT, motion.transit.waypoints, motion.transit_tool_state, transit, blend=COARSE_BLEND),
        line(kind.PREAPPROACH, in_bin.preapproach, settings.preapproach_speed),
        line(kind.APPROACH, in_bin.approach, settings.approach_speed),
        replace(contact, checker=meeting, touching=pressed.names),
    ]


def way_out(query: BinQuery, motion: PickMotion) -> list[Piece]:
    """With the item out of the bin and to where it is let go."""
    planner, settings, in_bin = query.planner, query.planner.settings, motion.in_bin
    tool_state, target, kind = in_bin.grasp.tool_state, query.target.id, SegmentKind
    held, contacts = in_bin.held, query.contacts
    lifting = contacts.while_lifting(in_bin.press)
    leaving = planner.checker(query.scene, tool_state, held, lifting)
    carrying = planner.checker(query.scene, tool_state, held, contacts.while_carrying())
    outside = planner.checker(query.scene, tool_state, held, contacts.while_transferring())

    def line(kind: SegmentKind, path: Line, speed: float, checker: SceneChecker) -> Piece:
        return Piece(kind, path.waypoints, tool_state, checker, held=target, max_tool_speed=speed)

    freed = line(kind.LIFT, in_bin.freed, settings.lift_speed, leaving)
    return [
        replace(freed, touching=lifting.names),
        line(kind.LIFT, in_bin.lift, settings.lift_speed, carrying),
        *(line(kind.RETREAT, push, settings.retreat_speed, carrying) for push in in_bin.retreat),
        Piece(kind.TRANSFER, motion.transfer.waypoints, tool_state, outside, held=target, blend=COARSE_BLEND),
        *(_landed(step, tool_state, target) for step in motion.landing.inward),
    ]


def way_up(motion: PickMotion) -> list[Piece]:
    """Empty again, away from the release."""
    return [_landed(step, motion.in_bin.grasp.tool_state) for step in motion.landing.away]


def _landed(step: Step, tool_state: ToolState, held: str | None = None) -> Piece:
    return Piece(step.kind, step.line.waypoints, tool_state, step.checker, held, step.touching, step.speed)


def moving(pieces: Sequence[Piece], speed_scale: float) -> list[Piece]:
    """The pieces that move at all, at the cell's speed."""
    return [
        replace(piece, scale=speed_scale * piece.scale)
        for piece in pieces
        if float(np.abs(np.diff(piece.waypoints, axis=0)).sum()) > STANDING
    ]
