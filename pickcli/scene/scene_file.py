"""Reads and writes scene files: items with their poses, as JSON. See docs/formats/scene.md.

Scene files are the interface for poses from other sources, so everything in them is checked, and every
mistake is reported with line and column.
"""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import cell_names, load_cell
from pickcli.cell.fingerprint import digest, numbers, rounded
from pickcli.cell.item import Item
from pickcli.cell.pod_tolerance import Displacement
from pickcli.errors import InputError, StaleError
from pickcli.files.atomic_write import write_text
from pickcli.files.file_kind import SCENE
from pickcli.files.file_warnings import FileWarnings
from pickcli.files.schema import validate
from pickcli.files.source import Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array, from_quaternion, pose, to_quaternion
from pickcli.name_suggestion import suggestion
from pickcli.scene.cloud import Cloud
from pickcli.scene.cloud_file import read_points
from pickcli.scene.scene import TOTE, CarrierPose, HeldItem, PlacedItem, PoseNoise, Scene, tote_pose
from pickcli.scene.scene_checks import (
    check_carriers,
    check_floating,
    check_held,
    check_names,
    check_overlaps,
    check_places,
    check_standing,
    check_unknown,
    check_upright,
)
from pickcli.scene.scene_schema import (
    CellReference,
    CloudModel,
    HeldModel,
    NoiseModel,
    PodErrorModel,
    SceneModel,
    ScenePoseModel,
)
from pickcli.scene.scene_warnings import warn_of_noise
from pickcli.scene.unknown_space import UnknownSpace

_UNIT_TOLERANCE = 1e-3  # tolerated error of a quaternion's length, before it is normalised

# What else makes another scene, for messages.
SCENE_FIGURES = (
    "other poses, noise or pod_error, and other figures of the cell's tool, pump or items make another scene"
)


def read_scene(
    path: Path,
    cell: Cell | None = None,
    load: Callable[[str], Cell] = load_cell,
    warn: Callable[[FileWarnings, Scene], None] | None = None,
) -> Scene:
    """Read a scene file.

    Args:
        path: The file.
        cell: The scene's cell; loaded by its name if None.
        load: Function that loads a cell by its name.
        warn: Function that adds further warnings about the scene.

    Returns:
        The scene.

    Raises:
        InputError: With every mistake and its position.
        StaleError: The file was made for another cell.
    """
    source = read_yaml(Path(path), SCENE, is_json=True)  # keeps line and column of every value
    model = validate(source, SceneModel)
    cell = cell_of_file(source, model.cell, cell, load)
    check_carriers(source, model, cell)
    check_unknown(source, model, cell)
    check_names(source, model, cell)
    scene = Scene(
        cell=cell,
        T_world_pod=(
            cell.T_world_pod
            if model.T_world_pod is None
            else pose_of_model(source, ("T_world_pod",), model.T_world_pod)
        ),
        items=tuple(
            PlacedItem(
                m.id,
                cell.items[m.name, m.year],
                m.location,
                pose_of_model(source, ("items", i), m),
                _noise(m.noise),
            )
            for i, m in enumerate(model.items)
        ),
        noise=PoseNoise(**model.noise.model_dump()),
        seed=model.seed,
        pod_error=_error(model.pod_error),
        carriers={
            name: _carrier_pose(cell, name, pose_of_model(source, ("places", name), at), _error(at.error))
            for name, at in model.places.items()
        },
        held=_held(source, model.held, cell),
        cloud=_cloud(source, model.cloud),
        unknown=tuple(
            UnknownSpace(
                each.place,
                pose_of_model(source, ("unknown", i), each),
                np.array(each.boxes).reshape(-1, 2, 3),
                np.array(each.unrecognised).reshape(-1, 2, 3),
            )
            for i, each in enumerate(model.unknown)
        ),
    )
    source.check()  # poses must be valid before they are compared with places
    check_upright(source, scene)
    source.check()
    check_places(source, scene)
    check_standing(source, scene)
    check_overlaps(source, scene)
    check_held(source, scene)
    source.check()  # an item at a wrong pose is not also reported to float
    check_floating(source, scene)
    source.check()
    warnings = FileWarnings.of(source)
    warn_of_noise(warnings, scene)
    if warn is not None:
        warn(warnings, scene)
    warnings.log()
    return scene


