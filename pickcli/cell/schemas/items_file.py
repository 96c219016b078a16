"""Reads item files, such as those under data/items: one file per year. See docs/formats/items.md."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field, field_validator, model_validator

from pickcli.cell.data_path import data_path
from pickcli.cell.hollow import Hollow
from pickcli.cell.item import LEAST_SHARE, Item
from pickcli.cell.schemas.hollow_schema import HollowModel, HollowName, check_together
from pickcli.cell.sensors.material import Material
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import InputError
from pickcli.files.file_kind import ITEMS
from pickcli.files.file_warnings import FileWarnings, refuse_unknown_kinds
from pickcli.files.schema import FileModel, Number, Text, not_blank, validate
from pickcli.files.yaml_reader import read_yaml

Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Interval = Annotated[tuple[Number, ...], Len(2, 2)]
ItemSize = Annotated[float, Field(ge=1e-4, le=2)]  # m: from foil to what a single arm can handle
HEAVIEST = 20.0  # kg of an item
MOST_DEFORMED = 0.4  # of the thinnest side of a box, by which a look may be inside of it
BEYOND = 0.005  # m that an area may be stated beyond its face
LIGHT, HEAVY = 10.0, 4000.0  # kg/m3: foam, and metal that fills most of its bounding box
NARROWEST_CUP = 0.02  # m, width of the smallest cup of which a hollow that seals is taken to have room
WARNINGS = ("odd_density", "narrow_hollow")  # kinds of warnings about item files
ItemName = Annotated[str, Field(min_length=1, max_length=100, pattern=r"^[a-z0-9_]+$")]


def _axes_of(shape: Shape, face: str) -> str:
    """Axes of the item frame along which the area of a face can be limited."""
    if shape.kind is ShapeKind.SPHERE:
        return ""
    return "z" if face == "mantle" else "xyz".replace(face[1], "")


def _narrowest(shape: Shape, face: str) -> float:
    """The narrowest side of a face, m."""
    return min(float(shape.extents["xyz".index(axis)]) for axis in _axes_of(shape, face))


class ItemModel(FileModel):
    """One item, with exactly one of box, cylinder and sphere."""

    box: Annotated[tuple[ItemSize, ...], Len(3, 3)] | None = Field(None, description="extents [x, y, z] in m")
    cylinder: Annotated[tuple[ItemSize, ...], Len(2, 2)] | None = Field(
        None, description="[radius, length] in m"
    )
    sphere: Annotated[tuple[ItemSize, ...], Len(1, 1)] | None = Field(None, description="[radius] in m")
    mass: Annotated[float, Field(gt=0, le=HEAVIEST, allow_inf_nan=False)] = Field(description="a mass in kg")
    mass_error: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)] = Field(
        0.1, description="bound of the mass's error as a share of it, 0 to 1"
    )
    bonus: Annotated[int, Field(ge=0, le=10)] = Field(description="points, 0 to 10")
    seal: Share = Field(description="a share of full vacuum, 0 (does not seal) to 1 (airtight)")
    seals: dict[str, Share] = Field(
        default_factory=dict, description="shares of full vacuum of the faces that seal otherwise"
    )
    areas: dict[str, dict[Literal["x", "y", "z"], Interval]] = Field(
        default_factory=dict,
        description="by face, [least, greatest] in m along axes of the item frame: the part that seals",
    )
    seal_source: Annotated[str, Field(min_length=3)] = Field(description="where the seals come from")
    why_not: str = Field("", description="the reason where no face seals")
    seal_inset: Annotated[float, Field(ge=0, le=0.5)] = Field(description="m")
    speed_scale: Annotated[float, Field(gt=0, le=1)] = Field(1.0, description="a factor in (0, 1]")
    max_tilt: Annotated[float, Field(gt=0, le=math.pi / 2)] | None = Field(
        None, description="rad, the most that it may be tilted while it is held"
    )
    fragile: bool = Field(False, description="whether smaller forces than on other items are damage")
    material: Material = Field(Material.MATTE, description="matte, dark, clear, mesh or shiny")
    colour: Annotated[tuple[Annotated[int, Field(ge=0, le=255)], ...], Len(3, 3)] | None = Field(
        None, description="[red, green, blue] of most of it, 0 to 255"
    )
    printed: bool = Field(False, description="whether its faces are printed, or plain")
    deforms: Annotated[float, Field(ge=0, le=0.1)] = Field(
        0.0, description="m by which its surface may be inside of its shape in pictures"
    )
    hollows: Annotated[dict[HollowName, HollowModel], Len(0, 20)] = Field(
        default_factory=dict, description="parts missing from the shape, by name, each open through one face"
    )
    folded: str = Field("", description="how cloth or a bag was folded")
    source: Annotated[str, Field(min_length=3)] = Field(description="where the figures come from")

    @field_validator("max_tilt", mode="before")
    @classmethod
    def _not_forgotten(cls, tilt: object) -> object:
        return not_blank(tilt, "rad")

    @model_validator(mode="after")
    def _one_shape(self) -> ItemModel:
        if not self._has_one_shape:
            raise ValueError("expected exactly one of box, cylinder and sphere; keep one")
        return self

    @model_validator(mode="after")
    def _deforms(self) -> ItemModel:
        if self.deforms and self._has_one_shape:
            most = MOST_DEFORMED * float(self.shape.extents.min())
            if self.box is None or self.deforms > most:
                raise ValueError(
                    f"deforms: expected a box, and at most {most:.4g} m, {MOST_DEFORMED} of its thinnest "
                    "side; make it less, or leave it out"
                )
        return self

    @model_validator(mode="after")
    def _hollows(self) -> ItemModel:
        if self.hollows and self._has_one_shape:
            if self.deforms:
                raise ValueError("deforms: expected none of an item with hollows, which is stiff; remove it")
            check_together(self.hollows_in_shape, self.shape)
        return self

    @model_validator(mode="after")
    def _faces(self) -> ItemModel:
        if self._has_one_shape:
            known = self.face_names
            for name in (*self.seals, *self.areas):
                if name not in known:
                    raise ValueError(f"expected faces of its shape ({', '.join(known)}), got {name}")
            best = max(self.shares.values())
            if (self.why_not and best >= LEAST_SHARE) or (not self.why_not and best == 0.0):
                raise ValueError(
                    f"expected why_not where no face keeps {LEAST_SHARE} of full vacuum, and only there; "
                    "add or remove it"
                )
        return self

    @model_validator(mode="after")
    def _areas(self) -> ItemModel:
        for name, area in self.areas.items():
            if self._has_one_shape and self.shares.get(name) == 0.0:
                raise ValueError(
                    f"expected areas of faces that seal, got {name}; remove it or state its seal"
                )
            for axis, (least, greatest) in area.items():
                if least >= greatest:
                    raise ValueError(
                        f"expected [least, greatest] for {axis} of {name}, got {[least, greatest]}"
                    )
                if self._has_one_shape:
                    self._check_area(name, axis, least, greatest)
        return self

    @model_validator(mode="after")
    def _over_hollows(self) -> ItemModel:
        """Refuse outer faces that are said to seal where a hollow opens through them."""
        for hollow in self.hollows_in_shape if self._has_one_shape else ():
            for face in hollow.opens(self.shape):
                if self.shares[face] > 0.0 and self._reaches_over(face, hollow):
                    raise ValueError(
                        f"hollows.{hollow.name}: {face} is said to seal where it opens; state areas of "
                        f"{face} beside it, or its seal as 0"
                    )
        return self

    def _reaches_over(self, face: str, hollow: Hollow) -> bool:
        """Whether the part of a face that seals reaches over a hollow that opens through it."""
        low, high = hollow.bounds(self.shape)
        stated = {"xyz".index(axis): side for axis, side in self.areas.get(face, {}).items()}
        across = [k for k in range(3) if k != "xyz".index(face[1])]
        within = {k: stated.get(k, (low[k], high[k])) for k in across}
        return all(least < high[k] and greatest > low[k] for k, (least, greatest) in within.items())

    def _check_area(self, name: str, axis: Literal["x", "y", "z"], least: float, greatest: float) -> None:
        """Raise ValueError if an area has a limit along an axis that its face lacks, or is beyond it."""
        known = _axes_of(self.shape, name)
        if axis not in known:
            which = f"along {' and '.join(known)} of the face" if known else "of a box or cylinder"
            raise ValueError(f"expected an area {which}, got {axis} of {name}; correct the axis")
        k = "xyz".index(axis)
        half = float(self.shape.extents[k]) / 2
        hollow = next((each for each in self.hollows_in_shape if each.bottom == name), None)
        if hollow is not None:
            low, high = hollow.bounds(self.shape)[:, k].tolist()
            if least < low - BEYOND or greatest > high + BEYOND or greatest < low or least > high:
                raise ValueError(
                    f"expected {axis} of {name} within its hollow, {[low, high]}, got {[least, greatest]}; "
                    "lengths are in m, not mm, along the axes of the item frame"
                )
        elif max(-least, greatest) > half + BEYOND or min(-least, greatest) < -half:
            raise ValueError(
                f"expected {axis} of {name} within {half:g} m of the middle, got {[least, greatest]}; "
                "lengths are in m, not mm, along the axes of the item frame"
            )

    @model_validator(mode="after")
    def _inset(self) -> ItemModel:
        if self._has_one_shape and not self.why_not and self.shape.kind is not ShapeKind.SPHERE:
            widths = {hollow.bottom: hollow.width for hollow in self.hollows_in_shape}
            sealing = [name for name, share in self.shares.items() if share > 0.0]
            sides = [widths.get(name) or _narrowest(self.shape, name) for name in sealing]
            if sides and 2 * self.seal_inset >= max(sides):
                raise ValueError(
                    f"expected a seal_inset under {max(sides) / 2:g} m, half of the widest face that seals, "
                    f"got {self.seal_inset:g}; nothing is left for the cup"
                )
        return self

    @property
    def _has_one_shape(self) -> bool:
        return sum(shape is not None for shape in (self.box, self.cylinder, self.sphere)) == 1

    @property
    def shape(self) -> Shape:
        """The stated shape."""
        if self.box is not None:
            return Shape(ShapeKind.BOX, self.box)
        if self.cylinder is not None:
            return Shape(ShapeKind.CYLINDER, self.cylinder)
        assert self.sphere is not None  # ensured by the schema
        return Shape(ShapeKind.SPHERE, self.sphere)

    @property
    def hollows_in_shape(self) -> tuple[Hollow, ...]:
        """The hollows, in their order. Raises ValueError if one does not fit into the shape."""
        return tuple(model.in_shape(name, self.shape) for name, model in self.hollows.items())

    @property
    def face_names(self) -> tuple[str, ...]:
        """Names of the faces: those of the shape, then the bottoms of the hollows."""
        return (*self.shape.face_names, *(hollow.bottom for hollow in self.hollows_in_shape))

    @property
    def shares(self) -> dict[str, float]:
        """Share of full vacuum by face."""
        return {face: self.seals.get(face, self.seal) for face in self.face_names}


class ItemsModel(FileModel):
    """A whole item file."""

    format: Literal["apc items"] = Field(description="'apc items'")
    version: Literal[1] = Field(description="1, the only version there is")
    year: Annotated[int, Field(ge=2015, le=2100)] = Field(description="the year whose rules give the bonus")
    items: dict[ItemName, ItemModel] = Field(description="the items by name")
    accepted_warnings: Annotated[tuple[Text, ...], Len(0, 1000)] = Field(
        (), description="warnings that are meant, as KIND or KIND:ITEM"
    )

    @field_validator("accepted_warnings")
    @classmethod
    def _known_kinds(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        refuse_unknown_kinds(names, WARNINGS)
        return names


def load_items(own: Path | None = None) -> dict[tuple[str, int], Item]:
    """Load the items of the package, and further ones from a user's files.

    Args:
        own: A file, or a folder of files; None for none.

    Returns:
        Items by (name, year).

    Raises:
        InputError: With every mistake in a file and its position; or two files state the same item; or the
            folder contains no item file.
    """
    items: dict[tuple[str, int], Item] = {}
    stated: dict[tuple[str, int], Path] = {}
    for path in (*_files(data_path() / "items"), *(() if own is None else _files(own))):
        found = read_items(path)
        for key in found.keys() & stated.keys():
            name, year = key
            raise InputError(
                f"{path}: items.{name}: {stated[key]} has a {name} of {year} already; choose another name "
                "or year"
            )
        stated |= dict.fromkeys(found, path)
        items |= found
    return items


def _files(path: Path) -> list[Path]:
    """Item files at a path: itself or those in the folder. Raise InputError if a folder has none."""
    if not path.is_dir():
        return [path]
    found = sorted(file for file in path.iterdir() if file.suffix in (".yaml", ".yml"))
    if not found:
        raise InputError(
            f"{path}: no file of items (.yaml) is in this folder; name a file, or another folder"
        )
    return found


def read_items(path: Path) -> dict[tuple[str, int], Item]:
    """Read the items of one file, and log warnings about implausible values.

    Args:
        path: The file.

    Returns:
        Items by (name, year).

    Raises:
        InputError: With every mistake and its position.
    """
    source = read_yaml(path, ITEMS)
    model = validate(source, ItemsModel)
    warnings = FileWarnings.of(source)
    for name, item in model.items.items():
        _warn_of_density(warnings, name, item)
        _warn_of_narrow_hollows(warnings, name, item)
    warnings.log()
    return {(name, model.year): _item(name, model.year, item) for name, item in model.items.items()}


def _warn_of_density(warnings: FileWarnings, name: str, item: ItemModel) -> None:
    """Warn of a mass that is implausible for the size."""
    density = item.mass / item.shape.volume
    if not LIGHT <= density <= HEAVY:
        size = " x ".join(f"{1e3 * side:.3g}" for side in item.shape.extents)
        text = f"{name} of {size} mm and {item.mass:g} kg has {density:.3g} kg/m3, "
        text += "as solid metal" if density > HEAVY else "less than foam"
        text += "; are sizes in m and masses in kg?"
        warnings.add("odd_density", name, ("items", name, "mass"), text)


def _warn_of_narrow_hollows(warnings: FileWarnings, name: str, item: ItemModel) -> None:
    """Warn of a hollow whose bottom is said to seal, though no usual cup goes into it."""
    for hollow in item.hollows_in_shape:
        if item.shares[hollow.bottom] > 0.0 and hollow.width < NARROWEST_CUP:
            text = f"{name}: the hollow {hollow.name} is {1e3 * hollow.width:.3g} mm wide, narrower than any "
            text += f"usual cup ({1e3 * NARROWEST_CUP:g} mm), so its bottom is never used; are lengths in m?"
            warnings.add("narrow_hollow", name, ("items", name, "hollows", hollow.name), text)


def _item(name: str, year: int, model: ItemModel) -> Item:
    return Item(
        name=name,
        year=year,
        shape=model.shape,
        mass=model.mass,
        bonus=model.bonus,
        seals=model.shares,
        seal_source=model.seal_source,
        areas={face: {axis: (a, b) for axis, (a, b) in area.items()} for face, area in model.areas.items()},
        why_not=model.why_not,
        seal_inset=model.seal_inset,
        speed_scale=model.speed_scale,
        folded=model.folded,
        source=model.source,
        mass_error=model.mass_error,
        is_fragile=model.fragile,
        material=model.material,
        colour=model.colour,
        is_printed=model.printed,
        deformation=model.deforms,
        hollows=model.hollows_in_shape,
        max_tilt=model.max_tilt,
    )
