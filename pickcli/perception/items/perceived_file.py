"""Reads and writes what a camera perceived: answers for the listed items of places, and the pod, as JSON.

See docs/formats/perceived.md.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.sensors.mounted_camera import MountedCamera, MountError
from pickcli.files.atomic_write import write_text
from pickcli.files.file_kind import PERCEIVED
from pickcli.files.schema import validate
from pickcli.files.source import Key, Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array, from_quaternion, inverse, pose
from pickcli.perception.items.item_observation import (
    FoundBy,
    ItemObservation,
    PlaceObservation,
    Support,
    UnexplainedPart,
)
from pickcli.perception.items.perceived_checks import (
    check_answer,
    check_cameras,
    check_names,
    check_sight,
)
from pickcli.perception.items.perceived_schema import (
    LocatedPodModel,
    PerceivedItemModel,
    PerceivedModel,
    PerceivedPoseModel,
)
from pickcli.perception.items.routing import ItemRoute
from pickcli.perception.pod_pose import PodEstimate, PodStart
from pickcli.scene.scene import PoseNoise
from pickcli.scene.scene_checks import check_boxes
from pickcli.scene.scene_file import pose_values

_UPRIGHT = 1e-3  # m and rad, by which a pod may be over the floor or tilted
_UNIT_TOLERANCE = 1e-3  # of a quaternion's length, before it is normalised


@dataclass(frozen=True, eq=False)
class Perceived:
    """What pictures of a camera say of the items in one or several places, and of the pod.

    Attributes:
        cell: Name of the cell.
        camera: Name of the camera in it.
        sensor: Name of its model.
        T_world_camera: (4, 4) its stated pose; of the first picture, if there are several.
        places: The answers by place.
        pod: Where the pod stands; None if it was not located.
        also_from: (4, 4) its stated poses of further pictures.
        versions: Versions of the packages that shaped the answers, by name; none if that is not known.
    """

    cell: str
    camera: str
    sensor: str
    T_world_camera: Array
    places: tuple[PlaceObservation, ...]
    pod: PodEstimate | None = None
    also_from: tuple[Array, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)

    def error_about_camera(self, mount: MountError) -> MountError:
        """Bound by how much all that was seen may be off alike, about the pose of the first picture.

        Args:
            mount: Bounds of the error of the camera's pose, in each picture by itself.

        Returns:
            The bounds: a turn about the camera of another picture is one about the first, and a shift.
        """
        first = self.T_world_camera[:3, 3]
        apart = max((float(np.linalg.norm(T[:3, 3] - first)) for T in self.also_from), default=0.0)
        return MountError(mount.position + mount.angle * apart, mount.angle)


def perceived_values(perceived: Perceived) -> dict[str, Any]:
    """Convert to JSON values.

    Args:
        perceived: What was perceived.

    Returns:
        The content of a file.
    """
    return {
        "format": "apc perceived",
        "version": 1,
        "cell": perceived.cell,
        "camera": perceived.camera,
        "sensor": perceived.sensor,
        "camera_pose": pose_values(perceived.T_world_camera),
        **({"also_from": [pose_values(T) for T in perceived.also_from]} if perceived.also_from else {}),
        "places": [
            {
                "place": each.place,
                "pose": pose_values(each.T_world_place),
                "seen": each.seen,
                "items": [_item_values(item) for item in each.items],
                "unexplained": [
                    {"pixels": part.n_pixels, "low": part.low.tolist(), "high": part.high.tolist()}
                    for part in each.unexplained
                ],
                "unknown": each.unknown.tolist(),
                "unrecognised": each.unrecognised.tolist(),
                "error": dataclasses.asdict(each.error),
            }
            for each in perceived.places
        ],
        **({} if perceived.pod is None else {"pod": _pod_values(perceived.pod)}),
        **({"made_from": {"versions": dict(perceived.versions)}} if perceived.versions else {}),
    }


def write_perceived(perceived: Perceived, path: Path, replace: bool = True) -> None:
    """Write a file of perceived items atomically.

    Args:
        perceived: What was perceived.
        path: The file.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
    """
    write_text(path, json.dumps(perceived_values(perceived), indent=1) + "\n", replace)


def read_perceived(
    path: Path, cell: Cell | None = None, load: Callable[[str], Cell] = load_cell
) -> Perceived:
    """Read a file of perceived items.

    Args:
        path: The file.
        cell: The cell, for its items and places; loaded by its name if None.
        load: Function that loads a cell by its name.

    Returns:
        What was perceived.

    Raises:
        InputError: The file has mistakes: with every problem.
        UnknownNameError: There is no such cell.
    """
    source = read_yaml(path, PERCEIVED, is_json=True)
    model = validate(source, PerceivedModel)
    cell = cell or load(model.cell)
    camera = _camera(source, model, cell)
    check_names(source, model, cell)
    places = []
    for i, each in enumerate(model.places):
        T = _pose(source, ("places", i, "pose"), each.pose)
        error = Displacement(each.error.x, each.error.y, each.error.yaw)
        if each.place in cell.pod.bins:
            T_pod = T @ inverse(cell.places[each.place].T_carrier_place)
            _check_pod(source, ("places", i, "pose"), T_pod, error, cell, f"with it the pod of {each.place} ")
        items = tuple(
            _item(source, ("places", i, "items", k), item, cell) for k, item in enumerate(each.items)
        )
        left = tuple(
            UnexplainedPart(part.pixels, np.array(part.low), np.array(part.high)) for part in each.unexplained
        )
        check_boxes(source, ("places", i, "unknown"), each.unknown)
        check_boxes(source, ("places", i, "unrecognised"), each.unrecognised)
        unknown, unrecognised = (
            np.array(boxes).reshape(-1, 2, 3) for boxes in (each.unknown, each.unrecognised)
        )
        places.append(PlaceObservation(each.place, T, items, left, each.seen, unknown, error, unrecognised))
    T_world_camera = _pose(source, ("camera_pose",), model.camera_pose)
    pod = None if model.pod is None else _pod(source, model.pod, cell)
    also_from = tuple(_pose(source, ("also_from", i), each) for i, each in enumerate(model.also_from))
    source.check()  # poses must be valid before they are compared with places
    if camera is not None:
        taken: dict[Key, Array] = {("camera_pose",): T_world_camera}
        taken |= {("also_from", i): T for i, T in enumerate(also_from)}
        check_cameras(source, cell, camera, taken)
        source.check()  # places are not also told to be far from a camera that is elsewhere
        for i, seen in enumerate(places):
            check_sight(source, ("places", i), seen, cell.places[seen.place], camera, list(taken.values()))
    source.check()
    versions = {} if model.made_from is None else model.made_from.versions
    return Perceived(
        model.cell, model.camera, model.sensor, T_world_camera, tuple(places), pod, also_from, versions
    )


def _camera(source: Source, model: PerceivedModel, cell: Cell) -> MountedCamera | None:
    """The camera; refused if the cell does not have it, or has it of another model: its errors are others.

    None of another cell, which is told by whoever needs the file to be of this one.
    """
    if model.cell != cell.name:
        return None
    if (camera := cell.cameras.get(model.camera)) is None:
        has = f"has {', '.join(cell.cameras)}" if cell.cameras else "has none"
        source.add(("camera",), f"cell {cell.name} has no camera {model.camera}, it {has}; look again")
    elif camera.model.name != model.sensor:
        own = camera.model.name
        source.add(("sensor",), f"camera {model.camera} of cell {cell.name} is {own} by now; look again")
    elif camera.model.depth is None:
        source.add(("sensor",), f"{model.sensor} measures no depth, by which all is found; correct it")
    return camera


def _pod(source: Source, model: LocatedPodModel, cell: Cell) -> PodEstimate:
    T = _pose(source, ("pod", "pose"), model.pose)
    error = Displacement(model.error.x, model.error.y, model.error.yaw)
    if not cell.pod.bins:
        source.add(("pod",), f"cell {cell.name} has no pod; leave it out")
    else:
        _check_pod(source, ("pod", "pose"), T, error, cell)
    start = None if model.start is None else PodStart(model.start)
    return PodEstimate(T, error, model.front_error, model.explained, model.pixels, start)


def _check_pod(
    source: Source, key: Key, T_world_pod: Array, error: Displacement, cell: Cell, what: str = ""
) -> None:
    """Check that a pod, as a pose (4, 4) has it, stands on the floor and within its tolerance and error."""
    free, off = cell.pod.displacement, inverse(cell.T_world_pod) @ T_world_pod
    most = Displacement(free.x + error.x, free.y + error.y, free.yaw + error.yaw)
    if np.abs(off[2] - [0.0, 0.0, 1.0, 0.0]).max() > _UPRIGHT:
        source.add(key, f"{what}leans, or is not on the floor; a pod is displaced by x, y and yaw only")
    elif not most.allows(off):
        source.add(key, f"{what}is beyond the pod's tolerance in the cell; locate it again")


def _item(source: Source, key: Key, model: PerceivedItemModel, cell: Cell) -> ItemObservation:
    T = None if model.pose is None else _pose(source, (*key, "pose"), model.pose)
    support = None if model.support is None else Support(**model.support.model_dump())
    bound = None if model.bound is None else PoseNoise(**model.bound.model_dump())
    item = cell.items[model.name, model.year]
    check_answer(source, key, model, item)
    route = None
    if model.route is not None:
        route = ItemRoute(model.route.views, model.route.why, model.route.twins)
    return ItemObservation(
        model.id, item, T, model.confidence, model.refusal, bound, support,
        found_by=FoundBy(model.found_by), route=route,
    )  # fmt: skip


def _pose(source: Source, key: Key, model: PerceivedPoseModel) -> Array:
    length = float(np.linalg.norm(model.quaternion))
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        fault = f"expected a length of 1, got {length:.4g}; write x, y, z, w normalised"
        source.add((*key, "quaternion"), fault)
        return pose()
    return pose(np.array(model.position), R=from_quaternion(model.quaternion))


def _item_values(item: ItemObservation) -> dict[str, Any]:
    return {
        "id": item.id,
        "name": item.item.name,
        "year": item.item.year,
        "pose": None if item.T_world_item is None else pose_values(item.T_world_item),
        "found_by": item.found_by.value,
        "confidence": item.confidence,
        "refusal": item.refusal,
        "bound": None if item.bound is None else item.bound.figures,
        "support": None if item.support is None else dataclasses.asdict(item.support),
        **({} if item.route is None else {"route": route_values(item.route)}),
    }


def route_values(route: ItemRoute) -> dict[str, Any]:
    """Convert a route to JSON values.

    Args:
        route: The route.

    Returns:
        Its values by key.
    """
    views = None if route.views is None else route.views.value
    return {"views": views, "why": route.why, "twins": list(route.twins)}


def _pod_values(pod: PodEstimate) -> dict[str, Any]:
    return {
        "pose": pose_values(pod.T_world_pod),
        "error": dataclasses.asdict(pod.error),
        "front_error": pod.front_error,
        "explained": pod.explained,
        "pixels": pod.n_pixels,
        "start": None if pod.start is None else pod.start.value,
    }
