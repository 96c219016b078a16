"""A place like bin_B of the default cell, by figures alone."""

from __future__ import annotations

from pickcli.cell.place import Access, Place, Room
from pickcli.cell.station import POD
from pickcli.geometry import pose


def front_place(
    width: float = 0.2988, height: float = 0.2319, y_range: tuple[float, float] = (-0.1494, 0.1494)
) -> Place:
    """A place with a mouth of this size, in m, and a room of this width behind it."""
    room = Room((0.0, 0.4361), y_range, -0.0108, -0.0297, 0.255, 0.236, 0.0116, 0.21)
    T_pod_bin = pose([0.0, 0.0, 1.5536])
    access = Access.from_front(width, height)
    return Place("bin_B", POD, T_pod_bin, access, room, ("slope", "flat"))
