"""What stands around the robot: the pod with its bins, the tote, obstacles."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pickcli.cell.place import Place
from pickcli.cell.pod_tolerance import UNMOVED, Displacement
from pickcli.cell.shapes import Body


@dataclass(frozen=True, eq=False)
class Pod:
    """The shelf. Its frame is the pod frame: front face at x = 0, +x into the shelf, z = 0 on the floor."""

    bodies: tuple[Body, ...]  # boxes in the pod frame
    bins: dict[str, Place]
    groups: dict[str, tuple[str, ...]]  # bounding groups: name -> body names (speeds up collision tests)
    displacement: Displacement = UNMOVED  # how far it may stand from its place

    def swept(self) -> Pod:
        """The pod with each body grown to a box that holds it wherever the pod stands in its bounds."""
        return replace(self, bodies=tuple(self.displacement.swept(body) for body in self.bodies))


@dataclass(frozen=True, eq=False)
class Tote:
    """The tote: an open box."""

    place: Place
    bodies: tuple[Body, ...]  # in the world frame


@dataclass(frozen=True, eq=False)
class Obstacles:
    """Everything else that stands still: boxes in the world frame."""

    bodies: tuple[Body, ...]
