"""Two runs compared: trials are paired, and the sentence says no more than the test does."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.errors import InputError
from pickcli.monte_carlo.sign_flips import SignFlipTest
from pickcli.monte_carlo.trial_comparison import TrialComparison
from support.command_line import apc, refused
from support.scripted_trials import write_scripted_trials


def run(scores: list[int], order: str = "o.json", first: int = 0) -> dict[str, dict[str, Any]]:
    return {
        f"t{seed}": {
            "score": score, "max_score": 100, "items_in_tote": score // 10, "clock_s": 100.0,
            "collisions": 0, "drops": 0, "items": [{"bin": "bin_A", "item": "bar"}],
            "made_from": {"order": order, "seed": seed},
        }
        for seed, score in enumerate(scores, first)
    }  # fmt: skip


def compared(a: list[int], b: list[int]) -> TrialComparison:
    return TrialComparison.of(("old", "new"), run(a), run(b))


def test_a_difference_beyond_chance_is_told_with_its_interval() -> None:
    a, b = [50, 60, 40, 70, 30, 60, 50, 40], [60, 80, 50, 80, 50, 60, 70, 60]
    found = compared(a, b)
    test = SignFlipTest.of((np.array(b) - a) / 100)
    assert found.decisive.test.p_value == test.p_value <= 0.05
    assert (found.decisive.test.low, found.decisive.test.high) == pytest.approx((test.low, test.high))
    assert found.better == "new"
    assert found.sentence == (
        f"new is better than old by {100 * test.mean:.1f} points in 100 (95 %: {100 * test.low:.1f} to "
        f"{100 * test.high:.1f}), more than chance has it (p = {test.p_value:.2g}, 8 pairs)"
    )
    turned = compared(b, a)
    assert turned.better == "old"
    assert turned.sentence == found.sentence.replace("new is better than old", "old is better than new")


def test_a_difference_that_chance_could_make_is_none() -> None:
    found = compared([50, 60, 40, 70, 30, 60, 50], [60, 50, 50, 60, 40, 50, 60])
    assert found.better == "" and found.values()["better"] is None
    assert found.sentence.startswith(
        "no difference beyond chance: new scores +1.4 points in 100 more than old"
    )


def test_runs_that_are_alike_have_no_difference() -> None:
    found = compared([50] * 8, [50] * 8)
    assert found.better == "" and found.decisive.test.p_value == 1.0


def test_too_few_pairs_are_told_as_that() -> None:
    found = compared([10] * 5, [90] * 5)
    assert found.better == ""
    assert found.sentence.startswith("5 pairs of trials are too few")
    assert found.values()["figures"]["score_share"]["interval"] is None
    json.dumps(found.values(), allow_nan=False)


def test_only_trials_of_both_are_compared() -> None:
    found = TrialComparison.of(("a", "b"), run([50] * 8), run([60] * 9, first=2))
    assert found.decisive.test.n == 6 and found.n_unpaired == (2, 3)


def test_what_cannot_be_paired_is_refused() -> None:
    for other, told in (
        (run([50], order="p.json"), "no order was played with the same seed in both"),
        ({"x": run([50])["t0"] | {"max_score": 90}}, "o.json is worth 100 points in the one and 90"),
        ({"x": run([50])["t0"] | {"items": []}}, "o.json names other targets"),
        (run([50]) | {"again": run([50])["t0"]}, "again plays o.json with seed 0 a second time"),
    ):
        with pytest.raises(InputError, match=told):
            TrialComparison.of(("a", "b"), run([50]), other)


def test_the_command_reads_folders_of_trials(tmp_path: Path) -> None:
    bad, good = tmp_path / "bad", tmp_path / "good"
    write_scripted_trials(bad, "o", range(10), 0.9)
    write_scripted_trials(good, "o", range(12), 0.1)
    answer = apc("compare-trials", bad, good)
    first, head, *rows = answer.out.splitlines()
    assert answer.code == 0 and first.startswith(f"{good} is better than {bad} by ")
    assert head.split()[:3] == ["mean", "of", "a"]
    assert [row.split("  ")[0] for row in rows[:2]] == ["score share", "delivered"]
    assert rows[-1] == f"only in {good}: 2 trials, which are left out"
    told = json.loads(apc("compare-trials", bad, good, "--json").out)
    assert (told["better"], told["sentence"], told["pairs"]) == (str(good), first, 10)
    assert apc("compare-trials", bad, good).out == answer.out
    refused(apc("compare-trials", bad, bad), 3, "are one folder; name two different ones")
    refused(apc("compare-trials", bad, tmp_path), 3, tmp_path, "no trials in it")
