"""What is compared of two Monte Carlo runs of commissions: successes of the whole chain decide."""

from __future__ import annotations

from pickcli.monte_carlo.trial_comparison import ComparedKind
from pickcli.monte_carlo.trial_statistics import Record


def _other_commission(one: Record, other: Record) -> str:
    same = one["made_from"]["commission_sha256"] == other["made_from"]["commission_sha256"]
    return "" if same else "is another file in the one than in the other"


COMMISSIONS = ComparedKind(
    "commission",
    {
        "success": lambda record: float(record["success"]),
        "items_placed": lambda record: float(record["items_placed"]),
        "duration_s": lambda record: float(record["duration_s"]),
        "handling_s": lambda record: float(record["handling_s"]),
        "collisions": lambda record: float(record["collisions"]),
    },
    "success",
    "has",
    "successes in 100 trials",
    _other_commission,
    "so the trials cannot be compared; play the same commission",
)
