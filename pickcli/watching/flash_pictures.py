"""What a pair of cameras sees with flash and, a moment later, without: pictures in counts, with noise.

Matte surfaces reflect as Lambert's law says, vests and reflectors throw the flash back towards it. Each
picture is of its own instant: truck and people move between both. Left out: gloss, smear of bright pixels,
dust and rain, lamps that flicker, other trucks' flashes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.watching.nir_pair import NirPair
from pickcli.watching.retroreflection import STRIPE, TORSO, TORSO_ENDS, retroreflection, stripe_cover
from pickcli.watching.scene_solids import (
    METAL,
    RETRO,
    STANDARD,
    VEST,
    SceneSolids,
    standing_solids,
    walker_solids,
)
from pickcli.watching.watched_scene import Walker, WatchedScene

GrayPicture: TypeAlias = NDArray[np.float32]
GLINT = np.radians(4.0)  # of the angle of incidence within which polished metal shows the flash itself
GLINT_COEFFICIENT = 30.0  # cd/lx/m^2 there
LEAST_LIGHT = 0.4  # of the ambient light that comes from everywhere; the rest grows towards facing surfaces


@dataclass(frozen=True, eq=False)
class FlashPictures:
    """Four pictures of one pair, each (height, width) in counts.

    Attributes:
        time: s of the exposure with flash.
        left_on: Left, with flash.
        right_on: Right, with flash.
        left_off: Left, without.
        right_off: Right, without.
    """

    time: float
    left_on: GrayPicture
    right_on: GrayPicture
    left_off: GrayPicture
    right_off: GrayPicture


@dataclass(frozen=True, eq=False)
class FlashRenderer:
    """Renders a watched scene as a pair sees it.

    Attributes:
        pair: The pair.
        scene: The scene.
        seed: Seed of how light surfaces are.
    """

    pair: NirPair
    scene: WatchedScene
    seed: int

    @cached_property
    def _standing(self) -> SceneSolids:
        return standing_solids(self.scene, self.seed)

    @cached_property
    def _rays(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """(height, width, 3) rays at depth 1, and (height, width) their lengths."""
        rays = self.pair.camera.rays.astype(np.float32)
        return rays, np.linalg.norm(rays, axis=-1)

    def pictures(
        self, time: float, pose_at: Callable[[float], Array], rng: np.random.Generator
    ) -> FlashPictures:
        """Take four pictures.

        Args:
            time: s of the exposure with flash.
            pose_at: The truck's true pose (3,) m, m, rad by time in s.
            rng: Source of the noise.

        Returns:
            The pictures.
        """
        taken = []
        for at, has_flash in ((time, True), (time + self.pair.gap, False)):
            solids = self._standing.then(walker_solids(self.scene.walkers, at))
            pose = pose_at(at)
            taken += [self._picture(solids, pose, is_right, has_flash, rng) for is_right in (False, True)]
        return FlashPictures(time, *taken)

    def visible_shares(self, time: float, pose: Array) -> Array:
        """Return how much of each person's vest both cameras see: the truth that detections are judged by.

        Args:
            time: s.
            pose: (3,) m, m, rad: true pose of the truck.

        Returns:
            (number of walkers,) least share of both cameras of the pixels of the vest's body that nothing
            else hides; 0 for those without a vest, and where the vest is not in range and whole in both
            pictures.
        """
        walkers = self.scene.walkers
        shares = np.zeros(len(walkers))
        solids = self._standing.then(walker_solids(walkers, time))
        bodies = np.flatnonzero(solids.surfaces == VEST)
        views = [self._index(solids, pose, is_right) for is_right in (False, True)]
        dressed = [k for k, walker in enumerate(walkers) if walker.has_vest]
        for k, body in zip(dressed, bodies.tolist(), strict=True):
            if not self._is_framed(walkers[k], time, pose):
                continue
            alone = walker_solids((walkers[k],), time)
            own = int(np.flatnonzero(alone.surfaces == VEST)[0])
            whole = [max(1, _count(self._index(alone, pose, is_right), own)) for is_right in (False, True)]
            shares[k] = min(
                _count(view, body) / all_of_it for view, all_of_it in zip(views, whole, strict=True)
            )
        return shares

    def _index(self, solids: SceneSolids, pose: Array, is_right: bool) -> NDArray[np.int32]:
        """(height, width) indices of the solids that a camera sees."""
        camera, T = self.pair.camera, _on_floor(pose) @ self.pair.T_truck_camera(is_right)
        return solids.kernel.cast_rays(camera.intrinsics, camera.size, T)[1]

    def _is_framed(self, walker: Walker, time: float, pose: Array) -> bool:
        """Whether a vest is in range and whole in both pictures."""
        scale, (x, y) = walker.height / STANDARD, (walker.place(time) - pose[:2]).tolist()
        c, s = np.cos(pose[2]), np.sin(pose[2])
        ahead, beside = c * x + s * y, c * y - s * x
        if not self.pair.nearest <= ahead - self.pair.forward <= self.pair.farthest:
            return False
        ends = np.array([
            (ahead - TORSO, beside + side * TORSO, scale * end) for side in (-1, 1) for end in TORSO_ENDS
        ])  # fmt: skip
        seen = np.concatenate([self.pair.projected(ends, is_right) for is_right in (False, True)])
        last = np.array([self.pair.width, self.pair.height]) - 1
        return bool((seen >= 0).all() and (seen <= last).all())

    def _picture(
        self, solids: SceneSolids, pose: Array, is_right: bool, has_flash: bool, rng: np.random.Generator
    ) -> GrayPicture:
        camera, T = self.pair.camera, _on_floor(pose) @ self.pair.T_truck_camera(is_right)
        depth, index, normals = solids.kernel.cast_rays(camera.intrinsics, camera.size, T)
        rays, lengths = self._rays
        is_seen = index >= 0
        # Albedo 0 and depth 1 where nothing is seen.
        albedo = np.append(solids.albedos, 0.0).astype(np.float32)[index]
        depth = np.where(is_seen, depth, np.float32(1.0))
        facing = -np.einsum("ijk,ijk->ij", rays, normals) / lengths
        facing = np.where(is_seen, facing, np.float32(0.0))
        scattered = np.float32(self.pair.ambient) * albedo * (LEAST_LIGHT + (1 - LEAST_LIGHT) * facing)
        light = (scattered * self._sunshine(depth, T)).astype(np.float32)
        if has_flash:
            off_axis = 1 / lengths
            flash = np.float32(self.pair.flash) * off_axis / (depth * lengths) ** 2
            light += flash * albedo / np.float32(np.pi) * facing
            self._add_retroreflection(light, flash, solids, (depth, index, facing), T)
        return self._exposed(light, rng)

    def _sunshine(self, depth: GrayPicture, T: Array) -> GrayPicture:
        """(height, width): how many times the light indoors each pixel has; 1 outside of the sun."""
        times = np.ones_like(depth)
        if not self.scene.sun:
            return times
        R, rays = T[:3, :3].astype(np.float32), self._rays[0]
        x, y = (T[k, 3].astype(np.float32) + depth * (rays @ R[k]) for k in (0, 1))
        for patch in self.scene.sun:
            c, s = np.float32(np.cos(patch.yaw)), np.float32(np.sin(patch.yaw))
            dx, dy = x - np.float32(patch.centre[0]), y - np.float32(patch.centre[1])
            along, across = c * dx + s * dy, c * dy - s * dx
            is_in = (np.abs(along) < patch.size[0] / 2) & (np.abs(across) < patch.size[1] / 2)
            times[is_in] = patch.strength
        return times

    def _add_retroreflection(
        self, light: GrayPicture, flash: GrayPicture, solids: SceneSolids,
        seen: tuple[GrayPicture, NDArray[np.int32], GrayPicture], T: Array,
    ) -> None:  # fmt: skip
        """Add to the light what vests, reflectors and polished metal throw back."""
        depth, index, facing = seen
        surfaces = np.append(solids.surfaces, 0)[index]
        rows, columns = np.nonzero(surfaces)
        if not len(rows):
            return
        at = rows, columns
        surface, which = surfaces[at], index[at]
        distance = depth[at] * self._rays[1][at]
        entrance = np.arccos(np.clip(facing[at], 0.0, 1.0)).astype(np.float64)
        returned = retroreflection((self.pair.flash_offset / distance).astype(np.float64), entrance)
        footprint = depth[at].astype(np.float64) / self.pair.camera.fx
        cover = np.ones(len(rows))
        is_vest = surface == VEST
        points = T[:3, 3] + (self._rays[0][at] * depth[at][:, None]).astype(np.float64) @ T[:3, :3].T
        cover[is_vest] = _vest_cover(
            solids, which[is_vest], points[is_vest], footprint[is_vest], facing[at][is_vest]
        )
        metal = np.where(entrance < GLINT, GLINT_COEFFICIENT, 0.0)
        factor = np.select([is_vest, surface == RETRO, surface == METAL], [cover * returned, returned, metal])
        light[at] += (flash[at] * factor).astype(np.float32)

    def _exposed(self, light: GrayPicture, rng: np.random.Generator) -> GrayPicture:
        """Counts of a camera: optics that blur by a pixel, shot and read noise, whole numbers."""
        light = _blurred(light)
        per_count = self.pair.full / self.pair.largest
        sigma = np.sqrt(self.pair.read_noise**2 + light / np.float32(per_count))
        noisy = light + sigma * rng.standard_normal(light.shape, dtype=np.float32)
        counts: GrayPicture = np.clip(np.rint(noisy), 0.0, self.pair.largest).astype(np.float32)
        return counts


def _vest_cover(
    solids: SceneSolids, which: NDArray[np.int32], points: Array, footprint: Array, facing: Array
) -> Array:
    """(N,) share of stripes in pixels of vests, at (N, 3) m with (N,) m of a pixel."""
    T, scale = solids.T[which], solids.scales[which]
    local = np.einsum("nji,nj->ni", T[:, :3, :3], points - T[:, :3, 3])
    around = np.arctan2(local[:, 1], local[:, 0])
    above = local[:, 2] / scale + sum(TORSO_ENDS) / 2
    across = np.minimum(footprint / np.maximum(facing, 0.1), 4 * STRIPE) / scale
    return stripe_cover(around, above, across, footprint / scale)


def _count(index: NDArray[np.int32], solid: int) -> int:
    """Number of pixels that show a solid."""
    return int(np.count_nonzero(index == solid))


def _on_floor(pose: Array) -> Array:
    """(4, 4) pose on the floor of (3,) m, m, rad."""
    T, c, s = np.eye(4), np.cos(pose[2]), np.sin(pose[2])
    T[:2, :2] = [[c, -s], [s, c]]
    T[:2, 3] = pose[:2]
    return T


def _blurred(picture: GrayPicture) -> GrayPicture:
    """A picture with each pixel spread by (1, 2, 1) / 4 along rows and columns."""
    for axis in (0, 1):
        rows = np.moveaxis(picture, axis, 0)
        inner = rows.copy()
        inner[1:-1] = rows[1:-1] / 2 + (rows[:-2] + rows[2:]) / 4
        picture = np.moveaxis(inner, 0, axis)
    return picture
