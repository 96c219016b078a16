"""The scene that ``bench.kernel`` measures in: a Motoman SIA20F on a rail as capsules, and 77 boxes.

It has the size of the default cell: a shelf of 12 bins, a tote, the surroundings.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.kernel import Chain, Checker


@dataclass(frozen=True)
class Capsule:
    """The points within radius of the segment start..end, in the link's frame, m."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float

    @property
    def length(self) -> float:
        return float(np.linalg.norm(np.subtract(self.end, self.start)))

    @property
    def T_link_capsule(self) -> Array:
        """Frame with the segment along z, centred."""
        middle, along = np.add(self.start, self.end) / 2, np.subtract(self.end, self.start)
        if self.length < 1e-9:
            return pose(middle)
        turn = np.cross([0, 0, 1], along / self.length)
        sine, cosine = np.linalg.norm(turn), along[2] / self.length
        axis = turn / sine if sine > 1e-9 else np.array([1.0, 0, 0])
        return pose(middle, R=rotation_axis_angle(axis, float(np.arctan2(sine, cosine))))

    def spheres(self) -> tuple[Array, Array]:
        """Centres (k, 3) and radii (k,) of spheres that contain it, spaced by at most 1.2 radii."""
        k = max(2, int(np.ceil(self.length / (1.2 * self.radius))) + 1)
        s = np.linspace(0, 1, k)[:, None]
        half_gap = self.length / (k - 1) / 2
        return (1 - s) * self.start + s * self.end, np.full(k, np.hypot(self.radius, half_gap))


# Joint types, origins in the parent, axes; capsules by link. Motoman SIA20F: motoman_sia20d_support.
TYPES = [1, 0, 0, 0, 0, 0, 0, 0]
ORIGINS = [
    (-1.758, 0, 0.85),
    (0, 0, 0.41),
    (0, 0, 0),
    (0, 0, 0.49),
    (0, 0, 0),
    (0, 0, 0.42),
    (0, 0, 0),
    (0, 0, 0.18),
]
AXES = [(1, 0, 0), (0, 0, 1), (0, 1, 0), (0, 0, 1), (0, -1, 0), (0, 0, -1), (0, -1, 0), (0, 0, -1)]
UPPER = np.array([1.15, 3.1415, 1.9198, 2.967, 2.2689, 3.1415, 1.9198, 3.1415])
LOWER = np.concatenate([[0.05], -UPPER[1:]])
LINKS = [
    [Capsule((0.055, 0, 0.029), (-0.166, -0.001, 0.087), 0.160)],
    [Capsule((0, 0.001, -0.226), (0, 0.017, 0.001), 0.124)],
    [Capsule((0, -0.057, 0), (0, 0, 0.169), 0.126)],
    [Capsule((0, -0.018, 0.003), (0, -0.001, -0.194), 0.105)],
    [Capsule((0, 0, 0.185), (0, 0.037, 0), 0.098)],
    [Capsule((0.002, 0, -0.147), (0.001, 0.019, -0.001), 0.077)],
    [Capsule((0, -0.028, 0.001), (0, -0.002, 0.120), 0.075)],
    [Capsule((0, 0, 0), (0, 0, 0.06), 0.045), Capsule((0, 0, 0.06), (0, 0, 0.53), 0.0135)],
]
SELF_PAIRS = [(a, b) for a, b in combinations(range(8), 2) if b - a >= 2]


@dataclass(frozen=True)
class Box:
    """An axis-aligned box, m."""

    center: tuple[float, float, float]
    half: tuple[float, float, float]


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Box:
    middle, half = np.add(low, high) / 2, np.subtract(high, low) / 2
    return Box(tuple(middle.tolist()), tuple(half.tolist()))


def shelf() -> Iterator[Box]:
    """Twelve bins in four rows: floor, two lips, back, dividers and posts."""
    heights, sides = [0.80, 1.08, 1.31, 1.54, 1.81], [-0.42, -0.14, 0.14, 0.42]
    for low, high in pairwise(heights):
        for right, left in pairwise(sides):
            yield box((0, right, low - 0.01), (0.43, left, low))
            yield box((0, right, low), (0.012, left, low + 0.011))
            yield box((0, right, high - 0.033), (0.012, left, high - 0.01))
            yield box((0.43, right, low), (0.44, left, high))
        for y in sides:
            yield box((0, y - 0.003, low), (0.43, y + 0.003, high))


