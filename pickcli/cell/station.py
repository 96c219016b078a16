"""Places and obstacles around the robot: pod, bins, tote."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pickcli.cell.place import Place
from pickcli.cell.pod_tolerance import UNMOVED, Displacement
from pickcli.cell.shapes import Body


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

    def swept(self) -> Pod:
        """The pod with each body grown to a box that holds it wherever the pod stands in its bounds.

        Returns:
            The grown pod.
        """
        return replace(self, bodies=tuple(self.displacement.swept(body) for body in self.bodies))


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
class Obstacles:
    """Everything else that stands still.

    Attributes:
        bodies: Boxes in the world frame.
    """

    bodies: tuple[Body, ...]
