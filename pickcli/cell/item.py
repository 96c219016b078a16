"""Items: size, mass, shape, faces that seal, and speed limits."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pickcli.cell.hollow import Hollow
from pickcli.cell.sensors.material import Material
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array
from pickcli.name_suggestion import suggestion

OWN_ITEMS = "items of your own: --items"  # hint in errors about unknown items
REFERENCE_FLOW = 60.0  # l/min of free air of the pump for which item files state seals: a small ejector
LEAST_SHARE = 0.225  # of full vacuum under a face that seals: half again what a vacuum switch must read
LYING_AXIS_Z = 0.7  # a cylinder rolls if the vertical component of its axis is below this


@dataclass(frozen=True)
class Item:
    """One product. The item frame is the centre of its shape (a cylinder's axis is z).

    The key is (name, year): six names occur in both years with different figures.

    Attributes:
        name: Name of the product.
        year: Year of the list that contains it.
        shape: Outer shape, which contains the product.
        mass: kg, as stated.
        bonus: Points by the rules of its year.
        seals: By face, the share of full vacuum that the pump keeps under a cup.
        seal_source: Source of the seals.
        why_not: Why no face seals under the reference pump, "" if one does.
        seal_inset: m that the cup's rim must keep from a face's edge.
        speed_scale: 1.0, or 0.5 for Delft's slow items.
        folded: "" or how cloth and bags were folded to get the stated size.
        source: Source of the figures.
        areas: By face, [least, greatest] m along axes of the item frame within which it seals.
        mass_error: Bound of the relative error of the stated mass.
        is_fragile: Whether smaller forces than on other items count as damage.
        material: How depth sensors see its surface.
        colour: Red, green, blue of most of it, 0 to 255; None where no file states it.
        is_printed: Whether its faces are printed, or plain.
        deformation: m by which its surface may be inside of its shape in pictures, as of cloth and bags.
        hollows: Parts that are missing from its outer shape; their bottoms are faces, too.
        max_tilt: rad, the most that it may be tilted while it is held, from how it stood; None for any.
    """

    name: str
    year: int
    shape: Shape
    mass: float
    bonus: int
    # By face (see face_names), the share of full vacuum kept under a cup: 1 airtight, 0 none.
    seals: Mapping[str, float] = field(hash=False)
    seal_source: str
    why_not: str
    seal_inset: float
    speed_scale: float
    folded: str
    source: str
    # By face, least and greatest coordinate in m along axes of the item frame, which bound the sealing area.
    areas: Mapping[str, Mapping[str, tuple[float, float]]] = field(default_factory=dict, hash=False)
    mass_error: float = 0.1
    is_fragile: bool = False
    material: Material = Material.MATTE
    colour: tuple[int, ...] | None = None
    is_printed: bool = False
    deformation: float = 0.0
    hollows: tuple[Hollow, ...] = ()
    max_tilt: float | None = None

    @property
    def face_names(self) -> tuple[str, ...]:
        """Names of the faces: those of the outer shape, then the bottoms of the hollows, e.g. "+z/bowl"."""
        return (*self.shape.face_names, *(hollow.bottom for hollow in self.hollows))

    def hollow_at(self, face: str) -> Hollow | None:
        """Return the hollow with a bottom.

        Args:
            face: Name of a face.

        Returns:
            The hollow; None if the face is one of the outer shape.
        """
        return next((hollow for hollow in self.hollows if hollow.bottom == face), None)

    def height(self, face: str) -> float:
        """Return the coordinate of a flat face along its normal's axis.

        Args:
            face: Name of a flat face.

        Returns:
            m in the item frame.
        """
        hollow = self.hollow_at(face)
        if hollow is not None:
            return hollow.height(self.shape)
        half = float(self.shape.extents["xyz".index(face[1])]) / 2
        return -half if face[0] == "-" else half

    @property
    def heaviest(self) -> float:
        """Upper bound of the mass, kg, for which loads are planned and verified."""
        return self.mass * (1.0 + self.mass_error)

    @property
    def lightest(self) -> float:
        """Lower bound of the mass, kg, with which the item must withstand the press of a cup."""
        return self.mass * (1.0 - self.mass_error)

    @property
    def suction(self) -> bool:
        """Whether a cup can hold the item on any face."""
        return any(share >= LEAST_SHARE for share in self.seals.values())

    def under_pump(self, flow: float) -> Item:
        """Return the item with the seals that a pump of another flow keeps.

        A pump that draws Q0 of free air draws Q0 (1 - s) at the share s of its full vacuum, and a face leaks
        in proportion to s. So a face that keeps s under the reference pump keeps r s / (r s + 1 - s) under
        one that draws r times as much. Faces that keep less than ``LEAST_SHARE`` do not seal.

        Args:
            flow: l/min of free air that the pump draws.

        Returns:
            The item; its stated seals are taken to be those of the reference pump.
        """
        ratio = flow / REFERENCE_FLOW
        kept = {face: share / (share + (1.0 - share) / ratio) for face, share in self.seals.items()}
        seals = {face: share if share >= LEAST_SHARE else 0.0 for face, share in kept.items()}
        if any(seals.values()):
            return replace(self, seals=seals, why_not="")
        too_little = (
            f"its faces keep at most {max(kept.values()):.0%} of the vacuum, {LEAST_SHARE:.1%} are needed"
        )
        return replace(self, seals=seals, why_not=self.why_not or too_little)

    def area(self, face: str) -> Array:
        """Return the corners of the area in which a face seals.

        Args:
            face: Name of the face.

        Returns:
            (2, 3) m in the item frame; infinite along axes that are not limited. The bottom of a rectangular
            hollow is limited by its sides.
        """
        stated, hollow = self.areas.get(face, {}), self.hollow_at(face)
        ends = np.array([stated.get(axis, (-np.inf, np.inf)) for axis in "xyz"], dtype=np.float64).T
        for axis, (least, greatest) in zip(hollow.across, hollow.sides, strict=False) if hollow else ():
            ends[0, axis], ends[1, axis] = max(ends[0, axis], least), min(ends[1, axis], greatest)
        return ends

    def rooms(self, face: str, point: Array) -> Array:
        """Return how far the edges of the sealing part of a face are from a point on it.

        Args:
            face: Name of the face.
            point: (3,) m in the item frame.

        Returns:
            (2, 2) m to the lower and the upper edge along both axes of a box's face, negative beyond it;
            infinite on other shapes.
        """
        if self.shape.kind is not ShapeKind.BOX:
            return np.full((2, 2), np.inf)
        half = self.shape.extents / 2
        low, high = self.area(face)
        ends = np.stack([point - np.maximum(low, -half), np.minimum(high, half) - point], axis=1)
        return np.asarray(np.delete(ends, "xyz".index(face[1]), axis=0))

    @property
    def inertia(self) -> Array:
        """Inertia (3, 3) in kg m^2 about the centre of mass in the item frame, of uniform density.

        For the stated mass; it scales in proportion to the mass.
        """
        return np.asarray(self.mass * self.shape.inertia_per_mass)

    def can_roll(self, R: Array) -> bool:
        """Whether the item rolls when pushed: a ball, or a lying cylinder.

        Args:
            R: (3, 3) orientation of the item in a frame whose z points up.

        Returns:
            True if it rolls.
        """
        is_lying = abs(float(R[2, 2])) < LYING_AXIS_Z
        return self.shape.kind is ShapeKind.SPHERE or (self.shape.kind is ShapeKind.CYLINDER and is_lying)


def item_suggestion(name: str, known: Collection[str]) -> str:
    """Suggest known names for an unknown item.

    Args:
        name: The unknown name.
        known: Names of the items that are known.

    Returns:
        Similar names; without any, the known names and a hint on the option for further items.
    """
    found = suggestion(name, known)
    return found if found.endswith("?") else f"{found} ({OWN_ITEMS})"
