"""Many commissions: one folder, one summary, one page; resumed, compared, and never mixed with orders."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest

from pickcli.commission.commission_comparison import COMMISSIONS
from pickcli.commission.commission_job import CommissionJob
from pickcli.commission.commission_statistics import CommissionStatistics, why_no_success
from pickcli.commission.commission_trials import TRIALS, commission_summary
from pickcli.errors import InputError
from pickcli.jobs.job_run import Build, RunOptions
from pickcli.monte_carlo.interrupted_run import SUMMARY, is_interrupted
from pickcli.monte_carlo.trial_comparison import TrialComparison
from pickcli.monte_carlo.trials_folder import (
    PAGE,
    TrialsReport,
    play_trials,
    write_trials,
)
from pickcli.page.commission_trials_page import commission_trials_page
from pickcli.page.html_page import page_bytes
from support.command_line import apc, misused, refused
from support.commissions import SHIPPED, few, written
from support.scripted_commissions import ScriptedCommissions, scripted_record, write_scripted_commissions
from support.scripted_trials import write_scripted_trials

SEEDS = range(4)


def played(job: ScriptedCommissions, folder: Path, replaced: bool = False) -> TrialsReport:
    folder.mkdir(exist_ok=True)
    build = Build(job, replace(RunOptions(), output=folder / SUMMARY))
    made_from = {"seeds": list(SEEDS)}
    report = play_trials(build, cast(CommissionJob, job), SEEDS, made_from, commission_summary)
    write_trials(folder, report, page_bytes(commission_trials_page(report.records)), replaced)
    build.finish()
    return report


def run(*argv: object) -> dict[str, Any]:
    answer = apc(*argv, "--json")
    assert answer.code == 0, answer.err
    told: dict[str, Any] = json.loads(answer.out)
    return told


def records(name: str, chance: float, seeds: range, sha256: str = "a") -> dict[str, dict[str, Any]]:
    return {f"{name}-{seed}": scripted_record(name, seed, chance, sha256) for seed in seeds}


def test_a_folder_has_every_trial_a_summary_and_a_page_that_show_makes_again(tmp_path: Path) -> None:
    report = played(ScriptedCommissions(("a", "b")), tmp_path / "run")
    names = [f"{name}-{seed}" for name in "ab" for seed in SEEDS]
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == [*names, PAGE, SUMMARY]
    told = json.loads((tmp_path / "run" / SUMMARY).read_text())
    assert told == report.summary and [line["trial"] for line in told["trials"]] == names
    assert told["made_from"]["format"] == "apc-commission-trials" and "statistics" not in told
    assert apc("show", tmp_path / "run", "-o", tmp_path / "page.html").code == 0
    assert (tmp_path / "page.html").read_bytes() == (tmp_path / "run" / PAGE).read_bytes()


def test_an_interrupted_run_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        played(ScriptedCommissions(("a",), ends_at=("a", "2")), tmp_path / "run")
    assert is_interrupted(tmp_path / "run")
    played(ScriptedCommissions(("a",)), tmp_path / "run", replaced=True)
    played(ScriptedCommissions(("a",)), tmp_path / "whole")
    for name in (SUMMARY, PAGE):
        assert (tmp_path / "run" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_statistics_count_successes_items_steps_and_reasons() -> None:
    found = CommissionStatistics({**records("a", 0.0, range(6)), **records("b", 1.0, range(2, 4))})
    values = found.values()
    assert (values["success"]["successes"], values["success"]["tries"]) == (5, 8)
    low, high = values["success"]["interval"]
    assert 0.2 < low < 5 / 8 < high < 0.95
    assert (values["items_placed"]["successes"], values["items_placed"]["tries"]) == (15, 24)
    assert values["by_product"]["beer"] == {**values["by_product"]["beer"], "successes": 10, "tries": 16}
    assert values["duration_s"]["n"] == 8 and values["duration_s"]["max"] == 31.0
    assert values["steps"]["transfer_item"]["failed"] == 6
    assert values["steps"]["transfer_item"]["s"]["median"] == 7.0
    assert values["totals"]["aborted"] == 1 and values["pallet_off_m"]["n"] == 7
    assert values["causes"] == [
        {"trials": 2, "cause": "items lost"},
        {"trials": 1, "cause": "ended early: enter_pallet: the pallet was not seen"},
    ]
    assert {"steps": 2, "why": "transfer_item: coke ended … mm off"} in values["failed_steps"]


def test_a_cause_names_all_that_a_success_asks_for() -> None:
    record = scripted_record("a", 2, 1.0)
    assert why_no_success({**record, "collisions": 2, "delivered": False}) == (
        "items lost, the pallet was not delivered, collisions"
    )


def test_the_run_with_more_successes_is_better() -> None:
    good, bad = records("a", 0.0, range(2, 14)), records("a", 0.9, range(2, 14))
    found = TrialComparison.of(("old", "new"), bad, good, COMMISSIONS)
    assert found.better == "new" and found.decisive.mean_b == 1.0
    assert found.sentence.startswith("new is better than old by 100.0 successes in 100 trials (95 %: ")
    alike = TrialComparison.of(("old", "new"), good, good, COMMISSIONS)
    assert alike.better == "" and alike.sentence.startswith("no difference beyond chance: new has +0.0 succ")
    other = records("a", 0.0, range(2, 14), sha256="b")
    with pytest.raises(InputError, match=r"a\.json is another file in the one than in the other, so the tr"):
        TrialComparison.of(("old", "new"), good, other, COMMISSIONS)
    with pytest.raises(InputError, match="no commission was played with the same seed in both"):
        TrialComparison.of(("old", "new"), good, records("a", 0.0, range(20, 22)), COMMISSIONS)


def test_folders_are_compared_by_the_command(tmp_path: Path) -> None:
    good = write_scripted_commissions(tmp_path / "good", "a", range(2, 10), 0.0)
    bad = write_scripted_commissions(tmp_path / "bad", "a", range(2, 10), 0.9)
    told = run("compare-trials", bad, good)
    assert told["better"] == str(good) and told["pairs"] == 8
    assert set(told["figures"]) == {"success", "items_placed", "duration_s", "handling_s", "collisions"}


def test_kinds_are_never_mixed(tmp_path: Path) -> None:
    ours = write_scripted_commissions(tmp_path / "ours", "a", range(3), 0.0)
    orders = write_scripted_trials(tmp_path / "orders", "o", range(3), 0.0)
    refused(apc("compare-trials", ours, orders), 3, f"{ours} has trials of commissions and {orders} others")
    refused(apc("compare-trials", orders, ours), 3, f"{ours} has trials of commissions and {orders} others")
    assert TRIALS.is_of(ours) and not TRIALS.is_of(orders)
    assert list(TRIALS.read(ours)) == ["a-0", "a-1", "a-2"]
    write_scripted_trials(tmp_path / "ours", "z", range(1), 0.0)
    for command in (("show", ours, "-o", tmp_path / "x.html"), ("compare-trials", ours, orders)):
        refused(apc(*command), 3, "has trials of commissions (a-0) and others (z-0)", "a folder of its own")
    refused(
        apc("run-trials", "apple_commission", "jsk_pick_sample", "-o", tmp_path / "x"), 3,
        "apple_commission is a commission and jsk_pick_sample is not",
    )  # fmt: skip
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda record: record["steps"][0].pop("t_end"), r"steps\[0\]\.t_end"),
        (lambda record: record.update(people={"number": 1}), r"people: lacks .*braked_s"),
        (lambda record: record.update(duration_s="long"), r"duration_s"),
        (lambda record: record["items"].append({"id": "beer"}), r"items\[3\]\.outcome"),
    ],
)
def test_a_record_that_statistics_cannot_take_is_refused_by_its_field(
    tmp_path: Path, change: Callable[[dict[str, Any]], object], told: str
) -> None:
    run = write_scripted_commissions(tmp_path / "run", "a", range(1), 0.3)
    path = run / "a-0" / "trial.json"
    record = json.loads(path.read_text())
    change(record)
    path.write_text(json.dumps(record))
    with pytest.raises(InputError, match=told):
        TRIALS.read(run)


def test_what_does_not_fit_is_refused_before_any_work(tmp_path: Path) -> None:
    out = tmp_path / "out"
    for command in ("run-trial", "run-trials"):
        misused(apc(command, SHIPPED, "--approach", "region", "-o", out), "--approach", "commissions")
        misused(apc(command, SHIPPED, "--pod-shift", "none", "-o", out), "--pod-shift", "commissions")
    misused(apc("run-trials", SHIPPED, "--perception", "camera", "-o", out), "--perception camera")
    copy = written(tmp_path, lambda data: None).rename(tmp_path / "apple_commission.json")
    refused(apc("run-trials", SHIPPED, copy, "-o", out), 3, copy, "a second commission of the name apple_c")
    bad = written(tmp_path, lambda data: data["start"].update(position=[9, 9]))
    refused(apc("run-trials", bad, "-o", out), 3, bad, "start: the truck at the start is")
    (out / "x").mkdir(parents=True)
    refused(apc("run-trials", SHIPPED, "-o", out), 3, "--overwrite")


@pytest.mark.slow
def test_trials_are_those_of_run_trial(tmp_path: Path) -> None:
    path = written(tmp_path, lambda data: few(data, "coke"))
    told = run("run-trials", path, "--seeds", "5:7", "--jobs", 1, "-o", tmp_path / "many")
    run("run-trial", path, "--seed", 6, "-o", tmp_path / "alone")
    names = {each.name for each in (tmp_path / "alone").iterdir()}
    assert names == {each.name for each in (tmp_path / "many" / "commission-6").iterdir()}
    for name in names:
        alone, many = (tmp_path / each / name for each in ("alone", "many/commission-6"))
        assert alone.read_bytes() == many.read_bytes(), name
    assert [line["seed"] for line in told["trials"]] == [5, 6]
    other, drives = (
        json.loads((tmp_path / f"many/commission-{seed}/trial.json").read_text())["drives"] for seed in (5, 6)
    )
    assert other != drives
    assert told["items_placed"]["tries"] == 2 and told["made_from"]["cell"] == "apple_booth"
