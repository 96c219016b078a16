"""Reads and writes watched scenes. See docs/formats/watch.md."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Len
from pydantic import Field

from pickcli.driving.driving_area import DrivingArea
from pickcli.files.file_kind import WATCHED_SCENE
from pickcli.files.schema import Angle, Coordinate, FileModel, Text, validate
from pickcli.files.source import Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.name_suggestion import suggestion
from pickcli.watching.foreseen_contact import outline_distance
from pickcli.watching.watched_scene import Reflector, ReflectorKind, SunPatch, Walker, WatchedScene

MOST_WALKERS, MOST_REFLECTORS, MOST_SUN = 20, 100, 20
MOST_TIME = 600.0  # s
USUAL_HEIGHT = 2.0  # m of boxes whose height is not stated
Point = Annotated[tuple[Coordinate, ...], Len(2, 2)]
Place = Annotated[tuple[Coordinate, ...], Len(3, 3)]
Side = Annotated[float, Field(ge=0.01, le=50)]


class WalkerModel(FileModel):
    """A person."""

    name: Text = Field(description="name in reports")
    route: Annotated[tuple[Point, ...], Len(1, 50)] = Field(description="places one after the other, m")
    speed: Annotated[float, Field(ge=0, le=5)] = Field(1.0, description="m/s")
    start: Annotated[float, Field(ge=0, le=MOST_TIME)] = Field(0.0, description="s of the first step")
    height: Annotated[float, Field(ge=1.2, le=2.3)] = Field(1.75, description="m")
    has_vest: bool = Field(True, description="whether the person wears a vest")


class ReflectorModel(FileModel):
    """Something else that reflects the flash."""

    kind: ReflectorKind = Field(description="sign, tape or post")
    centre: Place = Field(description="m")
    size: Annotated[tuple[Side, ...], Len(2, 2)] = Field(description="m along the floor and upwards")
    yaw: Angle = Field(0.0, description="rad, where its face looks")
    is_flat: bool = Field(False, description="whether it lies on the floor")


class SunModel(FileModel):
    """A rectangle in the sun."""

    centre: Point = Field(description="m")
    size: Annotated[tuple[Side, ...], Len(2, 2)] = Field(description="m along its own x and y")
    yaw: Angle = Field(0.0, description="rad")
    strength: Annotated[float, Field(ge=1, le=100)] = Field(description="times the light indoors")


class WatchedSceneModel(FileModel):
    """A whole file."""

    format: Literal["apc watched scene"] = Field(description="'apc watched scene'")
    version: Literal[1] = Field(description="1, the only version there is")
    duration: Annotated[float, Field(gt=0, le=MOST_TIME)] = Field(60.0, description="s, at most")
    box_heights: dict[Text, Annotated[float, Field(ge=0.01, le=10)]] = Field(
        default_factory=dict, description="m, by the name of a box of the area; 2 for all others"
    )
    walkers: Annotated[tuple[WalkerModel, ...], Len(0, MOST_WALKERS)] = Field((), description="the people")
    reflectors: Annotated[tuple[ReflectorModel, ...], Len(0, MOST_REFLECTORS)] = Field(
        (), description="what reflects the flash beside vests"
    )
    sun: Annotated[tuple[SunModel, ...], Len(0, MOST_SUN)] = Field((), description="where the sun shines")


def read_watched_scene(path: Path, area: DrivingArea) -> WatchedScene:
    """Read a watched scene.

    Args:
        path: The file, YAML or JSON.
        area: The area that it is in.

    Returns:
        The scene.

    Raises:
        InputError: With every mistake and its position: two people of one name, people outside of the walls
            or where the truck starts, a box that the area has not, and all that the format forbids.
    """
    source = read_yaml(path, WATCHED_SCENE)
    model = validate(source, WatchedSceneModel)
    names = [box.name for box in area.boxes]
    for name in model.box_heights:
        if name not in names:
            source.add(("box_heights", name), f"the area has no box of that name; {suggestion(name, names)}")
    _refuse_walkers(source, model, area)
    source.check()
    return WatchedScene(
        area, tuple(model.box_heights.get(name, USUAL_HEIGHT) for name in names),
        tuple(Walker(**dict(each)) for each in model.walkers),
        tuple(Reflector(**dict(each)) for each in model.reflectors),
        tuple(SunPatch(**dict(each)) for each in model.sun), model.duration,
    )  # fmt: skip


def _refuse_walkers(source: Source, model: WatchedSceneModel, area: DrivingArea) -> None:
    """Note people of one name, outside of the walls, or where the truck starts."""
    known: set[str] = set()
    for k, walker in enumerate(model.walkers):
        key = ("walkers", k)
        if walker.name in known:
            source.add((*key, "name"), f"{walker.name} is the name of another one, too; change one of them")
        known.add(walker.name)
        if area.wall_distance(np.array(walker.route)).min() <= 0:
            source.add((*key, "route"), f"{walker.name} leaves the walls; keep all places within them")
        first = np.array(walker.route[:1])
        if outline_distance(area.truck, area.start[None], first)[0] <= 0:
            source.add((*key, "route"), f"{walker.name} begins where the truck starts; move one of them")


def scene_to_dict(scene: WatchedScene) -> dict[str, Any]:
    """Return a scene as the content of a file.

    Args:
        scene: The scene.

    Returns:
        Plain values, as ``read_watched_scene`` reads them.
    """
    boxes = zip(scene.area.boxes, scene.box_heights, strict=True)
    return {
        "format": "apc watched scene",
        "version": 1,
        "duration": scene.duration,
        "box_heights": {box.name: height for box, height in boxes},
        "walkers": [
            {
                "name": each.name, "route": [list(place) for place in each.route], "speed": each.speed,
                "start": each.start, "height": each.height, "has_vest": each.has_vest,
            }
            for each in scene.walkers
        ],
        "reflectors": [
            {
                "kind": str(each.kind), "centre": list(each.centre), "size": list(each.size), "yaw": each.yaw,
                "is_flat": each.is_flat,
            }
            for each in scene.reflectors
        ],
        "sun": [
            {
                "centre": list(each.centre), "size": list(each.size), "yaw": each.yaw,
                "strength": each.strength,
            }
            for each in scene.sun
        ],
    }  # fmt: skip
