"""Statistics over many trials of streams: what was delivered, how it was met, and why the rest was not."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pickcli.monte_carlo.success_rate import SuccessRate
from pickcli.monte_carlo.trial_statistics import Record, counted_causes, rate_values
from pickcli.stream_trials.stream_result import ItemOutcome, percentiles

_QUERY = re.compile(r"no plan for [^:]*: ")  # names the item again
TOTALS = ("presented", "attempted", "delivered", "collisions", "limit_violations", "stops")
MET = {"offset_m": "offset", "slip_m_s": "slip", "late_s": "late"}  # what is told of meetings


@dataclass(frozen=True, eq=False)
class StreamStatistics:
    """Statistics of several trials; only ``computing`` depends on wall time.

    Attributes:
        records: Contents of their ``trial.json`` files, by name.
    """

    records: Mapping[str, Record]

    @property
    def items(self) -> list[Record]:
        """Entries of ``items`` of all trials."""
        return [item for record in self.records.values() for item in record["items"]]

    @property
    def delivered(self) -> SuccessRate:
        """How many of the items that came were delivered."""
        return _delivered(self.items)

    @property
    def delivered_of_attempted(self) -> SuccessRate:
        """How many of the items for which an arm moved were delivered."""
        return _delivered([item for item in self.items if item["attempts"]])

    @property
    def items_by_name(self) -> dict[str, list[Record]]:
        """Entries of ``items`` by the name of the item."""
        groups: dict[str, list[Record]] = {}
        for item in sorted(self.items, key=lambda item: str(item["item"])):
            groups.setdefault(_kind(item), []).append(item)
        return groups

    @property
    def by_item(self) -> dict[str, SuccessRate]:
        """Rates of delivered items, by the name of the item."""
        return {name: _delivered(group) for name, group in self.items_by_name.items()}

    @property
    def delivered_per_minute(self) -> float:
        """Delivered items per minute of all trials, each until its last motion ended."""
        minutes = sum(record["duration_s"] for record in self.records.values()) / 60.0
        return self.total("delivered") / minutes if minutes > 0.0 else 0.0

    def met(self, figure: str) -> dict[str, float] | None:
        """Describe how items were met.

        Args:
            figure: One of ``MET``.

        Returns:
            As ``percentiles`` of all items that a tool held; None without any.
        """
        return percentiles([item["met"][MET[figure]] for item in self.items if item["met"] is not None])

    @property
    def cost_bound(self) -> dict[str, float] | None:
        """The proven bounds on the cost of transits by ARA*, as ``percentiles``; None without any."""
        return percentiles([bound for item in self.items if (bound := item.get("cost_bound")) is not None])

    def causes(self, outcome: ItemOutcome) -> list[tuple[int, str]]:
        """Count why items had an outcome.

        Args:
            outcome: The outcome.

        Returns:
            Number of items and reason, without their names and without figures; the most frequent first.
        """
        return counted_causes(_reasons(self.items, outcome))

    def total(self, key: str) -> int:
        """Sum a figure over all trials.

        Args:
            key: Its name in ``trial.json``.

        Returns:
            The sum.
        """
        return sum(record[key] for record in self.records.values())

    def values(self) -> dict[str, Any]:
        """Return all figures that do not depend on wall time.

        Returns:
            JSON values by name.
        """
        not_attempted, lost = ItemOutcome.NOT_ATTEMPTED, ItemOutcome.LOST
        return {
            "delivered": rate_values(self.delivered),
            "delivered_of_attempted": rate_values(self.delivered_of_attempted),
            "delivered_per_minute": round(self.delivered_per_minute, 6),
            "by_item": {name: rate_values(rate) for name, rate in self.by_item.items()},
            **{figure: self.met(figure) for figure in MET},
            "cost_bound": self.cost_bound,
            "not_attempted": [{"items": n, "why": why} for n, why in self.causes(not_attempted)],
            "lost": [{"items": n, "why": why} for n, why in self.causes(lost)],
            "totals": {key: self.total(key) for key in TOTALS},
        }

    def computing(self) -> dict[str, Any]:
        """Return the figures that depend on wall time.

        Returns:
            ``planning_ms`` of all queries with a plan, ``refusing_ms`` of those without, as ``percentiles``.
        """
        queries = [record["statistics"]["queries"] for record in self.records.values()]
        return {
            "planning_ms": percentiles([ms for each in queries for ms in each["planned_ms"]]),
            "refusing_ms": percentiles([ms for each in queries for ms in each["refused_ms"]]),
        }


def _delivered(items: list[Record]) -> SuccessRate:
    return SuccessRate(sum(item["outcome"] == ItemOutcome.DELIVERED for item in items), len(items))


def _kind(item: Record) -> str:
    """Return the name of the item of an entry, whose id tells it from others of that name."""
    return str(item["item"]).split("#")[0]


def _reasons(items: list[Record], outcome: ItemOutcome) -> Iterator[str]:
    names = sorted({name for each in items for name in (each["item"], _kind(each))}, key=len, reverse=True)
    for item in items:
        if item["outcome"] == outcome:
            told, own = _QUERY.sub("no plan: ", str(item["reason"])), (item["item"], _kind(item))
            for name in names:
                of = "it" if name in own else "another"
                told = re.sub(rf"(?<![\w#]){re.escape(name)}(?![\w#])", of, told)
            yield told or "no reason given"
