"""How fast is the kernel: a valid edge of 32 configurations from Python, against pybullet and python-fcl.

    python -m bench.kernel [--json FILE]

The robot is 55 spheres for the kernel, capsules for the others; the world is 77 boxes (``kernel_scene``).
All three check the world and the same pairs of links. pybullet and python-fcl test the 32 states one by one
and prove nothing between them. Best of several runs, as other load only ever adds time.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable
from functools import partial
from itertools import combinations, product
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from bench.kernel_scene import BOXES, LINKS, LOWER, SELF_PAIRS, UPPER, Capsule, make_arm, make_kernel, urdf
from pickcli.geometry import Array, pose
from pickcli.kernel import Chain, Checker, set_simd, simd

N_STATES = 32
MARGIN = 0.005  # m


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
