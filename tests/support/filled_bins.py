"""A bin with a few items of the package, and the camera on the gripper before it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pickcli.cell.cell import NamedConfiguration
from pickcli.cell.place import Place
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.geometry import Array
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.depth_picture import measure_depth
from pickcli.perception.items.item_observation import ItemObservation, PlaceObservation
from pickcli.perception.items.item_perception import PlaceLook, perceive_items
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.rgbd_picture import RgbdPicture
from pickcli.perception.items.symmetry import error_of
from pickcli.perception.looks import colour_picture
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.perception.viewpoints import viewpoints_of
from pickcli.scene.scene import PoseNoise, Scene

CONTENTS = ("kleenex_tissue_box", "rawlings_baseball", "folgers_classic_roast_coffee", "dasani_water_bottle")


@dataclass(frozen=True, eq=False)
class Filled:
    """A scene, and what the camera on the gripper sees of one of its bins."""

    scene: Scene
    place: Place
    rgbd: RgbdPicture
    known: RenderedScene

    @property
    def T_world_place(self) -> Array:
        return self.scene.T_world_place(self.place)

    @property
    def listed(self) -> list[ListedItem]:
        return [ListedItem(each.id, each.item) for each in self.scene.in_location(self.place.name)]

    def perceived(self, listed: list[ListedItem] | None = None) -> PlaceObservation:
        """The answers for these items, or for those that are there."""
        listed = self.listed if listed is None else listed
        return perceive_items(self.rgbd, self.place, self.T_world_place, listed, self.known)

    def looked(self, listed: list[ListedItem] | None = None) -> PlaceLook:
        """The look for these items, or for those that are there."""
        listed = self.listed if listed is None else listed
        return PlaceLook.of(self.rgbd, self.place, self.T_world_place, listed, self.known)

    def error_of(self, answer: ItemObservation) -> PoseNoise:
        """By how much a pose is off."""
        assert answer.T_world_item is not None
        return error_of(answer.item.shape, answer.T_world_item, self.scene.find(answer.id).T_world_item)


def looked_at(
    scene: Scene,
    noise_seed: int = 1,
    texture_seed: int = 11,
    at: str = "cam_E",
    deformed_seed: int | None = None,
) -> Filled:
    """Bin E as the camera sees it from a configuration, printed otherwise than the models."""
    return _seen_from(scene, scene.cell.configurations[at], noise_seed, texture_seed, deformed_seed)


def looked_at_as(scene: Scene, sensor: str) -> Filled:
    """Bin E as a sensor of the package sees it in the place of the camera."""
    hand = scene.cell.cameras["hand"]
    cameras = {**scene.cell.cameras, "hand": replace(hand, model=read_sensor(sensor_file(sensor)))}
    return looked_at(replace(scene, cell=replace(scene.cell, cameras=cameras)))


def looked_at_aslant(scene: Scene, noise_seed: int = 2, texture_seed: int = 11) -> Filled:
    """Bin E as the camera sees it from the left."""
    viewpoints = viewpoints_of(scene.cell.places["bin_E"], scene.cell)
    return _seen_from(scene, viewpoints[1].at, noise_seed, texture_seed)


def _seen_from(
    scene: Scene,
    before: NamedConfiguration,
    noise_seed: int,
    texture_seed: int,
    deformed_seed: int | None = None,
) -> Filled:
    cell = scene.cell
    hand = cell.cameras["hand"]
    T = camera_pose(cell.robot, hand, before.q, before.tool_state)
    rendered = RenderedScene.of(scene, before.q, before.tool_state, deformed_seed)
    depth = measure_depth(rendered, hand.model, T, noise_seed).depth
    colour = colour_picture(rendered, hand.model.camera, T, texture_seed)
    known = RenderedScene.of(replace(scene, items=()), before.q, before.tool_state)
    return Filled(scene, cell.places["bin_E"], RgbdPicture(hand.model, T, depth, colour), known)
