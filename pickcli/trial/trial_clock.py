"""Clock of a trial: simulated motion plus a charge for planning, so that trials can be repeated exactly."""

from __future__ import annotations

from dataclasses import dataclass, replace

PLANNING_CHARGE = 1.5  # s per planning call: at most 0.5 s of planning and 1 s of verification


@dataclass(frozen=True)
class TrialClock:
    """Clock of a trial: simulated time plus a fixed charge per planning call, independent of wall time.

    Attributes:
        limit: s, end of the trial.
        simulated: s of simulated time so far.
        n_plans: Number of planning calls so far.
        charge: s per planning call.
    """

    limit: float
    simulated: float = 0.0
    n_plans: int = 0
    charge: float = PLANNING_CHARGE

    @property
    def now(self) -> float:
        """Time since the start of the trial, s."""
        return self.simulated + self.n_plans * self.charge

    @property
    def left(self) -> float:
        """Time until the limit, s; never negative."""
        return max(0.0, self.limit - self.now)

    def planned(self) -> TrialClock:
        """Count one more planning call.

        Returns:
            The updated clock.
        """
        return replace(self, n_plans=self.n_plans + 1)

    def moved(self, seconds: float) -> TrialClock:
        """Add simulated time.

        Args:
            seconds: Simulated s.

        Returns:
            The updated clock.
        """
        return replace(self, simulated=self.simulated + seconds)

    def has_time_for(self, seconds: float) -> bool:
        """Whether an action would end within the limit.

        Args:
            seconds: Its duration, s.

        Returns:
            True if it would.
        """
        return self.now + seconds <= self.limit