def cell_of_file(
    source: Source,
    stated: CellReference,
    cell: Cell | None,
    load: Callable[[str], Cell],
    kind: str = "scene",
) -> Cell:
    """Return the cell of a file of poses, and refuse a file of another one.

    Args:
        source: The file.
        stated: The cell that it states.
        cell: The cell that the user names; None to load it by its name.
        load: Function that loads a cell by its name.
        kind: Kind of the file, for messages.

    Returns:
        The cell.

    Raises:
        InputError: There is no such cell.
        StaleError: The file was made for another cell.
    """
    cell = cell or _cell_named(source, stated.name, load)
    if stated.fingerprint != cell.scene_fingerprint:
        raise StaleError(
            f"{source.path}: made for cell {stated.name} {stated.fingerprint}, but this is "
            f"{cell.name} {cell.scene_fingerprint}; {_remade(cell, stated.name, kind)}"
        )
    _check_equipment(source.path, stated, cell, kind)
    return cell


def _check_equipment(path: Path, stated_cell: CellReference, cell: Cell, kind: str) -> None:
    """Refuse a file of a cell with other devices, tool or motors, in which other grasps and motions hold."""
    stated = {"devices": stated_cell.devices, "tool": stated_cell.tool, "motors": stated_cell.motors}
    kinds = {
        "devices": "devices (e.g. a pump of another flow)",
        "tool": "load limits of the tool",
        "motors": "motor_forces or masses of links",
    }
    other = [
        kinds[kind]
        for kind, digest in stated.items()
        if digest is not None and digest != cell.equipment.get(kind, digest)
    ]
    if other:
        raise StaleError(
            f"{path}: made for a cell {stated_cell.name} with other {' and '.join(other)} than {cell.path}; "
            f"name its cell with --cell, or make the {kind} again"
        )


def _remade(cell: Cell, name: str, kind: str) -> str:
    """Advice for a file of another cell; scenes of cells without places are written by hand or a camera."""
    if name != cell.name and name in cell_names():
        return f"leave out --cell {cell.name}, or make a {kind} for it"
    if name != cell.name:
        return "name its cell with --cell"
    if cell.places:
        return f"make the {kind} again"
    return "if its poses are still right, write that fingerprint into it"


def _cell_named(source: Source, name: str, load: Callable[[str], Cell]) -> Cell:
    """Load the cell that a scene names. Raises InputError if it does not exist."""
    if name not in cell_names():
        hint = f"{suggestion(name, cell_names())} (for a cell elsewhere: --cell)"
        source.add(("cell", "name"), f"unknown cell {name!r}; {hint}")
        source.check()
    return load(name)


def write_scene(scene: Scene, path: Path, replace: bool = True) -> None:
    """Write a scene file atomically: after a crash or with a full disk the old file is intact.

    Args:
        scene: The scene.
        path: The file.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
    """
    write_text(Path(path), _to_text(scene, Path(path).parent), replace)


@lru_cache(maxsize=32)
def scene_hash(scene: Scene) -> str:
    """Compute the SHA-256 of everything in a scene that the validity of a motion depends on.

    Included: the cell, the load limits of its tool, carrier poses, all error bounds, figures and pose of
    every item, the held item, the cloud and unknown space; not the seed or the order of the items. Writing
    and reading a scene does not change it.

    Args:
        scene: The scene.

    Returns:
        Hexadecimal digits.
    """
    return digest(
        {
            **({} if scene.held is None else {"held": _held_content(scene, scene.held)}),
            **({} if scene.cloud is None else {"cloud": _cloud_content(scene.cloud)}),
            **({"places": _carriers_content(scene)} if scene.carriers else {}),
            **({"unknown": [_unknown_content(each) for each in scene.unknown]} if scene.unknown else {}),
            "cell": scene.cell.fingerprint,
            "T_world_pod": _coarse(scene.T_world_pod),
            "pod_error": numbers(dataclasses.astuple(scene.pod_error)),
            **rounded(scene.cell.robot.tool.grip.limit_figures()),
            "noise": numbers([*scene.noise.figures.values()]),
            "items": sorted(_item_content(scene, placed) for placed in scene.items),
        }
    )


