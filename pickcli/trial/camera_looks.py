"""Perception of a trial by the depth cameras of its cell.

In each bin, and each other place with a mouth at the front, items are found in a picture that the best placed
depth camera takes in one of the arm's configurations for that. The true scene is rendered with the noise of
the sensor, and nothing else is taken from it; pictures are taken as if the arm were there. What is in each
place is known from the order and from what the robot has done; a place is looked into again once the tool was
in it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.cell.sensors.mounted_camera import MountedCamera, MountError
from pickcli.errors import InputError
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.perception.believed_scene import believed_items, unknown_in
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.depth_picture import DepthPicture, measure_depth
from pickcli.perception.items.item_observation import ItemObservation, PlaceObservation
from pickcli.perception.items.item_perception import ListedItem, perceive_items
from pickcli.perception.items.rgbd_picture import RgbdPicture
from pickcli.perception.items.room_sight import LEAST_SEEN, coarse_view, room_sight
from pickcli.perception.items.symmetry import error_of
from pickcli.perception.looks import colour_picture
from pickcli.perception.pod_pose import locate_pod
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene, empty_scene
from pickcli.scene.unknown_space import UnknownSpace
from pickcli.seeds import derived_rng, derived_seed
from pickcli.trial.trial_perception import BoundedErrors, LookRecord, PerceivedItem, Touched

CAMERA_KIND = "camera"  # of named configurations in which cameras look
_EXACT = MountError(0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """From where a place is looked into.

    Attributes:
        camera: The camera.
        at: The configuration of the arm.
        T_world_camera: (4, 4) stated pose of the camera there.
    """

    camera: MountedCamera
    at: NamedConfiguration
    T_world_camera: Array


@dataclass(frozen=True, eq=False)
class _Seen:
    """The last look into a place."""

    observed: PlaceObservation
    viewpoint: Viewpoint


class CameraLooks:
    """Perception by the cameras of a cell.

    Args:
        true: The true scene at the start, for what the order says of the contents of places.
        around: Perception of all that no camera looks into: the pod's pose, and places open above.
        hand_eye: Whether cameras are off their stated poses, within the bounds of the cell.

    Raises:
        InputError: No camera sees enough of a place.
    """

    def __init__(self, true: Scene, around: BoundedErrors, hand_eye: bool) -> None:
        cell = true.cell
        self._cell, self._around, self._seed = cell, around, around.seed
        self._hand_eye = hand_eye
        self._viewpoints = {
            name: viewpoint_of(place, cell)
            for name, place in cell.places.items()
            if not place.access.is_from_above
        }
        self._products: dict[str, Item] = {placed.id: placed.item for placed in true.items}
        self._homes = {placed.id: placed.location for placed in true.items}
        self._may_be_in = {placed.id: frozenset({placed.location}) for placed in true.items}
        self._seen: dict[str, _Seen] = {}
        self._looks: list[LookRecord] = []

    @property
    def looks(self) -> tuple[LookRecord, ...]:
        """All looks so far."""
        return tuple(self._looks)

    def n_pictures(self, touched: Touched) -> int:
        """Return how many places the next look is into.

        Args:
            touched: What was touched since the last look.

        Returns:
            The number.
        """
        return max(1, len(self._due(touched)))

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
        """Look into the places that were touched, else into those in which something was refused.

        Args:
            true: The true scene, to be rendered.
            number: Number of the look, from 1.
            touched: What was touched since the last look.

        Returns:
            The scene that is believed from then on.
        """
        true = replace(true, cell=self._cell)
        around = self._around.look(true, number, touched)
        for item_id, places in touched.moved.items():
            self._may_be_in[item_id] |= places
        outside = [placed for placed in around.items if placed.location not in self._viewpoints]
        for placed in outside:
            self._may_be_in[placed.id] = frozenset({placed.location})
        due = self._due(touched)
        for name in due:
            self._seen[name] = self._look_into(name, true, around, number)
        for name in self._settle(due):  # again, without what was found elsewhere
            self._seen[name] = self._look_into(name, true, around, number)
        self._note(due, true, number)
        return self._believed(around, outside)

    def _due(self, touched: Touched) -> tuple[str, ...]:
        """The places to look into: at first all; then those touched, else where something is refused."""
        if not self._seen:
            return tuple(self._viewpoints)
        entered = tuple(name for name in self._viewpoints if name in touched.places)
        return entered or tuple(
            name
            for name, seen in self._seen.items()
            if not all(_is_believed(answer) for answer in seen.observed.items)
        )

    def _look_into(self, name: str, true: Scene, around: Scene, number: int) -> _Seen:
        """Take a picture of a place, and find what is listed to be in it."""
        viewpoint = self._viewpoints[name]
        camera, at = viewpoint.camera, viewpoint.at
        model = camera.model
        T_true = viewpoint.T_world_camera @ self._off(camera)
        rendered = RenderedScene.of(replace(true, held=None), at.q, at.tool_state)
        depth = measure_depth(rendered, model, T_true, derived_seed("look", self._seed, number, name)).depth
        prints = 1 + derived_seed("prints", self._seed) % (2**31 - 1)  # models know set 0
        colour = colour_picture(rendered, model.camera, T_true, prints)
        rgbd = RgbdPicture(model, viewpoint.T_world_camera, depth, colour)
        seen = replace(around, items=(), T_world_pod=self._pod_in(rgbd, around))
        place = true.cell.places[name]
        known = RenderedScene.of(seen, at.q, at.tool_state)
        listed = [
            ListedItem(item_id, self._products[item_id])
            for item_id, places in self._may_be_in.items()
            if name in places
        ]
        observed = perceive_items(rgbd, place, seen.T_world_place(place), listed, known)
        return _Seen(observed, viewpoint)

    def _pod_in(self, rgbd: RgbdPicture, around: Scene) -> Array:
        """Pose of the pod in the frame of a picture; where it is believed to be, if it is not found."""
        picture = DepthPicture(rgbd.sensor.camera, rgbd.T_world_camera, rgbd.depth)
        try:
            return locate_pod(
                picture, around.cell, rgbd.depth_model, T_world_guess=around.T_world_pod
            ).T_world_pod
        except InputError:
            return around.T_world_pod

    def _off(self, camera: MountedCamera) -> Array:
        """Pose (4, 4) of the true camera in the frame of the stated one: the same in the whole trial."""
        if not self._hand_eye:
            return np.eye(4)
        rng = derived_rng("hand-eye", self._seed, camera.name)
        shift, turn = rng.standard_normal(3), rng.standard_normal(3)
        shift *= camera.error.position * rng.random() ** (1 / 3) / np.linalg.norm(shift)
        angle = camera.error.angle * float(rng.random() ** (1 / 3))
        return pose(shift, R=rotation_axis_angle(turn / np.linalg.norm(turn), angle))

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
                if answer.id == item_id and _is_believed(answer)
            }
            if found:
                best = max(found, key=lambda name: found[name])
                changed |= found.keys() - {best}
                self._may_be_in[item_id] = frozenset({best})
        return tuple(name for name in looked_into if name in changed)

    def _believed(self, around: Scene, outside: Iterable[PlacedItem]) -> Scene:
        items = list(outside)
        unknown: list[UnknownSpace] = []
        for name in self._viewpoints:
            seen = self._seen[name]
            items += [placed for placed in self._items_in(name) if name in self._may_be_in[placed.id]]
            place = around.cell.places[name]
            space = unknown_in(seen.observed, place, seen.viewpoint.T_world_camera, self._error(seen))
            unknown += [space] if len(space.boxes) else []
        return replace(around, items=tuple(items), unknown=tuple(unknown))

    def _items_in(self, name: str) -> list[PlacedItem]:
        """The answers of the last look into a place, with bounds that hold the error of the camera's pose."""
        seen = self._seen[name]
        T_world_camera = seen.viewpoint.T_world_camera
        return list(believed_items(seen.observed, T_world_camera, self._error(seen)))

    def _error(self, seen: _Seen) -> MountError:
        return seen.viewpoint.camera.error if self._hand_eye else _EXACT

    def _note(self, due: tuple[str, ...], true: Scene, number: int) -> None:
        """Record a look, with the truth beside each pose."""
        items = []
        for name in due:
            believed = {placed.id: placed.noise for placed in self._items_in(name)}
            items += [
                PerceivedItem(name, answer, believed.get(answer.id), _off_by(answer, true))
                for answer in self._seen[name].observed.items
            ]
        cameras = {name: (self._viewpoints[name].camera.name, self._viewpoints[name].at.name) for name in due}
        self._looks.append(LookRecord(number, cameras, tuple(items)))


def viewpoint_of(place: Place, cell: Cell) -> Viewpoint:
    """Choose from where to look into a place: from where a depth camera sees most of its room.

    Args:
        place: The place.
        cell: Its cell.

    Returns:
        The viewpoint.

    Raises:
        InputError: No depth camera sees enough of it.
    """
    scene, best = empty_scene(cell), None
    most = LEAST_SEEN
    for at in cell.configurations.values():
        if at.kind != CAMERA_KIND:
            continue
        known = RenderedScene.of(scene, at.q, at.tool_state)
        for camera in cell.cameras.values():
            if camera.model.depth is None:
                continue
            T = camera_pose(cell.robot, camera, at.q, at.tool_state)
            view = coarse_view(camera.model.camera, T, known)
            seen = room_sight(view, known, place, cell.T_world_place(place)).seen
            if seen > most:
                most, best = seen, Viewpoint(camera, at, T)
    if best is None:
        raise InputError(
            f"{place.name}: no depth camera of {cell.name} sees half of its room from a configuration of "
            f"kind {CAMERA_KIND}; state one (docs/formats/cell.md), or play with --perception noise"
        )
    return best


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
