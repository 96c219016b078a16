"""How fast is the kernel: a valid edge of 32 configurations from Python, against pybullet and python-fcl.

    python bench/kernel.py [--json FILE]

The scene has the size of the default cell: a Motoman SIA20F on a rail as capsules (55 spheres for the kernel,
capsules for the others), and 77 boxes (a shelf of 12 bins, a tote, the surroundings).
All three check the world and the same pairs of links. pybullet and python-fcl test the 32 states one by one
and prove nothing between them. Best of several runs, as other load only ever adds time.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import combinations, pairwise, product
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.kernel import Chain, Checker, set_simd, simd

N_STATES = 32
MARGIN = 0.005  # m


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


def valid_edges(checker: Checker, n_edges: int) -> list[tuple[Array, Array]]:
    """Random edges that the kernel proves with exactly 32 configurations."""
    rng = np.random.default_rng(0)
    edges: list[tuple[Array, Array]] = []
    while len(edges) < n_edges:
        q0, q1 = rng.uniform(LOWER, UPPER, (2, 8))
        q1 = q0 + rng.uniform(0.05, 1.0) * (q1 - q0)
        report = checker.check_edge(q0, q1, MARGIN)
        if report.free and report.n_configurations == N_STATES:
            edges.append((q0, q1))
    return edges


def states(edges: list[tuple[Array, Array]]) -> list[Array]:
    """The 32 midpoints of each edge (32, 8)."""
    s = (np.arange(N_STATES)[:, None] + 0.5) / N_STATES
    return [q0 + s * (q1 - q0) for q0, q1 in edges]


def around_the_arm(rng: np.random.Generator, n: int) -> Array:
    """Places (n, 3) in a hollow cylinder about the middle of the rail that the arm reaches into, m."""
    angle, radius = rng.uniform(-np.pi, np.pi, n), rng.uniform(0.9, 2.2, n)
    x = -1.1 + radius * np.cos(angle)
    return np.column_stack([x, radius * np.sin(angle), rng.uniform(0.2, 2.2, n)])


def free_edges(checker: Checker, n_edges: int) -> list[tuple[Array, Array]]:
    """Random edges of 0.5 rad or m in all that the kernel proves."""
    rng = np.random.default_rng(1)
    edges: list[tuple[Array, Array]] = []
    while len(edges) < n_edges:
        q0, step = rng.uniform(LOWER, UPPER), rng.normal(size=8)
        q1 = q0 + 0.5 / np.linalg.norm(step) * step
        if checker.edge_is_free(q0, q1, MARGIN):
            edges.append((q0, q1))
    return edges


def measure_worlds() -> dict[str, float]:
    """A free edge of 0.5 rad us, and entering the world, ms: among boxes, and among points of 5 mm."""
    out: dict[str, float] = {}

    def add(name: str, checker: Checker, enter: Callable[[], None]) -> None:
        def once() -> int:
            enter()
            return 1

        out[f"{name}_enter_ms"] = microseconds(once, 1) / 1e3
        edges = free_edges(checker, 100)
        out[f"{name}_free_edge_us"] = microseconds(
            lambda: sum(checker.edge_is_free(q0, q1, MARGIN) for q0, q1 in edges), len(edges), 21
        )

    for n in (10, 1000, 10_000):
        rng, (_, checker) = np.random.default_rng(n), make_arm()
        T = np.tile(np.eye(4), (n, 1, 1))
        T[:, :3, 3], half = around_the_arm(rng, n), rng.uniform(0.005, 0.03, (n, 3))
        add(f"{n}_boxes", checker, partial(checker.set_world, T, half, np.zeros(n, np.uint64)))
    rng, (_, checker) = np.random.default_rng(3), make_arm()
    points = np.repeat(around_the_arm(rng, 60), 2000, axis=0)[:100_000]  # on the faces of boxes
    on_cubes, axis = rng.uniform(-1, 1, points.shape), rng.integers(3, size=len(points))
    on_cubes[np.arange(len(points)), axis] = rng.choice([-1.0, 1.0], len(points))
    add("100000_points", checker, partial(checker.set_cloud, points + 0.12 * on_cubes, 0.005))
    return out


def microseconds(check: Callable[[], int], n_calls: int, n_runs: int = 7) -> float:
    """Best time per call of something that makes n_calls calls and returns how many were free."""
    times = []
    for _ in range(n_runs):
        start = perf_counter()
        check()
        times.append(perf_counter() - start)
    return min(times) / n_calls * 1e6


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


def pybullet_check(paths: list[Array]) -> Callable[[], int]:
    """Sets each state, runs the collision detection and asks whether the robot touches anything."""
    import pybullet as p

    client = p.connect(p.DIRECT)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "arm.urdf"
        file.write_text(urdf())
        flags = p.URDF_USE_SELF_COLLISION
        robot = p.loadURDF(str(file), useFixedBase=True, flags=flags, physicsClientId=client)
    for b in BOXES:
        shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=b.half, physicsClientId=client)
        p.createMultiBody(0, shape, basePosition=b.center, physicsClientId=client)
    wanted = {frozenset(pair) for pair in SELF_PAIRS}
    for i, j in combinations(range(8), 2):
        p.setCollisionFilterPair(robot, robot, i, j, int(frozenset((i, j)) in wanted), physicsClientId=client)
    joints = list(range(8))

    def check() -> int:
        n_free = 0
        for Q in paths:
            for q in Q:
                p.resetJointStatesMultiDof(robot, joints, [[v] for v in q], physicsClientId=client)
                p.performCollisionDetection(physicsClientId=client)
                n_free += not p.getContactPoints(robot, physicsClientId=client)
        return n_free

    return check


def fcl_check(chain: Chain, paths: list[Array]) -> Callable[[], int]:
    """Two dynamic trees against each other, then the pairs of links; the poses by our own kinematics."""
    import fcl

    def moving(capsule: Capsule) -> Any:
        # fcl's capsule has its length along z and is centred, as ours.
        return fcl.CollisionObject(fcl.Capsule(capsule.radius, capsule.length), fcl.Transform())

    world = fcl.DynamicAABBTreeCollisionManager()
    world.registerObjects(
        [
            fcl.CollisionObject(fcl.Box(*np.multiply(2, b.half)), fcl.Transform(np.array(b.center)))
            for b in BOXES
        ]
    )
    world.setup()
    parts = [(link, c.T_link_capsule, moving(c)) for link, capsules in enumerate(LINKS) for c in capsules]
    robot = fcl.DynamicAABBTreeCollisionManager()
    robot.registerObjects([part for _, _, part in parts])
    robot.setup()
    pairs = [(a, b) for (i, _, a), (j, _, b) in product(parts, parts) if (i, j) in SELF_PAIRS]
    request = fcl.CollisionRequest()

    def is_free(frames: Array) -> bool:
        for link, T_link_capsule, part in parts:
            T = frames[link] @ T_link_capsule
            part.setTransform(fcl.Transform(T[:3, :3], T[:3, 3]))
        robot.update()
        data = fcl.CollisionData()
        robot.collide(world, data, fcl.defaultCollisionCallback)
        if data.result.is_collision:
            return False
        return not any(fcl.collide(a, b, request, fcl.CollisionResult()) for a, b in pairs)

    def check() -> int:
        return sum(is_free(frames) for Q in paths for frames in chain.fk_batch(Q))

    return check


def measure_ik(chain: Chain) -> dict[str, float]:
    """Inverse kinematics: per random seed and solution, and a straight line of 60 steps."""
    rng = np.random.default_rng(0)
    T_last_tip, ones = pose([0, 0, 0.54]), np.ones(8)
    targets = [chain.fk(rng.uniform(LOWER, UPPER))[-1] @ T_last_tip for _ in range(200)]
    seeds = rng.uniform(LOWER, UPPER, (200, 20, 8))
    home = np.array([0.158, 0, -0.30, 0, -1.90, 0, 0.03, 0])
    line = np.stack([chain.fk(home)[-1] @ pose([0, 0, 0.54 + 0.005 * i]) for i in range(60)])

    def solve() -> int:
        pairs = zip(targets, seeds, strict=True)
        return sum(len(chain.ik(T, T_last_tip, s, LOWER, UPPER, ones)) for T, s in pairs)

    def follow() -> int:
        return len(chain.follow(line, T_last_tip, home, LOWER, UPPER, ones, np.full(8, 0.05), 1e-3, 1e-2)[0])

    n_solved = solve()
    per_seed = microseconds(solve, seeds.shape[0] * seeds.shape[1], 3)
    return {
        "ik_solved_share": n_solved / (seeds.shape[0] * seeds.shape[1]),
        "ik_us_per_seed": per_seed,
        "follow_60_steps_us": microseconds(follow, 1),
        "follow_done_share": follow() / len(line),
    }


def measure() -> dict[str, Any]:
    """Microseconds per edge of 32 configurations, and how they compare."""
    chain, checker = make_kernel()
    edges = valid_edges(checker, 200)
    edge_is_free = checker.edge_is_free

    def kernel() -> int:
        return sum(edge_is_free(q0, q1, MARGIN) for q0, q1 in edges)

    out: dict[str, Any] = {
        "simd": simd(),
        "spheres": sum(len(c.spheres()[1]) for link in LINKS for c in link),
    }
    out |= {"boxes": len(BOXES), "configurations": N_STATES}
    out["kernel_us"] = microseconds(kernel, len(edges), 51)
    if simd() == "avx2":
        set_simd("baseline")
        out["kernel_baseline_us"] = microseconds(kernel, len(edges), 51)
        set_simd("avx2")
    out |= measure_worlds()
    out |= measure_ik(chain)
    few = states(edges[:20])
    for name, check in (("pybullet", pybullet_check(few)), ("python_fcl", fcl_check(chain, few))):
        out[f"{name}_free_share"] = check() / (len(few) * N_STATES)
        out[f"{name}_us"] = microseconds(check, len(few), 3)
        out[f"{name}_ratio"] = out[f"{name}_us"] / out["kernel_us"]
    return out


def main() -> None:
    """Print the figures and, if asked, write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures to FILE as well")
    arguments = parser.parse_args()
    figures = measure()
    for name, value in figures.items():
        print(f"{name:24} {value:.2f}" if isinstance(value, float) else f"{name:24} {value}")
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
