"""Places and obstacles around the robot: pod, tote, and carriers of the user's own."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

from pickcli.cell.place import Place
from pickcli.cell.pod_tolerance import UNMOVED, Displacement
from pickcli.cell.shapes import Body
from pickcli.geometry import Array

POD = "pod"  # name of the carrier of the bins
TOTE = "tote"  # the place of delivered items, and its carrier, which stands still
OBSTACLE = "obstacle"  # what is neither: no carrier is called so


@dataclass(frozen=True, eq=False)
class Pod:
    """The shelf. Its frame is the pod frame: front face at x = 0, +x into the shelf, z = 0 on the floor.

    Attributes:
        bodies: Boxes in the pod frame.
        bins: Bins by name.
        displacement: How far it may stand from its place.
    """

    bodies: tuple[Body, ...]
    bins: dict[str, Place]
    displacement: Displacement = UNMOVED


NO_POD = Pod((), {})  # of a cell without one


@dataclass(frozen=True, eq=False)
class Tote:
    """The tote: an open box. Its frame sits at the centre of the inner floor, axes of the world.

    Attributes:
        place: Its inside, where items are put.
        bodies: Boxes in the world frame.
    """

    place: Place
    bodies: tuple[Body, ...]


@dataclass(frozen=True, eq=False)
class Carrier:
    """What places are part of and move with: a shelf, a box, a table, or bodies of the user's own.

    It stands upright.

    Attributes:
        name: Its own in the cell.
        T_world_carrier: (4, 4) pose where it nominally stands; a scene says where it really does.
        bodies: Its solids, in its frame.
        places: Its places by name.
        displacement: How far it may stand from its place.
    """

    name: str
    T_world_carrier: Array
    bodies: tuple[Body, ...]
    places: dict[str, Place]
    displacement: Displacement = UNMOVED


_Standing = TypeVar("_Standing", Pod, Carrier)


def swept(standing: _Standing) -> _Standing:
    """A carrier or pod with each body grown to a box that holds it wherever the bounds let it stand.

    Args:
        standing: Pod or carrier.

    Returns:
        The grown one.
    """
    bodies = tuple(standing.displacement.swept(body) for body in standing.bodies)
    return replace(standing, bodies=bodies)


@dataclass(frozen=True, eq=False)
class Obstacles:
    """Everything else that stands still.

    Attributes:
        bodies: Boxes in the world frame.
    """

    bodies: tuple[Body, ...]
