"""Simulated cameras of a trial: they take pictures of the true scene, from poses not quite as stated."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.sensors.mounted_camera import MountedCamera, MountError
from pickcli.errors import InputError
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.perception.depth_picture import measure_depth
from pickcli.perception.items.rgbd_picture import RgbdPicture
from pickcli.perception.mount_calibration import MountCalibration, PodLook, calibrated_mounts, camera_in_pod
from pickcli.perception.photograph import photograph
from pickcli.perception.pod_fit import CameraFit
from pickcli.perception.procedural_texture import ColourPicture
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.perception.surface_view import FloatPicture
from pickcli.perception.viewpoints import Viewpoint
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_rng, derived_seed

PRINTS_OF_TRIALS = 1  # seed of the prints on items: models of colours know set 0, those of prints this one
_EXACT = MountError(0.0, 0.0)


@dataclass(frozen=True, eq=False)
class PlacePicture:
    """A picture of a place.

    Attributes:
        viewpoint: Camera and configuration, as stated.
        depth: Depth in m.
        colour: Colours.
        at_pod: The camera relative to the pod in it; None if that is not located.
    """

    viewpoint: Viewpoint
    depth: FloatPicture
    colour: ColourPicture
    at_pod: CameraFit | None

    def rgbd(self, T_world_camera: Array) -> RgbdPicture:
        """Return the picture with the camera at a pose.

        Args:
            T_world_camera: (4, 4) pose.

        Returns:
            Depth and colour.
        """
        return RgbdPicture(self.viewpoint.camera.model, T_world_camera, self.depth, self.colour)


class SimulatedCameras:
    """The cameras of a cell in a simulated hall.

    Args:
        seed: Seed of noise, mounts, background and looks.
        hand_eye: Whether cameras are off their stated poses, within the bounds of the cell.
        deformed: Whether cloth and bags look other than their boxes.
    """

    def __init__(self, seed: int, hand_eye: bool, deformed: bool) -> None:
        self._seed, self._hand_eye, self._deformed = seed, hand_eye, deformed
        self._hall_seed = derived_seed("hall", seed)

    def picture(
        self, name: str, viewpoint: Viewpoint, true: Scene, around: Scene, number: int
    ) -> PlacePicture:
        """Take a picture of a place, and locate the pod in it.

        Args:
            name: The place.
            viewpoint: From where.
            true: The true scene, which is rendered.
            around: What is known around the place, for about where the pod is.
            number: Number of the look, from 1.

        Returns:
            The picture.
        """
        camera, at = viewpoint.camera, viewpoint.at
        model, T_true = camera.model, viewpoint.T_world_camera @ self._off(camera)
        deformed_seed = derived_seed("deformed looks", self._seed) if self._deformed else None
        rendered = RenderedScene.of(replace(true, held=None), at.q, at.tool_state, deformed_seed)
        seed = derived_seed("look", self._seed, number, name, at.name)
        depth = measure_depth(rendered, model, T_true, seed)
        colour = photograph(rendered, model.camera, T_true, PRINTS_OF_TRIALS, self._hall_seed, seed)
        at_pod = None
        if name in true.cell.pod.bins and model.depth is not None:
            seen = replace(depth, T_world_camera=viewpoint.T_world_camera)
            with suppress(InputError):  # then the camera is taken to be where it is stated
                at_pod = camera_in_pod(seen, true.cell, model.depth, around.T_world_pod)
        return PlacePicture(viewpoint, depth.depth, colour, at_pod)

    def located_pod(self, pictures: Iterable[PlacePicture], around: Scene) -> MountCalibration | None:
        """Find the pod where pictures show it.

        Args:
            pictures: The pictures.
            around: What is known around, for about where the pod is.

        Returns:
            Its pose with bounds; None if no picture shows it.
        """
        looks = [
            PodLook(
                replace(each.viewpoint.camera, error=self.mount_error(each.viewpoint.camera)),
                each.viewpoint.T_world_camera,
                each.at_pod,
            )
            for each in pictures
            if each.at_pod is not None
        ]
        return calibrated_mounts(looks, around.T_world_pod) if looks else None

    def mount_error(self, camera: MountedCamera) -> MountError:
        """Return how far a camera may be off its stated pose.

        Args:
            camera: The camera.

        Returns:
            The bounds of the cell; zeros if all are where they are stated.
        """
        return camera.error if self._hand_eye else _EXACT

    def _off(self, camera: MountedCamera) -> Array:
        """Pose (4, 4) of the true camera in the frame of the stated one: the same in the whole trial."""
        if not self._hand_eye:
            return np.eye(4)
        rng = derived_rng("hand-eye", self._seed, camera.name)
        shift, turn = rng.standard_normal(3), rng.standard_normal(3)
        shift *= camera.error.position * rng.random() ** (1 / 3) / np.linalg.norm(shift)
        angle = camera.error.angle * float(rng.random() ** (1 / 3))
        return pose(shift, R=rotation_axis_angle(turn / np.linalg.norm(turn), angle))