def _carriers_content(scene: Scene) -> dict[str, Any]:
    return {
        name: [_coarse(at.T_world_carrier), numbers(dataclasses.astuple(at.error))]
        for name, at in scene.carriers.items()
    }


def _item_content(scene: Scene, placed: PlacedItem) -> list[Any]:
    figures = _figures(placed.item)
    return [placed.id, placed.location, *figures, _coarse(placed.T_world_item), *_own_noise(scene, placed)]


def _held_content(scene: Scene, held: HeldItem) -> list[Any]:
    return [held.id, *_figures(held.item), _coarse(held.T_tip_item), *_own_noise(scene, held)]


def _own_noise(scene: Scene, instance: PlacedItem | HeldItem) -> list[Any]:
    """Bounds of the error of an item's own pose; none where they are those of the scene."""
    own, others = (numbers([*n.figures.values()]) for n in (scene.noise_of(instance), scene.noise))
    return [] if own == others else [own]


def _unknown_content(space: UnknownSpace) -> list[Any]:
    content = [space.place, _coarse(space.T_world_place), numbers(space.boxes.ravel().tolist())]
    if len(space.unrecognised):
        content.append(numbers(space.unrecognised.ravel().tolist()))
    return content


def _cloud_content(cloud: Cloud) -> list[Any]:
    return [cloud.digest, _coarse(cloud.T_world_sensor), numbers([cloud.radius, cloud.error])]


@lru_cache(maxsize=256)
def _figures(item: Item) -> tuple[Any, ...]:
    """Figures of an item, independent of its pose."""
    return (
        item.name,
        item.year,
        item.shape.kind.value,
        numbers(item.shape.size),
        numbers([item.mass, item.mass_error, item.seal_inset, item.speed_scale]),
        [[face, *numbers([share]), numbers(item.area(face))] for face, share in sorted(item.seals.items())],
        *([_hollows(item)] if item.hollows else ()),
        *([numbers([item.max_tilt])] if item.max_tilt is not None else ()),
    )


def _hollows(item: Item) -> list[Any]:
    """Figures of the hollows of an item, in the order of their names."""
    hollows = sorted(item.hollows, key=lambda hollow: hollow.bottom)
    return [
        [hollow.bottom, numbers([hollow.depth, hollow.radius or 0.0, *np.ravel(hollow.sides).tolist()])]
        for hollow in hollows
    ]


def _coarse(T: Array) -> list[float]:
    """A pose rounded to 1e-7, well above the rounding of a conversion to a quaternion and back."""
    return [round(v, 7) + 0.0 for v in T[:3].ravel().tolist()]


def _held(source: Source, model: HeldModel | None, cell: Cell) -> HeldItem | None:
    if model is None:
        return None
    T_tip_item = pose_of_model(source, ("held",), model)
    return HeldItem(model.id, cell.items[model.name, model.year], T_tip_item, _noise(model.noise))


def _noise(model: NoiseModel | None) -> PoseNoise | None:
    return None if model is None else PoseNoise(**model.model_dump())


def _cloud(source: Source, model: CloudModel | None) -> Cloud | None:
    if model is None:
        return None
    path = source.path.parent / model.file
    T = pose_of_model(source, ("cloud",), model)
    try:
        return Cloud(path, T, read_points(path), model.radius, model.error)
    except InputError as error:
        source.add(("cloud", "file"), str(error))
        return None


def _error(model: PodErrorModel) -> Displacement:
    return Displacement(model.x, model.y, model.yaw)


def pose_of_model(source: Source, key: tuple[str | int, ...], model: ScenePoseModel) -> Array:
    """Return the pose that a file states, and report a quaternion that is none.

    Args:
        source: Collects the mistakes with their places in the file.
        key: Where the pose stands in it.
        model: The pose as it stands in the file.

    Returns:
        (4, 4).
    """
    length = float(np.linalg.norm(model.quaternion))
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        source.add(
            (*key, "quaternion"), f"expected a length of 1, got {length:.4g}; write x, y, z, w normalised"
        )
        return pose()
    x, y, z = model.position
    return pose((x, y, z), R=from_quaternion(model.quaternion))


