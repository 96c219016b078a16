"""The robot in one tool state as arrays of the kernel: its chain, its spheres and its self pairs."""

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
    """Spheres, each in the frame that it moves with.

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
        """Join the spheres of all frames.

        Args:
            covers: Of each frame, in their order.

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
        """Pick the spheres of some frames.

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
        spheres: That are tested against what stands around.
        fine: Tighter ones of some frames, by which these are told apart where their others do not do it.
        self_pairs: (P, 2) frames that are tested against each other.
    """

    chain: Chain
    spheres: FrameSpheres
    fine: FrameSpheres
    self_pairs: NDArray[np.int32]

    def of_frames(self, frames: Sequence[int]) -> Checker:
        """A checker of a part of the robot, with nothing around it.

        Args:
            frames: Indices of two frames that are tested against each other, or of one.

        Returns:
            The checker.
        """
        pairs = np.array([frames] if len(frames) > 1 else [], dtype=np.int32).reshape(-1, 2)
        return KernelRobot(self.chain, self.spheres.of(frames), self.fine.of(frames), pairs)._bare

    def checker(self) -> Checker:
        """A new checker of the robot, with nothing around it and nothing held.

        Returns:
            The checker.
        """
        return self._bare.bare()

    @cached_property
    def cup(self) -> KernelRobot:
        """The last frame alone, which is the cup: the others move it, and have no spheres."""
        last, none = [self.chain.n_frames - 1], np.zeros((0, 2), np.int32)
        return KernelRobot(self.chain, self.spheres.of(last), self.fine.of(last), none)

    @cached_property
    def _bare(self) -> Checker:
        """What all checkers are copied from: to cut the spheres into trees takes longer than to copy them."""
        coarse, fine = self.spheres, self.fine
        return Checker(
            self.chain, coarse.centers, coarse.radii, coarse.frames, self.self_pairs,
            fine.centers, fine.radii, fine.frames,
        )  # fmt: skip
