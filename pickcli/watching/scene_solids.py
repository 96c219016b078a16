"""The solids of a watched scene at one instant, as the kernel casts rays at them, and what each reflects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.kernel import RaycastingScene, SolidKind
from pickcli.seeds import derived_rng
from pickcli.watching.retroreflection import TORSO, TORSO_ENDS
from pickcli.watching.watched_scene import Reflector, ReflectorKind, Walker, WatchedScene

STANDARD = 1.75  # m, the height of which proportions are
WALL_HEIGHT = 4.0  # m
THIN = 0.004  # m, thickness of signs and tape
MATTE, VEST, RETRO, METAL = 0, 1, 2, 3  # surfaces
ALBEDO = (0.2, 0.8)  # of walls and boxes, drawn for each
CLOTHES, SKIN, METAL_ALBEDO = 0.35, 0.5, 0.6


@dataclass(frozen=True, eq=False)
class SceneSolids:
    """Solids, in the order of the kernel's indices.

    Attributes:
        T: (N, 4, 4) poses on the floor.
        half: (N, 3) m, half extents as the kernel takes them.
        kinds: (N,) of SolidKind.
        surfaces: (N,) MATTE, VEST, RETRO or METAL.
        albedos: (N,) of diffuse light.
        scales: (N,) of a vest: height of its person over that of the standard.
    """

    T: Array
    half: Array
    kinds: NDArray[np.int32]
    surfaces: NDArray[np.int32]
    albedos: Array
    scales: Array

    @classmethod
    def of(cls, rows: list[_Row]) -> SceneSolids:
        """Gather solids, in the order of their rows.

        Args:
            rows: One for each.

        Returns:
            All of them.
        """
        return cls(
            np.array([row.T for row in rows]).reshape(-1, 4, 4),
            np.array([row.half for row in rows]).reshape(-1, 3),
            np.array([row.kind for row in rows], dtype=np.int32),
            np.array([row.surface for row in rows], dtype=np.int32),
            np.array([row.albedo for row in rows]), np.array([row.scale for row in rows]),
        )  # fmt: skip

    def then(self, other: SceneSolids) -> SceneSolids:
        """Put other solids after these.

        Args:
            other: The others.

        Returns:
            All of them.
        """
        names = ("T", "half", "kinds", "surfaces", "albedos", "scales")
        return SceneSolids(*(np.concatenate([getattr(self, name), getattr(other, name)]) for name in names))

    @property
    def kernel(self) -> RaycastingScene:
        """The solids in the kernel."""
        n_planes = np.zeros(len(self.T), dtype=np.int32)
        return RaycastingScene(self.T, self.half, self.kinds, np.zeros((0, 4)), n_planes)


@dataclass(frozen=True, eq=False)
class _Row:
    """One solid, as in ``SceneSolids``."""

    T: Array
    half: tuple[float, float, float]
    kind: SolidKind
    surface: int
    albedo: float
    scale: float = 1.0


def standing_solids(scene: WatchedScene, seed: int) -> SceneSolids:
    """Return what does not move: floor, walls, boxes, reflectors.

    Args:
        scene: The scene.
        seed: Seed of how light floor, walls and boxes are.

    Returns:
        The solids.
    """
    area, rng = scene.area, derived_rng("watched surfaces", seed)
    (x, y), sides = (np.array(area.low) + area.high) / 2, np.array(area.high) - area.low
    rows = [_box((x, y, -0.5), (sides[0] / 2 + 1, sides[1] / 2 + 1, 0.5), 0.0, rng.uniform(*ALBEDO))]
    for sign in (-1, 1):
        for axis in (0, 1):
            middle, extent = np.array([x, y, WALL_HEIGHT / 2]), np.array([*(sides / 2 + 1), WALL_HEIGHT / 2])
            middle[axis] += sign * (sides[axis] / 2 + 0.05)
            extent[axis] = 0.05
            rows.append(_box(middle, extent, 0.0, rng.uniform(*ALBEDO)))
    for box, height in zip(area.boxes, scene.box_heights, strict=True):
        half = (box.size[0] / 2, box.size[1] / 2, height / 2)
        rows.append(_box((*box.centre, height / 2), half, box.yaw, rng.uniform(*ALBEDO)))
    return SceneSolids.of(rows + [_reflector(each) for each in scene.reflectors])


def walker_solids(walkers: tuple[Walker, ...], time: float) -> SceneSolids:
    """Return the people at one instant.

    Args:
        walkers: The people.
        time: s.

    Returns:
        Legs, body, arms and head of each.
    """
    return SceneSolids.of([row for walker in walkers for row in _person(walker, time)])


def _person(walker: Walker, time: float) -> list[_Row]:
    scale, (x, y), heading = walker.height / STANDARD, walker.place(time).tolist(), walker.heading(time)
    low, high = (scale * end for end in TORSO_ENDS)
    aside = 0.22 * scale * np.array([-np.sin(heading), np.cos(heading)])
    surface = VEST if walker.has_vest else MATTE
    legs = [_post((a, b), (0.0, low), r, MATTE, CLOTHES) for a, b, r in walker.legs(time)]
    arms = [
        _post((x + s * aside[0], y + s * aside[1]), (low, high), 0.045 * scale, MATTE, CLOTHES)
        for s in (-1, 1)
    ]
    body = _post((x, y), (low, high), TORSO * scale, surface, CLOTHES, heading, scale)
    head = _Row(
        _pose((x, y, high + 0.17 * scale), 0.0), (0.11 * scale,) * 3, SolidKind.SPHERE, MATTE, SKIN
    )  # fmt: skip
    return [*legs, *arms, body, head]


def _reflector(each: Reflector) -> _Row:
    (x, y, z), (along, up) = each.centre, each.size
    if each.kind is ReflectorKind.POST:
        return _post((x, y), (z - up / 2, z + up / 2), along / 2, METAL, METAL_ALBEDO)
    half = (along / 2, up / 2, THIN / 2) if each.is_flat else (THIN / 2, along / 2, up / 2)
    return _Row(_pose((x, y, z), each.yaw), half, SolidKind.BOX, RETRO, 0.7)


def _box(
    place: tuple[float, ...] | Array, half: tuple[float, ...] | Array, yaw: float, albedo: float
) -> _Row:
    a, b, c = (float(each) for each in half)
    return _Row(_pose(place, yaw), (a, b, c), SolidKind.BOX, MATTE, albedo)


def _post(
    place: tuple[float, float], ends: tuple[float, float], radius: float, surface: int, albedo: float,
    yaw: float = 0.0, scale: float = 1.0,
) -> _Row:  # fmt: skip
    low, high = ends
    half = (radius, radius, (high - low) / 2)
    return _Row(_pose((*place, (low + high) / 2), yaw), half, SolidKind.CYLINDER, surface, albedo, scale)


def _pose(place: tuple[float, ...] | Array, yaw: float) -> Array:
    T, c, s = np.eye(4), np.cos(yaw), np.sin(yaw)
    T[:2, :2] = [[c, -s], [s, c]]
    T[:3, 3] = place
    return T
