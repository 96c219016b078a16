"""Queries of two arms among shelves, boxes and tables: made from a seed, for benchmarks of the kernel.

The arms are written down in `bench/arms`: one with the lengths of a Panda, one with those of a UR5, each with
capsules of our own and a gripper. Goals and starts are poses of the gripper above a table, in an open box or
in the compartment of a shelf; a query goes from one to another.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, cycle
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.robots.urdf import read_urdf
from pickcli.cell.shapes import Body
from pickcli.collision.sphere_cover import cover_bodies
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.kernel import Chain, Checker

ARMS = ("seven_joints", "six_joints")
_FOLDER = Path(__file__).parent / "arms"
_MOST_EXCESS = 0.006  # m that spheres stick out of a link
_T_LAST_TIP = pose([0, 0, 0.2])
MARGIN = 0.005  # m, kept by paths

# m beyond the margin that starts and goals keep: the proof of an edge is no finer, so that from some
# configurations that are nearer to it than this not one edge can be proven.
_ROOM = 2e-4

Wall = tuple[tuple[float, float, float], tuple[float, float, float]]  # centre and half extents, m


@dataclass(frozen=True, eq=False)
class QueryArm:
    """An arm as the kernel takes it.

    Attributes:
        chain: Kinematics.
        centers: (S, 3) m, of the spheres, each in its frame.
        radii: (S,) m.
        frames: (S,) frame of each sphere.
        self_pairs: (P, 2) frames that must stay clear of each other.
        lower: (n,) rad.
        upper: (n,) rad.
    """

    chain: Chain
    centers: Array
    radii: Array
    frames: NDArray[np.int32]
    self_pairs: NDArray[np.int32]
    lower: Array
    upper: Array

    def checker(self) -> Checker:
        """A checker of the arm in an empty world."""
        return Checker(self.chain, self.centers, self.radii, self.frames, self.self_pairs)


@dataclass(frozen=True, eq=False)
class Query:
    """From one configuration to any of several, among boxes.

    Attributes:
        arm: Name of the arm.
        setting: "table", "box" or "shelf".
        T_world_box: (B, 4, 4) m, poses of the boxes.
        half_extents: (B, 3) m.
        start: (n,) rad.
        goals: (G, n) rad.
    """

    arm: str
    setting: str
    T_world_box: Array
    half_extents: Array
    start: Array
    goals: Array


def read_arm(name: str) -> QueryArm:
    """Read one of the arms and cover it by spheres.

    Args:
        name: One of ARMS.

    Returns:
        The arm. Frames joined by one joint are no self pair.
    """
    urdf = read_urdf(_FOLDER / f"{name}.urdf")
    joints = urdf.way(list(urdf.links)[-1])
    frames = np.arange(len(joints), dtype=np.int32)
    chain = Chain(
        np.zeros(len(joints), np.int32),
        np.array([joint.T_parent_joint for joint in joints]),
        np.array([joint.axis for joint in joints]),
        frames,
    )
    covers = [cover_bodies(urdf.links[joint.child].bodies, _excess) for joint in joints]
    return QueryArm(
        chain,
        np.concatenate([cover.centers for cover in covers]),
        np.concatenate([cover.radii for cover in covers]),
        np.repeat(frames, [len(cover.radii) for cover in covers]),
        np.array([(a, b) for a, b in combinations(frames, 2) if b - a >= 2], dtype=np.int32),
        np.array([joint.lower for joint in joints]),
        np.array([joint.upper for joint in joints]),
    )


def make_queries(name: str, arm: QueryArm, n: int, seed: int) -> list[Query]:
    """Draw queries whose start and goals keep the margin and whose straight edges are not free.

    Args:
        name: Of the arm.
        arm: The arm.
        n: Number of queries.
        seed: Of all draws.

    Returns:
        The queries. Whether they can be solved is not known, but all ends can be left.
    """
    rng = np.random.default_rng(seed)
    settings = cycle(_queries(name, arm, rng, setting) for setting in _SETTINGS)
    return [next(queries) for queries, _ in zip(settings, range(n), strict=False)]


def enter(checker: Checker, T_world_box: Array, half_extents: Array) -> None:
    """Give a checker boxes as its world.

    Args:
        checker: The checker.
        T_world_box: (B, 4, 4) m.
        half_extents: (B, 3) m.
    """
    checker.set_world(T_world_box, half_extents, np.zeros(len(half_extents), np.uint64))


def _excess(body: Body) -> float:
    return float(min(_MOST_EXCESS, 0.2 * body.shape.extents.min()))


def _queries(name: str, arm: QueryArm, rng: np.random.Generator, setting: str) -> Iterator[Query]:
    checker = arm.checker()
    while True:
        walls, tips = _SETTINGS[setting](rng)
        T, half = np.array([pose(center) for center, _ in walls]), np.array([half for _, half in walls])
        enter(checker, T, half)
        begins, ends = (_configurations(arm, checker, T_tip, rng) for T_tip in tips)
        if len(begins) and len(ends) and not any(checker.edge_is_free(begins[0], q, MARGIN) for q in ends):
            yield Query(name, setting, T, half, begins[0], ends)


def _configurations(arm: QueryArm, checker: Checker, T_world_tip: Array, rng: np.random.Generator) -> Array:
    """(K, n) that reach a pose and keep the margin with room to leave, at most four."""
    seeds = rng.uniform(arm.lower, arm.upper, (24, arm.chain.n))
    found = arm.chain.ik(T_world_tip, _T_LAST_TIP, seeds, arm.lower, arm.upper, np.ones(arm.chain.n))
    return np.asarray(found[np.asarray(checker.are_free(found, MARGIN + _ROOM), dtype=bool)][:4])


def _table(rng: np.random.Generator) -> tuple[list[Wall], list[Array]]:
    """Boxes that stand on a table; from beside one down to beside another."""
    height = float(rng.uniform(-0.1, 0.2))
    walls: list[Wall] = [((0.75, 0, height - 0.02), (0.4, 0.8, 0.02)), _floor()]
    for _ in range(int(rng.integers(10, 24))):
        x, y = rng.uniform(0.4, 0.95), rng.uniform(-0.7, 0.7)
        sides = rng.uniform([0.02, 0.02, 0.05], [0.08, 0.08, 0.3])
        walls.append(((float(x), float(y), height + float(sides[2])), _triple(sides)))
    down = np.diag([1.0, -1.0, -1.0])
    tips = [
        pose([rng.uniform(0.4, 0.75), side * rng.uniform(0.2, 0.5), height + rng.uniform(0.06, 0.15)],
             R=down @ _turn(rng))
        for side in (1, -1)
    ]  # fmt: skip
    return walls, tips


def _box(rng: np.random.Generator) -> tuple[list[Wall], list[Array]]:
    """Two open boxes with high walls beside each other; from the bottom of one to that of the other."""
    base = float(rng.uniform(-0.15, 0.15))
    walls, tips = [_floor()], []
    for side in (1, -1):
        half = rng.uniform([0.11, 0.11, 0.12], [0.17, 0.18, 0.22])
        x, y = rng.uniform(0.45, 0.6), side * rng.uniform(0.3, 0.45)
        walls += _open_box((float(x), float(y), base + float(half[2])), half)
        down = np.diag([1.0, -1.0, -1.0]) @ _turn(rng)
        tips.append(pose([x + rng.uniform(-0.04, 0.04), y, base + rng.uniform(0.06, 0.12)], R=down))
    return walls, tips


def _shelf(rng: np.random.Generator) -> tuple[list[Wall], list[Array]]:
    """A shelf with compartments in three rows and three columns; from one into another."""
    width, height, front = rng.uniform(0.22, 0.32), rng.uniform(0.22, 0.32), rng.uniform(0.4, 0.55)
    depth, middle = 0.16, float(rng.uniform(0.3, 0.5))
    x = float(front + depth)
    walls = [_floor(), ((x + depth, 0.0, middle), (0.01, 1.5 * float(width), 1.5 * float(height)))]
    for k in range(4):
        at = (k - 1.5) * width
        walls.append(((x, float(at), middle), (depth, 0.01, 1.5 * float(height))))
        up = middle + (k - 1.5) * height
        walls.append(((x, 0.0, float(up)), (depth, 1.5 * float(width), 0.01)))
    first, second = rng.choice(9, 2, replace=False)
    forwards = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    tips = [
        pose([front + rng.uniform(0.06, 0.2), (cell % 3 - 1) * width, middle + (cell // 3 - 1) * height],
             R=forwards @ _turn(rng))
        for cell in (int(first), int(second))
    ]  # fmt: skip
    return walls, tips


def _open_box(center: tuple[float, float, float], half: Array) -> list[Wall]:
    (x, y, z), (a, b, c), t = center, _triple(half), 0.008
    return [
        ((x, y, z - c), (a, b, t)),
        ((x - a, y, z), (t, b, c)),
        ((x + a, y, z), (t, b, c)),
        ((x, y - b, z), (a, t, c)),
        ((x, y + b, z), (a, t, c)),
    ]


def _floor() -> Wall:
    return (0.0, 0.0, -0.5), (1.5, 1.5, 0.05)


def _turn(rng: np.random.Generator) -> Array:
    """About the gripper's own axis."""
    return rotation_axis_angle(np.array([0.0, 0, 1]), float(rng.uniform(-np.pi, np.pi)))


def _triple(values: Array) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z


_SETTINGS = {"table": _table, "box": _box, "shelf": _shelf}
