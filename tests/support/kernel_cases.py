"""Random chains, spheres, worlds and edges, each a pure function of a generator."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array, pose, rotation_axis_angle
from support.kernel_reference import BOX, CYLINDER, FIXED, PRISMATIC, SPHERE, Arm, Solid, World


def random_pose(rng: np.random.Generator, reach: float) -> Array:
    """A pose with a uniform axis, any angle, and a position within a cube of half-width reach."""
    axis = rng.normal(size=3)
    R = rotation_axis_angle(axis / np.linalg.norm(axis), float(rng.uniform(-np.pi, np.pi)))
    return pose(rng.uniform(-reach, reach, 3), R=R)


def random_arm(rng: np.random.Generator) -> Arm:
    """2 to 9 joints of all types in any order of q, spheres on most frames, sometimes a held item."""
    n_frames = int(rng.integers(2, 10))
    types = rng.choice([0, 0, 0, 1, 2], n_frames).astype(np.int32)
    types[rng.integers(n_frames)] = 0
    q_index = np.full(n_frames, -1, np.int32)
    moving = np.flatnonzero(types != FIXED)
    q_index[moving] = rng.permutation(len(moving))
    axes = rng.normal(size=(n_frames, 3))
    frame = rng.integers(0, n_frames, int(rng.integers(1, 16))).astype(np.int32)
    own = rng.spawn(1)[0]  # which leaves the draws of everything else as they are
    fine_frame = own.choice(frame, int(own.integers(0, 12)))
    pairs = [(a, b) for a in range(n_frames) for b in range(a + 2, n_frames) if rng.random() < 0.5]
    n_held = int(rng.integers(0, 4))
    tested = [f for f in range(n_frames - 1) if n_held and rng.random() < 0.3]
    return Arm(
        joint_types=types,
        T_parent_joint=np.stack([random_pose(rng, 0.3) for _ in range(n_frames)]),
        axes=axes / np.linalg.norm(axes, axis=1, keepdims=True),
        q_index=q_index,
        centers=rng.uniform(-0.15, 0.15, (len(frame), 3)),
        radii=rng.uniform(0.01, 0.08, len(frame)),
        frame=frame,
        self_pairs=np.array([p if rng.random() < 0.5 else p[::-1] for p in pairs], np.int32).reshape(-1, 2),
        fine_centers=own.uniform(-0.2, 0.2, (len(fine_frame), 3)),
        fine_radii=own.uniform(0.005, 0.06, len(fine_frame)),
        fine_frame=fine_frame,
        held_centers=rng.uniform(-0.15, 0.15, (n_held, 3)),
        held_radii=rng.uniform(0.01, 0.06, n_held),
        held_tested=np.array(tested, np.int32),
    )


def random_world(rng: np.random.Generator, arm: Arm) -> World:
    """Up to 15 solids of all kinds, plates and sticks among them; some frames ignored."""
    n = int(rng.integers(0, 16))
    solids = [random_solid(rng, 1.2) for _ in range(n)]
    ignored = [sum(1 << f for f in range(arm.n_frames + 1) if rng.random() < 0.15) for _ in range(n)]
    return World(
        T_world_box=np.array([s.T for s in solids]).reshape(-1, 4, 4),
        half_extents=np.array([s.half for s in solids]).reshape(-1, 3),
        ignored_frames=np.array(ignored, np.uint64),
        kind=np.array([s.kind for s in solids], np.int32),
        rounding=np.array([s.rounding for s in solids]),
    )


def random_solid(rng: np.random.Generator, reach: float, size: float = 0.2) -> Solid:
    """A solid from a plate or stick to a block of some sizes, half of them rounded."""
    kind = int(rng.choice([BOX, CYLINDER, SPHERE], p=[0.5, 0.3, 0.2]))
    half = size * rng.choice([0.015, 0.25, 1.0, 2.5], 3)
    half[1] = half[0] if kind != BOX else half[1]
    half[2] = half[0] if kind == SPHERE else half[2]
    return Solid(random_pose(rng, reach), half, kind, float(rng.choice([0.0, 0.03])))


def random_configuration(rng: np.random.Generator, arm: Arm) -> Array:
    """Angles within +-2.5 rad, shifts within +-0.4 m."""
    q = rng.uniform(-2.5, 2.5, arm.n)
    q[arm.q_index[arm.joint_types == PRISMATIC]] *= 0.16
    return np.asarray(q)


def random_edge(rng: np.random.Generator, arm: Arm) -> tuple[Array, Array]:
    """An edge from a whole tour down to a hair's breadth."""
    q0 = random_configuration(rng, arm)
    return q0, q0 + float(10.0 ** rng.uniform(-4, 0)) * (random_configuration(rng, arm) - q0)
