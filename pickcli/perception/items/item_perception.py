"""Poses of all listed items of a place from looks into it: identity, pose, confidence, or why not.

Each look is searched by itself. Of several looks into a place in which nothing has moved, what two of them
agree on is sure, and known well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import TypeAlias

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse
from pickcli.perception.items.agreement import (
    FEW,
    SURE_BY_PRINT,
    agreed_confidence,
    agreement_with,
    matched,
    votes_on,
)
from pickcli.perception.items.confidence import LEAST_CONFIDENCE, LEAST_OWN_COLOUR, confidence_of, truncated
from pickcli.perception.items.item_observation import FoundBy, ItemObservation, PlaceObservation
from pickcli.perception.items.item_search import ItemSearch, PoseEstimate
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.place_pictures import solids_around
from pickcli.perception.items.place_view import PlaceView, view_of_place
from pickcli.perception.items.pose_bound import agreed_bound_of, bound_of, joint_bound_of
from pickcli.perception.items.product_model import product_model
from pickcli.perception.items.rgbd_picture import RgbdPicture
from pickcli.perception.items.room_sight import coarse_view, room_sight
from pickcli.perception.items.routing import NO_PRINTS, ItemRoute, PrintSearch, pixels_per_mm, routes_of
from pickcli.perception.items.symmetry import faced_as
from pickcli.perception.items.unknown_voxels import ASIDE, unknown_boxes, unrecognised_boxes
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.perception.textures.joint_pose import JointPose, PrintSighting
from pickcli.perception.textures.print_agreement import joint_print_poses

_OF_ONE = 0.03  # m from an answer, up to which a pose by prints is of the same thing


@dataclass(frozen=True, eq=False)
class PlaceLook:
    """One look into a place, and what a search found in its picture.

    Attributes:
        rgbd: The picture.
        place: The place.
        T_world_place: (4, 4) its pose.
        listed: What is known to be in it.
        search: The search in the picture.
        found: Poses by index of the listed item; without those of which none explains the picture better.
        seen: Share of its room that is in sight, were no items in it.
        prints: Where prints were recognised, by item.
        routes: By what each listed item was looked for.
        pixels_per_mm: Of the picture, at the mouth of the place.
    """

    rgbd: RgbdPicture
    place: Place
    T_world_place: Array
    listed: tuple[ListedItem, ...]
    search: ItemSearch
    found: dict[int, PoseEstimate]
    seen: float
    prints: Mapping[Item, tuple[PrintSighting, ...]]
    routes: tuple[ItemRoute, ...]
    pixels_per_mm: float

    @classmethod
    def of(
        cls,
        rgbd: RgbdPicture,
        place: Place,
        T_world_place: Array,
        listed: Sequence[ListedItem],
        known: RenderedScene,
        prints: PrintSearch = NO_PRINTS,
    ) -> PlaceLook:
        """Search for the listed items of a place in a picture.

        One thread; the same arguments give the same bytes.

        Args:
            rgbd: The picture.
            place: The place.
            T_world_place: (4, 4) its pose.
            listed: What is known to be in it.
            known: All that is known to be around, without items.
            prints: Whether and how prints are looked for.

        Returns:
            The look.

        Raises:
            InputError: The picture shows too little of the place, an item has no model, or a print is to be
                looked for and OpenCV is not installed.
        """
        models = [product_model(each.seen_as) for each in listed]
        coarse = coarse_view(rgbd.sensor.camera, rgbd.T_world_camera, known)
        sight = room_sight(coarse, known, place, T_world_place)
        view = view_of_place(rgbd, place, T_world_place, known)
        if not sight.seen or view is None:
            raise InputError(f"{place.name}: is not in the picture; look from before it")
        if not sight.is_enough:
            raise InputError(f"{place.name}: {sight.fault}; look from before it")
        solids = solids_around(known, place, T_world_place, rgbd.T_world_camera)
        items = [each.item for each in listed]
        fineness = pixels_per_mm(rgbd.sensor.camera, rgbd.T_world_camera, place, T_world_place)
        routes = routes_of(listed, fineness, prints.rule)
        recognised = _recognised(rgbd, view, items, routes, prints.texture_seed)
        by_print = {
            i: np.array([each.T_camera_item for each in recognised[item]])
            for i, item in enumerate(items)
            if item in recognised
        }
        search = ItemSearch(place, view, models, solids, rgbd.depth_model, by_print)
        found = search.run() if listed else {}
        return cls(
            rgbd, place, T_world_place, tuple(listed), search, found, sight.seen, recognised, routes, fineness
        )

    @cached_property
    def poses(self) -> dict[int, Array]:
        """(4, 4) in the world of what is found, by index of the listed item."""
        return {i: self.rgbd.T_world_camera @ each.T_camera_item for i, each in self.found.items()}

    def lost(self, i: int) -> float:
        """Return the share of an item's surface from which nothing comes back, by its material.

        Args:
            i: Index of the listed item.

        Returns:
            The share.
        """
        return self.rgbd.depth_model.no_return.get(self.listed[i].item.material, 0.0)

    def confidence(self, i: int) -> float:
        """Return how likely a found pose is right, by this look alone.

        Args:
            i: Index of the listed item.

        Returns:
            In (0, 1).
        """
        return confidence_of(self.found[i].support, self.lost(i), len(self.listed))

    def in_camera(self, poses: dict[int, Array]) -> dict[int, Array]:
        """Express poses in the frame of the camera that took the picture.

        Args:
            poses: (4, 4) in the world, by index of the listed item.

        Returns:
            (4, 4) in the camera's frame.
        """
        T_camera_world = inverse(self.rgbd.T_world_camera)
        return {i: T_camera_world @ T for i, T in poses.items()}


_Pair: TypeAlias = tuple[PlaceLook, PlaceLook]


def _recognised(
    rgbd: RgbdPicture, view: PlaceView, items: Sequence[Item], routes: Sequence[ItemRoute], texture_seed: int
) -> Mapping[Item, tuple[PrintSighting, ...]]:
    """Where prints are recognised, by item, of those whose routes say so."""
    views = {item: route.views for item, route in zip(items, routes, strict=True) if route.views is not None}
    if not views:
        return {}
    from pickcli.perception.items.print_search import prints_in  # it needs OpenCV

    return prints_in(rgbd, view, items, views, texture_seed)


def perceive_items(
    rgbd: RgbdPicture, place: Place, T_world_place: Array, listed: Sequence[ListedItem],
    known: RenderedScene, prints: PrintSearch = NO_PRINTS,
) -> PlaceObservation:  # fmt: skip
    """Find the listed items of a place in one look.

    Args:
        rgbd: The picture.
        place: The place.
        T_world_place: (4, 4) its pose.
        listed: What is known to be in it.
        known: All that is known to be around, without items.
        prints: Whether and how prints are looked for.

    Returns:
        An answer for each item, in their order.

    Raises:
        InputError: The picture shows too little of the place, an item has no model, or a print is to be
            looked for and OpenCV is not installed.
    """
    return concluded([PlaceLook.of(rgbd, place, T_world_place, listed, known, prints)])


def concluded(looks: Sequence[PlaceLook]) -> PlaceObservation:
    """Conclude from looks into a place what is in it where, and what is not known.

    Args:
        looks: One look; or several between which nothing has moved, by the same sensor and list.

    Returns:
        An answer for each listed item, in their order: of looks from several places as the two of them say
        that agree best, and if there are many, as most of them do; else by the last look alone.
    """
    last, pairs = looks[-1], [pair for pair in combinations(looks, 2) if _are_aside(*pair)]
    answers = _answers(last)
    if pairs:
        answers = _with_prints(_voted(_agreed_answers(pairs), looks), looks)
    answers = tuple(map(_if_of_its_colours, answers))
    answers = told_apart(answers, max(looks, key=lambda look: look.pixels_per_mm).routes)
    given = {
        i: each.T_world_item
        for i, each in enumerate(answers)
        if each.is_answer and each.T_world_item is not None
    }
    within = {i: bound.bound(answers[i].item) for i in given if (bound := answers[i].bound) is not None}
    bounded = {i: given[i] for i in within}
    left = last.search.unexplained(last.in_camera(given))
    sights = [look.search.line_of_sight(look.in_camera(bounded), within) for look in looks]
    T_place_world = inverse(last.T_world_place)
    explained = [(answers[i].item.shape.inflated(within[i]), T_place_world @ T) for i, T in bounded.items()]
    unknown = unknown_boxes(last.place.room, sights, explained)
    refused = [
        (each.item.shape, T_place_world @ each.T_world_item)
        for i, each in enumerate(answers)
        if i not in bounded and each.T_world_item is not None
    ]
    return PlaceObservation(
        last.place.name, last.T_world_place, answers, left, max(look.seen for look in looks), unknown,
        unrecognised=unrecognised_boxes(last.place.room, sights, explained, refused),
    )  # fmt: skip


def _answers(look: PlaceLook) -> tuple[ItemObservation, ...]:
    """The answers of one look."""
    answers = []
    for i, each in enumerate(look.listed):
        if i not in look.found:
            refusal = "no pose explains the picture better"
            answers.append(ItemObservation(each.id, each.item, None, 0.0, refusal, None, None))
            continue
        support, confidence = look.found[i].support, look.confidence(i)
        bound = bound_of(each.item, support, look.rgbd.depth_model, confidence, each.deformation)
        refusal = _refusal(look, look.poses[i], confidence)
        answers.append(
            replace(
                ItemObservation(each.id, each.item, look.poses[i], confidence, refusal, bound, support),
                found_by=look.found[i].found_by,
            )
        )
    return tuple(answers)


def told_apart(
    answers: Sequence[ItemObservation], routes: Sequence[ItemRoute]
) -> tuple[ItemObservation, ...]:
    """State the routes of answers, and doubt those that look like what is meant, but show no print.

    Args:
        answers: By what the joint decision of the place found.
        routes: That of each.

    Returns:
        The answers. One by shape is refused if a twin was not found by its print either: which of the two it
        is would be a guess. One whose print was looked for and not recognised has no bound: another item of
        about its shape, that nobody listed, may be there. Nor has any that is refused: nobody is to use it.
    """
    by_shape = {each.item.name for each in answers if each.found_by is FoundBy.SHAPE}
    out = []
    for answer, route in zip(answers, routes, strict=True):
        told = replace(answer, route=route)
        alike = [name for name in route.twins if name in by_shape]
        if answer.is_answer and answer.found_by is FoundBy.SHAPE and alike:
            refusal = f"shape and colour do not tell it from {', '.join(alike)}"
            confidence = answer.confidence / (1 + len(alike))
            told = replace(told, refusal=refusal, confidence=confidence)
        is_unprinted = answer.found_by is FoundBy.SHAPE and route.views is not None
        out.append(replace(told, bound=None) if is_unprinted or not told.is_answer else told)
    return tuple(out)


def _if_of_its_colours(answer: ItemObservation) -> ItemObservation:
    """Refuse an answer by shape most of which has colours that the item has not: another one is there."""
    if answer.support is None or not answer.is_answer or answer.found_by is FoundBy.PRINT:
        return answer
    if (own := answer.support.own_colour) >= LEAST_OWN_COLOUR:
        return answer
    refusal = f"only {int(100 * own)}% of what is seen of it has its colours: another item may be there"
    return replace(answer, refusal=refusal, confidence=min(answer.confidence, own))


def _are_aside(one: PlaceLook, other: PlaceLook) -> bool:
    """Whether two looks are from different places."""
    off = one.rgbd.T_world_camera[:3, 3] - other.rgbd.T_world_camera[:3, 3]
    return float(np.linalg.norm(off)) > ASIDE


def _agreed_answers(pairs: Sequence[_Pair]) -> tuple[ItemObservation, ...]:
    """The answers of pairs of looks: of each item by the two that agree best.

    Of copies, which looks may number in any order, each is in another place.
    """
    listed = pairs[-1][-1].listed
    items = [each.item for each in listed]
    found = [
        _agreed_answer((one, other), at, listed[i])
        for one, other in pairs
        for i, at in matched(items, one.poses, other.poses).items()
    ]
    best: dict[int, ItemObservation] = {}
    for answer in sorted(found, key=lambda each: -each.confidence):
        copies = [i for i, item in enumerate(items) if item == answer.item]
        left = [i for i in copies if i not in best]
        if left and not any(_overlap(answer, best[i]) for i in copies if i in best):
            best[left[0]] = replace(answer, id=listed[left[0]].id)
    refusal = "no two looks find a pose that explains their pictures better"
    none = (ItemObservation(each.id, each.item, None, 0.0, refusal, None, None) for each in listed)
    return tuple(best.get(i, each) for i, each in enumerate(none))


def _voted(answers: tuple[ItemObservation, ...], looks: Sequence[PlaceLook]) -> tuple[ItemObservation, ...]:
    """The answers as sure as looks from many places make them, and with bounds by that."""
    places: list[list[PlaceLook]] = []
    for look in looks:
        near = next((each for each in places if not _are_aside(each[0], look)), None)
        if near is None:
            places.append([look])
        else:
            near.append(look)
    if len(places) <= FEW:
        return answers
    return tuple(_voted_answer(i, answers, places) for i in range(len(answers)))


def _voted_answer(
    i: int, answers: Sequence[ItemObservation], places: Sequence[Sequence[PlaceLook]]
) -> ItemObservation:
    """One of the answers by the votes of looks from several places."""
    answer, any_look = answers[i], places[0][0]
    T, support, agreement = answer.T_world_item, answer.support, answer.agreement
    if T is None or support is None or agreement is None:
        return answer
    copies = [k for k, each in enumerate(answers) if each.item == answer.item]
    elsewhere = [T_copy for k in copies if k != i and (T_copy := answers[k].T_world_item) is not None]
    found = [
        [(look.poses[k], look.confidence(k)) for look in place for k in copies if k in look.found]
        for place in places
    ]
    confidence = votes_on(answer.item, T, found, elsewhere).weighed(answer.confidence)
    if agreement.n_prints and agreement.is_near:  # what others do not find there is hidden from them
        confidence = max(confidence, answer.confidence)
    if confidence == answer.confidence:
        return answer
    deformation = any_look.listed[i].deformation
    bound = agreed_bound_of(answer.item, support, any_look.rgbd.sensor, confidence, agreement, deformation)
    refusal = _refusal(any_look, T, confidence)
    return replace(answer, confidence=confidence, bound=bound, refusal=refusal)


def _with_prints(
    answers: tuple[ItemObservation, ...], looks: Sequence[PlaceLook]
) -> tuple[ItemObservation, ...]:
    """The answers, those by prints where these tell more."""
    out, coarsest = list(answers), min(looks, key=lambda look: look.pixels_per_mm)
    for item in dict.fromkeys(each.item for each in answers):
        copies = [i for i, each in enumerate(answers) if each.item == item]
        if any(looks[0].listed[i].deformation for i in copies):  # its surface is elsewhere
            continue
        seen = [(look.rgbd.T_world_camera, look.prints.get(item, ())) for look in looks]
        for joint in joint_print_poses(item, seen, ASIDE)[: len(copies)]:
            i = min(copies, key=lambda k: _away(out[k], joint.T_world_item))
            out[i] = _by_print(out[i], joint, coarsest)
            copies.remove(i)
    return tuple(out)


def _away(answer: ItemObservation, T: Array) -> float:
    """How far (m) an answer is from a pose."""
    own = answer.T_world_item
    return np.inf if own is None else float(np.linalg.norm(own[:3, 3] - T[:3, 3]))


def _by_print(answer: ItemObservation, joint: JointPose, look: PlaceLook) -> ItemObservation:
    """An answer, by prints in looks (the coarsest is given) if they bound its error more narrowly."""
    bound = joint_bound_of(answer.item, joint.covariance, look.pixels_per_mm)
    T, known = joint.T_world_item, answer.bound
    if bound is None or (known is not None and known.bound(answer.item) <= bound.bound(answer.item)):
        return answer
    confidence = max(answer.confidence, SURE_BY_PRINT)
    is_near = _away(answer, T) < _OF_ONE
    return replace(
        answer,
        T_world_item=T,
        confidence=confidence,
        refusal=_refusal(look, T, confidence),
        bound=bound,
        support=answer.support if is_near else None,
        agreement=answer.agreement if is_near else None,
        found_by=FoundBy.PRINT,
    )


def _overlap(one: ItemObservation, other: ItemObservation) -> bool:
    """Whether two copies are so near to each other that they are one."""
    assert one.T_world_item is not None and other.T_world_item is not None
    apart = float(np.linalg.norm(one.T_world_item[:3, 3] - other.T_world_item[:3, 3]))
    return apart < float(one.item.shape.extents.min())


def _agreed_answer(looks: _Pair, at: tuple[int, int], each: ListedItem) -> ItemObservation:
    """The answer for an item by two looks, as the surer of them has it; at: its indices in both."""
    (one, i), (other, k) = sorted(zip(looks, at, strict=True), key=lambda seen: -seen[0].confidence(seen[1]))
    T = one.poses[i]
    found_by = one.found[i].found_by, other.found[k].found_by
    n_prints = found_by.count(FoundBy.PRINT)
    agreement = agreement_with(each.item, T, other.poses[k], other.confidence(k), n_prints)
    support = one.found[i].support
    confidence = agreed_confidence(support, one.lost(i), len(one.listed), agreement)
    bound = agreed_bound_of(each.item, support, one.rgbd.sensor, confidence, agreement, each.deformation)
    refusal = _refusal(one, T, confidence)
    if found_by == (FoundBy.SHAPE, FoundBy.PRINT):
        T = faced_as(each.item.shape, T, other.poses[k])
    how = FoundBy.PRINT if n_prints else FoundBy.SHAPE
    return ItemObservation(each.id, each.item, T, confidence, refusal, bound, support, agreement, how)


def _refusal(look: PlaceLook, T_world_item: Array, confidence: float) -> str:
    """Why a pose is not to be used; "" if it is."""
    if not look.place.holds((inverse(look.T_world_place) @ T_world_item)[:3, 3], np.inf):
        return f"its middle is outside of {look.place.name}"
    if confidence < LEAST_CONFIDENCE:
        return f"confidence {truncated(confidence)} is below {LEAST_CONFIDENCE:g}"
    return ""
