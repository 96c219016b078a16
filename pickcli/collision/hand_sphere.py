"""One sphere of the hand as a body of its own: where it is not free, neither is the robot, however it turns.

Searches take from it where the hand may be, for all postures of the arm at once (Cohen, Chitta and Likhachev
2010 use the sphere inside of the wrist so).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.collision.collision_world import CollisionWorld
from pickcli.collision.kernel_robot import KernelRobot
from pickcli.geometry import Array
from pickcli.kernel import Chain, Checker, JointKind

# m by which the sphere is smaller than that of the robot: what single precision may add to distances, more
# than enough for worlds of several metres.
SMALLER = 5e-4


@dataclass(frozen=True, eq=False)
class HandSphere:
    """A sphere of the collision model.

    Attributes:
        frame: Frame of the robot that carries it.
        center: (3,) m, in that frame.
        radius: m.
    """

    frame: int
    center: Array
    radius: float

    @classmethod
    def of(cls, robot: KernelRobot, bodies: Sequence[int]) -> HandSphere | None:
        """Choose the largest sphere of the frames that are rigid with the flange.

        Args:
            robot: The robot in one tool state.
            bodies: Number of the rigid body of each frame.

        Returns:
            The sphere, None if these frames have none.
        """
        spheres = robot.spheres
        (mine,) = np.nonzero(np.asarray(bodies)[spheres.frames] == bodies[-1])
        if not len(mine):
            return None
        k = int(mine[np.argmax(spheres.radii[mine])])
        return cls(int(spheres.frames[k]), spheres.centers[k], float(spheres.radii[k]))


class HandSphereChecker:
    """Checks where a sphere keeps the margin.

    Args:
        sphere: The sphere.
        world: Solids of the scene.
        kept: Indices of those that it is tested against.
        margin: m, kept from all of them.

    Attributes:
        sphere: The sphere.
    """

    def __init__(
        self, sphere: HandSphere, world: CollisionWorld, kept: NDArray[np.intp], margin: float
    ) -> None:
        self.sphere, self._margin = sphere, margin
        kinds = np.full(3, int(JointKind.PRISMATIC), dtype=np.int32)
        chain = Chain(kinds, np.tile(np.eye(4), (3, 1, 1)), np.eye(3), np.arange(3, dtype=np.int32))
        radius = np.array([max(sphere.radius - SMALLER, 0.0)])
        one = np.array([2], dtype=np.int32)
        self._kernel = Checker(chain, np.zeros((1, 3)), radius, one, np.zeros((0, 2), np.int32))
        world.enter(self._kernel, kept, np.zeros(len(world.names), dtype=np.uint64))

    def are_free(self, centers: Array) -> NDArray[np.bool_]:
        """Whether the sphere keeps the margin at each of many positions.

        Args:
            centers: (N, 3) m, in the world.

        Returns:
            (N,) False only where no configuration with the sphere there is valid.
        """
        free = self._kernel.are_free(np.ascontiguousarray(centers), self._margin)
        return np.asarray(free, dtype=bool)
