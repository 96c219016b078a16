"""Folder of many trials of commissions: as that of orders, with another summary.

See docs/formats/trials.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pickcli.commission.commission_record import RECORDS
from pickcli.commission.commission_statistics import CommissionStatistics, Record
from pickcli.errors import InputError
from pickcli.monte_carlo.trials_folder import RECORD, require_folder

FORMAT, VERSION = "apc-commission-trials", 1
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


def are_commissions(folder: Path) -> bool:
    """Tell whether the trials in a folder are those of commissions.

    Args:
        folder: A folder with one folder per trial.

    Returns:
        Whether they are; False without any trial.

    Raises:
        InputError: It is no folder, a record cannot be read, or there are trials of commissions and others.
    """
    require_folder(folder)
    paths = sorted(folder.glob(f"*/{RECORD}"))
    ours = [path for path in paths if RECORDS.is_of(path)]
    if ours and len(ours) < len(paths):
        other = next(path for path in paths if path not in ours)
        raise InputError(
            f"{folder}: has trials of commissions ({ours[0].parent.name}) and others ({other.parent.name}), "
            "which have other figures; keep each kind in a folder of its own"
        )
    return bool(ours)


def read_commission_trials(folder: Path) -> dict[str, dict[str, Any]]:
    """Read the records of all trials in a folder of which ``are_commissions`` is true.

    Args:
        folder: The folder.

    Returns:
        Content of each ``trial.json``, by the name of its folder, sorted.

    Raises:
        InputError: A record cannot be read.
        StaleError: It has another version of the format.
    """
    return {path.parent.name: RECORDS.read(path) for path in sorted(folder.glob(f"*/{RECORD}"))}


def _line(name: str, record: Record) -> dict[str, Any]:
    made = record["made_from"]
    return {
        "trial": name, "commission": made["commission"], "seed": made["seed"],
        **{key: record[key] for key in _COUNTED},
    }  # fmt: skip
