"""Reads files of watches: vest cameras, laser scanner and fields of a truck. See docs/formats/watch.md."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from pathlib import Path
from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field, model_validator

from pickcli.cell.data_path import data_file
from pickcli.files.file_kind import WATCH
from pickcli.files.schema import FileModel, Size, Text, validate
from pickcli.files.yaml_reader import read_yaml
from pickcli.watching.laser_scanner import LaserScanner
from pickcli.watching.nir_pair import NirPair
from pickcli.watching.protective_field import FieldFigures

Period = Annotated[float, Field(ge=0.02, le=1)]  # s
Delay = Annotated[float, Field(ge=0, le=2)]  # s
Pixels = Annotated[int, Field(ge=64, le=4000)]
Counts = Annotated[float, Field(ge=0, le=1e6)]
Metres = Annotated[float, Field(ge=0, le=2)]


class MountModel(FileModel):
    """Where a sensor is on the truck, looking along its x."""

    forward: Annotated[float, Field(ge=-5, le=5)] = Field(description="m before the axle")
    above: Annotated[float, Field(ge=0.05, le=5)] = Field(description="m above the floor")


class PairPictureModel(FileModel):
    """Size of a picture."""

    width: Pixels = Field(description="px")
    height: Pixels = Field(description="px")


class PairModel(FileModel):
    """Two cameras with a flash."""

    picture: PairPictureModel = Field(description="size of each picture")
    field_of_view: Annotated[float, Field(ge=0.2, le=2.4)] = Field(description="rad, horizontally")
    baseline: Annotated[float, Field(ge=0.02, le=2)] = Field(description="m between both cameras")
    mount: MountModel = Field(description="where the middle between both is")
    range: Annotated[tuple[Annotated[float, Field(ge=0.2, le=100)], ...], Len(2, 2)] = Field(
        description="[nearest, farthest] in m, in which people are looked for"
    )
    period: Period = Field(description="s between two exposures with flash")
    gap: Annotated[float, Field(ge=0, le=0.1)] = Field(description="s from it to the one without flash")
    delay: Delay = Field(description="s from the exposure to the answer")
    flash: Annotated[float, Field(gt=0, le=1e6)] = Field(description="counts of 1 cd/lx/m^2 at 1 m")
    flash_offset: Annotated[float, Field(ge=0.001, le=0.5)] = Field(description="m from lens to lamps")
    ambient: Counts = Field(description="counts of a white surface without flash")
    full: Annotated[float, Field(ge=100, le=1e7)] = Field(description="electrons at the largest count")
    read_noise: Annotated[float, Field(ge=0, le=100)] = Field(description="counts")
    largest: Annotated[float, Field(ge=15, le=65535)] = Field(description="counts")
    disparity_error: Annotated[float, Field(ge=0.01, le=10)] = Field(description="px")

    @model_validator(mode="after")
    def _ordered(self) -> PairModel:
        low, high = self.range
        if not low < high:
            raise ValueError(f"expected range as [nearest, farthest], got {[low, high]}; swap them")
        if self.gap >= self.period:
            raise ValueError(f"expected a gap below the period of {self.period:g} s; correct one of them")
        return self

    @property
    def pair(self) -> NirPair:
        """The pair as a value."""
        rest = self.model_dump(exclude={"picture", "mount", "range"})
        size, mount, (nearest, farthest) = self.picture, self.mount, self.range
        return NirPair(
            width=size.width, height=size.height, forward=mount.forward, above=mount.above,
            nearest=nearest, farthest=farthest, **rest,
        )  # fmt: skip


class ScannerModel(FileModel):
    """A laser scanner."""

    mount: MountModel = Field(description="where it is")
    angle: Annotated[float, Field(ge=0.5, le=2 * pi)] = Field(description="rad that a scan covers")
    resolution: Annotated[float, Field(ge=0.001, le=0.1)] = Field(description="rad between beams")
    farthest: Annotated[float, Field(ge=0.5, le=100)] = Field(description="m that are measured")
    noise: Annotated[float, Field(ge=0, le=0.5)] = Field(description="m, standard deviation")
    period: Period = Field(description="s between two scans")
    scans: Annotated[int, Field(ge=1, le=20)] = Field(description="in a row that request a brake")
    delay: Delay = Field(description="s from the last of them to the request")

    @property
    def scanner(self) -> LaserScanner:
        """The scanner as a value."""
        rest = self.model_dump(exclude={"mount"})
        return LaserScanner(forward=self.mount.forward, above=self.mount.above, **rest)


class FieldsModel(FileModel):
    """Supplements of fields, and the brake."""

    reaction: Delay = Field(description="s from a request until the truck brakes")
    hold: Annotated[float, Field(ge=0, le=30)] = Field(description="s that all is clear before it goes on")
    start_speed: Annotated[float, Field(ge=0.05, le=5)] = Field(
        description="m/s, for which the field is to be clear then"
    )
    ahead: Metres = Field(description="m in front of the stopping distance")
    side: Metres = Field(description="m beside the truck")
    approach: Annotated[float, Field(ge=0, le=5)] = Field(
        description="m/s at which people may walk up to the truck"
    )
    known: Metres = Field(description="m around walls and boxes in which nothing brakes")
    body: Size = Field(description="m, radius of a person seen from above")
    clearance: Metres = Field(description="m that is kept from people in vests")


class WatchModel(FileModel):
    """A whole file."""

    format: Literal["apc watch"] = Field(description="'apc watch'")
    version: Literal[1] = Field(description="1, the only version there is")
    name: Text = Field(description="name of the watch")
    pair: PairModel = Field(description="the vest cameras")
    scanner: ScannerModel = Field(description="the laser scanner")
    rear: ScannerModel | None = Field(None, description="a second one, which looks backwards")
    fields: FieldsModel = Field(description="protective fields and brake")
    sources: dict[Text, Annotated[str, Field(min_length=3)]] = Field(
        description="where the figures come from, by section.key"
    )

    @model_validator(mode="after")
    def _has_sources(self) -> WatchModel:
        sections: dict[str, FileModel] = {"pair": self.pair, "scanner": self.scanner, "fields": self.fields}
        sections |= {} if self.rear is None else {"rear": self.rear}
        known = [f"{name}.{key}" for name, section in sections.items() for key in type(section).model_fields]
        if lacking := [key for key in known if key not in self.sources]:
            raise ValueError(f"expected a source of {', '.join(lacking)}, got nothing; add it to sources")
        if other := [key for key in self.sources if key not in known]:
            raise ValueError(f"expected sources of keys of this file, got {', '.join(other)}; remove it")
        return self


@dataclass(frozen=True)
class Watch:
    """How a truck watches for people.

    Attributes:
        pair: The vest cameras.
        scanner: The laser scanner.
        fields: Supplements of its fields, and the brake.
        rear: A second scanner, for drives backwards; None without.
    """

    pair: NirPair
    scanner: LaserScanner
    fields: FieldFigures
    rear: LaserScanner | None = None


def read_watch(path: Path) -> Watch:
    """Read a file of a watch.

    Args:
        path: The file, YAML or JSON.

    Returns:
        The watch.

    Raises:
        InputError: With every mistake and its position.
    """
    model = validate(read_yaml(path, WATCH), WatchModel)
    rear = None if model.rear is None else replace(model.rear.scanner, looks_back=True)
    return Watch(model.pair.pair, model.scanner.scanner, FieldFigures(**dict(model.fields)), rear)


def watch_file(name: str) -> Path:
    """Return the file of a watch.

    Args:
        name: A name under data/watches, or a path.

    Returns:
        The file.

    Raises:
        UnknownNameError: No watch has that name.
    """
    return data_file("watch", "watches", name)
