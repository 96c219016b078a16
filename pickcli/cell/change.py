"""What is other in a cell than it was: by digests of its parts, which a file can carry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from pickcli.cell.fingerprint import digest, rules, solids
from pickcli.cell.model import Cell
from pickcli.cell.shapes import Body
from pickcli.cell.station import Obstacles

_LENGTH = 16  # hexadecimal digits of a digest: enough to tell apart what nobody forges

_TOLD = {
    "robot": "the robot, its joint limits or its tool",
    "displacement": "how far the pod may be displaced",
    "allowed": "the allowed pairs",
    "clearance": "the clearance",
    "speed_scale": "the speed scale",
}


@dataclass(frozen=True)
class CellChange:
    """The difference between a cell and what it was.

    rules: in words, what changed of what every motion depends on
    added: solids ("pod wall_left") that were not there, or were other or elsewhere
    removed: solids that are not there any more, or are other or elsewhere
    """

    rules: tuple[str, ...]
    added: tuple[str, ...]
    removed: tuple[str, ...]

    @property
    def solids(self) -> tuple[str, ...]:
        """All solids that changed."""
        return tuple(dict.fromkeys((*self.added, *self.removed)))


def part_digests(cell: Cell) -> dict[str, dict[str, str]]:
    """What ``change_since`` compares, as JSON values: digests of the rules and of each solid, by name."""
    parts = {"rules": rules(cell), "solids": solids(cell)}
    return {
        kind: {name: digest(part)[:_LENGTH] for name, part in some.items()} for kind, some in parts.items()
    }


def change_since(before: Mapping[str, Mapping[str, str]], cell: Cell) -> CellChange:
    """What changed since ``part_digests`` were taken."""
    now, then = part_digests(cell), before
    return CellChange(
        tuple(text for name, text in _TOLD.items() if then["rules"].get(name) != now["rules"][name]),
        tuple(name for name, seen in now["solids"].items() if then["solids"].get(name) != seen),
        tuple(name for name, seen in then["solids"].items() if now["solids"].get(name) != seen),
    )


def with_solids(cell: Cell, names: Sequence[str]) -> Cell:
    """The cell with no other solids around the robot; its fingerprint stays."""
    wanted = set(names)

    def kept(kind: str, bodies: Sequence[Body]) -> tuple[Body, ...]:
        return tuple(body for body in bodies if f"{kind} {body.name}" in wanted)

    return replace(
        cell,
        pod=replace(cell.pod, bodies=kept("pod", cell.pod.bodies)),
        tote=replace(cell.tote, bodies=kept("tote", cell.tote.bodies)),
        obstacles=Obstacles(kept("obstacle", cell.obstacles.bodies)),
    )
