"""Hash over everything in a cell that the validity of a motion depends on.

Included: the robot's chain, shapes, limits and base pose, the tool's geometry, the pod and its displacement
bounds, tote, places, obstacles, allowed pairs, clearance and speed scale. Not included: file names, comments,
the order of keys, named configurations, items (the scene's hash covers them), and devices, load limits,
motors and masses, which have hashes of their own (``equipment``).
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterable, Mapping
from dataclasses import astuple
from math import isfinite
from typing import Any

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.robot import Joint, Robot
from pickcli.cell.shapes import Body
from pickcli.cell.station import Carrier
from pickcli.geometry import Array

_DIGITS = 9  # 1 nm and 1 nrad: below any practical meaning, above rounding errors of reading


def fingerprint(cell: Cell) -> str:
    """Compute the SHA-256 of the cell's canonical content.

    Args:
        cell: The cell.

    Returns:
        Hexadecimal digits.
    """
    return digest(
        {
            **rules(cell),
            "T_world_pod": numbers(cell.T_world_pod),
            "pod": _bodies(cell.pod.bodies),
            "tote": _bodies(cell.tote_bodies),
            "obstacles": _bodies(cell.obstacles.bodies),
            **(
                {"places": {each.name: _carrier(each) for each in cell.own_carriers}}
                if cell.own_carriers
                else {}
            ),
        }
    )


def equipment(cells: Collection[Cell]) -> dict[str, str]:
    """Compute the SHA-256 of what plans depend on beyond the fingerprint, and stored motions do not.

    Args:
        cells: The cell as seen by each of its arms.

    Returns:
        Hexadecimal digits of "devices", of "tool", its load limits, and of "motors", their efforts and the
        masses that they move.
    """
    devices = [
        [
            [each.name, each.kind.value, *numbers([each.lead, each.flow]), *each.actions]
            for each in cell.devices.values()
        ]
        for cell in cells
    ]
    limits = [rounded(cell.robot.tool.grip.limit_figures()) for cell in cells]
    motors = [[rounded(dict(sorted(cell.robot.motor_forces.items()))), _masses(cell.robot)] for cell in cells]
    return {
        "devices": digest(sorted((sorted(own) for own in devices), key=json.dumps)),
        "tool": digest(sorted(limits, key=json.dumps)),
        "motors": digest(sorted(motors, key=json.dumps)),
    }


def _masses(robot: Robot) -> list[Any]:
    """Mass properties of all links."""
    return [
        [link.name, *numbers([own.mass, *own.centre, *own.inertia.ravel()])]
        for link in robot.links
        for own in (link.inertial,)
    ]


def rules(cell: Cell) -> dict[str, Any]:
    """Return all canonical content that motions depend on, except the solids around the robot.

    Args:
        cell: The cell.

    Returns:
        Plain values.
    """
    found = {
        "robot": _robot(cell.robot),
        "displacement": numbers(astuple(cell.pod.displacement)),
        "allowed": sorted([pair.a, pair.b] + ["verified"] * pair.verified for pair in cell.allowed_pairs),
        "clearance": numbers(cell.clearance),
        "speed_scale": numbers(cell.speed_scale),
    }
    if cell.own_carriers:
        bounds = {each.name: numbers(astuple(each.displacement)) for each in cell.own_carriers}
        found["displacement of places"] = bounds
    if cell.max_tool_speed is not None:
        found["max_tool_speed"] = numbers(cell.max_tool_speed)
    return found


def solid(body: Body) -> list[Any]:
    """Return the canonical content of a solid: name, kind, size and pose; of a hull also the vertices.

    Args:
        body: The solid.

    Returns:
        Plain values.
    """
    content = [body.name, body.shape.kind.value, numbers(body.shape.size), numbers(body.T_parent_shape)]
    return [*content, numbers(np.array(body.shape.vertices))] if body.shape.vertices else content


def digest(content: Any) -> str:
    """Compute the SHA-256 of plain values, by canonical JSON: sorted keys, no blanks, all digits of floats.

    Args:
        content: Plain values.

    Returns:
        Hexadecimal digits.
    """
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def numbers(values: Array | float | Iterable[float]) -> list[Any]:
    """Return numbers as plain lists, rounded to 1e-9; infinities become text, and minus zero becomes zero.

    Args:
        values: The numbers.

    Returns:
        Plain values.
    """
    flat = np.asarray(values, dtype=float).ravel()
    return [round(v, _DIGITS) + 0.0 if isfinite(v) else str(v) for v in flat.tolist()]


def _robot(robot: Robot) -> dict[str, Any]:
    limits, tool = robot.limits, robot.tool
    return {
        "T_world_base": numbers(robot.T_world_base),
        "links": [[link.name, _bodies(link.bodies)] for link in robot.links],
        "joints": [_joint(joint) for joint in robot.joints],
        "planned": list(robot.joint_names),
        "limits": [
            numbers(part)
            for part in (limits.lower, limits.upper, limits.velocity, limits.acceleration, limits.jerk)
        ],
        "tool": {
            "links": [tool.flange_link, tool.lance_link, tool.last_link, tool.joint],
            "states": {state.name: numbers(position) for state, position in tool.positions.items()},
            "T_cup_tip": numbers(tool.T_last_tip),
            **rounded(tool.grip.motion_figures()),
        },
    }


def rounded(figures: Mapping[str, Any]) -> dict[str, Any]:
    """Return named figures with every number in them rounded as by ``numbers``.

    Args:
        figures: Lists of numbers and names, possibly nested, by name.

    Returns:
        Plain values, by name.
    """
    return {name: _rounded(value) for name, value in figures.items()}


def _rounded(value: Any) -> Any:
    if isinstance(value, list):
        return [_rounded(each) for each in value]
    return value if isinstance(value, str) else numbers(value)[0]


def _carrier(carrier: Carrier) -> list[Any]:
    """Content of a carrier: its pose and solids, its belt, and the frame and room of each of its places."""
    places = {
        name: [numbers(place.T_carrier_place), numbers(np.hstack(astuple(place.room))), list(place.support)]
        for name, place in carrier.places.items()
    }
    content = [numbers(carrier.T_world_carrier), _bodies(carrier.bodies), places]
    return content if carrier.conveyor is None else [*content, numbers(np.hstack(astuple(carrier.conveyor)))]


def _joint(joint: Joint) -> list[Any]:
    return [
        joint.name,
        joint.type.value,
        joint.parent,
        joint.child,
        numbers(joint.T_parent_joint),
        numbers(joint.axis),
        numbers([joint.lower, joint.upper]),
    ]


def _bodies(bodies: Iterable[Body]) -> list[Any]:
    """Content of bodies, sorted, because their order in the file has no meaning."""
    return sorted((solid(body) for body in bodies), key=json.dumps)
