"""Trials of commissions as a Monte Carlo run plays them, without physics: outcomes follow from a seed."""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pickcli.commission.commission_folder import NAMES
from pickcli.commission.commission_record import RECORDS
from pickcli.commission.commission_result import (
    CommissionedItem,
    CommissionedOutcome,
    CommissionResult,
    CommissionStep,
    FloorDeviation,
)
from pickcli.jobs.job import Key
from pickcli.jobs.job_result import JobResult
from pickcli.monte_carlo.packed_folder import misfit_of_folder
from pickcli.pallet_trials.pallet_result import SetDownDeviation
from pickcli.planning.pick_problem import StatedPlace
from pickcli.seeds import derived_rng
from pickcli.trial.trial_record import record_text

ITEMS = ("beer", "coke", "beer#2")
PLACE = StatedPlace(0.0, 0.0, 0.1)
THERE = SetDownDeviation(0.001, 0.0, 0.0)


def scripted_record(name: str, seed: int, chance: float, sha256: str = "a") -> dict[str, Any]:
    """The record of a trial in which each item is lost with that chance; with seed 1 there is no pallet."""
    steps, items, t = [], [], 10.0
    for item in ITEMS if seed != 1 else ():
        lost = bool(derived_rng(name, seed, item).random() < chance)
        why = f"{item} ended {seed + 3.5} mm off" if lost else ""
        steps.append(CommissionStep("transfer_item", item, t, t + 7.0, not lost, why))
        items.append(
            CommissionedItem(
                item, CommissionedOutcome.LOST if lost else CommissionedOutcome.PLACED, PLACE, 1, THERE,
                None if lost else THERE,
            )
        )  # fmt: skip
        t += 7.0
    if seed == 1:
        steps = [CommissionStep("enter_pallet", "", 0.0, 10.0, False, "the pallet was not seen")]
        items = [CommissionedItem(item, CommissionedOutcome.LEFT, PLACE, 0, None, None) for item in ITEMS]
    aborted = "enter_pallet: the pallet was not seen" if seed == 1 else ""
    off = None if aborted else FloorDeviation(0.001 * seed, 0.0)
    result = CommissionResult(
        tuple(steps), tuple(items), off, FloorDeviation(0.0, 0.0), 0, 0, 0, aborted, t, t - 10.0
    )
    made = {
        "format": RECORDS.format, "version": RECORDS.version, "commission": f"{name}.json",
        "commission_sha256": sha256, "seed": seed,
    }  # fmt: skip
    return {**result.record(), "drives": [], "arm_from_s": 0.0, "pallet_on_forks": None, "made_from": made}


@dataclass(frozen=True)
class ScriptedCommissions:
    """Plays commissions by script.

    ends_at: a key at which the process is gone, as by a kill
    """

    names: tuple[str, ...]
    chance: float = 0.3
    ends_at: Key | None = None
    inputs: str = "0123456789abcdef"

    def keys(self, seeds: range) -> list[Key]:
        """See CommissionJob."""
        return [(name, str(seed)) for name in self.names for seed in seeds]

    def effort(self, key: Key) -> float:
        """See Job."""
        return 1.0

    def make(self, key: Key) -> JobResult:
        """See Job."""
        if key == self.ends_at:
            raise KeyboardInterrupt
        text = record_text(scripted_record(key[0], int(key[1]), self.chance))
        return JobResult({"files": {"trial.json": base64.b64encode(text.encode()).decode()}})

    def misfit(self, key: Key, result: JobResult) -> str:
        """See CommissionJob."""
        made_from = {"commission": f"{key[0]}.json", "seed": int(key[1])}
        return misfit_of_folder(result, NAMES.__contains__, RECORDS, made_from)


def write_scripted_commissions(
    folder: Path, name: str, seeds: range, chance: float, sha256: str = "a"
) -> Path:
    """A folder as several ``run-trial`` leave it."""
    for seed in seeds:
        (folder / f"{name}-{seed}").mkdir(parents=True)
        record = scripted_record(name, seed, chance, sha256)
        (folder / f"{name}-{seed}" / "trial.json").write_text(json.dumps(record))
    return folder
