"""Items: size, mass, shape, how to grasp and how fast to carry."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array
from pickcli.name_suggestion import suggestion

OWN_ITEMS = "items of your own: --items"  # where an item is not known
LYING = 0.7  # vertical part of a cylinder's axis, below which it rolls


@dataclass(frozen=True)
class Item:
    """One product. The item frame is the centre of its shape (a cylinder's axis is z).

    The key is (name, year): six names stand in both years with other figures.

    Attributes:
        name: Of the product.
        year: Of the list that it is from.
        shape: Contains the product.
        mass: kg, as stated.
        bonus: Points by the rules of its year.
        seals: By face, share of full vacuum that the pump keeps under a cup there.
        seal_source: Where the seals come from.
        why_not: The reason why no face seals, else "".
        seal_inset: m that the rim of the cup must stay inside a face's edge.
        speed_scale: 1.0, or 0.5 for Delft's slow items.
        folded: "" or how cloth and bags were folded to get the stated size.
        source: Where the figures come from.
        areas: By face, [least, greatest] m along axes of the item frame between which it seals.
        mass_error: Bound of the stated mass's error, as a share of it.
    """

    name: str
    year: int
    shape: Shape
    mass: float
    bonus: int
    # By face (see Shape.face_names), the share of full vacuum kept under a cup: 1 airtight, 0 none.
    seals: Mapping[str, float] = field(hash=False)
    seal_source: str
    why_not: str
    seal_inset: float
    speed_scale: float
    folded: str
    source: str
    # By face, least and greatest coordinate in m along axes of the item frame: the part of it that seals.
    areas: Mapping[str, Mapping[str, tuple[float, float]]] = field(default_factory=dict, hash=False)
    mass_error: float = 0.1

    @property
    def heaviest(self) -> float:
        """The most that the item may weigh, kg: loads are planned and verified for it."""
        return self.mass * (1.0 + self.mass_error)

    @property
    def lightest(self) -> float:
        """The least that the item may weigh, kg: what a cup presses on is to stand with that."""
        return self.mass * (1.0 - self.mass_error)

    @property
    def suction(self) -> bool:
        """Whether a cup can hold the item at all."""
        return any(share > 0.0 for share in self.seals.values())

    def area(self, face: str) -> Array:
        """Corners between which a face seals.

        Args:
            face: Name of the face.

        Returns:
            (2, 3) m in the item frame; infinite along axes that are not limited.
        """
        stated = self.areas.get(face, {})
        ends = [stated.get(axis, (-np.inf, np.inf)) for axis in "xyz"]
        return np.array(ends, dtype=np.float64).T

    @property
    def inertia(self) -> Array:
        """Inertia (3, 3) in kg m^2 about the centre of mass in the item frame, of uniform density.

        It is that of the stated mass; that of another mass is in proportion.
        """
        return np.asarray(self.mass * self.shape.inertia_per_mass)

    def can_roll(self, R: Array) -> bool:
        """Whether the item rolls when it is pushed: a ball, or a cylinder that lies.

        Args:
            R: (3, 3) orientation of the item in a frame whose z points up.

        Returns:
            True if it does.
        """
        is_lying = abs(float(R[2, 2])) < LYING
        return self.shape.kind is ShapeKind.SPHERE or (self.shape.kind is ShapeKind.CYLINDER and is_lying)


def item_suggestion(name: str, known: Collection[str]) -> str:
    """What to write instead of an item's unknown name.

    Args:
        name: As it was given.
        known: Names of the items that are known.

    Returns:
        The names that could be meant; without any the known ones, and how to name a file of items.
    """
    found = suggestion(name, known)
    return found if found.endswith("?") else f"{found} ({OWN_ITEMS})"
