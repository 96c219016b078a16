"""Statistics over many trials: scores, success rates by item and place, and causes of failures."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pickcli.monte_carlo.sign_flips import FEWEST, SignFlipTest
from pickcli.monte_carlo.success_rate import SuccessRate
from pickcli.trial.trial_result import Outcome, Stage

_FIGURE = re.compile(r"[-+]?\d+(?:\.\d+)?")
_TOTALS = ("collisions", "limit_violations", "drops", "disturbed", "misjudged")

Record = Mapping[str, Any]  # content of a trial.json


@dataclass(frozen=True, eq=False)
class TrialStatistics:
    """Statistics of several trials; only ``computing`` depends on wall time.

    Attributes:
        records: Contents of their ``trial.json`` files, by name.
    """

    records: Mapping[str, Record]

    @property
    def targets(self) -> list[Mapping[str, Any]]:
        """Entries of ``items`` of all trials."""
        return [target for record in self.records.values() for target in record["items"]]

    @property
    def shares(self) -> list[float]:
        """Score of each trial as a share of the largest possible score of its order."""
        return [score_share(record) for record in self.records.values()]

    @property
    def mean_share(self) -> SignFlipTest:
        """Mean score share with its confidence interval."""
        return SignFlipTest.of(np.array(self.shares))

    @property
    def delivered(self) -> SuccessRate:
        """Success rate over all targets."""
        return _rate(self.targets)

    def by(self, key: str) -> dict[str, SuccessRate]:
        """Compute success rates by item or by bin.

        Args:
            key: "item" or "bin".

        Returns:
            Rates by name.
        """
        groups: dict[str, list[Mapping[str, Any]]] = {}
        for target in sorted(self.targets, key=lambda target: str(target[key])):
            groups.setdefault(target[key], []).append(target)
        return {name: _rate(group) for name, group in groups.items()}

    @property
    def causes(self) -> list[tuple[int, str]]:
        """Number of missed targets by cause without figures; the most frequent first."""
        return counted_causes(
            f"{t['outcome']}: {t['reason'] or 'no reason given'}" for t in self.targets if t["points"] <= 0
        )

    @property
    def failed_in(self) -> dict[str, int]:
        """Number of missed targets by what failed last: seeing, planning, moving, or the time was over."""
        counts = Counter(_stage(target["outcome"]) for target in self.targets if target["points"] <= 0)
        return {str(stage): counts[stage] for stage in Stage}

    @property
    def motion_times(self) -> list[float]:
        """Simulated time in s of all motion for each delivered target, including retries and recoveries."""
        return [target["motion_s"] for target in self.targets if target["points"] > 0]

    def total(self, key: str) -> int:
        """Sum a figure over all trials.

        Args:
            key: Its name in ``trial.json``, or "aborted" for the number of aborted trials.

        Returns:
            The sum.
        """
        return sum(bool(r[key]) if key == "aborted" else r[key] for r in self.records.values())

    def values(self) -> dict[str, Any]:
        """Return all figures that do not depend on wall time.

        Returns:
            JSON values by name.
        """
        shares, test = np.array(self.shares), self.mean_share
        has_interval = test.n >= FEWEST
        return {
            "score_share": {
                **spread(shares),
                "mean_interval": [_rounded(test.low), _rounded(test.high)] if has_interval else None,
            },
            "delivered": rate_values(self.delivered),
            "by_item": {name: rate_values(rate) for name, rate in self.by("item").items()},
            "by_place": {name: rate_values(rate) for name, rate in self.by("bin").items()},
            "failed_in": self.failed_in,
            "causes": [{"targets": n, "cause": cause} for n, cause in self.causes],
            "motion_s": spread(self.motion_times),
            "clock_s": spread([record["clock_s"] for record in self.records.values()]),
            "totals": {key: self.total(key) for key in (*_TOTALS, "aborted")},
        }

    def computing(self) -> dict[str, Any]:
        """Return the figures that depend on wall time.

        Returns:
            ``planning_ms`` per successful call, ``planning_failed_ms`` per failed call,
            ``planning_per_item_ms``: the time of all calls of a trial over its delivered targets,
            ``verification_ms``, and ``wall_s`` per trial, each as in ``spread``.
        """
        planned: list[float] = []
        failed: list[float] = []
        verified: list[float] = []
        per_item: list[float] = []
        for record in self.records.values():
            spent = 0.0
            for attempt, figures in _attempts(record):
                spent += figures.get("planning_ms", 0.0)
                if "planning_ms" in figures:
                    (failed if attempt["plan"] is None else planned).append(figures["planning_ms"])
                if "verification_ms" in figures:
                    verified.append(figures["verification_ms"])
            if record["items_in_tote"]:
                per_item.append(spent / record["items_in_tote"])
        return {
            "planning_ms": spread(planned),
            "planning_failed_ms": spread(failed),
            "planning_per_item_ms": spread(per_item),
            "verification_ms": spread(verified),
            "wall_s": spread([record["statistics"]["wall_s"] for record in self.records.values()]),
        }


def score_share(record: Record) -> float:
    """Compute the score of a trial as a share of the largest possible score of its order.

    Args:
        record: Content of its ``trial.json``.

    Returns:
        The share; below 0 if penalties outweigh the points.
    """
    return float(record["score"]) / max(1.0, float(record["max_score"]))


def counted_causes(told: Iterable[str]) -> list[tuple[int, str]]:
    """Count causes of failure, without the figures in them.

    Args:
        told: Causes, as often as they came.

    Returns:
        Number and cause; the most frequent first.
    """
    counts = Counter(" ".join(_FIGURE.sub("…", each).split()) for each in told)
    return [(n, cause) for cause, n in counts.most_common()]


def spread(values: Iterable[float]) -> dict[str, Any]:
    """Describe the distribution of values.

    Args:
        values: Any number of values.

    Returns:
        ``n``, and if there are values ``mean``, ``min``, ``p10``, ``median``, ``p90``, ``p99``, ``max``.
    """
    found = np.array(list(values), float)
    if len(found) == 0:
        return {"n": 0}
    names = ("min", "p10", "median", "p90", "p99", "max")
    percentiles = np.percentile(found, [0, 10, 50, 90, 99, 100])
    quantiles = {name: _rounded(percentile) for name, percentile in zip(names, percentiles, strict=True)}
    return {"n": len(found), "mean": _rounded(float(found.mean())), **quantiles}


def rate_values(rate: SuccessRate) -> dict[str, Any]:
    """Convert a success rate to JSON values.

    Args:
        rate: The rate.

    Returns:
        ``successes``, ``tries``, ``share`` and its ``interval``, which are None without tries.
    """
    low, high = rate.interval
    return {
        "successes": rate.successes,
        "tries": rate.tries,
        "share": _rounded(rate.share) if rate.tries else None,
        "interval": [_rounded(low), _rounded(high)] if rate.tries else None,
    }


def _stage(outcome: str) -> Stage:
    """What failed by an outcome of a record; records of later versions may have others."""
    return Outcome(outcome).stage if outcome in set(Outcome) else Stage.MOVING


def _rate(targets: Sequence[Mapping[str, Any]]) -> SuccessRate:
    return SuccessRate(sum(target["points"] > 0 for target in targets), len(targets))


def _attempts(record: Record) -> Iterable[tuple[Mapping[str, Any], Mapping[str, float]]]:
    return zip(record["attempts"], record["statistics"]["attempts"], strict=True)


def _rounded(value: float) -> float:
    return round(float(value), 6)
