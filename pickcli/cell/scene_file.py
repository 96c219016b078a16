"""Scene files: which items lie where, as JSON. See docs/formats/scene.md.

The interface for anyone who has poses from elsewhere, so everything in it is checked and every mistake is
told with line and column.
"""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Len
from pydantic import Field

from pickcli.cell.atomic import write_text
from pickcli.cell.fingerprint import digest, numbers
from pickcli.cell.load import load_cell
from pickcli.cell.model import Cell
from pickcli.cell.overlap import TOUCH, Solid, overlap_depth
from pickcli.cell.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.cell.validate import FileModel, NotNegative, Number, Vector, validate
from pickcli.cell.yaml_reader import Source, read_yaml
from pickcli.errors import StaleError
from pickcli.geometry import Array, from_quaternion, inverse, pose, to_quaternion

MAX_ASTRAY = 0.15  # m, how far an item's middle may be outside of its bin before the pose is called wrong
_UNIT_TOLERANCE = 1e-3  # of a quaternion's length; it is normalised then

Quaternion = Annotated[tuple[Number, ...], Len(4, 4)]


class PoseModel(FileModel):
    """A pose in the world."""

    position: Vector = Field(description="a position [x, y, z] in m")
    quaternion: Quaternion = Field(description="a unit quaternion [x, y, z, w]")


class CellReference(FileModel):
    """The cell that the scene belongs to."""

    name: str = Field(min_length=1, description="the cell's name")
    fingerprint: str = Field(pattern=r"^[0-9a-f]{64}$", description="the cell's fingerprint, 64 hex digits")


class NoiseModel(FileModel):
    """Bounds of the error of the item poses."""

    position: NotNegative = Field(description="m")
    angle: Annotated[float, Field(ge=0, le=3.2, allow_inf_nan=False)] = Field(description="rad")


class PlacedItemModel(PoseModel):
    """One instance of an item."""

    id: str = Field(min_length=1, description="a name of its own in this scene")
    name: str = Field(min_length=1, description="an item's name")
    year: int = Field(description="2015 or 2016")
    location: str = Field(min_length=1, description="a bin's name, or 'tote'")


class SceneModel(FileModel):
    """A whole scene file."""

    format: Literal["apc scene"] = Field(description="'apc scene'")
    version: Literal[1] = Field(description="1, the only version there is")
    cell: CellReference = Field(description="the cell's name and fingerprint")
    T_world_pod: PoseModel = Field(description="where the pod stands now")
    noise: NoiseModel = Field(description="bounds of the error of the item poses")
    seed: int = Field(ge=0, description="the seed it was made with")
    items: tuple[PlacedItemModel, ...] = Field(description="the items")


def read_scene(path: Path, cell: Cell | None = None) -> Scene:
    """The scene in a file; its cell is loaded by name unless given.

    Raises InputError with every mistake and its place, StaleError if the file was made for another cell.
    """
    source = read_yaml(Path(path))  # JSON is YAML, and so every value has a line and a column
    model = validate(source, SceneModel)
    cell = cell or load_cell(model.cell.name)
    if model.cell.fingerprint != cell.fingerprint:
        raise StaleError(
            f"{path}: made for cell {model.cell.name} {model.cell.fingerprint}, but this is "
            f"{cell.name} {cell.fingerprint}; make the scene again"
        )
    _check_names(source, model, cell)
    scene = Scene(
        cell=cell,
        T_world_pod=_pose(source, ("T_world_pod",), model.T_world_pod),
        items=tuple(
            PlacedItem(m.id, cell.items[m.name, m.year], m.location, _pose(source, ("items", i), m))
            for i, m in enumerate(model.items)
        ),
        noise=PoseNoise(model.noise.position, model.noise.angle),
        seed=model.seed,
    )
    _check_places(source, scene)
    _check_overlaps(source, scene)
    source.check()
    return scene


def write_scene(scene: Scene, path: Path) -> None:
    """Write a scene file: the old one or the new one, whole. Raises InputError if it cannot be written."""
    write_text(Path(path), _to_text(scene))


def scene_hash(scene: Scene) -> str:
    """SHA-256 (hex) of what the validity of a motion in this scene depends on.

    The cell, where the pod stands, the noise bounds, and every item's figures and pose; not the seed and
    not the order of the items. Survives writing and reading.
    """
    return digest(
        {
            "cell": scene.cell.fingerprint,
            "T_world_pod": _coarse(scene.T_world_pod),
            "noise": numbers([scene.noise.position, scene.noise.angle]),
            "items": sorted(_item_content(placed) for placed in scene.items),
        }
    )


