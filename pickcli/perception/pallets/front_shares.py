"""How much of the front of a pallet is seen where it should be: runners, deck and pockets, each by itself.

A box has no pockets, a table no deck at that height, a rack no runner in the middle: each part has to be
seen as it is, by most of the pixels that tell anything of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.sensors.sensor_model import DepthModel
from pickcli.geometry import Array
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.pallets.front_fit import LEAST_HEIGHT, TOP, FrontSight, front_corners
from pickcli.perception.pallets.front_pixels import FrontPixels
from pickcli.perception.pallets.pallet_shape import PalletShape

ON_IT, SIGMAS = 0.01, 3.0  # m, and standard deviations, from the front, within which it is seen
INSIDE = 0.02  # m behind that, from which on something is seen through a pocket
EDGE = 0.01  # m at the edges of parts that do not count
MOST_PIXELS = 12_000
LEAST_PIXELS = 12  # that tell anything of a part, for it to count as seen


@dataclass(frozen=True, eq=False)
class FrontShares:
    """What is seen of each part.

    Attributes:
        runners: (3,) share of the pixels of each runner that shows it, of those that are not hidden; NaN where
            too few tell anything.
        deck: (3,) likewise of the deck's edge: right, middle and left third.
        pockets: (2,) likewise of the pockets, through which something behind the front is seen; of the pixels
            in which something was measured.
        visible: Share of all these pixels that something before the front does not hide.
        residual: m, root of the mean square of distances from the front, of the pixels that show it.
        n_pixels: How many show it.
    """

    runners: Array
    deck: Array
    pockets: Array
    visible: float
    residual: float
    n_pixels: int

    @classmethod
    def of(
        cls, picture: DepthPicture, noise: DepthModel, shape: PalletShape, pose: Array
    ) -> FrontShares | None:
        """Look at the front of a pallet.

        Args:
            picture: The picture; its world is the frame on the floor.
            noise: How its depth is measured.
            shape: The pallet.
            pose: (3,) m, m, rad where it is said to stand.

        Returns:
            The shares; None if it is not in the picture.
        """
        pixels = FrontPixels.of(picture, noise, front_corners(shape, pose, 0.0), MOST_PIXELS)
        if pixels is None:
            return None
        seen = FrontSight.of(pixels, shape, pose)
        near = ON_IT + SIGMAS * seen.spread
        is_hidden = seen.behind < -near
        is_on = (np.abs(seen.behind) <= near) & (seen.depth > 0.0)
        is_measured = np.isfinite(seen.behind)
        is_behind = seen.behind > near + INSIDE
        tells = ~is_hidden & (seen.depth > 0.0)
        low = (seen.z > LEAST_HEIGHT) & (seen.z < shape.opening - EDGE)
        high = (seen.z > shape.opening + EDGE) & (seen.z < shape.height - TOP)

        def share(of: Array, within: Array, y: Array) -> float:
            is_part = within & tells & (seen.y > y[0] + EDGE) & (seen.y < y[1] - EDGE)
            return float(of[is_part].mean()) if is_part.sum() >= LEAST_PIXELS else float("nan")

        thirds = np.linspace(-shape.width / 2, shape.width / 2, 4)
        off = seen.behind[is_on & (low | high)]
        of_front = (low | high) & (np.abs(seen.y) < shape.width / 2)
        return cls(
            np.array([share(is_on, low, each) for each in shape.columns]),
            np.array([share(is_on, high, each) for each in zip(thirds[:-1], thirds[1:], strict=True)]),
            np.array([share(is_behind, low & is_measured, each) for each in shape.pockets]),
            float((of_front & tells).sum() / max(1, of_front.sum())),
            float(np.sqrt((off**2).mean())) if len(off) else 0.0,
            len(off),
        )  # fmt: skip
