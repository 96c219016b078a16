"""The record of a trial of a pallet: what was played under which conditions, and what became of it."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from pickcli.errors import StaleError
from pickcli.pallet_trials.pallet_station import PalletStation
from pickcli.pallet_trials.pallet_trial import PalletTrialRequest, PlayedPallet
from pickcli.palletizing.pallet_stack_file import StackedPallet, read_pallet_stack, stack_text
from pickcli.trial.record_kind import RecordKind

COUNTS = "ordered", "placed", "collisions", "limit_violations", "stops"
KEYS = frozenset((*COUNTS, "score", "collapsed", "boxes_per_hour", "aside_m", "cartons", "left"))
RECORDS = RecordKind("a pallet", "apc-pallet-trial", 2, KEYS)


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
    return {
        **played.result.record(),
        "noise": request.noise.figures,
        "reality": request.reality.as_dict(),
        "made_from": RECORDS.made_from(
            station.cell,
            request.seed,
            pallet=name,
            pallet_sha256=sha256,
            stack_sha256=_digest(stack_text(request.stack)),
        ),
    }


def read_recorded_stack(path: Path, record: dict[str, Any]) -> StackedPallet:
    """Read the stack that a trial played.

    Args:
        path: File of the stack.
        record: Record of the trial.

    Returns:
        The stack.

    Raises:
        InputError: The file cannot be read, or has mistakes.
        StaleError: It is another stack than the one of the record.
    """
    stack = read_pallet_stack(path)
    if _digest(stack_text(stack)) != record["made_from"].get("stack_sha256"):
        raise StaleError(f"{path}: is not the stack that the record was made from; play the trial again")
    return stack


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
