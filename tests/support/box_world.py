"""A checker for points among axis-aligned boxes in the plane or in space: exact, besides the kernel's own."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pickcli.errors import Reason
from pickcli.geometry import Array, pose
from pickcli.kernel import Chain, Checker
from pickcli.path_planning.state_space import JointSpace


@dataclass
class BoxWorld:
    """Free is what lies in no box (lower, upper); edges are decided exactly by the slab test.

    The kernel, which the planner asks, has the same point on n prismatic joints, n at most 3.
    """

    boxes: list[tuple[Array, Array]] = field(default_factory=list)
    n: int = 2
    n_edges: int = 0
    margin: float = 0.0

    @property
    def kernel(self) -> Checker:
        n = self.n
        joints = np.arange(n, dtype=np.int32)
        chain = Chain(np.ones(n, np.int32), np.tile(np.eye(4), (n, 1, 1)), np.eye(3)[:n], joints)
        point = np.zeros((1, 3)), np.full(1, 1e-9), np.array([n - 1], np.int32)
        checker = Checker(chain, *point, np.zeros((0, 2), np.int32))
        lower, upper = np.full((len(self.boxes), 3), -1.0), np.full((len(self.boxes), 3), 1.0)
        for b, (low, high) in enumerate(self.boxes):
            lower[b, :n], upper[b, :n] = low, high
        poses = np.array([pose(middle) for middle in (lower + upper) / 2]).reshape(-1, 4, 4)
        checker.set_world(poses, (upper - lower) / 2, np.zeros(len(self.boxes), np.uint64))
        return checker

    def is_valid(self, q: Array) -> bool:
        return not any(bool(np.all((q >= lo) & (q <= hi))) for lo, hi in self.boxes)

    def are_valid(self, Q: Array) -> NDArray[np.bool_]:
        return np.array([self.is_valid(q) for q in Q], dtype=bool)

    def is_valid_edge(self, q0: Array, q1: Array) -> bool:
        self.n_edges += 1
        return not any(_hits(q0, q1, lo, hi) for lo, hi in self.boxes)

    def is_valid_path(self, Q: Array, slack: Array | None = None) -> bool:
        return self.first_blocked_edge(Q, slack) < 0

    def first_blocked_edge(self, Q: Array, slack: Array | None = None) -> int:
        for i in range(len(Q) - 1):
            if not self.is_valid_edge(Q[i], Q[i + 1]):
                return i
        return -1

    def explain(self, q: Array) -> Reason:
        return Reason("collision", detail="inside a box")

    def explain_path(self, Q: Array, slack: Array | None = None) -> Reason:
        i = self.first_blocked_edge(Q)
        (k, *_) = (k for k, (lo, hi) in enumerate(self.boxes) if _hits(Q[i], Q[i + 1], lo, hi))
        return Reason("collision", detail=f"through box {k}", in_the_way=f"box {k}")


def _hits(q0: Array, q1: Array, lo: Array, hi: Array) -> bool:
    t0, t1 = 0.0, 1.0
    for a, b, low, high in zip(q0, q1, lo, hi, strict=True):
        d = b - a
        if d == 0.0:
            if a < low or a > high:
                return False
            continue
        enter, leave = sorted(((low - a) / d, (high - a) / d))
        t0, t1 = max(t0, enter), min(t1, leave)
        if t0 > t1:
            return False
    return True


def space(n: int = 2, size: float = 1.0) -> JointSpace:
    """The box [-size, size]^n; every joint does 1 per s and 2 per s^2."""
    return JointSpace(
        tuple(f"j{i}" for i in range(n)),
        np.full(n, -size),
        np.full(n, size),
        np.ones(n),
        np.full(n, 2.0),
    )


def wall(n: int = 2, gap: float = 0.2, half_thickness: float = 0.05) -> BoxWorld:
    """A wall across the first coordinate that leaves a gap below +1 of the second."""
    lo, hi = np.full(n, -1.0), np.full(n, 1.0)
    lo[0], hi[0], hi[1] = -half_thickness, half_thickness, 1.0 - gap
    return BoxWorld([(lo, hi)], n)
