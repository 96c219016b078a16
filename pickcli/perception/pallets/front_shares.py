"""How much of the front of a pallet is seen where it should be: runners, deck and pockets, each by itself.

A box has no pockets, a table no deck at that height, a rack no runner in the middle: each part has to be
seen as it is, by most of the pixels that tell anything of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.sensors.sensor_model import DepthModel
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.pallets.front_fit import BESIDE, LEAST_HEIGHT, TOP, FrontSight, front_corners
from pickcli.perception.pallets.front_pixels import FrontPixels
from pickcli.perception.pallets.pallet_shape import PalletShape

ON_IT, SIGMAS = 0.01, 3.0  # m, and standard deviations, from the front, within which it is seen
INSIDE = 0.02  # m behind that, from which on something is seen through a pocket
EDGE = 0.01  # m at the edges of parts that do not count
MOST_PIXELS = 12_000
MOST_NOTHING = 0.7  # of the pixels of a part that faces the camera, in which nothing is measured
LEAST_PIXELS = 12  # that tell anything of a part, for it to count as seen


@dataclass(frozen=True, eq=False)
class FrontShares:
    """What is seen of each part.

    Attributes:
        runners: (3,) share of the pixels of each runner that shows it, of those in which something was
            measured that does not hide it; NaN where too little is not hidden. Where nothing is
            measured it is 0: a runner faces the camera, and would be.
        deck: (3,) likewise of the deck's edge: right, middle and left third.
        pockets: (2,) share of the pixels of each pocket in which something behind the front was measured, of
            those in which anything was that does not hide it; NaN where these are too few.
        beside: (2,) likewise of what is right and left of the front, past which something is seen.
        visible: Share of all pixels of runners and deck that show anything but what hides them.
        residual: m, root of the mean square of distances from the front, of the pixels that show it.
        n_pixels: How many show it.
    """

    runners: Array
    deck: Array
    pockets: Array
    beside: Array
    visible: float
    residual: float
    n_pixels: int

    @classmethod
    def of(cls, picture: DepthPicture, noise: DepthModel, shape: PalletShape, pose: Array) -> FrontShares:
        """Look at the front of a pallet.

        Args:
            picture: The picture; its world is the frame on the floor.
            noise: How its depth is measured.
            shape: The pallet.
            pose: (3,) m, m, rad where it is said to stand.

        Returns:
            The shares.

        Raises:
            InputError: It is not in the picture.
        """
        pixels = FrontPixels.of(picture, noise, front_corners(shape, pose), MOST_PIXELS)
        if pixels is None:
            raise InputError("no pallet here: what looks like its front leaves the picture")
        seen = FrontSight.of(pixels, shape, pose)
        near = ON_IT + SIGMAS * seen.spread
        is_there = ~(seen.behind < -near) & (seen.depth > 0.0)
        is_measured = np.isfinite(seen.behind)
        is_on = is_there & is_measured & (seen.behind <= near)
        is_behind = is_there & is_measured & (seen.behind > near + INSIDE)
        low = (seen.z > LEAST_HEIGHT) & (seen.z < shape.opening - EDGE)
        high = (seen.z > shape.opening + EDGE) & (seen.z < shape.height - TOP)

        def share(of: NDArray[np.bool_], within: NDArray[np.bool_], y: Array, is_opaque: bool) -> float:
            is_part = within & (seen.depth > 0.0) & (seen.y > y[0] + EDGE) & (seen.y < y[1] - EDGE)
            n_measured = int((is_part & is_there & is_measured).sum())
            if n_measured >= LEAST_PIXELS:
                return float((of & is_part).sum() / n_measured)
            n, n_nothing = int(is_part.sum()), int((is_part & ~is_measured).sum())
            return 0.0 if is_opaque and n_nothing > max(LEAST_PIXELS, MOST_NOTHING * n) else float("nan")

        half = shape.width / 2
        ends = np.array([[-half - BESIDE, -half], [half, half + BESIDE]])
        thirds = np.linspace(-half, half, 4)
        is_runner = ((seen.y[:, None] > shape.columns[:, 0]) & (seen.y[:, None] < shape.columns[:, 1])).any(
            axis=1
        )
        of_front = (high | low & is_runner) & (np.abs(seen.y) < half)
        off = seen.behind[is_on & of_front]
        return cls(
            np.array([share(is_on, low, each, True) for each in shape.columns]),
            np.array([share(is_on, high, thirds[k : k + 2], True) for k in range(3)]),
            np.array([share(is_behind, low, each, False) for each in shape.pockets]),
            np.array([share(is_behind, low | high, each, False) for each in ends]),
            float((of_front & is_there & is_measured).sum() / max(1, of_front.sum())),
            float(np.sqrt((off**2).mean())) if len(off) else 0.0,
            len(off),
        )  # fmt: skip
