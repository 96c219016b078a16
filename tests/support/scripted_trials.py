"""Trials as a Monte Carlo run plays them, without physics: outcomes follow from a seed."""

from __future__ import annotations

import base64
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pickcli.cell.cell_file import load_cell
from pickcli.errors import Reason
from pickcli.jobs.job import Key
from pickcli.jobs.job_result import JobResult
from pickcli.monte_carlo.packed_folder import misfit_of_folder
from pickcli.seeds import derived_rng
from pickcli.trial.loop import run_trial
from pickcli.trial.trial_folder import is_name_of_trial
from pickcli.trial.trial_record import RECORDS, record_text, trial_record
from pickcli.trial.trial_settings import TrialSettings
from support.order_builders import ITEMS, pick_order
from support.scripted_trial import ScriptedTrial, scene_of

BINS = ("bin_A", "bin_B", "bin_C", "bin_D", "bin_E")
CONTENTS = {name: (item,) for name, item in zip(BINS, ITEMS, strict=True)}
ORDER = pick_order(CONTENTS, *zip(BINS, ITEMS, strict=True))


def scripted_record(name: str, seed: int, chance: float) -> dict[str, Any]:
    """The record of a trial in which each target has no plan with that chance."""
    missed = frozenset(item for item in ITEMS if derived_rng(name, seed, item).random() < chance)
    fake = ScriptedTrial(scene_of(ORDER, load_cell("apc2016_delft")), no_plan=missed)
    return trial_record(run_trial(ORDER, fake.interfaces(), TrialSettings(seed)), f"{name}.json", 0.5)


@dataclass(frozen=True)
class ScriptedJob:
    """Plays orders by script. An order of the name "full" cannot be stowed.

    ends_at: a key at which the process is gone, as by a kill
    """

    orders: tuple[str, ...]
    chance: float = 0.3
    ends_at: Key | None = None
    inputs: str = "0123456789abcdef"

    def keys(self, seeds: range) -> list[Key]:
        """See TrialJob."""
        return [(name, str(seed)) for name in self.orders for seed in seeds]

    def effort(self, key: Key) -> float:
        """See Job."""
        return 1.0

    def make(self, key: Key) -> JobResult:
        """See Job."""
        if key == self.ends_at:
            raise KeyboardInterrupt
        name, seed = key
        if name == "full":
            return JobResult(reason=Reason("cannot be stowed", name, "bin_A: its items do not fit"))
        text = record_text(scripted_record(name, int(seed), self.chance) | {"process": os.getpid()})
        return JobResult({"files": {"trial.json": base64.b64encode(text.encode()).decode()}})

    def misfit(self, key: Key, result: JobResult) -> str:
        """See TrialJob."""
        if key[0] == "full":
            return ""
        made_from = {"order": f"{key[0]}.json", "seed": int(key[1])}
        return misfit_of_folder(result, is_name_of_trial, RECORDS, made_from)


def write_scripted_trials(folder: Path, name: str, seeds: range, chance: float) -> Path:
    """A folder as several ``run-trial`` leave it."""
    for seed in seeds:
        (folder / f"{name}-{seed}").mkdir(parents=True)
        record = scripted_record(name, seed, chance)
        (folder / f"{name}-{seed}" / "trial.json").write_text(json.dumps(record))
    return folder
