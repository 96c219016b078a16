"""What is compared of two Monte Carlo runs of streams: the share delivered of what came decides."""

from __future__ import annotations

from pickcli.monte_carlo.trial_comparison import ComparedKind
from pickcli.monte_carlo.trial_statistics import Record


def _other_stream(one: Record, other: Record) -> str:
    same = one["made_from"]["stream_sha256"] == other["made_from"]["stream_sha256"]
    return "" if same else "is another file in the one than in the other"


STREAMS = ComparedKind(
    "stream",
    {
        "delivered_share": lambda record: record["delivered"] / max(1, record["presented"]),
        "attempted": lambda record: float(record["attempted"]),
        "delivered": lambda record: float(record["delivered"]),
        "delivered_per_minute": lambda record: float(record["delivered_per_minute"]),
        "collisions": lambda record: float(record["collisions"]),
        "stops": lambda record: float(record["stops"]),
    },
    "delivered_share",
    "delivers",
    "items in 100",
    _other_stream,
    "so the trials cannot be compared; play the same stream",
)
