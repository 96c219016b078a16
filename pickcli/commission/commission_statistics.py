"""Statistics over many trials of commissions: how often the chain succeeds, how fast, and what fails."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pickcli.monte_carlo.success_rate import SuccessRate
from pickcli.monte_carlo.trial_statistics import counted_causes, rate_values, spread

TOTALS = ("collisions", "limit_violations", "stops")
PEOPLE = ("number", "brake_requests", "touched", "walked_in")  # of watched drives, which are summed up

Record = Mapping[str, Any]  # content of a trial.json


@dataclass(frozen=True, eq=False)
class CommissionStatistics:
    """Statistics of several trials.

    Attributes:
        records: Contents of their ``trial.json`` files, by name.
    """

    records: Mapping[str, Record]

    @property
    def success(self) -> SuccessRate:
        """How many of the trials succeeded: the whole chain."""
        return SuccessRate(sum(bool(r["success"]) for r in self.records.values()), len(self.records))

    @property
    def placed(self) -> SuccessRate:
        """How many of all items stand in their places at the end."""
        return _placed(self.items)

    @property
    def delivered(self) -> SuccessRate:
        """How many of the pallets stand where they were to be delivered."""
        return SuccessRate(sum(bool(r["delivered"]) for r in self.records.values()), len(self.records))

    @property
    def items(self) -> list[Record]:
        """Entries of ``items`` of all trials."""
        return [item for record in self.records.values() for item in record["items"]]

    @property
    def by_product(self) -> dict[str, SuccessRate]:
        """Rates of items in their places, by product."""
        groups: dict[str, list[Record]] = {}
        for item in sorted(self.items, key=lambda item: str(item["id"])):
            groups.setdefault(item["id"].split("#")[0], []).append(item)
        return {name: _placed(group) for name, group in groups.items()}

    @property
    def steps(self) -> dict[str, list[Record]]:
        """All steps that took time, by action in the order in which they first come."""
        groups: dict[str, list[Record]] = {}
        for record in self.records.values():
            for step in record["steps"]:
                if step["t_end"] > step["t_start"] or not step["is_success"]:
                    groups.setdefault(step["action"], []).append(step)
        return groups

    @property
    def failed_steps(self) -> list[tuple[int, str]]:
        """Number of failed steps by action and reason without figures; the most frequent first."""
        return counted_causes(
            f"{step['action']}: {step['reason'] or 'no reason given'}"
            for record in self.records.values()
            for step in record["steps"]
            if not step["is_success"]
        )

    @property
    def causes(self) -> list[tuple[int, str]]:
        """Number of trials without success by why, without figures; the most frequent first."""
        missed = (record for record in self.records.values() if not record["success"])
        return counted_causes(why_no_success(record) for record in missed)

    @property
    def durations(self) -> list[float]:
        """Times (s) of each trial."""
        return [float(record["duration_s"]) for record in self.records.values()]

    @property
    def handling(self) -> list[float]:
        """Times (s) of each trial in which the arm looked and moved."""
        return [float(record["handling_s"]) for record in self.records.values()]

    def total(self, key: str) -> int:
        """Sum a figure over all trials.

        Args:
            key: Its name in ``trial.json``, or "aborted" for the number of trials that ended early.

        Returns:
            The sum.
        """
        return sum(bool(r[key]) if key == "aborted" else r[key] for r in self.records.values())

    @property
    def people(self) -> dict[str, Any] | None:
        """Sums over the trials that were watched for people, and the spread of s braked; None without one."""
        found = [record["people"] for record in self.records.values() if record.get("people") is not None]
        if not found:
            return None
        sums = {key: sum(each[key] for each in found) for key in PEOPLE}
        return {"trials": len(found), **sums, "braked_s": spread([each["braked_s"] for each in found])}

    def values(self) -> dict[str, Any]:
        """Return all figures.

        Returns:
            JSON values by name.
        """
        off = [r["pallet_off"] for r in self.records.values() if r["pallet_off"] is not None]
        return {
            "success": rate_values(self.success),
            "items_placed": rate_values(self.placed),
            "delivered": rate_values(self.delivered),
            "by_product": {name: rate_values(rate) for name, rate in self.by_product.items()},
            "duration_s": spread(self.durations),
            "handling_s": spread(self.handling),
            "pallet_off_m": spread([each["distance"] for each in off]),
            "pallet_turned_rad": spread([each["turn"] for each in off]),
            "steps": {
                name: {
                    "number": len(steps),
                    "failed": sum(not each["is_success"] for each in steps),
                    "s": spread([each["t_end"] - each["t_start"] for each in steps]),
                }
                for name, steps in self.steps.items()
            },
            "failed_steps": [{"steps": n, "why": why} for n, why in self.failed_steps],
            "causes": [{"trials": n, "cause": cause} for n, cause in self.causes],
            "people": self.people,
            "totals": {key: self.total(key) for key in (*TOTALS, "aborted")},
        }


def why_no_success(record: Record) -> str:
    """Say why a trial was no success.

    Args:
        record: Its record.

    Returns:
        Everything that a success asks for and that was not so.
    """
    if record["aborted"]:
        return f"ended early: {record['aborted']}"
    missing = Counter(str(each["outcome"]) for each in record["items"] if each["outcome"] != "placed")
    told = [f"items {outcome}" for outcome in missing]
    if not record["delivered"]:
        told.append("the pallet was not delivered")
    told += [key.replace("_", " ") for key in ("collisions", "limit_violations") if record[key]]
    return ", ".join(told)


def _placed(items: list[Record]) -> SuccessRate:
    return SuccessRate(sum(each["outcome"] == "placed" for each in items), len(items))
