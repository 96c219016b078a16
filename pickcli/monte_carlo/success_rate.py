"""Success rates with confidence intervals."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from statistics import NormalDist

CONFIDENCE = 0.95
_Z = NormalDist().inv_cdf(0.5 + CONFIDENCE / 2)


@dataclass(frozen=True)
class SuccessRate:
    """Number of successes among tries.

    Attributes:
        successes: Number of successes.
        tries: Number of tries.
    """

    successes: int
    tries: int

    @property
    def share(self) -> float:
        """Successes over tries; 0 without tries."""
        return self.successes / self.tries if self.tries else 0.0

    @property
    def text(self) -> str:
        """The numbers, the share and its interval; "none" without tries."""
        if not self.tries:
            return "none"
        low, high = self.interval
        return f"{self.successes} of {self.tries}, {self.share:.0%} (95 %: {low:.0%} to {high:.0%})"

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's score interval (1927) at 95 %.

        Unlike the normal approximation it stays within 0 and 1, and is meaningful for 0 or all successes.
        """
        n, p = self.tries, self.share
        if n == 0:
            return 0.0, 1.0
        middle, spread = p + _Z**2 / (2 * n), _Z * sqrt(p * (1 - p) / n + _Z**2 / (4 * n**2))
        low, high = ((middle + sign * spread) / (1 + _Z**2 / n) for sign in (-1, 1))
        return max(0.0, low) if self.successes else 0.0, min(1.0, high) if p < 1.0 else 1.0
