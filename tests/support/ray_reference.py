"""Rays against solids in double precision by numpy, each against each: what the kernel must see."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pickcli.geometry import Array, inverse, rotation_axis_angle
from pickcli.kernel import RaycastingScene

BOX, CYLINDER, SPHERE = 0, 1, 2


@dataclass
class Solids:
    """Solids as the kernel takes them, one list of planes to each."""

    T: list[Array] = field(default_factory=list)
    half: list[Array] = field(default_factory=list)
    kind: list[int] = field(default_factory=list)
    planes: list[Array] = field(default_factory=list)

    def add(self, T: Array, half: Array, kind: int = BOX, planes: Array | None = None) -> None:
        self.T.append(np.asarray(T, float))
        self.half.append(np.asarray(half, float))
        self.kind.append(kind)
        self.planes.append(np.zeros((0, 4)) if planes is None else np.asarray(planes, float))

    @property
    def scene(self) -> RaycastingScene:
        return RaycastingScene(
            np.array(self.T).reshape(-1, 4, 4),
            np.array(self.half).reshape(-1, 3),
            np.array(self.kind, np.int32),
            np.concatenate([np.zeros((0, 4)), *self.planes]),
            np.array([len(p) for p in self.planes], np.int32),
        )


def rays(intrinsics: Array, size: tuple[int, int], shift: tuple[float, float] = (0.0, 0.0)) -> Array:
    """(H, W, 3) of the camera's rays at depth 1, through places shifted from the middles of pixels."""
    fx, fy, cx, cy = intrinsics
    u, v = np.meshgrid(np.arange(size[0]) + shift[0], np.arange(size[1]) + shift[1])
    return np.stack([(u - cx) / fx, (v - cy) / fy, np.ones_like(u)], axis=-1)


def entry(T: Array, half: Array, kind: int, planes: Array, T_world_camera: Array, d: Array) -> Array:
    """Depths at which rays enter one solid before the camera; infinite where they do not."""
    T_solid_camera = inverse(T) @ T_world_camera
    o, d = T_solid_camera[:3, 3], d @ T_solid_camera[:3, :3].T
    near, far = np.full(d.shape[:2], -np.inf), np.full(d.shape[:2], np.inf)
    flat = {BOX: range(3), CYLINDER: [2], SPHERE: []}[kind]
    cuts = [(sign * np.eye(3)[k], half[k]) for k in flat for sign in (1.0, -1.0)]
    with np.errstate(divide="ignore", invalid="ignore"):
        for normal, offset in [*cuts, *((p[:3], p[3]) for p in planes)]:
            rate, room = d @ normal, offset - normal @ o
            depth = room / rate
            near = np.where(rate < 0, np.maximum(near, depth), near)
            far = np.where(rate > 0, np.minimum(far, depth), far)
            far = np.where((rate == 0) & (room < 0), -np.inf, far)
        if kind != BOX:
            axes = 2 if kind == CYLINDER else 3
            a, b = (d[..., :axes] ** 2).sum(-1), d[..., :axes] @ o[:axes]
            c = o[:axes] @ o[:axes] - half[0] ** 2
            root = np.sqrt(b * b - a * c)  # NaN where it misses
            low, high = (-b - root) / a, (-b + root) / a
            along = a < 1e-24
            near = np.maximum(near, np.where(along, -np.inf, low))
            far = np.minimum(far, np.where(along, np.inf if c <= 0 else -np.inf, high))
        return np.where((near <= far) & (near > 1e-6), near, np.inf)


def seen(
    solids: Solids, intrinsics: Array, size: tuple[int, int], T_world_camera: Array,
    shift: tuple[float, float] = (0.0, 0.0),
) -> tuple[Array, Array]:  # fmt: skip
    """Depth (H, W), infinite where nothing is, and the index of the solid, -1 there."""
    d = rays(intrinsics, size, shift)
    depths = [
        entry(T, half, kind, planes, T_world_camera, d)
        for T, half, kind, planes in zip(solids.T, solids.half, solids.kind, solids.planes, strict=True)
    ]
    all_depths = np.array([np.full(d.shape[:2], np.inf), *depths])
    return all_depths.min(axis=0), all_depths.argmin(axis=0) - 1


def random_pose(rng: np.random.Generator, reach: float) -> Array:
    T = np.eye(4)
    axis = rng.normal(size=3)
    T[:3, :3] = rotation_axis_angle(axis / np.linalg.norm(axis), rng.uniform(-np.pi, np.pi))
    T[:3, 3] = rng.uniform(-reach, reach, 3)
    return T


def random_solids(rng: np.random.Generator, n: int) -> Solids:
    """Boxes, cylinders, balls and convex pieces from 5 mm to 0.8 m around the origin, some upright."""
    solids = Solids()
    for _ in range(n):
        T = random_pose(rng, 1.0)
        if rng.random() < 0.3:
            T[:3, :3] = np.eye(3)
        half, kind = np.exp(rng.uniform(np.log(0.005), np.log(0.4), 3)), int(rng.integers(4))
        planes = None
        if kind == 3:
            normals = rng.normal(size=(5, 3))
            normals /= np.linalg.norm(normals, axis=1)[:, None]
            planes = np.column_stack([normals, 0.7 * np.abs(normals) @ half])
        if kind in (CYLINDER, SPHERE):
            half = half[[0, 0, 2]] if kind == CYLINDER else half[[0, 0, 0]]
        solids.add(T, half, kind % 3, planes)
    return solids
