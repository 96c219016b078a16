"""Trials of streams as a Monte Carlo run plays them, without physics: outcomes follow from a seed."""

from __future__ import annotations

import base64
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pickcli.jobs.job import Key
from pickcli.jobs.job_result import JobResult
from pickcli.monte_carlo.packed_folder import misfit_of_folder
from pickcli.seeds import derived_rng
from pickcli.stream_trials.stream_folder import NAMES
from pickcli.stream_trials.stream_record import RECORDS
from pickcli.stream_trials.stream_result import (
    ItemOutcome,
    MeetingRecord,
    StreamItemResult,
    StreamTrialResult,
)
from pickcli.trial.trial_record import record_text

ITEMS = ("cup", "pen", "cup#2", "bottle")


def scripted_record(
    name: str, seed: int, chance: float, sha256: str = "a", planning_ms: float = 50.0
) -> dict[str, Any]:
    """The record of a trial: bottles are never attempted, each other item is lost with that chance."""
    items = []
    for k, item in enumerate(ITEMS):
        if item == "bottle":
            items.append(
                StreamItemResult(
                    item,
                    ItemOutcome.NOT_ATTEMPTED,
                    0,
                    f"no plan for pick {item} from belt: {item}: too late: by {seed}.5 ms",
                )
            )
            continue
        is_lost = bool(derived_rng(name, seed, item).random() < chance)
        why = f"{item} fell after {k} s" if is_lost else ""
        met = MeetingRecord(5.0 * k, 0.002, 1e-4 * (k + 1), 1e-3 * (seed + 1))
        outcome = ItemOutcome.LOST if is_lost else ItemOutcome.DELIVERED
        items.append(StreamItemResult(item, outcome, 1, why, 5.0 * (k + 1), met, "", 0.004))
    result = StreamTrialResult(
        0.33, tuple(items), 0, 0, 0, 30.0, (planning_ms, 3.0 * planning_ms), (2.0,)
    )  # fmt: skip
    made = {
        "format": RECORDS.format, "version": RECORDS.version, "stream": f"{name}.json",
        "stream_sha256": sha256, "seed": seed,
    }  # fmt: skip
    return {**result.record(), "reality": {}, "rule": "earliest", "made_from": made}


@dataclass(frozen=True)
class ScriptedStreams:
    """Plays streams by script.

    ends_at: a key at which the process is gone, as by a kill
    """

    names: tuple[str, ...]
    chance: float = 0.3
    planning_ms: float = 50.0
    ends_at: Key | None = None
    inputs: str = "0123456789abcdef"

    def keys(self, seeds: range) -> list[Key]:
        """See StreamJob."""
        return [(name, str(seed)) for name in self.names for seed in seeds]

    def effort(self, key: Key) -> float:
        """See Job."""
        return 1.0

    def make(self, key: Key) -> JobResult:
        """See Job."""
        if key == self.ends_at:
            raise KeyboardInterrupt
        record = scripted_record(key[0], int(key[1]), self.chance, planning_ms=self.planning_ms)
        return JobResult({"files": {"trial.json": base64.b64encode(record_text(record).encode()).decode()}})

    def misfit(self, key: Key, result: JobResult) -> str:
        """See StreamJob."""
        made_from = {"stream": f"{key[0]}.json", "seed": int(key[1])}
        return misfit_of_folder(result, NAMES.__contains__, RECORDS, made_from)


def write_scripted_streams(folder: Path, name: str, seeds: range, chance: float, sha256: str = "a") -> Path:
    """A folder as several ``run-trial`` leave it."""
    for seed in seeds:
        (folder / f"{name}-{seed}").mkdir(parents=True)
        record = scripted_record(name, seed, chance, sha256)
        (folder / f"{name}-{seed}" / "trial.json").write_text(json.dumps(record))
    return folder
