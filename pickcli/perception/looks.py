"""How the solids of a scene look: colours, gloss and textures, and the light on them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.sensors.material import Material
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import Array, pose
from pickcli.kernel import Lighting, Looks, Texture
from pickcli.perception.procedural_texture import ColourPicture, damaged_faces, face_textures
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene, RenderedSolid
from pickcli.scene.colours import Colour, item_colour, static_colour

_LINK: Colour = (0.80, 0.81, 0.83, 1.0)
_GLOSS = {Material.SHINY: 0.6, Material.CLEAR: 0.35}
_PRINTED_GLOSS, _OTHER_GLOSS = 0.12, 0.04
_NO_TEXTURES = (-1,) * 6


@dataclass(frozen=True)
class LightingModel:
    """Light in the hall. Amounts of light: 1 makes a white surface white.

    Attributes:
        ambient: From everywhere.
        headlight: Of a light at the camera, on a surface that faces it 0.5 m away.
        lamp: Of a lamp in the hall, on a surface that faces it.
        lamp_position: m, position of the lamp in the world.
        lamp_target: m, the point that it shines at; it throws shadows within 45 degrees around.
        background: Red, green, blue, 0 to 255, where nothing is seen.
    """

    ambient: float = 0.30
    headlight: float = 0.22
    lamp: float = 0.62
    lamp_position: tuple[float, float, float] = (-2.4, 1.1, 3.4)
    lamp_target: tuple[float, float, float] = (0.1, -0.1, 1.1)
    background: tuple[int, int, int] = (96, 100, 106)

    @property
    def kernel(self) -> Lighting:
        """The kernel's lighting of these amounts."""
        background = np.array(self.background, dtype=np.float64)
        return Lighting(self.ambient, self.headlight, self.lamp, self.T_world_lamp, background)

    @property
    def T_world_lamp(self) -> Array:
        """(4, 4) pose of the lamp, which shines along its z."""
        position, target = np.array(self.lamp_position), np.array(self.lamp_target)
        z = (target - position) / np.linalg.norm(target - position)
        x = np.cross(z, [0.0, 0.0, 1.0] if abs(z[2]) < 0.99 else [1.0, 0.0, 0.0])
        x /= np.linalg.norm(x)
        T = pose(position)
        T[:3, :3] = np.column_stack([x, np.cross(z, x), z])
        return T


HALL = LightingModel()


def colour_picture(
    rendered: RenderedScene, camera: PinholeCamera, T_world_camera: Array, texture_seed: int = 0,
    lighting: LightingModel = HALL, damage_seed: int | None = None,
) -> ColourPicture:  # fmt: skip
    """Render a colour picture.

    Args:
        rendered: The solids.
        camera: Intrinsics of the camera.
        T_world_camera: (4, 4) its pose.
        texture_seed: Seed of the set of textures: another one prints the same items differently.
        lighting: Light in the hall.
        damage_seed: Seed of the damage to labels; None for prints as new.

    Returns:
        (height, width, 3) red, green, blue; the same bytes for the same arguments.
    """
    looks = looks_of(rendered, texture_seed, damage_seed)
    picture = rendered.kernel.shaded(camera.intrinsics, camera.size, T_world_camera, looks, lighting.kernel)
    return np.asarray(picture)


def looks_of(rendered: RenderedScene, texture_seed: int, damage_seed: int | None = None) -> Looks:
    """Collect colours and textures of all solids for the kernel.

    Args:
        rendered: The solids.
        texture_seed: Seed of the set of textures.
        damage_seed: Seed of the damage to labels; None for prints as new.

    Returns:
        The looks, in the order of the solids.
    """
    textures: list[Texture] = []
    first: dict[tuple[Item, str], int] = {}  # the first texture of each product: copies as new share them
    faces = []
    for solid in rendered.solids:
        item = solid.item
        if item is None:
            faces.append(_NO_TEXTURES)
            continue
        key = item, "" if damage_seed is None else solid.owner
        if key not in first:
            first[key] = len(textures)
            if damage_seed is None:
                textures += _textures(coloured(item), texture_seed)
            else:
                textures += _damaged_textures(coloured(item), texture_seed, damage_seed, solid.owner)
        n = 3 if item.shape.kind is ShapeKind.CYLINDER else 6
        faces.append((*range(first[key], first[key] + n), *_NO_TEXTURES[n:]))
    return Looks(
        np.array([_colour(solid) for solid in rendered.solids]).reshape(-1, 3),
        np.array([_gloss(solid.item) for solid in rendered.solids]),
        np.array(faces, dtype=np.int32).reshape(-1, 6),
        textures,
    )


@lru_cache(maxsize=256)
def _textures(item: Item, seed: int) -> tuple[Texture, ...]:
    """The faces of an item in the kernel, with their smaller copies; cached."""
    return tuple(map(Texture, face_textures(item, seed)))


@lru_cache(maxsize=256)
def _damaged_textures(item: Item, seed: int, damage_seed: int, owner: str) -> tuple[Texture, ...]:
    """The damaged faces of one copy of an item in the kernel; cached."""
    return tuple(map(Texture, damaged_faces(face_textures(item, seed), damage_seed, owner)))


def coloured(item: Item) -> Item:
    """Give an item without a stated colour the one that follows from its name.

    Args:
        item: The item.

    Returns:
        The item with a colour.
    """
    if item.colour is not None:
        return item
    red, green, blue, _ = item_colour(item)
    return replace(item, colour=(round(255 * red), round(255 * green), round(255 * blue)))


def _colour(solid: RenderedSolid) -> Array:
    """(3,) 0 to 255, of faces without a texture."""
    if solid.item is not None:
        return np.array(coloured(solid.item).colour, dtype=np.float64)
    return 255.0 * np.array((_LINK if solid.kind is OwnerKind.LINK else static_colour(solid.owner))[:3])


def _gloss(item: Item | None) -> float:
    if item is None:
        return _OTHER_GLOSS
    return _GLOSS.get(item.material, _PRINTED_GLOSS if item.is_printed else _OTHER_GLOSS)
