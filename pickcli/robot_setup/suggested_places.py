"""Places of a new cell, with typical dimensions of each kind, as lines of a cell file."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.data_path import data_path
from pickcli.errors import InputError, UnknownNameError
from pickcli.geometry import Array, to_rpy
from pickcli.name_suggestion import shortened

POD, GRID, BOX, TABLE = "pod", "grid", "box", "table"
KINDS = (POD, GRID, BOX, TABLE)
OPTION = "--place"
RESERVED = ("home", "parked", "pod", "tote", "obstacle", "obstacles")  # names with another meaning in cells
MAX_PLACES = 20  # places per call: the search takes a second or more for each
DECIMALS = 3  # of a suggested pose

# Lines of each kind except its pose; comments state the source of a figure.
_FIGURES = {
    GRID: (
        "rows: [0.26, 0.26]  # m, clear heights from the top; ours: measure yours",
        "columns: [0.25, 0.25, 0.25]  # m, clear widths from the left; measure yours",
        "depth: 0.3  # m, front to back; measure yours",
        "board_thickness: 0.012  # m; measure yours",
    ),
    BOX: (
        "inner: [0.294, 0.394, 0.117]  # m, clear inside; a Euro container's of 400 x 300 mm: measure yours",
        "wall_thickness: 0.003  # m; measure yours",
    ),
    TABLE: (
        "size: [0.4, 0.6, 0.03]  # m, of the top; ours: measure yours",
        "height: 0.3  # m over it in which items count as on it",
    ),
}
_LEVELS = {GRID: 0.0, BOX: 0.003, TABLE: 0.0}  # m, height of its frame above the floor it stands on
_SHIPPED_POD = data_path() / "cells" / "apc2016_delft" / "cell.yaml"


@dataclass(frozen=True, eq=False)
class SuggestedPlace:
    """A place for items in a new cell.

    Attributes:
        name: Name of the shelf, box or table.
        kind: "pod", "grid", "box" or "table".
        xyz: m, position of its frame in the world.
        yaw: rad.
        source: How the pose was found.
    """

    name: str
    kind: str
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.0
    source: str = ""

    @property
    def level(self) -> float | None:
        """Height in m of its frame above a robot base on the same level, or on the same table.

        None for the pod, which stands on the floor of the hall.
        """
        return _LEVELS.get(self.kind)

    def at(self, T_world_place: Array, source: str) -> SuggestedPlace:
        """Return the place at a pose.

        Args:
            T_world_place: (4, 4), upright.
            source: How the pose was found.

        Returns:
            The place at the pose.
        """
        x, y, z = (T_world_place[:3, 3].round(DECIMALS) + 0.0).tolist()
        yaw = float(np.round(to_rpy(T_world_place[:3, :3])[2], DECIMALS)) + 0.0
        return replace(self, xyz=(x, y, z), yaw=yaw, source=source)

    def lines(self) -> Iterator[str]:
        """Format the place as lines of a cell file: the key ``pod`` for the pod, else an entry of ``places``.

        Yields:
            Each line.
        """
        xyz = ", ".join(f"{value:g}" for value in self.xyz)
        T = f"{{xyz: [{xyz}], rpy: [0, 0, {self.yaw:g}]}}  # {self.source}"
        if self.kind == POD:
            yield "# The Kiva pod of the Amazon Picking Challenge, as apc2016_delft has it: measure yours."
            yield "pod:"
            yield f"  T_world_pod: {T}"
            yield from _pod_figures()
            return
        yield f"  {self.name}:"
        yield f"    kind: {self.kind}"
        yield f"    T_world_place: {T}"
        yield from (f"    {line}" for line in _FIGURES[self.kind])


def requested_places(texts: Sequence[str]) -> tuple[SuggestedPlace, ...]:
    """Parse the requested places.

    Args:
        texts: [NAME=]KIND each.

    Returns:
        The places, without poses; default names are the kind, numbered from the second on.

    Raises:
        UnknownNameError: There is no such kind.
        InputError: A name is invalid or given twice, there are two pods, or too many places.
    """
    found = dict[str, SuggestedPlace]()
    if len(texts) > MAX_PLACES:
        raise InputError(
            f"{OPTION}: {len(texts)} places; at most {MAX_PLACES} are sought at once, add others by hand"
        )
    for text in texts:
        name, equals, kind = text.rpartition("=")
        if kind not in KINDS:
            raise UnknownNameError("kind of place", kind, list(KINDS), f"{OPTION} {shortened(text)}")
        if kind == POD and (equals or POD in found):
            reason = "the pod has no name but its own" if equals else "a cell has one pod"
            raise InputError(f"{OPTION} {text}: {reason}; take grid for a shelf with a name")
        if not equals:
            name = next(
                n for n in (kind, *(f"{kind}_{k}" for k in range(2, MAX_PLACES + 2))) if n not in found
            )
        _check_name(text, name, kind, found)
        found[name] = SuggestedPlace(name, kind)
    return tuple(found.values())


def _check_name(text: str, name: str, kind: str, taken: Sequence[str] | dict[str, SuggestedPlace]) -> None:
    """Refuse an invalid name of a place. Raises InputError."""
    where = f"{OPTION} {shortened(text)}"
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,49}", name):
        raise InputError(f"{where}: expected a name of letters, digits and _, a letter first, 50 at most")
    if name in RESERVED and kind != POD:
        raise InputError(f"{where}: {name!r} is the name of something else in cells; choose another")
    if name in taken:
        raise InputError(f"{where}: there is a place {name!r} already; give each a name of its own")


def _pod_figures() -> Iterator[str]:
    """Lines of the shipped pod, except its pose, whose comments do not apply here."""
    text = _SHIPPED_POD.read_text().partition("\npod:\n")[2].partition("\n\n")[0]
    yield from (line for line in text.splitlines() if not line.startswith("  T_world_pod:"))
