"""Whether a mean differs from 0 by more than chance: the sign-flip (Fisher-Pitman) test, and its interval.

Without a difference each value would as likely have come with the other sign. The test asks in which share of
all ways to give signs the mean is as far from 0 as it is. It knows nothing of a normal distribution. The
interval holds all shifts of the values that the test does not refuse, so that the two never disagree.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array
from pickcli.seeds import derived_rng
from pickcli.trial.success_rate import CONFIDENCE

EXACT = 14  # values up to which all 2^n ways are gone through
N_FLIPS = 9999  # drawn where there are more
FEWEST = 6  # values from which on a mean can differ from 0 by more than chance: 2 / 2^5 is over 5 %
_ROUNDING = 1e-9


@dataclass(frozen=True)
class SignFlipTest:
    """A mean, its interval, and the chance of one as far from 0.

    Attributes:
        n: Number of values.
        mean: Their mean.
        low: Lower end of the 95 % interval; minus infinity where there are fewer than 6 values.
        high: Its upper end, or infinity.
        p_value: Share of the ways to give signs in which the mean is at least as far from 0.
    """

    n: int
    mean: float
    low: float
    high: float
    p_value: float

    @classmethod
    def of(cls, values: Array) -> SignFlipTest:
        """Test a mean against 0.

        Args:
            values: (n,), n at least 1.

        Returns:
            The mean, its interval and its p-value. The same values give the same figures.
        """
        d = np.asarray(values, float)
        mean, signs = float(d.mean()), _signs(len(d))
        means, balance = signs @ d / len(d), signs.mean(axis=1)
        slack = _ROUNDING * float(np.abs(d).max())
        p_value = float(np.mean(np.abs(means) >= abs(mean) - slack))
        beside = means - mean * balance  # the flipped mean of what is left when the mean is taken off
        low, high = mean - _reach(beside, -balance), mean + _reach(beside, balance)
        return cls(len(d), mean, low - slack, high + slack, p_value)

    @property
    def is_significant(self) -> bool:
        """Whether the mean is farther from 0 than chance would have it, once in 20 times."""
        return self.p_value <= 1.0 - CONFIDENCE


def _signs(n: int) -> Array:
    """Ways (m, n) to give signs, the one as it is first: all, or so many at random."""
    if n <= EXACT:
        return np.where((np.arange(2**n)[:, None] >> np.arange(n)) & 1, -1.0, 1.0)
    signs = np.ones((N_FLIPS + 1, n))
    signs[1:] -= 2.0 * derived_rng("sign flips", n).integers(0, 2, (N_FLIPS, n), dtype=np.int8)
    return signs


def _reach(beside: Array, balance: Array) -> float:
    """How far the mean may be shifted before the test refuses the shift.

    Shifted by x, the flipped mean is ``beside - x balance``, the mean itself ``-x``; each way to give signs
    is as far from 0 up to an x of its own.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.fmax(beside / (1.0 + balance), -beside / (1.0 - balance))
    ends[np.abs(balance) == 1.0] = np.inf  # all signs alike: as far as the mean itself, whatever x is
    at_most = int((1.0 - CONFIDENCE) * len(ends) + _ROUNDING)
    return float(np.sort(ends)[::-1][at_most])
