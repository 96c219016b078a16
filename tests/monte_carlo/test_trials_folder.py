"""A Monte Carlo run: its folder, the same bytes whoever plays, going on where it was interrupted."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest

from pickcli.commands.output.trials_output import TrialsFolder, played_trials
from pickcli.errors import DamagedError, InputError, StaleError
from pickcli.jobs.executors import ProcessExecutor, SerialExecutor
from pickcli.jobs.job import Key
from pickcli.jobs.job_result import JobResult
from pickcli.jobs.job_run import Build, BuildProgress, RunOptions
from pickcli.jobs.journal import Journal
from pickcli.monte_carlo import trials_folder
from pickcli.monte_carlo.interrupted_run import SUMMARY, is_interrupted
from pickcli.monte_carlo.trial_job import TrialJob
from pickcli.monte_carlo.trials_folder import (
    TrialsReport,
    order_summary,
    play_trials,
    read_trials,
    refuse_trials_folder,
    write_trials,
)
from pickcli.page.html_page import page_bytes
from pickcli.page.trials_page import trials_page
from support.command_line import apc, refused
from support.scripted_trials import ScriptedJob

SEEDS = range(3)


def played(
    job: ScriptedJob, folder: Path, options: RunOptions | None = None, replaced: bool = False
) -> TrialsReport:
    folder.mkdir(exist_ok=True)
    build = Build(job, replace(options or RunOptions(), output=folder / SUMMARY))
    report = play_trials(build, cast(TrialJob, job), SEEDS, {"seeds": list(SEEDS)}, order_summary)
    write_trials(folder, report, page_bytes(trials_page(report.records)), replaced)
    build.finish()
    return report


def without_clock(text: str) -> dict[str, Any]:
    told: dict[str, Any] = json.loads(text)
    assert told.pop("statistics")
    told.pop("process", None)
    return told


def test_every_trial_has_its_folder_and_all_have_a_summary_and_a_page(tmp_path: Path) -> None:
    report = played(ScriptedJob(("a", "b")), tmp_path)
    names = [f"{name}-{seed}" for name in "ab" for seed in SEEDS]
    assert sorted(path.name for path in tmp_path.iterdir()) == [*names, "trials.html", "trials.json"]
    told = json.loads((tmp_path / SUMMARY).read_text())
    assert told == report.summary
    assert [line["trial"] for line in told["trials"]] == names
    assert [(line["order"], line["seed"]) for line in told["trials"][:2]] == [("a.json", 0), ("a.json", 1)]
    assert told["delivered"]["tries"] == 30
    done = sum(line["items_in_tote"] for line in told["trials"])
    assert told["delivered"]["successes"] == done == 30 - sum(each["targets"] for each in told["causes"])


def test_show_makes_the_page_again(tmp_path: Path) -> None:
    played(ScriptedJob(("a",)), tmp_path / "run")
    assert apc("show", tmp_path / "run", "-o", tmp_path / "page.html").code == 0
    assert (tmp_path / "page.html").read_bytes() == (tmp_path / "run" / "trials.html").read_bytes()


def test_what_cannot_be_stowed_is_told_and_counts_nowhere(tmp_path: Path) -> None:
    report = played(ScriptedJob(("a", "full")), tmp_path)
    assert report.summary["not_stowed"] == {f"full-{n}": "bin_A: its items do not fit" for n in SEEDS}
    assert report.summary["score_share"]["n"] == 3
    with pytest.raises(InputError, match="no trial could be played: bin_A: its items do not fit"):
        played(ScriptedJob(("full",)), tmp_path / "none")
    assert not (tmp_path / "none" / SUMMARY).exists()


def test_the_bytes_are_the_same_from_one_process_and_from_two(tmp_path: Path) -> None:
    job = ScriptedJob(("a", "b"))
    one, two = tmp_path / "one", tmp_path / "two"
    played(job, one, RunOptions(SerialExecutor()))
    played(job, two, RunOptions(ProcessExecutor(2)))
    processes = {json.loads(path.read_text())["process"] for path in two.glob("*/trial.json")}
    assert len(processes) == 2, "two did the work"
    assert (one / "trials.html").read_bytes() == (two / "trials.html").read_bytes()
    for path in [one / SUMMARY, *one.glob("*/trial.json")]:
        other = two / path.relative_to(one)
        assert without_clock(path.read_text()) == without_clock(other.read_text())


def test_an_interrupted_run_goes_on_and_ends_in_the_same_figures(tmp_path: Path) -> None:
    job, whole, folder = ScriptedJob(("a", "b")), tmp_path / "whole", tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        played(replace(job, ends_at=("b", "1")), folder)
    (journal,) = folder.iterdir()
    assert journal.name == "trials.json.0123456789ab.journal"
    refused(
        apc("show", folder, "-o", tmp_path / "page.html"),
        3,
        "its run was interrupted, and has no trials.json",
    )
    refuse_trials_folder(folder, overwrite=False)
    told: list[BuildProgress] = []
    played(job, folder, RunOptions(report=told.append))
    assert told[-1].n_kept == 4 and not journal.exists()
    played(job, whole)
    assert (folder / "trials.html").read_bytes() == (whole / "trials.html").read_bytes()
    assert without_clock((folder / SUMMARY).read_text()) == without_clock((whole / SUMMARY).read_text())


@pytest.mark.parametrize("name", ["../victim.txt", "sub/x", "{absolute}"])
def test_a_journal_writes_nowhere_but_in_the_folders_of_its_trials(tmp_path: Path, name: str) -> None:
    job, folder, victim = ScriptedJob(("a",)), tmp_path / "run", tmp_path / "victim.txt"
    folder.mkdir()
    victim.write_text("mine")
    result = job.make(("a", "0"))
    files = {**result.values["files"], name.format(absolute=victim): "b3ZlcndyaXR0ZW4="}
    journal = Journal(folder / SUMMARY, job.inputs)
    journal.append(("a", "0"), JobResult({"files": files}).to_bytes())
    with pytest.raises(DamagedError, match=rf"{journal.path}: .* which no such trial writes; delete this"):
        played(job, folder)
    assert victim.read_text() == "mine" and list(folder.iterdir()) == [journal.path]


def test_a_run_that_was_interrupted_as_it_wrote_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    job, whole, folder = ScriptedJob(("a", "b")), tmp_path / "whole", tmp_path / "run"

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(trials_folder, "write_text", interrupted)  # the summary is written last
        played(job, folder)
    refuse_trials_folder(folder, False, [f"{name}-{seed}" for name in "ab" for seed in SEEDS])
    assert is_interrupted(folder)
    played(job, folder, replaced=True)
    played(job, whole)
    assert not is_interrupted(folder)
    assert without_clock((folder / SUMMARY).read_text()) == without_clock((whole / SUMMARY).read_text())


def test_a_folder_that_was_removed_before_the_trials_are_written_is_made_again(tmp_path: Path) -> None:
    job, folder = ScriptedJob(("a",)), tmp_path / "run"
    report = played(job, folder)
    shutil.rmtree(folder)
    write_trials(folder, report, b"page", False)
    assert (folder / SUMMARY).exists() and read_trials(folder).keys() == report.records.keys()


def test_a_folder_that_is_removed_during_a_run_is_told(tmp_path: Path) -> None:
    class Removing(ScriptedJob):
        def make(self, key: Key) -> JobResult:
            shutil.rmtree(tmp_path / "run")
            return super().make(key)

    folder = TrialsFolder(tmp_path / "run", False, None, False)
    with pytest.raises(InputError, match=r"run: was removed during the run, .*; run the same command again"):
        played_trials(cast(TrialJob, Removing(("a",))), SEEDS, folder, 1, {}, order_summary, trials_page)
    assert not folder.path.exists()


def test_a_trial_of_another_seed_than_is_listed_is_refused(tmp_path: Path) -> None:
    played(ScriptedJob(("a",)), tmp_path)
    (tmp_path / "a-1" / "trial.json").write_bytes((tmp_path / "a-0" / "trial.json").read_bytes())
    with pytest.raises(
        StaleError, match=r"a-1/trial\.json: is of seed 0, and trials\.json lists it with seed 1"
    ):
        read_trials(tmp_path)


def test_a_folder_with_other_files_needs_a_word(tmp_path: Path) -> None:
    (tmp_path / "trials.json.0123456789ab.journal").write_bytes(b"")
    refuse_trials_folder(tmp_path, overwrite=False)
    (tmp_path / "a-0").mkdir()  # of the interrupted run, which had begun to write
    (tmp_path / "trials.json").write_text("of that run")
    refuse_trials_folder(tmp_path, overwrite=False, trials=["a-0"])
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="--overwrite"):
        refuse_trials_folder(tmp_path, overwrite=False)
    refuse_trials_folder(tmp_path, overwrite=True)


def test_only_folders_of_trials_are_read(tmp_path: Path) -> None:
    for path, told in (
        (tmp_path, "no trials in it"), (tmp_path / "none", "no such folder; apc run-trials makes one"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=told):
            read_trials(path)
