"""Grasp envelopes: the set of tool poses from which an object can be grasped, as inequalities.

A grasp is not chosen among given ones: any pose in the envelope is one, and what moves the arm takes the one
that suits it. Source: Krug et al., "The next step in robot commissioning" (APPLE), RA-L 2016, section III-A,
Fig. 3a.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array, inverse, pose
from pickcli.kernel import (
    PoseConstraint,
    PoseConstraintKind,
    ReferenceKind,
    SurfaceKind,
    pose_constraint_values,
)

APPROACH = np.array([0.0, 0.0, 1.0])  # of a tool, in its own frame
UNIT = 1e-6  # by which products of unit vectors may be off
LEAST_CONE = 2e-3  # rad, of which projections find poses
MOST_ROUNDS = 200  # of samples, of which those outside of the alignment's cone are drawn again


@dataclass(frozen=True, eq=False)
class Alignment:
    """Cone about an axis of the object in which an axis of the tool stays.

    Attributes:
        tool_axis: (3,) unit, in the tool frame, across its approach.
        object_axis: (3,) unit, in the object frame.
        angle: rad, half of the cone's opening.
    """

    tool_axis: Array
    object_axis: Array
    angle: float


@dataclass(frozen=True, eq=False)
class Envelope:
    """Set of tool poses: a palm within coordinates of a surface, its approach in a cone, its roll in another.

    The palm is a frame of the tool, behind its tip, turned like it. Its z axis is the approach.

    Attributes:
        name: What is grasped from where, e.g. "side" or the name of a face.
        surface: What the palm is about. PLANE: coordinates are x, y and z in m along the axes of the
            surface's frame, and the normal is its z axis. CYLINDER: azimuth in rad from its x axis, height
            along its z axis in m, and distance from that axis in m. SPHERE: azimuth in rad, elevation over
            the x-y plane in rad, and distance from the origin in m.
        T_object_surface: (4, 4) frame of the surface in the object's.
        low: (3,) least coordinates of the palm, see ``surface``.
        high: (3,) greatest coordinates.
        cone: rad, half of the opening of the cone about the inward normal in which the approach stays.
        alignment: Cone of another axis of the tool, if its roll is not free.
        depth: m, from the palm to the tip along the approach.
        face: Face of the object that the tool touches, as in the name of a grasp; empty if none is stated.
    """

    name: str
    surface: SurfaceKind
    T_object_surface: Array
    low: Array
    high: Array
    cone: float
    alignment: Alignment | None = None
    depth: float = 0.0
    face: str = ""

    def why_empty(self) -> str:
        """Tell which bounds no pose meets; "" if some do."""
        for name, low, high in zip(coordinate_names(self.surface), self.low, self.high, strict=True):
            if low > high:
                return f"{name}: from {low:.4g} to {high:.4g}"
        if self.surface is not SurfaceKind.PLANE and self.low[2] <= 0.0:
            return f"distance: from {self.low[2]:.4g} m, where there is no normal"
        if self.surface is SurfaceKind.SPHERE and max(-self.low[1], self.high[1]) > np.pi / 2:
            return f"elevation: from {self.low[1]:.4g} to {self.high[1]:.4g}, over a right angle"
        if not LEAST_CONE <= self.cone < np.pi / 2:
            return f"cone: {self.cone:.4g} rad, {LEAST_CONE:g} at least"
        if self.alignment is not None and (why := self._why_not_aligned(self.alignment)):
            return f"alignment: {why}"
        is_round = self.surface is not SurfaceKind.PLANE
        if is_round and np.linalg.norm(np.cross(self.roll_from, self.T_object_surface[:3, 2])) > 1e-6:
            return "alignment: an axis other than the surface's, which no roll keeps all around"
        return ""

    def _why_not_aligned(self, alignment: Alignment) -> str:
        tool, normal = alignment.tool_axis, self.T_object_surface[:3, 2]
        if abs(tool @ APPROACH) > UNIT or abs(tool @ tool - 1.0) > UNIT:
            return "an axis of the tool that is not a unit vector across its approach"
        if not LEAST_CONE <= alignment.angle < np.pi / 2:
            return f"{alignment.angle:.4g} rad, {LEAST_CONE:g} at least"
        if self.surface is SurfaceKind.PLANE and abs(alignment.object_axis @ normal) > UNIT:
            return "an axis of the object that is not across the normal"
        return ""

    @cached_property
    def constraints(self) -> tuple[PoseConstraint, ...]:
        """The terms e(T) <= 0 on the palm's pose in the object frame, in m or as differences of cosines."""
        return (*self._position(), *self._orientation())

    def terms(self, T_object_tip: Array) -> Array:
        """Evaluate the terms at poses.

        Args:
            T_object_tip: (N, 4, 4) poses of the tool's tip in the object frame.

        Returns:
            (N, m) m or differences of cosines; a pose is in the envelope if none is over 0.
        """
        return np.asarray(pose_constraint_values(self.constraints, T_object_tip @ self.T_tip_palm))

    def contains(self, T_object_tip: Array, tolerance: float = 1e-9) -> NDArray[np.bool_]:
        """Whether poses are in the envelope.

        Args:
            T_object_tip: (N, 4, 4) poses of the tool's tip in the object frame.
            tolerance: m or difference of cosines that still count as inside.

        Returns:
            (N,) True for those that are.
        """
        return np.asarray((self.terms(T_object_tip) <= tolerance).all(axis=1))

    def sample(self, rng: np.random.Generator, n: int) -> Array:
        """Draw poses: uniform in coordinates, roll, and over the cone's area.

        Args:
            rng: Source of the samples.
            n: Number of poses.

        Returns:
            (n, 4, 4) poses of the tool's tip in the object frame, each in the envelope; fewer if the
            alignment leaves next to nothing of the approach's cone.
        """
        found = np.empty((0, 4, 4))
        for _ in range(MOST_ROUNDS):
            coordinates = self.low + (self.high - self.low) * rng.random((n, 3))
            roll = rng.uniform(-self.most_roll, self.most_roll, n)
            off, around = self.cone * np.sqrt(rng.random(n)), rng.uniform(-np.pi, np.pi, n)
            tilt = off[:, None] * np.stack([np.cos(around), np.sin(around)], axis=1)
            T = self.poses_at(coordinates, roll, tilt)
            found = np.concatenate([found, T[self.contains(T)]])[:n]
            if len(found) == n:
                break
        return found

    def poses_at(self, coordinates: Array, roll: Array, tilt: Array) -> Array:
        """Return the poses at coordinates, turned about the approach and then tilted.

        Args:
            coordinates: (N, 3) of the palm, see ``surface``.
            roll: (N,) rad about the approach, from where the tool's axis is nearest to its alignment.
            tilt: (N, 2) rad, rotation vectors across the inward normal.

        Returns:
            (N, 4, 4) poses of the tool's tip in the object frame.
        """
        origin, normal = self._at(coordinates)
        x, y = self._across(normal)
        T = np.tile(np.eye(4), (len(coordinates), 1, 1))
        c, s = np.cos(roll)[:, None], np.sin(roll)[:, None]
        R = np.stack([c * x + s * y, c * y - s * x, -normal], axis=-1)
        axis = tilt[:, :1] * x + tilt[:, 1:] * y
        T[:, :3, :3] = _turned(axis, R @ self.R_nominal)
        T[:, :3, 3] = origin
        return np.asarray(T @ inverse(self.T_tip_palm))

    def clipped(self, T_object_tip: Array) -> Array:
        """Move poses, without a turn, so that the palm's coordinates are within their bounds.

        Args:
            T_object_tip: (N, 4, 4) poses of the tool's tip in the object frame.

        Returns:
            (N, 4, 4) the moved poses; those whose coordinates were within bounds stay where they are.
        """
        T_palm = T_object_tip @ self.T_tip_palm
        T_palm[:, :3, 3], _ = self._at(np.clip(self._coordinates(T_palm[:, :3, 3]), self.low, self.high))
        return np.asarray(T_palm @ inverse(self.T_tip_palm))

    def within(self, low: Array, high: Array, share: float) -> Envelope:
        """Return a part of the envelope.

        Args:
            low: (3,) its least coordinates.
            high: (3,) its greatest coordinates.
            share: Of the angles of both cones.

        Returns:
            The smaller envelope.
        """
        alignment = self.alignment and replace(
            self.alignment, angle=max(LEAST_CONE, share * self.alignment.angle)
        )
        cone = max(LEAST_CONE, share * self.cone)
        return replace(self, low=low, high=high, cone=cone, alignment=alignment)

    @property
    def T_tip_palm(self) -> Array:
        """(4, 4) pose of the palm in the frame of the tool's tip."""
        return pose((0.0, 0.0, -self.depth))

    @property
    def most_roll(self) -> float:
        """Bound of the roll of a pose in rad.

        A tilt turns the aligned axis by its own angle at most, so before it the axis was within the sum of
        both angles of its object's; the roll, the angle between their parts across the normal, is no more
        than that if it is less than a right angle.
        """
        if self.alignment is None or self.alignment.angle + self.cone >= np.pi / 2:
            return np.pi
        return self.alignment.angle + self.cone

    @property
    def is_closed(self) -> bool:
        """Whether the palm may go all around the surface."""
        return self.surface is not SurfaceKind.PLANE and self.high[0] - self.low[0] >= 2 * np.pi - 1e-9

    @property
    def roll_from(self) -> Array:
        """(3,) unit, in the object frame: roll is measured from what of it is across the normal."""
        if self.alignment is not None:
            return self.alignment.object_axis
        return np.ascontiguousarray(self.T_object_surface[:3, 0 if self.surface is SurfaceKind.PLANE else 2])

    @property
    def R_nominal(self) -> Array:
        """(3, 3) the tool in a frame whose x axis is the aligned one, and whose z axis the approach."""
        if self.alignment is None:
            return np.eye(3)
        x = self.alignment.tool_axis
        return np.stack([x, np.cross(APPROACH, x), APPROACH])

    def _at(self, coordinates: Array) -> tuple[Array, Array]:
        """Return points (N, 3) and outward normals (N, 3) at coordinates (N, 3), in the object frame."""
        R, p = self.T_object_surface[:3, :3], self.T_object_surface[:3, 3]
        if self.surface is SurfaceKind.PLANE:
            return coordinates @ R.T + p, np.tile(R[:, 2], (len(coordinates), 1))
        a, b, d = coordinates.T
        if self.surface is SurfaceKind.CYLINDER:
            normal = np.stack([np.cos(a), np.sin(a), np.zeros(len(a))], axis=1)
            point = d[:, None] * normal + b[:, None] * APPROACH
        else:
            normal = np.stack([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)], axis=1)
            point = d[:, None] * normal
        return point @ R.T + p, normal @ R.T

    def _coordinates(self, points: Array) -> Array:
        """Return coordinates (N, 3) of points (N, 3) in the object frame; azimuths about their bounds."""
        R, p = self.T_object_surface[:3, :3], self.T_object_surface[:3, 3]
        x, y, z = local = ((points - p) @ R).T
        if self.surface is SurfaceKind.PLANE:
            return np.asarray(local.T)
        middle = (self.low[0] + self.high[0]) / 2
        azimuth = middle + (np.arctan2(y, x) - middle + np.pi) % (2 * np.pi) - np.pi
        flat = np.hypot(x, y)
        if self.surface is SurfaceKind.CYLINDER:
            return np.stack([azimuth, z, flat], axis=1)
        return np.stack([azimuth, np.arctan2(z, flat), np.hypot(flat, z)], axis=1)

    def _across(self, normal: Array) -> tuple[Array, Array]:
        """Return two axes (N, 3) across normals (N, 3), the first nearest to the alignment's."""
        wanted = self.roll_from
        x = wanted - (normal @ wanted)[:, None] * normal
        size = np.linalg.norm(x, axis=1, keepdims=True)
        other = np.cross(normal, self.T_object_surface[:3, 0])  # where the normal is along the wanted axis
        x = np.where(size > 1e-9, x / np.maximum(size, 1e-9), other)
        return x, np.cross(-normal, x)

    def _position(self) -> list[PoseConstraint]:
        R, p = self.T_object_surface[:3, :3], self.T_object_surface[:3, 3]
        found: list[PoseConstraint] = []
        if self.surface is SurfaceKind.PLANE:
            for k in range(3):
                found += _distances(ReferenceKind.PLANE, p, R[:, k], self.low[k], self.high[k])
            return found
        if not self.is_closed:
            middle, half = (self.low[0] + self.high[0]) / 2, (self.high[0] - self.low[0]) / 2
            towards = R @ np.array([np.cos(middle), np.sin(middle), 0.0])
            found.append(_normal_to(ReferenceKind.LINE, p, R[:, 2], towards, np.cos(half)))
        if self.surface is SurfaceKind.CYLINDER:
            found += _distances(ReferenceKind.PLANE, p, R[:, 2], self.low[1], self.high[1])
            return [*found, *_distances(ReferenceKind.LINE, p, R[:, 2], self.low[2], self.high[2])]
        for sign, bound in ((1.0, self.low[1]), (-1.0, self.high[1])):
            if abs(bound) < np.pi / 2:
                found.append(
                    _normal_to(ReferenceKind.POINT, p, R[:, 2], sign * R[:, 2], sign * np.sin(bound))
                )
        return [*found, *_distances(ReferenceKind.POINT, p, R[:, 2], self.low[2], self.high[2])]

    def _orientation(self) -> list[PoseConstraint]:
        R, p = self.T_object_surface[:3, :3], self.T_object_surface[:3, 3]
        cosine = float(np.cos(self.cone))
        if self.surface is SurfaceKind.PLANE:
            found = [_tool_to(APPROACH, -R[:, 2], cosine)]
        else:
            about = ReferenceKind.LINE if self.surface is SurfaceKind.CYLINDER else ReferenceKind.POINT
            kind = PoseConstraintKind.TOOL_TO_NORMAL
            found = [PoseConstraint(kind, about, p, R[:, 2], -APPROACH, R[:, 2], cosine)]
        if (aligned := self.alignment) is not None:
            found.append(_tool_to(aligned.tool_axis, aligned.object_axis, float(np.cos(aligned.angle))))
        return found


