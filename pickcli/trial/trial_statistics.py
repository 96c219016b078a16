"""What many trials have in common: scores, how often which item came out of which place, and why not."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pickcli.trial.sign_flips import FEWEST, SignFlipTest
from pickcli.trial.success_rate import SuccessRate

MAX_CAUSE = 160  # characters of a cause
_FIGURE = re.compile(r"[-+]?\d+(?:\.\d+)?")
_TOTALS = ("collisions", "limit_violations", "drops", "disturbed", "misjudged")

Record = Mapping[str, Any]  # what a trial.json says


@dataclass(frozen=True, eq=False)
class TrialStatistics:
    """Figures of several trials, all but ``computing`` without a clock on the wall.

    Attributes:
        records: What their ``trial.json`` say, by name.
    """

    records: Mapping[str, Record]

    @property
    def targets(self) -> list[Mapping[str, Any]]:
        """Entries of ``items`` of all trials."""
        return [target for record in self.records.values() for target in record["items"]]

    @property
    def shares(self) -> list[float]:
        """Of each trial its score as a share of the most that its order can give."""
        return [score_share(record) for record in self.records.values()]

    @property
    def mean_share(self) -> SignFlipTest:
        """Mean of these, with its interval."""
        return SignFlipTest.of(np.array(self.shares))

    @property
    def delivered(self) -> SuccessRate:
        """How many of all targets were delivered."""
        return _rate(self.targets)

    def by(self, key: str) -> dict[str, SuccessRate]:
        """How many targets were delivered, apart.

        Args:
            key: "item" or "bin", which tells them apart.

        Returns:
            Rates by name.
        """
        groups: dict[str, list[Mapping[str, Any]]] = {}
        for target in sorted(self.targets, key=lambda target: str(target[key])):
            groups.setdefault(target[key], []).append(target)
        return {name: _rate(group) for name, group in groups.items()}

    @property
    def causes(self) -> list[tuple[int, str]]:
        """Why targets were missed: how many, and the cause without figures; the most frequent first."""
        told = Counter(
            f"{t['outcome']}: {_FIGURE.sub('…', t['reason']) or 'no reason told'}"[:MAX_CAUSE]
            for t in self.targets
            if t["points"] <= 0
        )
        return [(n, cause) for cause, n in told.most_common()]

    @property
    def motion_times(self) -> list[float]:
        """Of each delivered target all motion for it, with retries and recoveries, in simulated s."""
        return [target["motion_s"] for target in self.targets if target["points"] > 0]

    def total(self, key: str) -> int:
        """Sum a figure that trials count.

        Args:
            key: Its name in ``trial.json``, or "aborted" for how many trials were.

        Returns:
            The sum.
        """
        return sum(bool(r[key]) if key == "aborted" else r[key] for r in self.records.values())

    def values(self) -> dict[str, Any]:
        """All figures but those by the clock on the wall.

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
            "causes": [{"targets": n, "cause": cause} for n, cause in self.causes],
            "motion_s": spread(self.motion_times),
            "clock_s": spread([record["clock_s"] for record in self.records.values()]),
            "totals": {key: self.total(key) for key in (*_TOTALS, "aborted")},
        }

    def computing(self) -> dict[str, Any]:
        """Figures by the clock on the wall.

        Returns:
            ``planning_ms`` per call that gave a plan, ``planning_failed_ms`` per call that gave none,
            ``planning_per_item_ms`` of each trial all calls, those in vain too, by delivered targets,
            ``verification_ms`` and ``wall_s`` of a trial, each as in ``spread``.
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
    """The score of a trial as a share of the most that its order can give.

    Args:
        record: What its ``trial.json`` says.

    Returns:
        The share; below 0 where penalties outweigh.
    """
    return float(record["score"]) / max(1.0, float(record["max_score"]))


def spread(values: Iterable[float]) -> dict[str, Any]:
    """How values are distributed.

    Args:
        values: Any number of values.

    Returns:
        ``n``, and where there are any ``mean``, ``min``, ``p10``, ``median``, ``p90``, ``p99``, ``max``.
    """
    found = np.array(list(values), float)
    if len(found) == 0:
        return {"n": 0}
    names = ("min", "p10", "median", "p90", "p99", "max")
    marks = np.percentile(found, [0, 10, 50, 90, 99, 100])
    told = {name: _rounded(mark) for name, mark in zip(names, marks, strict=True)}
    return {"n": len(found), "mean": _rounded(float(found.mean())), **told}


def rate_values(rate: SuccessRate) -> dict[str, Any]:
    """A success rate as JSON values.

    Args:
        rate: The rate.

    Returns:
        ``successes``, ``tries``, ``share`` and its ``interval``.
    """
    low, high = rate.interval
    return {
        "successes": rate.successes,
        "tries": rate.tries,
        "share": _rounded(rate.share),
        "interval": [_rounded(low), _rounded(high)],
    }


def _rate(targets: Sequence[Mapping[str, Any]]) -> SuccessRate:
    return SuccessRate(sum(target["points"] > 0 for target in targets), len(targets))


def _attempts(record: Record) -> Iterable[tuple[Mapping[str, Any], Mapping[str, float]]]:
    return zip(record["attempts"], record["statistics"]["attempts"], strict=True)


def _rounded(value: float) -> float:
    return round(float(value), 6)
