"""The scene that a robot believes in after looks: what it saw and recognised, and what remains unknown."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.place import Place, Room
from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.errors import InputError, UnknownNameError
from pickcli.geometry import Array, inverse
from pickcli.perception.items.item_observation import PlaceObservation
from pickcli.perception.items.perceived_file import Perceived
from pickcli.perception.items.unknown_voxels import whole_room
from pickcli.scene.scene import TOTE, CarrierPose, PlacedItem, PoseNoise, Scene, empty_scene
from pickcli.scene.unknown_space import UnknownSpace

_STEP = 0.002  # m that a floor or a ceiling may slope along a box


def believed_scene(
    cell: Cell, looks: Sequence[Perceived], empty: Collection[str] = (), tote: CarrierPose | None = None
) -> Scene:
    """Combine what looks say of places into a scene.

    Answers become items with bounds of their own; answers that were refused, or that have no bounds, are left
    out. Their place in space is unknown, as is all that no ray went through. A place that no look was into is
    unknown as a whole. To all bounds those of the camera's own pose are added.

    Args:
        cell: The cell.
        looks: What was perceived, in order of time; of a place the last look counts.
        empty: Names of places that are known to hold nothing.
        tote: Where the tote was located; None for its place in the cell, or where looks into it have it.

    Returns:
        The scene. Carriers are where the last look into one of their places says, but the pod where the last
        picture in which it was located has it.

    Raises:
        InputError: A look is of another cell or camera, a place is said to be empty that was looked into, two
            places have an item of the same id, the tote was looked into and is located
            otherwise, or bins were looked into with the pod elsewhere than where it
            was located.
        UnknownNameError: A place is not one of the cell's.
    """
    scene = empty_scene(cell)
    if tote is not None:
        _refuse_looks_into_tote(looks)
        scene = replace(scene, carriers={TOTE: tote})
    latest: dict[str, tuple[PlaceObservation, Perceived]] = {}
    for look in looks:
        if look.cell != cell.name:
            raise InputError(f"a look is of cell {look.cell}, not of {cell.name}; believe looks of one cell")
        if look.camera not in cell.cameras:
            raise UnknownNameError("camera", look.camera, list(cell.cameras), f"cell {cell.name}")
        for seen in look.places:
            latest.pop(seen.place, None)
            latest[seen.place] = seen, look
            scene = _carried(scene, seen)
    if located := [look.pod for look in looks if look.pod is not None]:
        scene = replace(scene, T_world_pod=located[-1].T_world_pod, pod_error=located[-1].error)
        _refuse_elsewhere(scene, [seen for seen, _ in latest.values()])
    for name in empty:
        if name not in cell.places:
            raise UnknownNameError("place", name, list(cell.places), f"cell {cell.name}")
        if name in latest:
            raise InputError(f"{name} is said to be empty, but was looked into; only one of both can count")
    items: dict[str, PlacedItem] = {}
    unknown = []
    for name, place in cell.places.items():
        if name in latest:
            seen, look = latest[name]
            error = look.error_about_camera(cell.cameras[look.camera].error)
            for placed in believed_items(seen, look.T_world_camera, error):
                if placed.id in items:
                    raise InputError(
                        f"{placed.id} is in {items[placed.id].location} and in {name}; look again"
                    )
                items[placed.id] = placed
            unknown.append(unknown_in(seen, place, look.T_world_camera, error, cell.clearance))
        elif name not in empty:
            unknown.append(never_seen(place, scene.T_world_place(place), cell.clearance))
    return Scene(
        cell, scene.T_world_pod, tuple(items.values()), PoseNoise(), pod_error=scene.pod_error,
        carriers=scene.carriers, unknown=tuple(space for space in unknown if not space.is_empty),
    )  # fmt: skip


def _refuse_looks_into_tote(looks: Sequence[Perceived]) -> None:
    """Refuse looks into a tote that was located otherwise: its items were seen relative to another place."""
    if any(seen.place == TOTE for look in looks for seen in look.places):
        raise InputError(
            "the tote was looked into where the cell has it, but located elsewhere; leave out one of both"
        )


def _carried(scene: Scene, seen: PlaceObservation) -> Scene:
    """The scene with the carrier of a place where that was seen."""
    place = scene.cell.places[seen.place]
    T = seen.T_world_place @ inverse(place.T_carrier_place)
    if place.name in scene.cell.pod.bins:
        return replace(scene, T_world_pod=T, pod_error=seen.error)
    if np.allclose(T, scene.cell.carriers[place.carrier].T_world_carrier, atol=1e-6):
        return scene
    return replace(scene, carriers={**scene.carriers, place.carrier: CarrierPose(T, seen.error)})


def _refuse_elsewhere(scene: Scene, places: Iterable[PlaceObservation]) -> None:
    """Refuse looks into bins of a pod that does not stand where it was located."""
    error = scene.pod_error
    for seen in places:
        if seen.place not in scene.cell.pod.bins:
            continue
        T_pod = seen.T_world_place @ inverse(scene.cell.places[seen.place].T_carrier_place)
        off, own = inverse(scene.T_world_pod) @ T_pod, seen.error
        if not Displacement(error.x + own.x, error.y + own.y, error.yaw + own.yaw).allows(off):
            raise InputError(
                f"{seen.place} was looked into with the pod {1e3 * np.hypot(*off[:2, 3]):.1f} mm from where "
                "it was located, which is more than both errors; look for its items where the pod was located"
            )


def believed_items(seen: PlaceObservation, T_world_about: Array, error: MountError) -> Iterator[PlacedItem]:
    """Take the answers with useful bounds as items.

    Args:
        seen: What was perceived in a place.
        T_world_about: (4, 4) the pose that all in it may be off with: the stated one of the camera.
        error: Bounds of the error of that.

    Yields:
        The items, with bounds of their own.
    """
    for answer in seen.items:
        T, bound = answer.T_world_item, answer.bound
        if not answer.is_answer or T is None or bound is None:
            continue
        distance = float(np.linalg.norm(T[:3, 3] - T_world_about[:3, 3]))
        by_camera, radius = error.position + error.angle * distance, answer.item.shape.bounding_radius
        within = PoseNoise(
            bound.position + by_camera,
            bound.angle + error.angle,
            None if bound.displacement is None else bound.displacement + by_camera + error.angle * radius,
        )
        yield PlacedItem(answer.id, answer.item, seen.place, T, within)


def unknown_in(
    seen: PlaceObservation, place: Place, T_world_about: Array, error: MountError, clearance: float
) -> UnknownSpace:
    """Grow the unknown space of a place by the error of the pose that all in it may be off with.

    Not through its floor, walls and ceiling, which were located in the same picture: what is unknown is
    between them. It ends below the ceiling by what all motions keep from that: nothing gets there, whatever
    is in it. Else what stands on a thin shelf could not be lifted off it, for what may be right under that.

    Args:
        seen: What was perceived in it.
        place: The place.
        T_world_about: (4, 4) that pose: the stated one of the camera.
        error: Bounds of the error of that.
        clearance: m that every motion keeps from the ceiling.

    Returns:
        The space.
    """
    about = (inverse(seen.T_world_place) @ T_world_about)[:3, 3]
    unknown, unrecognised = (
        _grown(boxes.reshape(-1, 2, 3), about, error, place, clearance)
        for boxes in (seen.unknown, seen.unrecognised)
    )
    return UnknownSpace(seen.place, seen.T_world_place, unknown, unrecognised)


def _grown(boxes: Array, about: Array, error: MountError, place: Place, clearance: float) -> Array:
    """Boxes (N, 2, 3) grown by what points in them may be off, within the sides of the room but its access.

    about: (3,) m, the point about which all may be turned, in the place's frame
    clearance: m below the ceiling at which they end
    """
    boxes, room = _split_on_slope(boxes, place.room), place.room
    farthest = np.linalg.norm(np.maximum(np.abs(boxes[:, 0] - about), np.abs(boxes[:, 1] - about)), axis=1)
    off = (error.position + error.angle * farthest)[:, None]
    low, high = (np.broadcast_to(corner, (len(boxes), 3)).copy() for corner in (room.low, room.high))
    low[:, 2] = room.floor_at(boxes[:, :, 0]).min(axis=1)
    if place.access.is_from_above:
        high[:, 2] = np.inf
    else:
        high[:, 2] = room.ceiling_at(boxes[:, :, 0]).max(axis=1) - clearance
        low[:, 0] = -np.inf
    grown = np.stack([np.maximum(boxes[:, 0] - off, low), np.minimum(boxes[:, 1] + off, high)], axis=1)
    return grown[(grown[:, 0] < grown[:, 1]).all(axis=1)]


def _split_on_slope(boxes: Array, room: Room) -> Array:
    """Cut boxes (N, 2, 3) across x, so that along each floor and ceiling slope by ``_STEP`` at most."""
    drop = max(abs(room.floor_front - room.floor_back), abs(room.ceiling_front - room.ceiling_back))
    if drop == 0.0 or room.floor_flat_from <= room.slope_from:
        return boxes
    cuts = np.linspace(room.slope_from, room.floor_flat_from, 1 + int(np.ceil(drop / _STEP)))
    parts = []
    for low, high in boxes:
        ends = [low[0], *cuts[(cuts > low[0]) & (cuts < high[0])], high[0]]
        parts += [[[a, *low[1:]], [b, *high[1:]]] for a, b in pairwise(ends)]
    return np.array(parts).reshape(-1, 2, 3)


def never_seen(place: Place, T_world_place: Array, clearance: float) -> UnknownSpace:
    """Take a whole place as unknown.

    Args:
        place: The place.
        T_world_place: (4, 4) its pose.
        clearance: m that every motion keeps from the ceiling.

    Returns:
        The space: all between its floor and what is kept free below its ceiling.
    """
    boxes = whole_room(place.room)
    if not place.access.is_from_above:
        ceiling = place.room.ceiling_at(boxes[:, :, 0]).max(axis=1)
        boxes[:, 1, 2] = np.minimum(boxes[:, 1, 2], ceiling - clearance)
    return UnknownSpace(place.name, T_world_place, boxes[boxes[:, 0, 2] < boxes[:, 1, 2]])
