"""Consistency of a file of perceived items: with its cell, and with what perception answers at all.

Such files come from other programs, too, and a planner relies on them. So what no look can have said is a
mistake: names that there are not, answers that contradict themselves, poses that no camera of the cell sees.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.cell.sensors.mounted_camera import MountedCamera
from pickcli.files.source import Key, Source
from pickcli.geometry import Array, inverse
from pickcli.name_suggestion import shortened, suggestion
from pickcli.perception.camera_pose import farthest_camera
from pickcli.perception.items.confidence import LEAST_CONFIDENCE, LEAST_OWN_COLOUR
from pickcli.perception.items.item_observation import FoundBy, PlaceObservation
from pickcli.perception.items.perceived_schema import (
    PerceivedItemModel,
    PerceivedModel,
    PerceivedPlaceModel,
    SupportModel,
)
from pickcli.perception.items.pose_bound import LARGEST, LEAST_CONFIDENCE_OF_BOUND
from pickcli.perception.items.routing import NOT_PRINTED, why_not_printed
from pickcli.perception.recorded_picture import MOST_SHIFT
from pickcli.scene.scene_checks import check_item

_ASIDE = 2.0  # length of a ray over its depth: of one 60 degrees off the axis, which no camera here sees
_ROUNDED = 1e-6  # m, of a pose that was written as position and quaternion


def check_names(source: Source, model: PerceivedModel, cell: Cell) -> None:
    """Check that places, items and twins exist, and none stands twice. Raises at once.

    Args:
        source: The file, for positions in messages.
        model: The file as it stands.
        cell: Its cell.

    Raises:
        InputError: With every mistake and its position.
    """
    places: set[str] = set()
    ids: set[str] = set()
    for i, place in enumerate(model.places):
        key: Key = ("places", i, "place")
        if place.place not in cell.places:
            hint = suggestion(place.place, list(cell.places))
            source.add(key, f"unknown place {shortened(place.place)!r}; {hint}")
        elif place.place in places:
            source.add(key, f"{place.place} stands twice; leave one of both looks out")
        places.add(place.place)
        for k, item in enumerate(place.items):
            at: Key = ("places", i, "items", k)
            if item.id in ids:
                source.add((*at, "id"), f"{item.id!r} stands twice; give each instance an id of its own")
            ids.add(item.id)
            check_item(source, (*at, "name"), item, cell)
            _check_twins(source, at, item, place)
    source.check()  # other checks need them


def _check_twins(source: Source, key: Key, item: PerceivedItemModel, place: PerceivedPlaceModel) -> None:
    """Check that twins are other products among the items of the place."""
    others = {each.name for each in place.items if (each.name, each.year) != (item.name, item.year)}
    twins = () if item.route is None else item.route.twins
    for n, twin in enumerate(twins):
        if twin not in others:
            fault = f"{shortened(twin)!r} is not among the other items of {place.place}"
            source.add((*key, "route", "twins", n), f"{fault}; {suggestion(twin, others)}")
        elif twin in twins[:n]:
            source.add((*key, "route", "twins", n), f"{twin!r} stands twice; leave it out")


def check_answer(source: Source, key: Key, model: PerceivedItemModel, item: Item) -> None:
    """Check that the parts of an answer agree with each other, and its route with the item.

    Args:
        source: Collects the mistakes with their places in the file.
        key: Where the answer stands in it.
        model: The answer as it stands in the file.
        item: Its item.
    """
    if model.pose is None:
        if not model.refusal:
            source.add((*key, "pose"), "is null without a refusal; state one, or the pose")
        for part in ("bound", "support"):
            if getattr(model, part) is not None:
                source.add((*key, part), "is that of a pose, and there is none; set it to null")
        if model.confidence > 0.0:
            source.add((*key, "confidence"), "is that of a pose, and there is none; set it to 0")
    elif not model.refusal and model.confidence < LEAST_CONFIDENCE:
        fault = f"{model.confidence:g} is below {LEAST_CONFIDENCE:g}, from which on a pose is an answer"
        source.add((*key, "confidence"), f"{fault}; state in refusal why it is none")
    if model.support is not None:
        _check_counts(source, (*key, "support"), model.support)
    if model.pose is not None and not model.refusal and FoundBy(model.found_by) is FoundBy.SHAPE:
        _check_support(source, (*key, "support"), model.support)
    if model.pose is not None and model.bound is not None:
        _check_bound(source, key, model)
    if model.route is not None:
        _check_route(source, key, model, item)


def _check_counts(source: Source, key: Key, support: SupportModel) -> None:
    """Check that no more pixels are shown than expected, and no more told of than are shown."""
    if support.shown > support.expected:
        source.add((*key, "shown"), f"is over expected, {support.expected}, of which it is a part")
    told = support.supported + support.through + support.before
    if told > support.shown:
        parts = f"with through and before {told}"
        source.add((*key, "supported"), f"is {parts}, over shown, {support.shown}, of which they are parts")


def _check_support(source: Source, key: Key, support: SupportModel | None) -> None:
    """Check that the picture speaks for an answer by shape alone, and with colours of its item."""
    if support is None:
        source.add(key, "is null, and the item was found by shape; state what the picture says for the pose")
    elif support.own_colour < LEAST_OWN_COLOUR:
        fault = f"{support.own_colour:g} is below {LEAST_OWN_COLOUR:g}, which an answer by shape has at least"
        source.add((*key, "own_colour"), f"{fault}; state in refusal why it is none")


def _check_bound(source: Source, key: Key, model: PerceivedItemModel) -> None:
    """Check that a bound is one of a pose that has one, and as narrow as any has."""
    bound, set_null = model.bound, "set the bound to null"
    assert bound is not None
    if model.refusal:
        source.add((*key, "bound"), f"a refused pose has none; {set_null}")
    elif model.confidence < LEAST_CONFIDENCE_OF_BOUND:
        least = f"below {LEAST_CONFIDENCE_OF_BOUND:g} nothing is said of the error of a pose"
        source.add((*key, "bound"), f"the confidence is {model.confidence:g}, and {least}; {set_null}")
    elif bound.position > LARGEST.position or bound.angle > LARGEST.angle:
        most = f"{LARGEST.position:g} m or {LARGEST.angle:.4g} rad"
        source.add((*key, "bound"), f"is wider than {most}, beyond which a pose has none; {set_null}")


def _check_route(source: Source, key: Key, model: PerceivedItemModel, item: Item) -> None:
    """Check that a route says either how a print was looked for or why not, and that the rest fits that."""
    route, at = model.route, (*key, "route")
    assert route is not None
    not_printed = why_not_printed(item)
    if route.views is None:
        if not route.why:
            source.add((*at, "why"), "is empty, and views null; state why no print was looked for, or views")
        elif route.why in NOT_PRINTED and not not_printed:
            source.add((*at, "why"), f"{route.why!r}, but {item.name} is printed; correct it")
        if FoundBy(model.found_by) is FoundBy.PRINT:
            fault = 'is "print", but by its route no print was looked for; correct one of both'
            source.add((*key, "found_by"), fault)
        return
    if route.why:
        fault = f"{shortened(route.why)!r} says why no print was looked for, but views has how"
        source.add((*at, "why"), f'{fault}; set it to "", or views to null')
    elif not_printed:
        fault = f"a print of {item.name} was looked for, but {not_printed}"
        source.add((*at, "views"), f"{fault}; set it to null and say so in why")
    elif model.bound is not None and FoundBy(model.found_by) is FoundBy.SHAPE and not model.refusal:
        fault = "its print was looked for and not recognised, so another item may be there"
        source.add((*key, "bound"), f'{fault}; set it to null, or found_by to "print"')


def check_cameras(source: Source, cell: Cell, camera: MountedCamera, poses: Mapping[Key, Array]) -> None:
    """Check that a camera of the cell can be where its pictures were taken.

    Args:
        source: Collects the mistakes with their places in the file.
        cell: The cell.
        camera: The camera.
        poses: (4, 4) its stated poses in the world, by where they stand in the file.
    """
    robot = cell.robot
    if camera.link is None:
        origin, most = camera.T_parent_camera[:3, 3], MOST_SHIFT
        where = f"where cell {cell.name} has camera {camera.name}, which stays there"
    else:
        origin, most = robot.T_world_base[:3, 3], farthest_camera(robot, camera) + MOST_SHIFT
        where = f"the base of {robot.name}, which takes camera {camera.name} no farther than {most:.1f} m"
    for key, T in poses.items():
        away = float(np.linalg.norm(T[:3, 3] - origin))
        if away > most:
            source.add((*key, "position"), f"is {away:.3g} m from {where}; correct it (in m)")


def check_sight(
    source: Source,
    key: Key,
    seen: PlaceObservation,
    place: Place,
    camera: MountedCamera,
    poses: Sequence[Array],
) -> None:
    """Check that a place and what was found in it are where a camera measures, and answers in the place.

    Args:
        source: Collects the mistakes with their places in the file.
        key: Where the place stands in it.
        seen: What was perceived in the place.
        place: The place.
        camera: The camera, which measures depth.
        poses: (4, 4) its poses in the world.
    """
    assert camera.model.depth is not None
    greatest, T_place_world = camera.model.depth.greatest, inverse(seen.T_world_place)
    eyes = np.array([(T_place_world @ T)[:3, 3] for T in poses])
    beyond = f"from the camera, which measures up to {greatest:g} m; correct it (in m)"
    beside = eyes - np.clip(eyes, place.room.low, place.room.high)
    if (away := float(np.linalg.norm(beside, axis=1).min())) > _ASIDE * greatest:
        source.add((*key, "pose", "position"), f"{seen.place} is {away:.3g} m {beyond}")
        return  # so are its items
    for k, item in enumerate(seen.items):
        if item.T_world_item is None:
            continue
        at: Key = (*key, "items", k, "pose", "position")
        middle = (T_place_world @ item.T_world_item)[:3, 3]
        away = float(np.linalg.norm(eyes - middle, axis=1).min())
        if away > _ASIDE * greatest + item.item.shape.bounding_radius:
            source.add(at, f"{item.id} is {away:.3g} m {beyond}")
        elif item.is_answer and not _is_in(place, middle):
            fault = f"the middle of {item.id} is outside of {seen.place}"
            source.add(at, f"{fault}, so it is no answer; correct it, or state the refusal")


def _is_in(place: Place, middle: Array) -> bool:
    """Whether the middle (3,) of an item, m in the place's frame, is in a place, but for rounding."""
    nearest = np.clip(middle, place.room.low, place.room.high)
    return place.holds(nearest if np.abs(middle - nearest).max() < _ROUNDED else middle, np.inf)