def surroundings() -> Iterator[Box]:
    """A tote of five walls; table, cabinet, boom, camera, compressor, rail bed and floor."""
    yield box((-1.315, -0.796, 0.577), (-0.776, -0.437, 0.580))
    yield box((-1.318, -0.796, 0.577), (-1.315, -0.437, 0.781))
    yield box((-0.776, -0.796, 0.577), (-0.773, -0.437, 0.781))
    yield box((-1.315, -0.799, 0.577), (-0.776, -0.796, 0.781))
    yield box((-1.315, -0.437, 0.577), (-0.776, -0.434, 0.781))
    yield box((-1.742, -0.934, 0), (-0.712, -0.404, 0.567))
    yield box((-1.800, -0.934, 0), (-1.460, -0.574, 2.193))
    yield box((-1.462, -0.934, 1.682), (-0.981, -0.904, 2.163))
    yield box((-1.239, -0.934, 2.100), (-0.924, -0.574, 2.223))
    yield box((-1.954, 0.440, 0), (-1.395, 1.000, 1.255))
    yield box((-2.218, -0.395, 0), (-0.228, 0.395, 0.264))
    yield box((-2.617, -0.123, 0.036), (-1.105, 0.122, 0.500))
    yield box((-4, -3, -0.1), (3, 3, 0))


BOXES = [*shelf(), *surroundings()]


def make_arm() -> tuple[Chain, Checker]:
    """The robot for the kernel, in an empty world."""
    chain = Chain(
        np.array(TYPES), np.stack([pose(o) for o in ORIGINS]), np.array(AXES), np.arange(8, dtype=np.int32)
    )
    cover = [(*capsule.spheres(), link) for link, capsules in enumerate(LINKS) for capsule in capsules]
    centers, radii = np.concatenate([c for c, _, _ in cover]), np.concatenate([r for _, r, _ in cover])
    frame = np.concatenate([np.full(len(r), link) for _, r, link in cover])
    return chain, Checker(chain, centers, radii, frame, np.array(SELF_PAIRS))


def make_kernel() -> tuple[Chain, Checker]:
    """The scene for the kernel; the robot's base stands on the rail and does not see the surroundings."""
    chain, checker = make_arm()
    T = np.stack([pose(b.center) for b in BOXES])
    checker.set_world(T, np.array([b.half for b in BOXES]), np.zeros(len(BOXES), np.uint64))
    return chain, checker


def urdf() -> str:
    """The robot for pybullet, whose importer knows capsules (length: of the segment)."""
    mass = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    links, joints = [f'<link name="base">{mass}</link>'], []
    for k, capsules in enumerate(LINKS):
        shapes = ""
        for c in capsules:
            T = c.T_link_capsule
            pitch, yaw = np.arctan2(np.hypot(T[0, 2], T[1, 2]), T[2, 2]), np.arctan2(T[1, 2], T[0, 2])
            origin = f'<origin xyz="{T[0, 3]} {T[1, 3]} {T[2, 3]}" rpy="0 {pitch} {yaw}"/>'
            shape = f'<capsule radius="{c.radius}" length="{c.length}"/>'
            shapes += f"<collision>{origin}<geometry>{shape}</geometry></collision>"
        links.append(f'<link name="link{k}">{mass}{shapes}</link>')
        parent = "base" if k == 0 else f"link{k - 1}"
        kind, (x, y, z), (ax, ay, az) = ("prismatic" if TYPES[k] else "revolute"), ORIGINS[k], AXES[k]
        joints.append(
            f'<joint name="j{k}" type="{kind}"><parent link="{parent}"/><child link="link{k}"/>'
            f'<origin xyz="{x} {y} {z}"/><axis xyz="{ax} {ay} {az}"/>'
            f'<limit lower="-4" upper="4" effort="1" velocity="1"/></joint>'
        )
    return f'<robot name="arm">{"".join(links + joints)}</robot>'
