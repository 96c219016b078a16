"""The record of a trial of a pallet: what was played under which conditions, and what became of it."""

from __future__ import annotations

from typing import Any

from pickcli.trial.pallet_station import PalletStation
from pickcli.trial.pallet_trial import PalletTrialRequest, PlayedPallet
from pickcli.trial.trial_record import package_versions

FORMAT = "apc pallet trial"
VERSION = 1


def pallet_record(
    request: PalletTrialRequest, station: PalletStation, played: PlayedPallet, name: str, sha256: str
) -> dict[str, Any]:
    """Return the record as JSON values; all but ``statistics`` is a function of stack, conditions and seed.

    Args:
        request: The stack and the conditions.
        station: The cell.
        played: The played trial.
        name: Name of the file of the order or stack.
        sha256: Digest of that file as it was read.

    Returns:
        Values by name.
    """
    cell = station.cell
    return {
        **played.result.record(),
        "noise": request.noise.figures,
        "reality": request.reality.as_dict(),
        "made_from": {
            "format": FORMAT,
            "version": VERSION,
            "pallet": name,
            "pallet_sha256": sha256,
            "seed": request.seed,
            "cell": cell.name,
            "cell_fingerprint": cell.scene_fingerprint,
            "versions": package_versions(),
        },
    }
