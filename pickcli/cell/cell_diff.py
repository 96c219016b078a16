"""Difference between two cells, from a record of a cell's parts that a file can carry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.fingerprint import digest, numbers, rules, solid
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.cell.station import OBSTACLE, POD, TOTE, Carrier, Obstacles
from pickcli.geometry import Array

_LENGTH = 16  # hexadecimal digits of a digest: enough to tell apart what nobody forges

_TOLD = {
    "robot": "the robot, its joint limits or its tool",
    "displacement": "how far the pod may be displaced",
    "displacement of places": "how far places may be displaced",
    "allowed": "the allowed pairs",
    "clearance": "the clearance",
    "speed_scale": "the speed scale",
    "max_tool_speed": "the limit of the tool's speed",
}


@dataclass(frozen=True, eq=False)
class CellChange:
    """The difference between a cell and what it was.

    Attributes:
        rules: In words, what changed of what every motion depends on.
        came: Solids ("pod wall_left") that are new, changed or moved.
        went: Solids that were removed, changed or moved.
        cell_of_came: The cell with no other solids than those that came around the robot.
        cell_of_went: The cell with no other solids than those that went around the robot.
    """

    rules: tuple[str, ...]
    came: tuple[str, ...]
    went: tuple[str, ...]
    cell_of_came: Cell
    cell_of_went: Cell

    @property
    def leaves_room(self) -> bool:
        """True if a solid was removed, or a solid outside the pod was changed or moved."""
        return any(name not in self.came or not name.startswith("pod ") for name in self.went)

    @property
    def solids(self) -> tuple[str, ...]:
        """Names of all solids that changed."""
        return tuple(dict.fromkeys((*self.came, *self.went)))


def parts_of(cell: Cell) -> dict[str, Any]:
    """What ``change_since`` compares: digests of the rules, and every solid by name.

    Args:
        cell: The cell.

    Returns:
        JSON values.
    """
    return {
        "rules": {name: digest(rule)[:_LENGTH] for name, rule in rules(cell).items()},
        "T_world_pod": numbers(cell.T_world_pod),
        **({"T_world_carriers": _stand(cell)} if cell.own_carriers else {}),
        "solids": {f"{kind} {body.name}": solid(body) for kind, body in _bodies(cell)},
    }


def change_since(before: Mapping[str, Any], cell: Cell) -> CellChange:
    """What changed since ``parts_of`` was taken.

    Args:
        before: The parts of the cell as it was.
        cell: The cell as it is.

    Returns:
        The difference.

    Raises:
        ValueError: If ``before`` is no such record.
        TypeError: If ``before`` is no such record.
        KeyError: If ``before`` is no such record.
    """
    now, then = parts_of(cell), before
    stood = then.get("T_world_carriers", {})
    moved = {name for name, T in _stand(cell).items() if stood.get(name) != T}
    moved |= {POD} if now["T_world_pod"] != then["T_world_pod"] else set()
    came = _others(now["solids"], then["solids"], moved)
    went = _others(then["solids"], now["solids"], moved)
    own = tuple(_stood(cell, name, _pose(T)) for name, T in stood.items())
    old = replace(cell, T_world_pod=_pose(then["T_world_pod"]), own_carriers=own)
    return CellChange(
        tuple(text for name, text in _TOLD.items() if then["rules"].get(name) != now["rules"].get(name)),
        came,
        went,
        _with_solids(cell, [(kind, body) for kind, body in _bodies(cell) if f"{kind} {body.name}" in came]),
        _with_solids(old, [_body(name, then["solids"][name]) for name in went]),
    )


def _stand(cell: Cell) -> dict[str, list[Any]]:
    """Where the carriers of a cell's own stand."""
    return {carrier.name: numbers(carrier.T_world_carrier) for carrier in cell.own_carriers}


def _stood(cell: Cell, name: str, T: Array) -> Carrier:
    """A carrier of a cell's own, or one that is no longer there, where it stood."""
    known = next((carrier for carrier in cell.own_carriers if carrier.name == name), None)
    return Carrier(name, T, (), {}) if known is None else replace(known, T_world_carrier=T)


def _others(some: Mapping[str, Any], than: Mapping[str, Any], moved: set[str]) -> tuple[str, ...]:
    """Names of solids that are not the same in both; all of the carriers that have ``moved`` as a whole."""
    return tuple(
        name for name, content in some.items() if than.get(name) != content or name.partition(" ")[0] in moved
    )


def _bodies(cell: Cell) -> list[tuple[str, Body]]:
    """Every solid around the robot, with the name of its carrier, or OBSTACLE."""
    kinds = [(POD, cell.pod.bodies), (TOTE, cell.tote_bodies), (OBSTACLE, cell.obstacles.bodies)]
    kinds += [(carrier.name, carrier.bodies) for carrier in cell.own_carriers]
    return [(kind, body) for kind, bodies in kinds for body in bodies]


def _body(name: str, content: Sequence[Any]) -> tuple[str, Body]:
    """A solid from its canonical content."""
    kind, _, own = name.partition(" ")
    _, shape, size, T = content
    return kind, Body(own, Shape(ShapeKind(shape), tuple(float(v) for v in size)), _pose(T))


def _pose(T: Sequence[float]) -> Array:
    return np.array(T, dtype=float).reshape(4, 4)


def _with_solids(cell: Cell, solids: Sequence[tuple[str, Body]]) -> Cell:
    """The cell with these solids, by kind, and no others around the robot; its fingerprint stays."""
    own = [carrier.name for carrier in cell.own_carriers]
    of_kind = {kind: tuple(body for k, body in solids if k == kind) for kind in (POD, TOTE, OBSTACLE, *own)}
    return replace(
        cell,
        pod=replace(cell.pod, bodies=of_kind[POD]),
        tote=None if cell.tote is None else replace(cell.tote, bodies=of_kind[TOTE]),
        own_carriers=tuple(replace(each, bodies=of_kind[each.name]) for each in cell.own_carriers),
        obstacles=Obstacles(of_kind[OBSTACLE]),
    )
