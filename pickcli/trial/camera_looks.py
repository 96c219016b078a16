"""Perception of a trial by the depth cameras of its cell.

In each bin, and each other place with a mouth at the front, items are found in pictures that the best placed
depth camera takes in one of the arm's configurations for that, and, if the arm moves it, aslant from both
sides: what two of them agree on is sure. Only the pictures are of the true scene. What is in each place is
known from the order and from what the robot has done; once the tool was in a place, what was seen in it is
forgotten, as soon as a camera can be brought there again. Copies of an item have the names that the trial
judges them by.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.geometry import Array, pose, transform_points
from pickcli.perception.believed_scene import believed_items, never_seen, unknown_in
from pickcli.perception.items.agreement import matched
from pickcli.perception.items.item_observation import ItemObservation, PlaceObservation
from pickcli.perception.items.item_perception import PlaceLook, concluded
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.perceived_file import Perceived
from pickcli.perception.items.routing import NO_PRINTS, PrintSearch
from pickcli.perception.items.symmetry import error_of
from pickcli.perception.mount_calibration import MountCalibration
from pickcli.perception.next_view import hiding_items, next_views
from pickcli.perception.perceived_picture import perceived_picture
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.perception.viewpoints import Viewpoint, further_viewpoints, viewpoints_of
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene, empty_scene
from pickcli.trial.simulated_cameras import PlacePicture, SimulatedCameras
from pickcli.trial.trial_perception import BoundedErrors, LookRecord, PerceivedItem, ReachedViews, Touched

N_NEXT = 3  # pictures of a place in which something is refused
_DRAWN = 640  # px, about the width of a drawing of answers
MOST_PICTURES = 6  # of an unchanged place: what they have not shown others will not


@dataclass(frozen=True, eq=False)
class _Seen:
    """What pictures show of a place since it was last touched.

    All that is seen in it may be off alike: by ``error``, about the pose ``T_world_about`` (4, 4).
    looks: one for each picture
    """

    pictures: tuple[PlacePicture, ...]
    looks: tuple[PlaceLook, ...]
    observed: PlaceObservation
    T_world_about: Array
    error: MountError
    drawn: NDArray[np.uint8]

    @property
    def has_refused(self) -> bool:
        """Whether something listed is not recognised surely enough."""
        return not all(_is_believed(answer) for answer in self.observed.items)

    @property
    def may_show_more(self) -> bool:
        """Whether another picture may show what these do not."""
        return len(self.pictures) < MOST_PICTURES


class CameraLooks:
    """Perception by the cameras of a cell.

    Args:
        true: The true scene at the start, for what the order says of the contents of places.
        around: Perception of all that no camera looks into: places open above, and the pod until it is seen.
        hand_eye: Whether cameras are off their stated poses, within the bounds of the cell.
        deformed: Whether cloth and bags look other than their boxes.
        prints: Whether and how prints are looked for.

    Raises:
        InputError: No camera sees enough of a place.
    """

    def __init__(
        self, true: Scene, around: BoundedErrors, hand_eye: bool, deformed: bool = False,
        prints: PrintSearch = NO_PRINTS,
    ) -> None:  # fmt: skip
        cell = true.cell
        self._cell, self._around, self._prints, self._deformed = cell, around, prints, deformed
        self._cameras = SimulatedCameras(around.seed, hand_eye, deformed)
        self._viewpoints = {
            name: viewpoints_of(place, cell)
            for name, place in cell.places.items()
            if not place.access.is_from_above
        }
        self._products: dict[str, Item] = {placed.id: placed.item for placed in true.items}
        self._homes = {placed.id: placed.location for placed in true.items}
        self._may_be_in = {placed.id: frozenset({placed.location}) for placed in true.items}
        self._further: dict[str, tuple[Viewpoint, ...]] = {}
        self._seen: dict[str, _Seen] = {}
        self._taken: dict[str, frozenset[str]] = {}  # by place that was touched since, ids that may be gone
        self._in_doubt: frozenset[str] = frozenset()  # places out of which no plan led since they were seen
        self._next_views: dict[str, tuple[Viewpoint, ...]] = {}
        # All that no camera is brought to, as seen in the last look, and all that is believed since.
        self._around_places = self._believed = empty_scene(cell)
        self._pod: MountCalibration | None = None
        self._looks: list[LookRecord] = []

    @property
    def looks(self) -> tuple[LookRecord, ...]:
        """All looks so far."""
        return tuple(self._looks)

    def homes(self, first: Scene) -> Mapping[str, str]:
        """Return where the order says that items are.

        Args:
            first: The scene as first perceived, which may lack some.

        Returns:
            Places by item id.
        """
        return self._homes

    def refusal(self, item: str, home: str) -> str:
        """Return why an item was refused in the last look into a place that it may be in.

        Args:
            item: Its name.
            home: The place that it was in at the start.

        Returns:
            The reason for one of its copies; "" if none was refused.
        """
        for seen in self._seen.values():
            for answer in seen.observed.items:
                is_copy = answer.item.name == item and self._homes[answer.id] == home
                if is_copy and seen.observed.place in self._may_be_in[answer.id] and not _is_believed(answer):
                    return answer.refusal or "the error of its pose has no bounds"
        return ""

    def hiding(self, place: str) -> tuple[str, ...]:
        """Return what hides most of what is not known in a place from where it is looked into.

        Args:
            place: Name of the place.

        Returns:
            Ids of recognised items, first that which hides most; none before the first look.
        """
        if place not in self._viewpoints:
            return ()
        return hiding_items(self._viewpoints[place], self._believed, place)

    def claimed(self, scene: Scene) -> Scene:
        """Add items that are not recognised to the places that they must be in, at no particular pose.

        Args:
            scene: The scene as last perceived.

        Returns:
            The scene for the output file.
        """
        seen = {placed.id for placed in scene.items}
        missing = []
        for item_id, places in self._may_be_in.items():
            if item_id not in seen:
                home = self._homes[item_id]
                name = home if home in places else min(places)
                T = scene.T_world_place(scene.cell.places[name])
                missing.append(PlacedItem(item_id, self._products[item_id], name, T))
        return replace(scene, items=(*scene.items, *missing))

    def look(self, true: Scene, number: int, touched: Touched) -> Scene:
        """See all that no camera is brought to, and note what was touched.

        Args:
            true: The true scene.
            number: Number of the look, from 1.
            touched: What was touched since the last look.

        Returns:
            The scene that is believed from then on: places as they were seen before, without what was taken.
            One that no camera looked into yet is unknown as a whole.
        """
        around = self._around.look(true, number, touched)
        for item_id, places in touched.moved.items():
            self._may_be_in[item_id] |= places
        outside = tuple(placed for placed in around.items if placed.location not in self._viewpoints)
        for placed in outside:
            self._may_be_in[placed.id] = frozenset({placed.location})
        for name in touched.places & self._viewpoints.keys():
            self._taken[name] = self._taken.get(name, frozenset()) | touched.moved.keys()
        self._in_doubt |= touched.in_doubt & self._viewpoints.keys()
        self._around_places = replace(around, items=outside)
        return self._believe()

    def viewpoints(self) -> tuple[Viewpoint, ...]:
        """Return from where to look into the places that were touched, else those that may hide something.

        These are places in which something is refused, and those out of which no plan led for an item.

        Returns:
            The viewpoints, each once; none if there is nothing more to see.
        """
        self._next_views = {name: self._views_of(name) for name in self._due()}
        return tuple({view.name: view for views in self._next_views.values() for view in views}.values())

    def look_from(self, true: Scene, number: int, reached: ReachedViews) -> Scene:
        """Take the pictures of the last ``viewpoints``, and find the items in them.

        Args:
            true: The true scene, to be rendered.
            number: Number of the look, from 1.
            reached: Those of the viewpoints where the arm was; what was looked into from none stays as seen.

        Returns:
            The scene that is believed from then on.
        """
        true, around = replace(true, cell=self._cell), replace(self._around_places, cell=self._cell)
        views = {name: tuple(filter(reached.has, views)) for name, views in self._next_views.items()}
        views = {name: found for name, found in views.items() if found}
        pictures = {
            name: [self._cameras.picture(name, viewpoint, true, around, number) for viewpoint in found]
            for name, found in views.items()
        }
        if self._pod is None:
            self._pod = self._cameras.located_pod(
                (each for taken in pictures.values() for each in taken), around
            )
        around = self._with_pod(around)
        for name, taken in pictures.items():
            before = None if name in self._taken else self._seen.get(name)
            self._taken.pop(name, None)
            self._in_doubt -= {name}
            seen = self._perceived(name, taken, around, before)
            self._seen[name] = replace(seen, observed=with_names_of_copies(seen.observed, true))
        for name in self._settle(views):  # again, without what was found elsewhere
            seen = self._perceived(name, self._seen[name].pictures, around)
            self._seen[name] = replace(seen, observed=with_names_of_copies(seen.observed, true))
        if views or reached.motions:
            self._note(views, true, number, reached)
        return self._believe()

    def _due(self) -> list[str]:
        """The places to look into: those never seen or touched since, else where something may be hidden."""
        due = [name for name in self._viewpoints if name in self._taken or name not in self._seen]
        return due or [name for name in self._viewpoints if self._may_hide(name, self._seen[name])]

    def _may_hide(self, name: str, seen: _Seen) -> bool:
        """Whether what pictures of a place do not show may matter, and others may show it."""
        return seen.may_show_more and (seen.has_refused or name in self._in_doubt)

    def _views_of(self, name: str) -> tuple[Viewpoint, ...]:
        """From where to look into a place: where it was not seen as it is, else where most of the rest is."""
        if name in self._taken or name not in self._seen:
            return self._viewpoints[name]
        believed = replace(self._believed, cell=self._cell)
        if name not in self._further:
            self._further[name] = further_viewpoints(self._cell.places[name], believed)
        return next_views(self._further[name], believed, name, N_NEXT) or self._viewpoints[name]

    def _with_pod(self, scene: Scene) -> Scene:
        """A scene with the pod where pictures show it."""
        if self._pod is None:
            return scene
        return replace(scene, T_world_pod=self._pod.T_world_pod, pod_error=self._pod.error)

    def _perceived(
        self, name: str, pictures: Sequence[PlacePicture], around: Scene, before: _Seen | None = None
    ) -> _Seen:
        """Find what is listed to be in a place in new pictures of it, beside what was seen before."""
        listed = tuple(
            ListedItem.of(item_id, self._products[item_id], self._deformed)
            for item_id, places in self._may_be_in.items()
            if name in places
        )
        if before is not None and before.looks[-1].listed != listed:  # other items may be found in them now
            pictures, before = (*before.pictures, *pictures), None
        looks = tuple(self._look_of(name, each, around, listed) for each in pictures)
        if before is not None:
            pictures, looks = (*before.pictures, *pictures), (*before.looks, *looks)
        observed, last = concluded(looks), pictures[-1]
        T_about, error = self._off_alike(name, pictures, around)
        camera, rgbd = last.viewpoint.camera, looks[-1].rgbd
        of = Perceived(around.cell.name, camera.name, camera.model.name, rgbd.T_world_camera, (observed,))
        coarser = max(1, round(camera.model.camera.width / _DRAWN))
        drawn = perceived_picture(rgbd, self._known(last.viewpoint, around), of, coarser)
        return _Seen(tuple(pictures), looks, observed, T_about, error, drawn)

    def _look_of(
        self, name: str, picture: PlacePicture, around: Scene, listed: Sequence[ListedItem]
    ) -> PlaceLook:
        """Search in a picture, from where the camera is relative to the pod in it."""
        viewpoint, place = picture.viewpoint, around.cell.places[name]
        T_world_camera = viewpoint.T_world_camera
        if self._pod is not None and picture.at_pod is not None:
            T_world_camera = self._pod.T_world_pod @ picture.at_pod.T_pod_camera
        rgbd, known = picture.rgbd(T_world_camera), self._known(viewpoint, around)
        return PlaceLook.of(rgbd, place, around.T_world_place(place), listed, known, self._prints)

    def _known(self, viewpoint: Viewpoint, around: Scene) -> RenderedScene:
        """All that is known to be seen from a viewpoint, without items."""
        return RenderedScene.of(replace(around, items=()), viewpoint.at.q, viewpoint.at.tool_state)

    def _off_alike(
        self, name: str, pictures: Sequence[PlacePicture], around: Scene
    ) -> tuple[Array, MountError]:
        """By how much all that is seen in a place may be off alike, and about which pose (4, 4).

        What is found relative to the pod is off with it, about the middle of the place. In a picture in which
        the pod is not located it is off with the camera, and what is known of the place is off with the pod.
        """
        viewpoint, place = pictures[0].viewpoint, around.cell.places[name]
        mount = self._cameras.mount_error(viewpoint.camera)
        if self._pod is None or name not in around.cell.pod.bins:
            return viewpoint.T_world_camera, mount
        middle = transform_points(place.T_carrier_place, (place.room.low + place.room.high)[None] / 2)[0]
        T_world_middle = self._pod.T_world_pod @ pose(middle)
        position, angle = self._pod.error_at(middle), self._pod.error.yaw
        if unlocated := [each.viewpoint.T_world_camera for each in pictures if each.at_pod is None]:
            away = max(float(np.linalg.norm(T_world_middle[:3, 3] - T[:3, 3])) for T in unlocated)
            position, angle = position + mount.position + mount.angle * away, angle + mount.angle
        return T_world_middle, MountError(position, angle)

    def _settle(self, looked_into: Iterable[str]) -> tuple[str, ...]:
        """Decide where items are that were looked for in several places; return where they are no more."""
        changed: set[str] = set()
        for item_id, places in self._may_be_in.items():
            if len(places) == 1:
                continue
            found = {
                name: answer.confidence
                for name in sorted(places & self._seen.keys())
                for answer in self._seen[name].observed.items
                if answer.id == item_id
                and _is_believed(answer)
                and item_id not in self._taken.get(name, frozenset())
            }
            if found:
                best = max(found, key=lambda name: found[name])
                changed |= found.keys() - {best}
                self._may_be_in[item_id] = frozenset({best})
        return tuple(name for name in looked_into if name in changed)

    def _believe(self) -> Scene:
        """The scene that follows from all that was seen so far."""
        around, unknown = self._with_pod(self._around_places), []
        items = list(around.items)
        for name in self._viewpoints:
            place, seen = around.cell.places[name], self._seen.get(name)
            if seen is None:
                unknown.append(never_seen(place, around.T_world_place(place), around.cell.clearance))
                continue
            items += [placed for placed in self._items_in(name) if self._may_be_there(placed)]
            space = unknown_in(seen.observed, place, seen.T_world_about, seen.error, around.cell.clearance)
            unknown += [] if space.is_empty else [space]
        self._believed = replace(around, items=tuple(items), unknown=tuple(unknown))
        return self._believed

    def _may_be_there(self, placed: PlacedItem) -> bool:
        """Whether an item may still be where it was seen."""
        taken = self._taken.get(placed.location, frozenset())
        return placed.location in self._may_be_in[placed.id] and placed.id not in taken

    def _items_in(self, name: str) -> list[PlacedItem]:
        """The answers of the last look into a place, with bounds that hold the error of the pod's pose."""
        seen = self._seen[name]
        return list(believed_items(seen.observed, seen.T_world_about, seen.error))

    def _note(
        self, views: Mapping[str, Sequence[Viewpoint]], true: Scene, number: int, reached: ReachedViews
    ) -> None:
        """Record a look, with the truth beside each pose."""
        items = []
        for name in views:
            believed = {placed.id: placed.noise for placed in self._items_in(name)}
            items += [
                PerceivedItem(name, answer, believed.get(answer.id), _off_by(answer, true))
                for answer in self._seen[name].observed.items
            ]
        cameras = {name: found[0].name for name, found in views.items()}
        drawn = {name: self._seen[name].drawn for name in views}
        self._looks.append(LookRecord(number, cameras, tuple(items), drawn, reached.motions))