def _cloud_values(cloud: Cloud, folder: Path) -> dict[str, Any]:
    file = os.path.relpath(cloud.file.resolve(), folder.resolve())
    return {
        "file": file, "radius": cloud.radius, "error": cloud.error, **pose_values(cloud.T_world_sensor)
    }  # fmt: skip


def _to_text(scene: Scene, folder: Path) -> str:
    """Format a scene with one line per item, for readability and diffs."""
    head: dict[str, Any] = {
        "format": "apc scene",
        "version": 1,
        "cell": {
            "name": scene.cell.name,
            "fingerprint": scene.cell.scene_fingerprint,
            **scene.cell.equipment,
        },
        **_carriers_values(scene),
        "noise": scene.noise.figures,
        "seed": scene.seed,
    }
    if scene.held is not None:
        head["held"] = held_values(scene.held)
    if scene.cloud is not None:
        head["cloud"] = _cloud_values(scene.cloud, folder)
    if scene.unknown:
        head["unknown"] = [_unknown_values(space) for space in scene.unknown]
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}," for key, value in head.items()]
    items = ",\n".join("    " + json.dumps(_item_values(placed)) for placed in scene.items)
    return "\n".join(["{", *lines, '  "items": [', items, "  ]", "}"]) + "\n"


def _unknown_values(space: UnknownSpace) -> dict[str, Any]:
    values = {"place": space.place, **pose_values(space.T_world_place), "boxes": space.boxes.tolist()}
    return {**values, "unrecognised": space.unrecognised.tolist()} if len(space.unrecognised) else values


def _carriers_values(scene: Scene) -> dict[str, Any]:
    """Poses of the pod and of user-defined carriers, if the cell has any."""
    values: dict[str, Any] = {}
    if scene.cell.pod.bins:
        values = {
            "T_world_pod": pose_values(scene.T_world_pod),
            "pod_error": dataclasses.asdict(scene.pod_error),
        }
    if scene.carriers:
        values["places"] = {
            name: {**pose_values(_stated_pose(scene, name, at)), "error": dataclasses.asdict(at.error)}
            for name, at in scene.carriers.items()
        }
    return values


def _carrier_pose(cell: Cell, name: str, T: Array, error: Displacement) -> CarrierPose:
    """Pose of a carrier that a file states by T (4, 4); that of the tote is of the middle of its floor."""
    return tote_pose(cell, T, error) if name == TOTE else CarrierPose(T, error)


def _stated_pose(scene: Scene, name: str, at: CarrierPose) -> Array:
    """Pose (4, 4) by which a file states that of a carrier; the inverse of ``_carrier_pose``."""
    if name != TOTE:
        return at.T_world_carrier
    return np.asarray(at.T_world_carrier @ scene.cell.places[TOTE].T_carrier_place)


def held_values(held: HeldItem) -> dict[str, Any]:
    """Return the held item as JSON values.

    Args:
        held: The held item.

    Returns:
        Id, name, year, position, quaternion, and bounds of the error of its own pose.
    """
    named = {"id": held.id, "name": held.item.name, "year": held.item.year}
    return {**named, **pose_values(held.T_tip_item), **_noise_values(held)}


def _item_values(placed: PlacedItem) -> dict[str, Any]:
    return {
        "id": placed.id,
        "name": placed.item.name,
        "year": placed.item.year,
        "location": placed.location,
        **pose_values(placed.T_world_item),
        **_noise_values(placed),
    }


def _noise_values(instance: PlacedItem | HeldItem) -> dict[str, Any]:
    return {} if instance.noise is None else {"noise": instance.noise.figures}


def pose_values(T: Array) -> dict[str, list[float]]:
    """Return a pose as JSON values.

    Args:
        T: (4, 4).

    Returns:
        Position, and quaternion x, y, z, w.
    """
    return {
        "position": [float(v) for v in T[:3, 3]],
        "quaternion": [float(v) for v in to_quaternion(T[:3, :3])],
    }
