"""``apc run-trials``: what is wrong is refused before any work; real trials are those of ``run-trial``."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import click
import pytest

from pickcli.commands.run_trials import MOST_SEEDS, parse_seeds
from support.command_line import apc, misused, refused
from support.order_builders import pick_data

TWO = {
    "bin_contents": {name: [] for name in pick_data()["bin_contents"]}
    | {"bin_A": ["crayola_24_ct"], "bin_B": ["dove_beauty_bar"]},
    "tote_contents": [],
    "work_order": [{"bin": "bin_A", "item": "crayola_24_ct"}],
}


@pytest.fixture
def order(tmp_path: Path) -> Path:
    path = tmp_path / "small.json"
    path.write_text(json.dumps(TWO))
    return path


@pytest.mark.parametrize(
    ("text", "seeds"),
    [("0:3", (0, 1, 2)), ("7", (7,)), ("3,5:7", (3, 5, 6)), ("2147483647", (2147483647,))],
)
def test_seeds_are_ranges_and_numbers(text: str, seeds: tuple[int, ...]) -> None:
    assert parse_seeds(None, None, text) == seeds


@pytest.mark.parametrize(
    "text", ["", "a", "3:3", "5:2", "-1:3", "0:2:4", "1,1", "0:", ":4", "1.5", f"0:{MOST_SEEDS + 1}",
             "2147483648", "9" * 5000, "²"],
)  # fmt: skip
def test_other_seeds_are_wrong_usage(text: str, order: Path, tmp_path: Path) -> None:
    with pytest.raises(click.BadParameter):
        parse_seeds(None, None, text)
    misused(apc("run-trials", order, f"--seeds={text}", "-o", tmp_path / "out"), "--seeds")
    assert not (tmp_path / "out").exists()


def test_what_cannot_be_played_is_refused_before_any_work(order: Path, tmp_path: Path) -> None:
    out, other = tmp_path / "out", tmp_path / "x"
    other.mkdir()
    (other / "small.json").write_text(order.read_text())
    done = tmp_path / "done.json"
    done.write_text(json.dumps({key: TWO[key] for key in ("bin_contents", "tote_contents")}))
    refused(apc("run-trials", order, done, "-o", out), 3, done, "a trial plays pick")
    refused(apc("run-trials", order, other / "small.json", "-o", out), 3, "a second order of the name small")
    refused(apc("run-trials", order, "--pod-shift", "500,0,0", "-o", out), 3, "beyond what the cell")
    refused(apc("run-trials", order, "-o", order), 3, "is a file")
    refused(apc("run-trials", order, "-o", tmp_path), 3, "--overwrite")
    misused(apc("run-trials", "-o", out), "ORDER")
    assert not out.exists()


def run(*argv: object) -> dict[str, Any]:
    """``apc`` in a process of its own, as two jobs are."""
    words = [sys.executable, "-m", "pickcli", *map(str, argv), "--json"]
    told: dict[str, Any] = json.loads(subprocess.run(words, capture_output=True, check=True).stdout)
    return told


@pytest.mark.slow
def test_no_folder_is_left_when_nothing_was_played(order: Path, tmp_path: Path) -> None:
    out = tmp_path / "many"
    refused(apc("run-trials", order, "--seeds", "0:2", "--scheduler", "tcp://127.0.0.1:1", "-o", out), 3)
    assert not out.exists()


@pytest.mark.slow
def test_a_trial_is_kept_when_nobody_reads_what_it_prints(order: Path, tmp_path: Path) -> None:
    out = tmp_path / "alone"
    argv = [sys.executable, "-m", "pickcli.commands.main", "run-trial", str(order), "-o", str(out)]
    argv += ["--perception", "noise"]
    with subprocess.Popen(argv, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.close()
        assert process.wait(300) == 0
    assert (out / "trial.json").exists() and (out / "motion.json.gz").exists()


def test_trials_are_those_of_run_trial_from_one_job_and_from_two(order: Path, tmp_path: Path) -> None:
    one, two, alone = tmp_path / "one", tmp_path / "two", tmp_path / "alone"
    noise = ("--perception", "noise")
    told = run("run-trials", order, "--seeds", "4:6", "--jobs", 1, *noise, "-o", one)
    run("run-trials", order, "--seeds", "4:6", "--jobs", 2, *noise, "-o", two)
    run("run-trial", order, "--seed", 5, *noise, "-o", alone)
    files = sorted(path.relative_to(one) for path in one.rglob("*") if path.is_file())
    assert files == sorted(path.relative_to(two) for path in two.rglob("*") if path.is_file())
    for name in files:
        assert clockless(one / name) == clockless(two / name), name
    for path in alone.iterdir():
        assert clockless(path) == clockless(one / "small-5" / path.name), path.name
    assert [line["trial"] for line in told["trials"]] == ["small-4", "small-5"]
    assert told["delivered"]["tries"] == 2 and told["statistics"]["planning_ms"]["n"] >= 2
    assert told["made_from"]["pod_shift"] == "random"


def clockless(path: Path) -> object:
    """The content of a file without what the clock on the wall told."""
    if path.name not in ("trial.json", "trials.json"):
        return path.read_bytes()
    told = json.loads(path.read_text())
    del told["statistics"]
    return told
