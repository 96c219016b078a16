"""Hollows in item files: their keys, and what they must be to lie in the item's shape."""

from __future__ import annotations

from typing import Annotated

from annotated_types import Len
from pydantic import Field, model_validator

from pickcli.cell.hollow import Hollow
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.files.schema import FileModel, Number

LEAST = 1e-3  # m: depth and width of a hollow, and what is left of the item under it
OPEN_SIDE = 1e-4  # m from the edge of a face within which the side of a hollow counts as open
HollowName = Annotated[str, Field(min_length=1, max_length=40, pattern=r"^[a-z0-9_]+$")]
_Side = Annotated[tuple[Number, ...], Len(2, 2)]


class HollowModel(FileModel):
    """One hollow: round, about the axis of a cylinder, or rectangular, in a box."""

    face: str = Field(description="the flat face that it opens through, as +z")
    depth: Annotated[float, Field(ge=LEAST, le=2)] = Field(description="m from the face to its flat bottom")
    radius: Annotated[float, Field(ge=LEAST, le=2)] | None = Field(
        None, description="m, in a cylinder: round, about its axis"
    )
    x: _Side | None = Field(None, description="[least, greatest] in m, in a box")
    y: _Side | None = Field(None, description="[least, greatest] in m, in a box")
    z: _Side | None = Field(None, description="[least, greatest] in m, in a box")

    @model_validator(mode="after")
    def _sides(self) -> HollowModel:
        for axis, side in self._stated.items():
            if side[1] - side[0] < LEAST:
                raise ValueError(
                    f"expected [least, greatest] for {axis}, at least {LEAST:g} m apart, got {list(side)}"
                )
        return self

    @property
    def _stated(self) -> dict[str, tuple[float, ...]]:
        return {axis: side for axis, side in zip("xyz", (self.x, self.y, self.z), strict=True) if side}

    def in_shape(self, name: str, shape: Shape) -> Hollow:
        """Return the hollow in an item's outer shape.

        Args:
            name: Name of the hollow.
            shape: The outer shape.

        Returns:
            The hollow.

        Raises:
            ValueError: It is not one of that shape: its face, kind, size or depth does not fit.
        """
        flat = [face for face in shape.face_names if face[0] in "+-"]
        if not flat:
            raise ValueError(f"hollows.{name}: a sphere has no flat face to open through; remove it")
        if self.face not in flat:
            raise ValueError(
                f"hollows.{name}.face: expected a flat face of its shape ({', '.join(flat)}), got "
                f"{self.face}; correct it"
            )
        thick = float(shape.extents["xyz".index(self.face[1])])
        if self.depth > thick - LEAST:
            raise ValueError(
                f"hollows.{name}.depth: expected at most {thick - LEAST:g} m, as the shape is {thick:g} m "
                f"thick there and a bottom must be left, got {self.depth:g}; make it less deep"
            )
        if shape.kind is ShapeKind.CYLINDER:
            return self._round(name, shape.size[0])
        return self._rectangular(name, shape)

    def _round(self, name: str, outer: float) -> Hollow:
        """Return the hollow in a cylinder of an outer radius, m."""
        if self.radius is None or self._stated:
            raise ValueError(f"hollows.{name}: expected radius alone, as its shape is a cylinder; correct it")
        if self.radius > outer - LEAST:
            raise ValueError(
                f"hollows.{name}.radius: expected at most {outer - LEAST:g} m, inside of the cylinder, got "
                f"{self.radius:g}; make it narrower"
            )
        return Hollow(name, self.face, self.depth, self.radius)

    def _rectangular(self, name: str, shape: Shape) -> Hollow:
        along = "xyz".replace(self.face[1], "")
        if self.radius is not None or set(self._stated) != set(along):
            raise ValueError(
                f"hollows.{name}: expected {' and '.join(along)}, the axes of face {self.face} of a box, and "
                "no others; correct it"
            )
        halves = {axis: float(shape.extents["xyz".index(axis)]) / 2 for axis in along}
        sides = tuple(self._side(name, axis, half) for axis, half in halves.items())
        if sides == tuple((-half, half) for half in halves.values()):
            raise ValueError(
                f"hollows.{name}: it takes all of face {self.face}; state a thinner box instead of a hollow"
            )
        return Hollow(name, self.face, self.depth, None, sides)

    def _side(self, name: str, axis: str, half: float) -> tuple[float, float]:
        """Return both ends along an axis, m; on the edge of the face, half from its middle, if near it."""
        least, greatest = self._stated[axis]
        if least < -half - OPEN_SIDE or greatest > half + OPEN_SIDE:
            raise ValueError(
                f"hollows.{name}.{axis}: expected within {half:g} m of the middle, inside of the box, got "
                f"{[least, greatest]}; lengths are in m, not mm, along the axes of the item frame"
            )
        is_open = least < -half + OPEN_SIDE, greatest > half - OPEN_SIDE
        return -half if is_open[0] else least, half if is_open[1] else greatest


def check_together(hollows: tuple[Hollow, ...], shape: Shape) -> None:
    """Refuse hollows that leave nothing between them.

    Args:
        hollows: All hollows of an item.
        shape: Its outer shape.

    Raises:
        ValueError: Two of them meet, so that the bottom of one is missing where the other is. Those of one
            face may lie side by side.
    """
    for k, one in enumerate(hollows):
        for other in hollows[:k]:
            (low, high), (low_other, high_other) = one.bounds(shape), other.bounds(shape)
            apart = -OPEN_SIDE if one.face == other.face else LEAST - OPEN_SIDE
            if (low < high_other + apart).all() and (low_other < high + apart).all():
                raise ValueError(
                    f"hollows: {other.name} and {one.name} meet, so no bottom is left between them; "
                    "make one of them smaller"
                )
