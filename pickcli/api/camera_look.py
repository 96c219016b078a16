"""A look of a simulated camera, and what is found in it."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.api.configurations import Configuration, start_of
from pickcli.errors import UnknownNameError
from pickcli.perception.camera_picture import PictureSeeds, taken_picture, viewpoint_at
from pickcli.perception.items.perceived_file import Perceived
from pickcli.perception.items.routing import PrintSearch
from pickcli.perception.perceived_places import listed_in, perceived_in, places_in_sight
from pickcli.perception.textures.sift_views import SiftRule
from pickcli.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class CameraLook:
    """What is asked of a camera.

    Attributes:
        camera: Its name.
        at: Where the arm is.
        places: Names of the places to look into; none for all with items of which enough is seen.
        rule: For which items prints are looked for.
        textures: Seed of the prints on the items.
        seed: Seed of the noise.
    """

    camera: str
    at: Configuration
    places: tuple[str, ...]
    rule: SiftRule
    textures: int
    seed: int


def perceived_by(scene: Scene, look: CameraLook) -> Perceived:
    """Take a picture of a scene, and find the items in it.

    Args:
        scene: The scene.
        look: What is asked.

    Returns:
        The answers by place.

    Raises:
        UnknownNameError: The cell has no such camera, configuration or place.
        InputError: The camera measures no depth, too little of a place is seen, an item has no model, or
            prints are looked for and OpenCV is not installed.
    """
    cell = scene.cell
    if look.camera not in cell.cameras:
        raise UnknownNameError("camera", look.camera, list(cell.cameras), f"cell {cell.name}")
    for name in look.places:
        if name not in cell.places:
            raise UnknownNameError("place", name, list(cell.places), f"cell {cell.name}")
    begin, at = start_of(cell, look.at), look.at if isinstance(look.at, str) else "the configuration"
    where, contents = f"camera {look.camera} at {at}", listed_in(scene)
    viewpoint = viewpoint_at(cell, cell.cameras[look.camera], at, begin.q, begin.tool_state)
    picture = taken_picture(scene, viewpoint, where, PictureSeeds(look.textures, look.seed))
    named = tuple(cell.places[name] for name in dict.fromkeys(look.places))
    places = named or places_in_sight(scene, contents, {where: viewpoint}, "move the arm")
    prints = PrintSearch(look.rule, look.textures)
    return perceived_in(scene, contents, dict.fromkeys(places, (picture,)), prints)
