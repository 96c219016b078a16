"""Poses of all listed items of one place from one look: identity, pose, confidence, or why not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse
from pickcli.perception.items.confidence import LEAST_CONFIDENCE, confidence_of, truncated
from pickcli.perception.items.item_observation import ItemObservation, PlaceObservation
from pickcli.perception.items.item_search import ItemSearch, PoseEstimate
from pickcli.perception.items.place_pictures import solids_around
from pickcli.perception.items.place_view import view_of_place
from pickcli.perception.items.pose_bound import bound_of
from pickcli.perception.items.product_model import product_model
from pickcli.perception.items.rgbd_picture import RgbdPicture
from pickcli.perception.items.room_sight import coarse_view, room_sight
from pickcli.perception.items.unknown_voxels import unknown_boxes
from pickcli.perception.rendered_scene import RenderedScene


@dataclass(frozen=True)
class ListedItem:
    """An item that is known to be in a place.

    Attributes:
        id: Id of the instance.
        item: The item.
    """

    id: str
    item: Item


def perceive_items(
    rgbd: RgbdPicture, place: Place, T_world_place: Array, listed: Sequence[ListedItem], known: RenderedScene
) -> PlaceObservation:
    """Find the listed items of a place.

    One thread; the same arguments give the same bytes.

    Args:
        rgbd: The picture.
        place: The place.
        T_world_place: (4, 4) its pose.
        listed: What is known to be in it.
        known: All that is known to be around, without items.

    Returns:
        An answer for each item, in their order.

    Raises:
        InputError: The picture shows too little of the place, or an item has no model.
    """
    models = [product_model(each.item) for each in listed]
    coarse = coarse_view(rgbd.sensor.camera, rgbd.T_world_camera, known)
    sight = room_sight(coarse, known, place, T_world_place)
    view = view_of_place(rgbd, place, T_world_place, known)
    if not sight.seen or view is None:
        raise InputError(f"{place.name}: is not in the picture; look from before it")
    if not sight.is_enough:
        raise InputError(f"{place.name}: {sight.fault}; look from before it")
    solids = solids_around(known, place, T_world_place, rgbd.T_world_camera)
    search = ItemSearch(place, view, models, solids, rgbd.depth_model)
    found = search.run() if listed else {}
    at = place, T_world_place
    answers = tuple(_answer(each, found.get(i), rgbd, len(listed), at) for i, each in enumerate(listed))
    left = search.unexplained({i: pose for i, pose in found.items() if answers[i].is_answer})
    bounded = {
        i: each.bound.bound(each.item)
        for i, each in enumerate(answers)
        if each.is_answer and each.bound is not None
    }
    rays = search.line_of_sight({i: found[i] for i in bounded}, bounded)
    T_place_camera = inverse(rays.T_camera_place)
    explained = [
        (answers[i].item.shape.inflated(within), T_place_camera @ found[i].T_camera_item)
        for i, within in bounded.items()
    ]
    unknown = unknown_boxes(place.room, rays, explained)
    return PlaceObservation(place.name, T_world_place, answers, left, sight.seen, unknown)


def _answer(
    each: ListedItem, found: PoseEstimate | None, rgbd: RgbdPicture, n_listed: int, at: tuple[Place, Array]
) -> ItemObservation:
    if found is None:
        refusal = "no pose explains the picture better"
        return ItemObservation(each.id, each.item, None, 0.0, refusal, None, None)
    no_return = rgbd.depth_model.no_return.get(each.item.material, 0.0)
    confidence = confidence_of(found.support, no_return, n_listed)
    T = rgbd.T_world_camera @ found.T_camera_item
    bound = bound_of(each.item, found.support, rgbd.depth_model, confidence)
    place, T_world_place = at
    refusal = ""
    if not place.holds((inverse(T_world_place) @ T)[:3, 3], np.inf):
        refusal = f"its middle is outside of {place.name}"
    elif confidence < LEAST_CONFIDENCE:
        refusal = f"confidence {truncated(confidence)} is below {LEAST_CONFIDENCE:g}"
    return ItemObservation(each.id, each.item, T, confidence, refusal, bound, found.support)
