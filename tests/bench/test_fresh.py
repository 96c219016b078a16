"""Fresh orders as a benchmark: what is left out, what is kept, how figures are summed."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from bench import fresh


def trial(**changes: Any) -> dict[str, Any]:
    default = {
        "items_in_tote": 10, "score": 120, "max_score": 180, "contacts": [], "limit_violations": 0,
        "neighbours_moved": {}, "aborted": "", "missed": [], "loads": [(0.5, 0.5)], "drops": 0,
        "certified": 12, "rejected": 0, "clock_s": 100.0, "delivery_s": [6.0], "event_distance_mm": 1.0,
        "delivered_by": {}, "by_region": 0, "verification_ms": [200.0],
        "planning_ms": [50.0], "planning_failed_ms": [],
    }  # fmt: skip
    return {**default, **changes}


def missed_rows(*trials: dict[str, Any]) -> list[str]:
    return [what for what, _, _, is_kept in fresh.rows(fresh.summary(trials)) if not is_kept]


def test_a_clean_trial_keeps_every_promise() -> None:
    assert missed_rows(trial(), trial()) == []


@pytest.mark.parametrize(
    ("changes", "row"),
    [
        ({"contacts": [{"force": 1.0}]}, "unplanned contact"),
        ({"limit_violations": 1}, "limit violation"),
        ({"neighbours_moved": {"book": "fell 40 mm"}}, "neighbours"),
        ({"aborted": "no way out"}, "aborted"),
        ({"missed": [{"why_not": ""}]}, "delivered"),
        ({"loads": [(0.5, 0.58)]}, "planned load"),
        ({"drops": 1}, "drops"),
        ({"rejected": 1}, "rejected"),
        ({"event_distance_mm": 3.0}, "events"),
    ],
)
def test_each_failure_misses_its_row_alone(changes: dict[str, Any], row: str) -> None:
    missed = missed_rows(trial(**changes))
    assert len(missed) == 1 and row in missed[0]


def test_targets_that_nothing_could_deliver_are_left_out_and_counted() -> None:
    gone = [{"why_not": "cannot be held"}, {"why_not": "no plan when cleared"}, {"why_not": ""}]
    figures = fresh.summary([trial(items_in_tote=9, missed=gone)])
    assert figures["delivered_share"] == pytest.approx(9 / 10)
    assert figures["missed_cannot_be_held"] == figures["missed_no_plan_when_cleared"] == 1


def test_what_could_only_be_cleared_by_magic_counts_as_missed_and_is_told_apart() -> None:
    figures = fresh.summary([trial(items_in_tote=9, missed=[{"why_not": "cannot be cleared"}])])
    assert figures["delivered_share"] == pytest.approx(9 / 10)
    assert figures["delivered_share_of_clearable"] == 1.0
    assert figures["missed_deliverable"] == figures["missed_cannot_be_cleared"] == 1


def test_shares_without_a_hold_are_missing_and_not_zero() -> None:
    assert fresh.summary([trial(loads=[])])["holds_over_plan_share"] is None
    assert [row[:9] for row in missed_rows(trial(loads=[]))] == ["holds wit", "the same,"]


def test_loads_over_the_plan_count_by_their_share_and_by_how_much() -> None:
    """A cup that is loaded next to not at all may well be loaded twice as much as planned."""
    figures = fresh.summary([trial(loads=[(0.02, 0.05), (0.4, 0.43), (0.4, 0.6), (0.8, 0.81)])])
    assert figures["holds_over_plan_share"] == pytest.approx(0.5)
    assert figures["holds_over_by_share"] == pytest.approx(0.25)
    assert figures["load_worst"] == pytest.approx(0.81)


def test_jobs_are_kept_apart_by_seed_and_levels(tmp_path: Path) -> None:
    levels = tmp_path / "levels.yaml"
    levels.write_text("format: apc reality\nversion: 1\nmass_error: 0.2\n")
    plain = fresh.jobs(range(2), 2016, None, tmp_path)
    other = fresh.jobs(range(2), 2016, levels, tmp_path)
    assert len({job.folder for job in (*plain, *other)}) == 4
    assert [job.folder for job in fresh.jobs(range(2), 2016, None, tmp_path)] == [j.folder for j in plain]


@pytest.mark.parametrize("changed", fresh.JUDGES)
def test_figures_are_kept_by_every_file_that_judges(
    changed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in fresh.JUDGES:
        (tmp_path / f"{name}.py").write_text(f"the judge {name}")
    monkeypatch.setattr(fresh, "__file__", str(tmp_path / "fresh.py"))
    (job,) = fresh.jobs([7], 2016, None, tmp_path)
    before = job.judged
    (tmp_path / f"{changed}.py").write_text("another opinion")
    assert job.judged != before


def test_play_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A trial that is judged is not played again; one that did not end is, and says why it did not."""
    job = fresh.jobs([7], 2016, None, tmp_path)[0]
    called: list[list[str]] = []

    def fails(command: list[str], **options: object) -> subprocess.CompletedProcess[str]:
        called.append(command)
        return subprocess.CompletedProcess(command, 3, "", "apc: error: no room")

    monkeypatch.setattr(subprocess, "run", fails)
    assert fresh.play(job) == "order 7: exit code 3: apc: error: no room"
    assert not job.is_played and {"run-trial", "--overwrite"} <= set(called[0])
    job.folder.mkdir()
    (job.folder / "after.png").touch()
    job.judged.write_text(json.dumps(trial()))
    assert job.is_played and fresh.play(job) == ""
    assert len(called) == 1


def test_cells_are_kept_apart_and_arms_counted(tmp_path: Path) -> None:
    named, default = (fresh.jobs([7], 2016, None, tmp_path, cell)[0] for cell in ("mine", fresh.CELL))
    assert named.folder != default.folder and named.cell == "mine"
    attempts = [("left", "in tote"), ("right", "in tote"), ("right", "in tote"), ("left", "no plan")]
    record = {"attempts": [{"arm": arm, "outcome": outcome} for arm, outcome in attempts]}
    assert fresh.delivered_by(record) == {"left": 1, "right": 2}
    assert fresh.delivered_by({"attempts": [{"outcome": "in tote"}]}) == {}
    trials = [trial(delivered_by={"left": 1}), trial(delivered_by={"left": 2, "right": 3})]
    assert fresh.summary(trials)["delivered_by"] == {"left": 3, "right": 3}
