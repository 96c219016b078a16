"""The record of a trial of a commission: what was played under which conditions, and what came of it."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.commission.commission import Commission
from pickcli.commission.commission_file import read_commission
from pickcli.commission.commission_record_schema import refuse_bad_commission_record
from pickcli.commission.commission_station import CommissionStation
from pickcli.commission.commission_trial import CommissionRequest, PlayedCommission
from pickcli.commission.people_watch import SHOWN_EVERY, WatchedOutcome
from pickcli.driving.drive_tracking import PERIOD
from pickcli.geometry import Array
from pickcli.scene.scene_file import scene_hash
from pickcli.trial.record_kind import RecordKind, refuse_other_file

DRIVE_STEP = 10  # periods between poses of a drive that are kept
KEYS = frozenset(
    ("success", "steps", "items", "drives", "duration_s", "collisions", "arm_from_s", "pallet_on_forks")
)
RECORDS = RecordKind("a commission", "apc-commission-trial", 2, KEYS, refuse_bad_commission_record)


def commission_record(
    request: CommissionRequest, station: CommissionStation, played: PlayedCommission, name: str, sha256: str
) -> dict[str, Any]:
    """Return the record as JSON values, a function of commission, cell, conditions and seed.

    Args:
        request: The conditions.
        station: The commission in its cell.
        played: The played trial.
        name: Name of the file of the commission.
        sha256: Digest of that file as it was read.

    Returns:
        Values by name.
    """
    return {
        **played.result.record(),
        "arm_from_s": played.arm_from,
        "pallet_on_forks": None if played.on_forks is None else played.on_forks.tolist(),
        "drives": [
            {
                "name": each.drive.name,
                "t_start": each.t_start,
                "t_end": each.t_start + each.drive.duration,
                "step_s": PERIOD * DRIVE_STEP,
                "poses": np.round(_thinned(each.drive.poses), 4).tolist(),
                **_people(each.drive.watched),
            }
            for each in played.drives
        ],
        "noise": request.noise.figures,
        "reality": request.reality.as_dict(),
        "strategy": {"name": request.strategy.name, "digest": request.strategy.digest},
        "made_from": RECORDS.made_from(
            station.cell,
            request.seed,
            commission=name,
            commission_sha256=sha256,
            scene_hash=None if played.before is None else scene_hash(played.before),
            guards=None if request.watched is None else asdict(request.watched.guards),
        ),
    }


def _people(watched: WatchedOutcome | None) -> dict[str, Any]:
    """Where people were during a drive, if it was watched."""
    if watched is None:
        return {}
    return {
        "people": [
            {
                "name": each.name,
                "height": each.height,
                "has_vest": each.has_vest,
                "step_s": PERIOD * SHOWN_EVERY,
                "places": np.round(each.places, 3).tolist(),
            }
            for each in watched.people
        ]
    }


def read_played_commission(path: Path, record: dict[str, Any]) -> Commission:
    """Read the commission that a trial played.

    Args:
        path: File of the commission.
        record: Record of the trial.

    Returns:
        The commission.

    Raises:
        InputError: The file cannot be read, or has mistakes.
        StaleError: It is another file than the one of the record.
    """
    commission = read_commission(path)
    refuse_other_file("commission", path, record)
    return commission


def _thinned(poses: Array) -> Array:
    """Every ``DRIVE_STEP``-th pose, and the last one."""
    kept = poses[::DRIVE_STEP]
    return kept if len(poses) % DRIVE_STEP == 1 else np.vstack([kept, poses[-1:]])
