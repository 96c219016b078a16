"""Sign-flip (Fisher-Pitman) test of a mean against 0, with its confidence interval.

Under the null hypothesis each value is equally likely with either sign. The p-value is the share of all sign
assignments whose mean is at least as far from 0 as the observed one; no normal distribution is assumed. The
interval consists of all shifts that the test does not reject, so test and interval always agree.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array
from pickcli.monte_carlo.success_rate import CONFIDENCE
from pickcli.seeds import derived_rng

EXACT = 14  # largest number of values for which all 2^n sign assignments are enumerated
N_FLIPS = 9999  # random assignments for more values
FEWEST = 6  # least number of values for a significant result: 2 / 2^5 is over 5 %
_ROUNDING = 1e-9


@dataclass(frozen=True)
class SignFlipTest:
    """A mean with its confidence interval and p-value.

    Attributes:
        n: Number of values.
        mean: Their mean.
        low: Lower end of the 95 % interval; -infinity for fewer than 6 values.
        high: Upper end of the interval, or infinity.
        p_value: Share of the sign assignments whose mean is at least as far from 0.
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
            The mean, its interval and its p-value; deterministic.
        """
        d = np.asarray(values, float)
        mean, signs = float(d.mean()), _signs(len(d))
        means, balance = signs @ d / len(d), signs.mean(axis=1)
        slack = _ROUNDING * float(np.abs(d).max())
        p_value = float(np.mean(np.abs(means) >= abs(mean) - slack))
        beside = means - mean * balance  # flipped means of the values without their mean
        low, high = mean - _reach(beside, -balance), mean + _reach(beside, balance)
        return cls(len(d), mean, low - slack, high + slack, p_value)

    @property
    def is_significant(self) -> bool:
        """Whether the mean differs from 0 at the 5 % level."""
        return self.p_value <= 1.0 - CONFIDENCE


def _signs(n: int) -> Array:
    """Sign assignments (m, n), the unchanged one first: all, or random ones."""
    if n <= EXACT:
        return np.where((np.arange(2**n)[:, None] >> np.arange(n)) & 1, -1.0, 1.0)
    signs = np.ones((N_FLIPS + 1, n))
    signs[1:] -= 2.0 * derived_rng("sign flips", n).integers(0, 2, (N_FLIPS, n), dtype=np.int8)
    return signs


def _reach(beside: Array, balance: Array) -> float:
    """Largest shift of the mean that the test does not reject.

    Shifted by x, the flipped mean is ``beside - x balance`` and the mean itself ``-x``; each sign assignment
    is at least as far from 0 up to its own limit of x.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.fmax(beside / (1.0 + balance), -beside / (1.0 - balance))
    ends[np.abs(balance) == 1.0] = np.inf  # all signs equal: as far from 0 as the mean itself, for any x
    at_most = int((1.0 - CONFIDENCE) * len(ends) + _ROUNDING)
    return float(np.sort(ends)[::-1][at_most])
