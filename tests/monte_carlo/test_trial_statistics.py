"""What many trials have in common, from records of which every figure is known."""

from __future__ import annotations

from typing import Any

import pytest

from pickcli.monte_carlo.success_rate import SuccessRate
from pickcli.monte_carlo.trial_statistics import TrialStatistics, spread


def target(place: str, item: str, points: int, reason: str = "", motion_s: float = 5.0) -> dict[str, Any]:
    outcome = "in tote" if points else "lost"
    return {"bin": place, "item": item, "points": points, "outcome": outcome, "reason": reason,
            "motion_s": motion_s}  # fmt: skip


def record(
    score: int, *targets: dict[str, Any], planning: tuple[tuple[bool, float], ...] = ()
) -> dict[str, Any]:
    return {
        "score": score, "max_score": 40, "items": list(targets), "clock_s": 100.0, "aborted": "",
        "items_in_tote": sum(t["points"] > 0 for t in targets),
        "collisions": 1, "limit_violations": 0, "drops": 2, "disturbed": 0, "misjudged": 0,
        "attempts": [{"plan": {} if planned else None} for planned, _ in planning],
        "statistics": {"wall_s": 9.0, "attempts": [{"planning_ms": ms} for _, ms in planning]},
    }  # fmt: skip


TOLD = TrialStatistics({
    "a": record(40, target("bin_A", "bar", 20, motion_s=4.0), target("bin_B", "wax", 20, motion_s=8.0),
                planning=((True, 30.0), (False, 500.0), (True, 70.0))),
    "b": record(-10, target("bin_A", "wax", 0, "fell 12.5 mm"), target("bin_B", "wax", 0, "fell 3 mm"),
                planning=((False, 90.0),)),
})  # fmt: skip


def test_targets_are_counted_by_item_and_place() -> None:
    assert TOLD.delivered == SuccessRate(2, 4)
    assert TOLD.by("item") == {"bar": SuccessRate(1, 1), "wax": SuccessRate(1, 3)}
    assert TOLD.by("bin") == {"bin_A": SuccessRate(1, 2), "bin_B": SuccessRate(1, 2)}


def test_causes_that_differ_in_figures_alone_are_one() -> None:
    assert TOLD.causes == [(2, "lost: fell … mm")]


def test_failures_of_seeing_are_told_from_those_of_planning_and_moving() -> None:
    seeing, planning = ("not recognised", "missing"), ("no plan", "rejected", "no plan")
    outcomes = (*seeing, *planning, "lost", "not picked", "no time", "not tried")
    missed = [target("bin_A", "bar", 0) | {"outcome": outcome} for outcome in outcomes]
    told = TrialStatistics({"a": record(20, target("bin_B", "wax", 20), *missed)})
    assert told.failed_in == {"seeing": 2, "planning": 3, "moving": 2, "time": 1, "strategy": 1}
    assert told.values()["failed_in"] == told.failed_in
    assert sum(told.failed_in.values()) == sum(n for n, _ in told.causes)


def test_scores_are_shares_of_what_the_order_can_give() -> None:
    assert TOLD.shares == [1.0, -0.25]
    values = TOLD.values()
    assert values["score_share"]["mean"] == 0.375 and values["score_share"]["min"] == -0.25
    assert values["score_share"]["mean_interval"] is None, "two trials tell nothing of the next ones"
    assert values["totals"] == {"collisions": 2, "limit_violations": 0, "drops": 4, "disturbed": 0,
                                "misjudged": 0, "aborted": 0}  # fmt: skip


def test_only_delivered_targets_have_a_time() -> None:
    assert TOLD.values()["motion_s"]["mean"] == 6.0 and TOLD.values()["motion_s"]["n"] == 2


def test_planning_is_told_by_its_success_and_by_what_it_came_to() -> None:
    told = TOLD.computing()
    assert told["planning_ms"]["mean"] == 50.0 and told["planning_failed_ms"]["mean"] == 295.0
    assert told["planning_per_item_ms"] == spread([300.0]), "of the trial that delivered none, none"


def test_a_spread_of_nothing_is_told_as_that() -> None:
    assert spread([]) == {"n": 0}
    assert spread([3.0]) == {
        "n": 1,
        **dict.fromkeys(("mean", "min", "p10", "median", "p90", "p99", "max"), 3.0),
    }


@pytest.mark.parametrize("n", [5, 6])
def test_a_mean_has_an_interval_from_six_trials_on(n: int) -> None:
    told = TrialStatistics({str(k): record(10 + k, target("bin_A", "bar", 10)) for k in range(n)})
    assert (told.values()["score_share"]["mean_interval"] is not None) == (n == 6)