def coordinate_names(surface: SurfaceKind) -> tuple[str, str, str]:
    """Name the coordinates of a surface.

    Args:
        surface: The surface.

    Returns:
        The three names.
    """
    return {
        SurfaceKind.PLANE: ("x", "y", "z"),
        SurfaceKind.CYLINDER: ("azimuth", "height", "distance"),
        SurfaceKind.SPHERE: ("azimuth", "elevation", "distance"),
    }[surface]


def _distances(
    kind: ReferenceKind, origin: Array, axis: Array, low: float, high: float
) -> tuple[PoseConstraint, ...]:
    least, most = PoseConstraintKind.DISTANCE_AT_LEAST, PoseConstraintKind.DISTANCE_AT_MOST
    bounds = ((least, low), (most, high))
    return tuple(PoseConstraint(each, kind, origin, axis, APPROACH, axis, bound) for each, bound in bounds)


def _normal_to(
    kind: ReferenceKind, origin: Array, axis: Array, fixed: Array, cosine: float
) -> PoseConstraint:
    return PoseConstraint(
        PoseConstraintKind.NORMAL_TO_FIXED, kind, origin, axis, APPROACH, fixed, float(cosine)
    )


def _tool_to(tool: Array, fixed: Array, cosine: float) -> PoseConstraint:
    origin = np.zeros(3)
    return PoseConstraint(
        PoseConstraintKind.TOOL_TO_FIXED, ReferenceKind.POINT, origin, APPROACH, tool, fixed, cosine
    )


def _turned(vectors: Array, R: Array) -> Array:
    """Rotate frames R (N, 3, 3) by rotation vectors (N, 3) of less than pi (Rodrigues)."""
    squared = (vectors**2).sum(axis=1)[:, None, None]
    x, y, z = vectors.T
    zero = np.zeros(len(vectors))
    K = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    half_sinc = np.sinc(np.sqrt(squared) / 2 / np.pi)
    turns = np.eye(3) + np.sinc(np.sqrt(squared) / np.pi) * K + half_sinc**2 / 2 * (K @ K)
    return np.asarray(turns @ R)
