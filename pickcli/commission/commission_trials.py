"""Folder of many trials of commissions: as that of orders, with another summary.

See docs/formats/trials.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from pickcli.commission.commission_folder import COMMISSION
from pickcli.commission.commission_record import RECORDS
from pickcli.commission.commission_statistics import CommissionStatistics, Record
from pickcli.monte_carlo.trials_kind import TrialsKind
from pickcli.trial.record_kind import refuse_other_file

FORMAT, VERSION = "apc-commission-trials", 1
TRIALS = TrialsKind("commissions", RECORDS, COMMISSION, partial(refuse_other_file, "commission"))
_COUNTED = ("success", "items_placed", "items_ordered", "delivered", "duration_s", "handling_s", "collisions",
            "limit_violations", "stops", "aborted")  # fmt: skip


def commission_summary(
    records: Mapping[str, Record], not_played: Mapping[str, str], made_from: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the content of ``trials.json``.

    Args:
        records: Content of each ``trial.json``, by name of the trial's folder.
        not_played: Empty: every commission that is begun is played.
        made_from: Provenance.

    Returns:
        JSON values, none of which depends on wall time.
    """
    return {
        **CommissionStatistics(records).values(),
        "trials": [_line(name, record) for name, record in records.items()],
        "made_from": {"format": FORMAT, "version": VERSION, **made_from},
    }


def _line(name: str, record: Record) -> dict[str, Any]:
    made = record["made_from"]
    return {
        "trial": name, "commission": made["commission"], "seed": made["seed"],
        **{key: record[key] for key in _COUNTED},
    }  # fmt: skip
