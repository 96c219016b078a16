"""Where the pod stands by its two front legs, in a slice of the cloud below its bins.

After team KTH (paper 000, section III-A): in a planar scan two things are looked for that may be the front
legs, and the position and direction of the line between them say where the pod is. What else looks like a leg
there, or hides one, makes it ambiguous; then nothing is said. A leg is a few pixels wide: this is a place to
start from.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.makers.pod import FRONT_LEGS
from pickcli.geometry import Array, inverse
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.planar_scan import PlanarScan, ScannedThing

SLICE, BELOW_BINS = 0.10, 0.07  # m, KTH's: 0.63 to 0.73 m over the floor, where the legs end at 0.80 m
LEAST_HEIGHT = 0.03  # m over the floor, where the slice may begin
MARGIN = 0.06  # m around where the legs can be within the pod's tolerance, in which things may be mistaken
NEAREST = 0.3  # m from the camera: what is nearer is no leg, but may hide one
WIDER, BEARINGS = 0.3, 2.0  # share of its width and bearings by which a leg may look wider or narrower
MOST_APART = 0.015  # m by which the distance of the legs may differ from the model's
LEAST_RETURNS = 20  # of a leg
_ROUNDS = 3  # what is seen of a leg depends on where it is


@dataclass(frozen=True, eq=False)
class FrontLegs:
    """The front legs of a cell's pod.

    Attributes:
        corners: (2, 4, 2) m, corners of both in the plane, the left one first, in the frame of the pod.
        low: m over the floor, where the slice begins.
        high: m over the floor, where it ends.
        aside: m by which a leg may be off its place by the pod's tolerance.
    """

    corners: Array
    low: float
    high: float
    aside: float

    @classmethod
    def of(cls, cell: Cell) -> FrontLegs | None:
        """Take the legs of a cell's pod.

        Args:
            cell: The cell.

        Returns:
            The legs; None if the pod has none, or too short ones for a slice.
        """
        bodies = [body for name in FRONT_LEGS for body in cell.pod.bodies if body.name == name]
        if not bodies:
            return None
        middles = np.array([body.T_parent_shape[:3, 3] for body in bodies])
        halves = np.array([body.shape.extents / 2 for body in bodies])
        high = float((middles + halves)[:, 2].min()) - BELOW_BINS
        if high - SLICE < LEAST_HEIGHT:
            return None
        signs = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        corners = middles[:, None, :2] + signs * halves[:, None, :2]
        free = cell.pod.displacement
        turned = free.yaw * float(np.hypot(*corners.reshape(-1, 2).T).max())
        return cls(corners, high - SLICE, high, float(np.hypot(free.x, free.y)) + turned)

    def located(self, picture: DepthPicture, T_world_guess: Array) -> Array | None:
        """Locate the pod by its legs.

        Args:
            picture: A picture.
            T_world_guess: (4, 4) where the pod may stand, within its tolerance.

        Returns:
            (3,) offset in x and y, m, and yaw, rad, in the frame of the guess; None if not both legs are seen
            whole, or something else may be one.
        """
        T_guess_camera = inverse(T_world_guess) @ picture.T_world_camera
        eye, ahead = T_guess_camera[:2, 3], self.corners.mean(axis=(0, 1)) - T_guess_camera[:2, 3]
        T_guess_slice = np.eye(4)
        c, s = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
        T_guess_slice[:2, :2] = [[c, -s], [s, c]]  # so that no bearing of interest is behind the camera
        scan = PlanarScan.of(picture, inverse(T_guess_camera) @ T_guess_slice, self.low, self.high)
        R = T_guess_slice[:2, :2]
        alike = [
            (eye + R @ thing.point, thing)
            for thing in scan.things
            if self._may_be_leg(eye + R @ thing.point, thing, eye, scan.step)
        ]
        if len(alike) != 2 or not all(thing.is_whole for _, thing in alike):
            return None
        left, right = sorted((point for point, _ in alike), key=lambda point: -float(point[1]))
        return self._offset(np.array([left, right]), eye)

    def _may_be_leg(self, point: Array, thing: ScannedThing, eye: Array, step: float) -> bool:
        """Whether something at a point (2,), m in the frame of the guess, looks like a front leg."""
        if thing.n_returns < LEAST_RETURNS or thing.range < NEAREST:
            return False
        low, high = self.corners.min(axis=(0, 1)), self.corners.max(axis=(0, 1))
        around = self.aside + MARGIN
        if (point < low - around).any() or (point > high + around).any():
            return False
        nearest = int(np.argmin(np.linalg.norm(self.corners.mean(axis=1) - point, axis=1)))
        middle = self.corners[nearest].mean(axis=0)
        seen = _seen(self.corners[nearest] - middle + point, eye)
        return abs(thing.extent - seen.extent) <= WIDER * seen.extent + BEARINGS * step

    def _offset(self, points: Array, eye: Array) -> Array | None:
        """By what offset of the pod its legs are seen from an eye (2,) at points (2, 2); None if by none."""
        offset = np.zeros(3)
        for _ in range(_ROUNDS):
            c, s = np.cos(offset[2]), np.sin(offset[2])
            R = np.array([[c, -s], [s, c]])
            at = R.T @ (eye - offset[:2])
            model = np.array([_seen(corners, at).point for corners in self.corners])
            across, between = points[0] - points[1], model[0] - model[1]
            yaw = np.arctan2(across[1], across[0]) - np.arctan2(between[1], between[0])
            c, s = np.cos(yaw), np.sin(yaw)
            shift = points.mean(axis=0) - np.array([[c, -s], [s, c]]) @ model.mean(axis=0)
            offset = np.array([*shift, np.arctan2(s, c)])
        is_apart = abs(np.linalg.norm(across) - np.linalg.norm(between)) > MOST_APART
        return None if is_apart else offset


@dataclass(frozen=True, eq=False)
class _SeenLeg:
    """What an eye sees of a leg: the middle of it, (2,) m, and its extent, rad."""

    point: Array
    extent: float


def _seen(corners: Array, eye: Array) -> _SeenLeg:
    """What an eye (2,) sees of a convex shape with corners (P, 2) in order, in the same frame."""
    rays = corners - eye
    middle = rays.mean(axis=0)
    angles = np.arctan2(middle[0] * rays[:, 1] - middle[1] * rays[:, 0], rays @ middle)
    half = (angles.max() + angles.min()) / 2
    c, s = np.cos(half), np.sin(half)
    way = np.array([[c, -s], [s, c]]) @ middle / np.linalg.norm(middle)
    sides = np.roll(rays, -1, axis=0) - rays
    # ray: t * way = rays + u * sides, for the nearest of the sides that it meets
    across = way[0] * sides[:, 1] - way[1] * sides[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (rays[:, 0] * sides[:, 1] - rays[:, 1] * sides[:, 0]) / across
        u = (rays[:, 0] * way[1] - rays[:, 1] * way[0]) / across
    meets = (u >= -1e-9) & (u <= 1.0 + 1e-9) & np.isfinite(t)
    return _SeenLeg(eye + float(t[meets].min()) * way, float(angles.max() - angles.min()))
