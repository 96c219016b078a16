"""Carriers of places and obstacles around the robot: pod, tote, and user-defined ones."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

from pickcli.cell.conveyor import Conveyor
from pickcli.cell.place import Place
from pickcli.cell.pod_tolerance import UNMOVED, Displacement
from pickcli.cell.shapes import Body
from pickcli.geometry import Array

POD = "pod"  # name of the carrier of the bins
TOTE = "tote"  # name of the place for delivered items and of its carrier, which is stationary
UNKNOWN = "unknown"  # stands for space of places of which nothing is known; no name of a carrier either
OBSTACLE = "obstacle"  # stands for bodies of no carrier; not allowed as a name of a carrier


@dataclass(frozen=True, eq=False)
class Pod:
    """The shelf. Pod frame: front face at x = 0, +x into the shelf, z = 0 on the floor.

    Attributes:
        bodies: Boxes in the pod frame.
        bins: Bins by name.
        displacement: Displacement bounds.
    """

    bodies: tuple[Body, ...]
    bins: dict[str, Place]
    displacement: Displacement = UNMOVED


NO_POD = Pod((), {})  # for cells without a pod


@dataclass(frozen=True, eq=False)
class Tote:
    """The tote: an open box. Its frame is at the centre of the inner floor, parallel to the world.

    Attributes:
        place: The inside, where items are placed.
        bodies: Boxes in the world frame.
    """

    place: Place
    bodies: tuple[Body, ...]


@dataclass(frozen=True, eq=False)
class Carrier:
    """A carrier of places, which move with it: a shelf, a box, a table, a conveyor, or user-defined bodies.

    Carriers stand upright.

    Attributes:
        name: Unique in the cell.
        T_world_carrier: (4, 4) nominal pose; a scene states the actual one.
        bodies: Its solids, in its frame.
        places: Its places by name.
        displacement: Displacement bounds.
        conveyor: The belt that is its running surface; None where items on it stand still.
    """

    name: str
    T_world_carrier: Array
    bodies: tuple[Body, ...]
    places: dict[str, Place]
    displacement: Displacement = UNMOVED
    conveyor: Conveyor | None = None


_Standing = TypeVar("_Standing", Pod, Carrier)


def swept(standing: _Standing) -> _Standing:
    """Replace each body of a carrier or pod by its swept volume within the displacement bounds.

    Args:
        standing: The pod or carrier.

    Returns:
        The pod or carrier with swept bodies.
    """
    bodies = tuple(standing.displacement.swept(body) for body in standing.bodies)
    return replace(standing, bodies=bodies)


@dataclass(frozen=True, eq=False)
class Obstacles:
    """All other stationary solids.

    Attributes:
        bodies: Boxes in the world frame.
    """

    bodies: tuple[Body, ...]
