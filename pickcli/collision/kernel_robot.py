"""The robot in one tool state as arrays of the kernel: its chain, spheres and self-collision pairs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pickcli.collision.sphere_cover import Cover
from pickcli.geometry import Array
from pickcli.kernel import Chain, Checker


@dataclass(frozen=True, eq=False)
class FrameSpheres:
    """Spheres, each in its moving frame.

    Attributes:
        centers: (S, 3) m.
        radii: (S,) m.
        frames: (S,) index of each sphere's frame.
    """

    centers: Array
    radii: Array
    frames: NDArray[np.int32]

    @classmethod
    def of_covers(cls, covers: Sequence[Cover]) -> FrameSpheres:
        """Join the covers of all frames.

        Args:
            covers: Cover of each frame, in their order.

        Returns:
            The spheres, frame by frame.
        """
        counts = [len(cover.radii) for cover in covers]
        return cls(
            np.concatenate([cover.centers for cover in covers]),
            np.concatenate([cover.radii for cover in covers]),
            np.repeat(np.arange(len(covers), dtype=np.int32), counts),
        )

    def of(self, frames: Sequence[int]) -> FrameSpheres:
        """Select the spheres of some frames.

        Args:
            frames: Indices of frames.

        Returns:
            Their spheres.
        """
        mine = np.isin(self.frames, frames)
        return FrameSpheres(self.centers[mine], self.radii[mine], self.frames[mine])


@dataclass(frozen=True, eq=False)
class KernelRobot:
    """The robot in one tool state, as arrays of the kernel.

    Attributes:
        chain: Kinematics.
        spheres: Spheres that are tested against the world.
        fine: Tighter spheres of some frames, for self-collision if the others do not prove clearance.
        self_pairs: (P, 2) frames that are tested against each other.
    """

    chain: Chain
    spheres: FrameSpheres
    fine: FrameSpheres
    self_pairs: NDArray[np.int32]

    def of_frames(self, frames: Sequence[int]) -> Checker:
        """Return a checker of a part of the robot, without a world.

        Args:
            frames: Indices of two frames that are tested against each other, or of one.

        Returns:
            The checker.
        """
        pairs = np.array([frames] if len(frames) > 1 else [], dtype=np.int32).reshape(-1, 2)
        return KernelRobot(self.chain, self.spheres.of(frames), self.fine.of(frames), pairs)._bare

    def checker(self) -> Checker:
        """Return a new checker of the robot, without a world and without a held item.

        Returns:
            The checker.
        """
        return self._bare.bare()

    @cached_property
    def cup(self) -> KernelRobot:
        """Only the last frame, the cup: the other frames move it, and have no spheres."""
        last, none = [self.chain.n_frames - 1], np.zeros((0, 2), np.int32)
        return KernelRobot(self.chain, self.spheres.of(last), self.fine.of(last), none)

    @cached_property
    def _bare(self) -> Checker:
        """Template of all checkers: building the trees of spheres takes longer than copying them."""
        coarse, fine = self.spheres, self.fine
        return Checker(
            self.chain, coarse.centers, coarse.radii, coarse.frames, self.self_pairs,
            fine.centers, fine.radii, fine.frames,
        )  # fmt: skip
