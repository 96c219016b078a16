"""Folder of many trials of streams: as that of orders, with another summary.

See docs/formats/trials.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from pickcli.monte_carlo.trial_statistics import Record
from pickcli.monte_carlo.trials_kind import TrialsKind
from pickcli.stream_trials.stream_folder import STREAM
from pickcli.stream_trials.stream_record import COUNTS, RECORDS
from pickcli.stream_trials.stream_statistics import StreamStatistics
from pickcli.trial.record_kind import refuse_other_file

FORMAT, VERSION = "apc-stream-trials", 1
TRIALS = TrialsKind("streams", RECORDS, STREAM, partial(refuse_other_file, "stream"))
_FIGURES = (*COUNTS, "speed_m_s", "duration_s", "delivered_per_minute", "rule")


def stream_summary(
    records: Mapping[str, Record], not_played: Mapping[str, str], made_from: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the content of ``trials.json``.

    Args:
        records: Content of each ``trial.json``, by name of the trial's folder.
        not_played: Empty: every stream that is begun is played.
        made_from: Provenance.

    Returns:
        JSON values; those that depend on wall time are under ``statistics``.
    """
    statistics = StreamStatistics(records)
    return {
        **statistics.values(),
        "trials": [_line(name, record) for name, record in records.items()],
        "made_from": {"format": FORMAT, "version": VERSION, **made_from},
        "statistics": statistics.computing(),
    }


def _line(name: str, record: Record) -> dict[str, Any]:
    made = record["made_from"]
    return {
        "trial": name, "stream": made["stream"], "seed": made["seed"],
        **{key: record[key] for key in _FIGURES},
    }  # fmt: skip
