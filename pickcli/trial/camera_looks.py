"""Perception of a trial by the depth cameras of its cell.

In each bin, and each other place with a mouth at the front, items are found in a picture that the best placed
depth camera takes in one of the arm's configurations for that. The true scene is rendered with the noise of
the sensor, and nothing else is taken from it; pictures are taken as if the arm were there. What is in each
place is known from the order and from what the robot has done; a place is looked into again once the tool was
in it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.cell.sensors.mounted_camera import MountedCamera, MountError
from pickcli.errors import InputError
from pickcli.geometry import Array, pose, rotation_axis_angle, transform_points
from pickcli.perception.believed_scene import believed_items, unknown_in
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.depth_picture import DepthPicture, measure_depth
from pickcli.perception.items.item_observation import ItemObservation, PlaceObservation
from pickcli.perception.items.item_perception import ListedItem, perceive_items
from pickcli.perception.items.perceived_file import Perceived
from pickcli.perception.items.rgbd_picture import RgbdPicture
from pickcli.perception.items.room_sight import LEAST_SEEN, coarse_view, room_sight
from pickcli.perception.items.symmetry import error_of
from pickcli.perception.looks import colour_picture
from pickcli.perception.mount_calibration import MountCalibration, PodLook, calibrated_mounts, camera_in_pod
from pickcli.perception.perceived_picture import perceived_picture
from pickcli.perception.procedural_texture import ColourPicture
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.perception.surface_view import FloatPicture
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene, empty_scene
from pickcli.scene.unknown_space import UnknownSpace
from pickcli.seeds import derived_rng, derived_seed
from pickcli.trial.trial_perception import BoundedErrors, LookRecord, PerceivedItem, Touched

CAMERA_KIND = "camera"  # of named configurations in which cameras look
_EXACT = MountError(0.0, 0.0)
_DRAWN = 640  # px, about the width of a drawing of answers


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
class _Picture:
    """A picture of a place.

    T_pod_camera: (4, 4) the camera relative to the pod in it; None if that is not located.
    """

    viewpoint: Viewpoint
    depth: FloatPicture
    colour: ColourPicture
    T_pod_camera: Array | None

    def rgbd(self, T_world_camera: Array) -> RgbdPicture:
        """The picture, with the camera at a pose."""
        return RgbdPicture(self.viewpoint.camera.model, T_world_camera, self.depth, self.colour)


@dataclass(frozen=True, eq=False)
class _Seen:
    """The last look into a place.

    All that is seen in it may be off alike: by ``error``, about the pose ``T_world_about`` (4, 4).
    """

    observed: PlaceObservation
    T_world_about: Array
    error: MountError
    drawn: NDArray[np.uint8]


class CameraLooks:
    """Perception by the cameras of a cell.

    Args:
        true: The true scene at the start, for what the order says of the contents of places.
        around: Perception of all that no camera looks into: places open above, and the pod until it is seen.
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
        self._pod: MountCalibration | None = None
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
        pictures = {name: self._picture_of(name, true, around, number) for name in due}
        if self._pod is None:
            self._pod = self._located(pictures.values(), around)
        if self._pod is not None:
            around = replace(around, T_world_pod=self._pod.T_world_pod, pod_error=self._pod.error)
        for name in due:
            self._seen[name] = self._perceived(name, pictures[name], around)
        for name in self._settle(due):  # again, without what was found elsewhere
            self._seen[name] = self._perceived(name, pictures[name], around)
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

    def _picture_of(self, name: str, true: Scene, around: Scene, number: int) -> _Picture:
        """Take a picture of a place."""
        viewpoint = self._viewpoints[name]
        camera, at = viewpoint.camera, viewpoint.at
        model = camera.model
        T_true = viewpoint.T_world_camera @ self._off(camera)
        rendered = RenderedScene.of(replace(true, held=None), at.q, at.tool_state)
        depth = measure_depth(rendered, model, T_true, derived_seed("look", self._seed, number, name)).depth
        prints = 1 + derived_seed("prints", self._seed) % (2**31 - 1)  # models know set 0
        colour = colour_picture(rendered, model.camera, T_true, prints)
        T_pod_camera = None
        if name in true.cell.pod.bins and model.depth is not None:
            picture = DepthPicture(model.camera, viewpoint.T_world_camera, depth)
            with suppress(InputError):  # then the camera is taken to be where it is stated
                T_pod_camera = camera_in_pod(picture, true.cell, model.depth, around.T_world_pod)
        return _Picture(viewpoint, depth, colour, T_pod_camera)

    def _located(self, pictures: Iterable[_Picture], around: Scene) -> MountCalibration | None:
        """The pod as pictures show it; None if none does."""
        looks = [
            PodLook(
                replace(each.viewpoint.camera, error=self._mount_error(each.viewpoint.camera)),
                each.viewpoint.T_world_camera,
                each.T_pod_camera,
            )
            for each in pictures
            if each.T_pod_camera is not None
        ]
        return calibrated_mounts(looks, around.T_world_pod) if looks else None

    def _perceived(self, name: str, picture: _Picture, around: Scene) -> _Seen:
        """Find what is listed to be in a place in a picture of it."""
        viewpoint, place = picture.viewpoint, around.cell.places[name]
        T_about, error = viewpoint.T_world_camera, self._mount_error(viewpoint.camera)
        T_world_camera = viewpoint.T_world_camera
        if self._pod is not None and name in around.cell.pod.bins:
            middle = transform_points(place.T_carrier_place, (place.room.low + place.room.high)[None] / 2)[0]
            T_about = self._pod.T_world_pod @ pose(middle)
            error = MountError(self._pod.error_at(middle), self._pod.error.yaw)
            if picture.T_pod_camera is not None:
                T_world_camera = self._pod.T_world_pod @ picture.T_pod_camera
            else:
                mounted = self._pod.T_camera_mounted.get(viewpoint.camera.name, np.eye(4))
                T_world_camera = viewpoint.T_world_camera @ mounted
        known = RenderedScene.of(replace(around, items=()), viewpoint.at.q, viewpoint.at.tool_state)
        listed = [
            ListedItem(item_id, self._products[item_id])
            for item_id, places in self._may_be_in.items()
            if name in places
        ]
        T_world_place = around.T_world_place(place)
        rgbd = picture.rgbd(T_world_camera)
        observed = perceive_items(rgbd, place, T_world_place, listed, known)
        camera = viewpoint.camera
        of = Perceived(around.cell.name, camera.name, camera.model.name, T_world_camera, (observed,))
        coarser = max(1, round(camera.model.camera.width / _DRAWN))
        return _Seen(observed, T_about, error, perceived_picture(rgbd, known, of, coarser))

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
            space = unknown_in(seen.observed, place, seen.T_world_about, seen.error)
            unknown += [space] if len(space.boxes) else []
        return replace(around, items=tuple(items), unknown=tuple(unknown))

    def _items_in(self, name: str) -> list[PlacedItem]:
        """The answers of the last look into a place, with bounds that hold the error of the pod's pose."""
        seen = self._seen[name]
        return list(believed_items(seen.observed, seen.T_world_about, seen.error))

    def _mount_error(self, camera: MountedCamera) -> MountError:
        return camera.error if self._hand_eye else _EXACT

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
        drawn = {name: self._seen[name].drawn for name in due}
        self._looks.append(LookRecord(number, cameras, tuple(items), drawn))


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
