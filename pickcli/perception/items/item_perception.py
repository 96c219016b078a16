"""Poses of all listed items of one place from one look: identity, pose, confidence, or why not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.perception.items.confidence import LEAST_CONFIDENCE, confidence_of
from pickcli.perception.items.item_observation import ItemObservation, PlaceObservation
from pickcli.perception.items.item_search import ItemSearch, PoseEstimate
from pickcli.perception.items.place_pictures import solids_around
from pickcli.perception.items.place_view import view_of_place
from pickcli.perception.items.product_model import product_model
from pickcli.perception.items.rgbd_picture import RgbdPicture
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
        InputError: The place is not in the picture, or an item has no model.
    """
    models = [product_model(each.item) for each in listed]
    view = view_of_place(rgbd, place, T_world_place, known)
    if view is None:
        raise InputError(f"{place.name}: is not in the picture; look from before it")
    found: dict[int, PoseEstimate] = {}
    if listed:
        solids = solids_around(known, place, T_world_place, rgbd.T_world_camera)
        found = ItemSearch(place, view, models, solids, rgbd.depth_model).run()
    answers = (_answer(each, found.get(i), rgbd) for i, each in enumerate(listed))
    return PlaceObservation(place.name, T_world_place, tuple(answers))


def _answer(each: ListedItem, found: PoseEstimate | None, rgbd: RgbdPicture) -> ItemObservation:
    if found is None:
        return ItemObservation(each.id, each.item, None, 0.0, "no pose explains the picture better", None)
    confidence = confidence_of(found.support, rgbd.depth_model.no_return.get(each.item.material, 0.0))
    refusal = ""
    if confidence < LEAST_CONFIDENCE:
        refusal = f"confidence {confidence:.2f} is below {LEAST_CONFIDENCE:g}"
    return ItemObservation(
        each.id, each.item, rgbd.T_world_camera @ found.T_camera_item, confidence, refusal, found.support
    )