def with_names_of_copies(observed: PlaceObservation, true: Scene) -> PlaceObservation:
    """Call copies of an item what the trial calls them.

    No picture tells copies from each other, and nobody asks which of them is taken. So their names are free
    to choose; but what the arm touches and takes is judged by them.

    Args:
        observed: What was seen, with copies in any order.
        true: The true scene.

    Returns:
        The same answers, each of a copy with the name of the nearest one.
    """
    answers = observed.items
    items = [each.item for each in answers]
    seen = {i: each.T_world_item for i, each in enumerate(answers) if each.T_world_item is not None}
    truly = {placed.id: placed.T_world_item for placed in true.items}
    there = {k: truly[each.id] for k, each in enumerate(answers) if each.id in truly}
    named = {k: i for i, (_, k) in matched(items, seen, there).items()}
    out: list[ItemObservation] = []
    for k, each in enumerate(answers):
        if k not in named:
            left = (i for i, item in enumerate(items) if item == each.item and i not in named.values())
            named[k] = next(left)
        out.append(replace(answers[named[k]], id=each.id))
    return replace(observed, items=tuple(out))


def _is_believed(answer: ItemObservation) -> bool:
    return answer.is_answer and answer.bound is not None


def _off_by(answer: ItemObservation, true: Scene) -> PoseNoise | None:
    """By how much a pose is off that of the nearest copy."""
    T = answer.T_world_item
    if T is None:
        return None
    off = [
        error_of(answer.item.shape, T, placed.T_world_item)
        for placed in true.items
        if placed.item == answer.item
    ]
    return min(off, key=lambda error: error.position, default=None)