def _item_content(placed: PlacedItem) -> list[Any]:
    item = placed.item
    return [
        placed.id,
        placed.location,
        item.name,
        item.year,
        item.shape.kind.value,
        numbers(item.shape.size),
        numbers([item.mass, item.seal_inset, item.speed_scale]),
        item.suction,
        _coarse(placed.T_world_item),
    ]


def _coarse(T: Array) -> list[float]:
    """A pose rounded to 1e-7: far over the noise of turning it into a quaternion and back."""
    return [round(float(v), 7) + 0.0 for v in T[:3].ravel()]


def _pose(source: Source, key: tuple[str | int, ...], model: PoseModel) -> Array:
    length = float(np.linalg.norm(model.quaternion))
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        source.add(
            (*key, "quaternion"), f"expected a length of 1, got {length:.4g}; write x, y, z, w normalised"
        )
        return np.eye(4)
    x, y, z = model.position
    return pose((x, y, z), R=from_quaternion(model.quaternion))


def _check_names(source: Source, model: SceneModel, cell: Cell) -> None:
    """Ids of their own, known items and known places; raises at once, for the rest needs them."""
    from difflib import get_close_matches

    locations = [*cell.pod.bins, TOTE]
    seen: set[str] = set()
    for i, item in enumerate(model.items):
        if item.id in seen:
            source.add(("items", i, "id"), f"{item.id!r} stands twice; give each instance an id of its own")
        seen.add(item.id)
        if (item.name, item.year) not in cell.items:
            known = [name for name, year in cell.items if year == item.year]
            close = get_close_matches(item.name, known, n=1)
            hint = f"did you mean {close[0]!r}?" if close else "add it to data/items or correct the name"
            source.add(("items", i, "name"), f"unknown item {item.name!r} of {item.year}; {hint}")
        if item.location not in locations:
            source.add(
                ("items", i, "location"), f"unknown place {item.location!r}; known: {', '.join(locations)}"
            )
    source.check()


def _check_places(source: Source, scene: Scene) -> None:
    """Every item lies about where its location says: catches poses in another frame."""
    for i, placed in enumerate(scene.items):
        if placed.location == TOTE:
            continue
        bin_ = scene.cell.pod.bins[placed.location]
        p = (inverse(scene.T_world_pod @ bin_.T_pod_bin) @ placed.T_world_item)[:3, 3]
        low = np.array([0.0, bin_.y_range[0], bin_.floor_back])
        high = np.array([bin_.depth, bin_.y_range[1], bin_.ceiling_front])
        astray = float(np.linalg.norm(p - np.clip(p, low, high)))
        if astray > MAX_ASTRAY:
            source.add(
                ("items", i, "position"),
                f"{placed.id} is {astray:.2f} m away from {placed.location}; poses are those of the item's "
                "middle in the world frame (docs/formats/scene.md)",
            )


def _check_overlaps(source: Source, scene: Scene) -> None:
    """No two items stand in each other deeper than their poses are uncertain."""
    solids = [Solid(placed.item.shape, placed.T_world_item) for placed in scene.items]
    bounds = [TOUCH + 2 * scene.noise.bound(placed.item) for placed in scene.items]
    for (i, a), (j, b) in combinations(enumerate(solids), 2):
        depth = overlap_depth(a, b, tolerance=(bounds[i] + bounds[j]) / 2)
        if depth > 0.0:
            source.add(
                ("items", j),
                f"{scene.items[i].id} and {scene.items[j].id} overlap by {1000 * depth:.1f} mm; "
                "correct one of the poses",
            )


def _to_text(scene: Scene) -> str:
    """One line per item, so that scenes can be read and compared."""
    head = {
        "format": "apc scene",
        "version": 1,
        "cell": {"name": scene.cell.name, "fingerprint": scene.cell.fingerprint},
        "T_world_pod": _pose_values(scene.T_world_pod),
        "noise": {"position": scene.noise.position, "angle": scene.noise.angle},
        "seed": scene.seed,
    }
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}," for key, value in head.items()]
    items = ",\n".join("    " + json.dumps(_item_values(placed)) for placed in scene.items)
    return "\n".join(["{", *lines, '  "items": [', items, "  ]", "}"]) + "\n"


def _item_values(placed: PlacedItem) -> dict[str, Any]:
    return {
        "id": placed.id,
        "name": placed.item.name,
        "year": placed.item.year,
        "location": placed.location,
        **_pose_values(placed.T_world_item),
    }


def _pose_values(T: Array) -> dict[str, list[float]]:
    return {
        "position": [float(v) for v in T[:3, 3]],
        "quaternion": [float(v) for v in to_quaternion(T[:3, :3])],
    }
