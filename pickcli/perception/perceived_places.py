"""From pictures to answers for all places that they show: what ``apc perceive`` and scripts do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from pickcli.cell.place import Place
from pickcli.errors import InputError
from pickcli.perception.camera_picture import CameraPicture
from pickcli.perception.items.item_observation import PlaceObservation
from pickcli.perception.items.item_perception import PlaceLook, concluded
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.perceived_file import Perceived
from pickcli.perception.items.room_sight import LEAST_SEEN, RoomSight, coarse_view, room_sight
from pickcli.perception.items.routing import ItemRoute, PrintSearch, pixels_per_mm, routes_of
from pickcli.perception.perception_versions import perception_versions
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.perception.textures.sift_views import SiftRule
from pickcli.perception.viewpoints import Viewpoint
from pickcli.scene.scene import Scene

Contents: TypeAlias = Mapping[str, Sequence[ListedItem]]  # by name of the place


def listed_in(scene: Scene, may_deform: bool = False) -> Contents:
    """List what a scene has in each place, without what the tool holds.

    Args:
        scene: The scene.
        may_deform: Whether cloth, bags and plush may look other than their boxes.

    Returns:
        The items by name of the place.
    """
    held = None if scene.held is None else scene.held.id
    placed = {name: scene.in_location(name) for name in scene.cell.places}
    return {
        name: [ListedItem.of(each.id, each.item, may_deform) for each in items if each.id != held]
        for name, items in placed.items()
    }


def places_in_sight(
    scene: Scene, contents: Contents, viewpoints: Mapping[str, Viewpoint], advice: str
) -> tuple[Place, ...]:
    """Choose the places with items of whose room enough is seen.

    Args:
        scene: The scene, for where the places are.
        contents: What is listed to be in each.
        viewpoints: From where pictures are taken, by how messages call them.
        advice: What to do if there is none, as "move the arm".

    Returns:
        The places, in the order of the cell.

    Raises:
        InputError: No items are listed, or too little is seen of all places with items.
    """
    listed = [place for place in scene.cell.places.values() if contents.get(place.name)]
    if not listed:
        raise InputError("no items are listed to be in any place; name the places to look into")
    sights = {place: _best_sight(scene, place, list(viewpoints.values())) for place in listed}
    most = max(sights, key=lambda place: sights[place].seen)
    if not sights[most].is_enough:
        best = f"of {most.name}, the best of these, {sights[most].fault}" if sights[most].seen else ""
        raise InputError(
            f"{next(iter(viewpoints))}: shows less than {LEAST_SEEN:.0%} of the room of every place with "
            f"items{': ' * bool(best)}{best}; {advice} before one"
        )
    return tuple(place for place, sight in sights.items() if sight.is_enough)


def perceived_place(
    scene: Scene, place: Place, listed: Sequence[ListedItem], taken: Sequence[CameraPicture],
    prints: PrintSearch,
) -> PlaceObservation:  # fmt: skip
    """Find the items of a place in all pictures that show enough of it; in the best one if none does.

    Args:
        scene: A scene, for where the places are.
        place: The place.
        listed: What is known to be in it.
        taken: The pictures.
        prints: Whether and how prints are looked for.

    Returns:
        The answers.

    Raises:
        InputError: The pictures show too little of the place, an item has no model, or a print is to be
            looked for and OpenCV is not installed.
    """
    T = scene.T_world_place(place)
    sights = [(each, _sight(scene, place, each.viewpoint)) for each in taken]
    enough = [each for each, sight in sights if sight.is_enough]
    used = enough or [max(sights, key=lambda seen: seen[1].seen)[0]]
    looks = [
        PlaceLook.of(each.rgbd, place, T, listed, known_from(scene, each.viewpoint), prints) for each in used
    ]
    return replace(concluded(looks), error=scene.pose_of(scene.cell.carriers[place.carrier]).error)


def perceived_in(
    scene: Scene, contents: Contents, pictures: Mapping[Place, Sequence[CameraPicture]], prints: PrintSearch
) -> Perceived:
    """Find the listed items of several places. Models of items are made once for all.

    Args:
        scene: A scene, for where the places are.
        contents: What is listed to be in each.
        pictures: Those of each place, all by one camera; the first one is the same for all.
        prints: Whether and how prints are looked for.

    Returns:
        The answers for all places.

    Raises:
        InputError: As ``perceived_place``.
    """
    (first, *_), *_ = pictures.values()
    found = tuple(
        perceived_place(scene, place, contents.get(place.name, ()), taken, prints)
        for place, taken in pictures.items()
    )
    used = {id(each): each for taken in pictures.values() for each in taken if each is not first}
    camera = first.viewpoint.camera
    return Perceived(
        scene.cell.name, camera.name, camera.model.name, first.rgbd.T_world_camera, found,
        also_from=tuple(each.rgbd.T_world_camera for each in used.values()),
        versions=perception_versions(item.route for place in found for item in place.items),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class PlaceRoutes:
    """By what the items of a place are looked for from a viewpoint.

    Attributes:
        place: Name of the place.
        pixels_per_mm: Of the picture, at its mouth.
        seen: Share of its room that is in sight, were no items in it.
        routes: By id of the item.
    """

    place: str
    pixels_per_mm: float
    seen: float
    routes: Mapping[str, ItemRoute]


def routes_from(
    scene: Scene, place: Place, listed: Sequence[ListedItem], viewpoint: Viewpoint, rule: SiftRule
) -> PlaceRoutes:
    """Tell by what the items of a place would be looked for, without looking.

    Args:
        scene: A scene, for where the places are.
        place: The place.
        listed: What is known to be in it.
        viewpoint: From where it would be looked into.
        rule: For which items prints would be looked for.

    Returns:
        The routes.

    Raises:
        InputError: An item has no model.
    """
    camera = viewpoint.camera.model.camera
    fineness = pixels_per_mm(camera, viewpoint.T_world_camera, place, scene.T_world_place(place))
    routes = routes_of(listed, fineness, rule)
    by_id = {each.id: route for each, route in zip(listed, routes, strict=True)}
    return PlaceRoutes(place.name, fineness, _sight(scene, place, viewpoint).seen, by_id)


def known_from(scene: Scene, viewpoint: Viewpoint) -> RenderedScene:
    """Return all that is known to be in a picture.

    Args:
        scene: A scene, for where its carriers are.
        viewpoint: From where the picture was taken.

    Returns:
        The solids without items.
    """
    return RenderedScene.of(replace(scene, items=()), viewpoint.at.q, viewpoint.at.tool_state)


def _sight(scene: Scene, place: Place, viewpoint: Viewpoint) -> RoomSight:
    """How much of a place is seen from a viewpoint."""
    known = known_from(scene, viewpoint)
    view = coarse_view(viewpoint.camera.model.camera, viewpoint.T_world_camera, known)
    return room_sight(view, known, place, scene.T_world_place(place))


def _best_sight(scene: Scene, place: Place, viewpoints: Sequence[Viewpoint]) -> RoomSight:
    return max((_sight(scene, place, each) for each in viewpoints), key=lambda sight: sight.seen)
