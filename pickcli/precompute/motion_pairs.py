"""Motion pairs worth storing: those that Team Delft recorded, by the kinds of their ends."""

from __future__ import annotations

from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.roadmap.trajectory_database import MotionKey, PayloadClass

# After Delft's cache of 270 motions (135 pairs, each recorded both ways): home to everything, each bin to its
# own camera pose, bins and camera poses to the tote, camera poses among each other, the tote to its cells.
# The drop poses here are in place of their tote cells, and are reached from the bins as well.
_EMPTY = (
    ("home", "bin"),
    ("home", "camera"),
    ("home", "tote"),
    ("home", "drop"),
    ("bin", "camera"),
    ("bin", "tote"),
    ("bin", "drop"),
    ("camera", "tote"),
    ("camera", "camera"),
    ("tote", "yardstick"),
    ("tote", "drop"),
)

# With an item in the cup the arm moves from a bin to the tote, or home.
_LADEN = (("home", "bin"), ("home", "tote"), ("bin", "tote"))

_WITHOUT_TOTE = (("bin", "bin"),)  # from any place to any other

_NOT_RECORDED = (("cam_A", "cam_H"), ("cam_C", "cam_D"), ("cam_C", "cam_G"), ("cam_C", "cam_I"))


def coarse_pairs(cell: Cell) -> list[MotionKey]:
    """List the motions to store for a cell.

    Args:
        cell: The cell.

    Returns:
        The motions, each in one direction, in the order of its configurations.
    """
    named = list(cell.configurations.values())
    pairs = [(a, b) for i, a in enumerate(named) for b in named[i + 1 :]]
    more = _WITHOUT_TOTE if cell.tote is None else ()
    return [
        MotionKey(a.name, b.name, payload)
        for payload, kinds in ((PayloadClass.EMPTY, _EMPTY), (PayloadClass.CUBE, _LADEN))
        for a, b in pairs
        if _is_wanted(a, b, kinds + more)
    ]


def delft_pairs(cell: Cell, payload: PayloadClass) -> list[MotionKey]:
    """List the 135 pairs of named configurations that Delft recorded both ways, as 270 motions.

    From the names in their cache (poses 0 to 11 are the letters A to L here). Drop poses and the four pairs
    of camera poses for which they had no motion are not included.

    Args:
        cell: The cell.
        payload: Payload class, the same for all.

    Returns:
        The motions, each in one direction.
    """
    return [
        MotionKey(key.start, key.goal, payload)
        for key in coarse_pairs(cell)
        if key.payload is PayloadClass.EMPTY
        and "drop" not in {cell.configurations[name].kind for name in (key.start, key.goal)}
        and (key.start, key.goal) not in _NOT_RECORDED
    ]


def _is_wanted(a: NamedConfiguration, b: NamedConfiguration, kinds: tuple[tuple[str, str], ...]) -> bool:
    if {a.kind, b.kind} == {"bin", "camera"}:
        return ("bin", "camera") in kinds and a.place == b.place
    return (a.kind, b.kind) in kinds or (b.kind, a.kind) in kinds
