"""The kernel's oracle: the same questions answered in plain numpy, slowly and without any cleverness."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.kernel import Chain, Checker

REVOLUTE, PRISMATIC, FIXED = 0, 1, 2
BOX, CYLINDER, SPHERE = 0, 1, 2


@dataclass(frozen=True, eq=False)
class Arm:
    """A chain with spheres and perhaps a held item, as the kernel takes them."""

    joint_types: NDArray[np.int32]  # (L,)
    T_parent_joint: Array  # (L, 4, 4)
    axes: Array  # (L, 3) unit
    q_index: NDArray[np.int32]  # (L,)
    centers: Array  # (S, 3)
    radii: Array  # (S,)
    frame: NDArray[np.int32]  # (S,)
    self_pairs: NDArray[np.int32]  # (P, 2)
    fine_centers: Array = field(default_factory=lambda: np.empty((0, 3)))
    fine_radii: Array = field(default_factory=lambda: np.empty(0))
    fine_frame: NDArray[np.int32] = field(default_factory=lambda: np.empty(0, np.int32))
    held_centers: Array = field(default_factory=lambda: np.empty((0, 3)))
    held_radii: Array = field(default_factory=lambda: np.empty(0))
    held_tested: NDArray[np.int32] = field(default_factory=lambda: np.empty(0, np.int32))

    @property
    def n(self) -> int:
        return int(self.q_index.max()) + 1

    @property
    def n_frames(self) -> int:
        return len(self.joint_types)

    def chain(self) -> Chain:
        return Chain(self.joint_types, self.T_parent_joint, self.axes, self.q_index)

    def checker(self, world: World) -> Checker:
        fine = (self.fine_centers, self.fine_radii, self.fine_frame)
        checker = Checker(self.chain(), self.centers, self.radii, self.frame, self.self_pairs, *fine)
        world.enter(checker)
        checker.set_held(self.held_centers, self.held_radii, self.held_tested)
        return checker


@dataclass(frozen=True, eq=False)
class World:
    """Solids; without kinds and roundings plain boxes."""

    T_world_box: Array  # (B, 4, 4)
    half_extents: Array  # (B, 3)
    ignored_frames: NDArray[np.uint64]  # (B,)
    kind: NDArray[np.int32] | None = None  # (B,)
    rounding: Array | None = None  # (B,)

    def solids(self) -> list[Solid]:
        n = len(self.half_extents)
        kind = np.zeros(n, np.int32) if self.kind is None else self.kind
        rounding = np.zeros(n) if self.rounding is None else self.rounding
        columns = zip(self.T_world_box, self.half_extents, kind.tolist(), rounding.tolist(), strict=True)
        return [Solid(*column) for column in columns]

    def enter(self, checker: Checker) -> None:
        T, half, ignored = self.T_world_box, self.half_extents, self.ignored_frames
        if self.kind is None and self.rounding is None:
            checker.set_world(T, half, ignored)
        else:
            checker.set_world(T, half, ignored, self.kind, self.rounding)


@dataclass(frozen=True, eq=False)
class Solid:
    """A box, a cylinder about its z or a sphere, and all within its rounding."""

    T: Array  # (4, 4) in the parent
    half: Array  # (3,)
    kind: int = BOX
    rounding: float = 0.0

    def distances(self, points: Array) -> Array:
        """Signed distances (...,) of points (..., 3)."""
        local = (points - self.T[:3, 3]) @ self.T[:3, :3]
        if self.kind == SPHERE:
            return np.asarray(np.linalg.norm(local, axis=-1) - self.half[0] - self.rounding)
        if self.kind == CYLINDER:
            local = np.stack([np.linalg.norm(local[..., :2], axis=-1), local[..., 2]], axis=-1)
        d = np.abs(local) - (self.half[[0, 2]] if self.kind == CYLINDER else self.half)
        outside = np.linalg.norm(np.maximum(d, 0.0), axis=-1)
        return np.asarray(np.where(outside > 0, outside, d.max(axis=-1)) - self.rounding)


def motion(joint_type: int, axis: Array, q: Array) -> Array:
    """Motions (N, 4, 4) of one joint at the positions q (N,)."""
    T = np.tile(np.eye(4), (len(q), 1, 1))
    if joint_type == PRISMATIC:
        T[:, :3, 3] = q[:, None] * axis
    elif joint_type == REVOLUTE:
        x, y, z = axis
        K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        T[:, :3, :3] += np.sin(q)[:, None, None] * K + (1 - np.cos(q))[:, None, None] * (K @ K)
    return T


def frames(arm: Arm, Q: Array) -> Array:
    """Poses (N, L, 4, 4) of all frames at Q (N, n)."""
    T = np.tile(np.eye(4), (len(Q), 1, 1))
    out = []
    for k in range(arm.n_frames):
        q = Q[:, arm.q_index[k]] if arm.q_index[k] >= 0 else np.zeros(len(Q))
        T = T @ arm.T_parent_joint[k] @ motion(arm.joint_types[k], arm.axes[k], q)
        out.append(T)
    return np.stack(out, axis=1)


def spheres(arm: Arm, Q: Array) -> tuple[Array, Array, NDArray[np.int32]]:
    """Centres (N, S + H, 3) in the world, radii and frames (S + H,), the held item last, as frame L."""
    return _placed(arm, Q, arm.centers, arm.radii, arm.frame)


def self_spheres(arm: Arm, Q: Array) -> tuple[Array, Array, NDArray[np.int32]]:
    """The same of what frames are tested against each other by: the fine ones where a frame has any."""
    coarse = ~np.isin(arm.frame, arm.fine_frame)
    return _placed(
        arm,
        Q,
        np.concatenate([arm.centers[coarse], arm.fine_centers]),
        np.concatenate([arm.radii[coarse], arm.fine_radii]),
        np.concatenate([arm.frame[coarse], arm.fine_frame]),
    )


def _placed(
    arm: Arm, Q: Array, centers: Array, radii: Array, frame: NDArray[np.int32]
) -> tuple[Array, Array, NDArray[np.int32]]:
    T = frames(arm, Q)
    frame = np.concatenate([frame, np.full(len(arm.held_radii), arm.n_frames, np.int32)])
    T_sphere = T[:, np.minimum(frame, arm.n_frames - 1)]
    centers = np.concatenate([centers, arm.held_centers])
    world = np.einsum("nsij,sj->nsi", T_sphere[..., :3, :3], centers) + T_sphere[..., :3, 3]
    return world, np.concatenate([radii, arm.held_radii]), frame


def pair_clearances(arm: Arm, world: World, Q: Array) -> dict[tuple[int, int, int], Array]:
    """Clearance (N,) by (frame, kind, index) of everything that is tested, kinds as in the kernel."""
    centers, radii, frame = spheres(arm, Q)
    out: dict[tuple[int, int, int], Array] = {}
    for f in sorted(set(frame.tolist())):
        mine = frame == f
        for b, solid in enumerate(world.solids()):
            if not (int(world.ignored_frames[b]) >> f) & 1:
                out[f, 0, b] = (solid.distances(centers[:, mine]) - radii[mine]).min(axis=1)
    fine = self_spheres(arm, Q)
    pairs = [(max(a, b), min(a, b)) for a, b in arm.self_pairs.tolist()]
    pairs += [(arm.n_frames, int(f)) for f in arm.held_tested]
    for f, g in pairs:
        if (frame == f).any() and (frame == g).any():
            out[f, 1, g] = _gap(*fine, f, g)
            if f < arm.n_frames:  # clear where either of the two kinds of spheres is
                out[f, 1, g] = np.maximum(out[f, 1, g], _gap(centers, radii, frame, f, g))
    return out


def _gap(centers: Array, radii: Array, frame: NDArray[np.int32], f: int, g: int) -> Array:
    """m (N,) between the spheres of two frames."""
    gap = np.linalg.norm(centers[:, frame == f, None] - centers[:, None, frame == g], axis=-1)
    return np.asarray((gap - (radii[frame == f][:, None] + radii[frame == g])).min(axis=(1, 2)))


def clearances(arm: Arm, world: World, Q: Array) -> Array:
    """Clearance (N,) at Q (N, n), infinite where nothing is tested."""
    pairs = pair_clearances(arm, world, Q)
    return np.min(list(pairs.values()), axis=0) if pairs else np.full(len(Q), np.inf)


def along(q0: Array, q1: Array, n_samples: int) -> Array:
    """Configurations (n_samples, n) on the segment, both ends included."""
    return np.asarray(q0 + np.linspace(0.0, 1.0, n_samples)[:, None] * (q1 - q0))
