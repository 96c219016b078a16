"""Difference between a cell and an earlier version of it, recorded in a file as digests and solids."""

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

_LENGTH = 16  # hexadecimal digits of a digest: enough against accidental collisions

_DESCRIPTIONS = {
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
    """The difference between a cell and an earlier version of it.

    Attributes:
        rules: Texts for the changed rules, on which every motion depends.
        added: Names of solids ("pod wall_left") that are new, changed or moved.
        removed: Names of solids that were removed, changed or moved.
        cell_of_added: The cell with only the solids in ``added`` around the robot.
        cell_of_removed: The earlier cell with only the solids in ``removed`` around the robot.
    """

    rules: tuple[str, ...]
    added: tuple[str, ...]
    removed: tuple[str, ...]
    cell_of_added: Cell
    cell_of_removed: Cell

    @property
    def frees_space(self) -> bool:
        """True if a solid was removed, or a solid outside the pod was changed or moved."""
        return any(name not in self.added or not name.startswith("pod ") for name in self.removed)

    @property
    def solids(self) -> tuple[str, ...]:
        """Names of all solids that changed."""
        return tuple(dict.fromkeys((*self.added, *self.removed)))


def parts_of(cell: Cell) -> dict[str, Any]:
    """Return the record that ``change_since`` compares: digests of the rules, and every solid by name.

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
    """Compare a cell with an earlier record of its parts.

    Args:
        before: Result of ``parts_of`` for the earlier cell.
        cell: The cell as it is now.

    Returns:
        The difference.

    Raises:
        ValueError: ``before`` is not such a record.
        TypeError: ``before`` is not such a record.
        KeyError: ``before`` is not such a record.
    """
    now, then = parts_of(cell), before
    stood = then.get("T_world_carriers", {})
    moved = {name for name, T in _stand(cell).items() if stood.get(name) != T}
    moved |= {POD} if now["T_world_pod"] != then["T_world_pod"] else set()
    added = _others(now["solids"], then["solids"], moved)
    removed = _others(then["solids"], now["solids"], moved)
    own = tuple(_stood(cell, name, _pose(T)) for name, T in stood.items())
    old = replace(cell, T_world_pod=_pose(then["T_world_pod"]), own_carriers=own)
    return CellChange(
        tuple(
            text for name, text in _DESCRIPTIONS.items() if then["rules"].get(name) != now["rules"].get(name)
        ),
        added,
        removed,
        _with_solids(cell, [(kind, body) for kind, body in _bodies(cell) if f"{kind} {body.name}" in added]),
        _with_solids(old, [_body(name, then["solids"][name]) for name in removed]),
    )


def _stand(cell: Cell) -> dict[str, list[Any]]:
    """Poses of the carriers that the cell file lists under ``places``."""
    return {carrier.name: numbers(carrier.T_world_carrier) for carrier in cell.own_carriers}


def _stood(cell: Cell, name: str, T: Array) -> Carrier:
    """A carrier at its earlier pose, without bodies and places if the cell no longer has it."""
    known = next((carrier for carrier in cell.own_carriers if carrier.name == name), None)
    return Carrier(name, T, (), {}) if known is None else replace(known, T_world_carrier=T)


def _others(some: Mapping[str, Any], than: Mapping[str, Any], moved: set[str]) -> tuple[str, ...]:
    """Names of solids that differ or are missing in ``than``, and of all solids on ``moved`` carriers."""
    return tuple(
        name for name, content in some.items() if than.get(name) != content or name.partition(" ")[0] in moved
    )


def _bodies(cell: Cell) -> list[tuple[str, Body]]:
    """Every solid around the robot, with the name of its carrier, or OBSTACLE."""
    kinds = [(POD, cell.pod.bodies), (TOTE, cell.tote_bodies), (OBSTACLE, cell.obstacles.bodies)]
    kinds += [(carrier.name, carrier.bodies) for carrier in cell.own_carriers]
    return [(kind, body) for kind, bodies in kinds for body in bodies]


def _body(name: str, content: Sequence[Any]) -> tuple[str, Body]:
    """Rebuild a solid from its canonical content."""
    kind, _, own = name.partition(" ")
    _, shape, size, T = content
    return kind, Body(own, Shape(ShapeKind(shape), tuple(float(v) for v in size)), _pose(T))


def _pose(T: Sequence[float]) -> Array:
    return np.array(T, dtype=float).reshape(4, 4)


def _with_solids(cell: Cell, solids: Sequence[tuple[str, Body]]) -> Cell:
    """The cell with only these solids around the robot; its fingerprint stays."""
    own = [carrier.name for carrier in cell.own_carriers]
    of_kind = {kind: tuple(body for k, body in solids if k == kind) for kind in (POD, TOTE, OBSTACLE, *own)}
    return replace(
        cell,
        pod=replace(cell.pod, bodies=of_kind[POD]),
        tote=None if cell.tote is None else replace(cell.tote, bodies=of_kind[TOTE]),
        own_carriers=tuple(replace(each, bodies=of_kind[each.name]) for each in cell.own_carriers),
        obstacles=Obstacles(of_kind[OBSTACLE]),
    )
