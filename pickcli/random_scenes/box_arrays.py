"""Arrays of bin-aligned boxes around the items of a bin, in the bin frame: x into the bin, y left, z up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array

Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class BoxArrays:
    """Axis-aligned boxes in arrays of any shape (...).

    Attributes:
        low: (..., 3) m, lower corners.
        high: (..., 3) m, upper corners.
    """

    low: Array
    high: Array

    @property
    def middle(self) -> Array:
        """Centres (..., 3)."""
        return (self.low + self.high) / 2

    @property
    def column(self) -> BoxArrays:
        """The boxes as (..., N, 1, 3), for pairwise operations."""
        return BoxArrays(self.low[..., None, :], self.high[..., None, :])

    @property
    def row(self) -> BoxArrays:
        """The boxes as (..., 1, N, 3), for pairwise operations."""
        return BoxArrays(self.low[..., None, :, :], self.high[..., None, :, :])

    def __getitem__(self, index: Any) -> BoxArrays:
        """Return a subset, by any numpy index."""
        return BoxArrays(self.low[index], self.high[index])

    def replaced(self, k: int, by: BoxArrays) -> BoxArrays:
        """Return the boxes with one box of each row replaced.

        Args:
            k: Index of the box in its row (..., N, 3).
            by: (..., 3) the new boxes.

        Returns:
            The changed boxes.
        """
        low, high = self.low.copy(), self.high.copy()
        low[..., k, :], high[..., k, :] = by.low, by.high
        return BoxArrays(low, high)


def gap(a: BoxArrays, b: BoxArrays) -> Array:
    """Compute the horizontal distance of boxes.

    Args:
        a: Boxes (..., 3).
        b: Boxes (..., 3).

    Returns:
        (...) m, negative if one is above the other.
    """
    return np.asarray(
        np.maximum(
            np.maximum(a.low[..., 0] - b.high[..., 0], b.low[..., 0] - a.high[..., 0]),
            np.maximum(a.low[..., 1] - b.high[..., 1], b.low[..., 1] - a.high[..., 1]),
        )
    )


def lies_on(upper: BoxArrays, lower: BoxArrays) -> Bools:
    """Whether boxes are above others.

    Args:
        upper: Boxes (..., 3).
        lower: Boxes (..., 3).

    Returns:
        (...).
    """
    return np.asarray((gap(upper, lower) < 0.0) & (upper.middle[..., 2] > lower.middle[..., 2]))
