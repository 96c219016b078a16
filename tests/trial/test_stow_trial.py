"""A stow played by script: where each item goes, what is asked for it, and what the rules give."""

from __future__ import annotations

import json
from bisect import bisect_right
from collections import Counter
from dataclasses import replace

import pytest

from pickcli.cell.cell import Cell
from pickcli.scene.scene import TOTE
from pickcli.simulation.places import OUTSIDE
from pickcli.strategy.strategy_file import load_strategy, packaged_strategies
from pickcli.trial.action_values import MOST_REFUSALS_OF_STOW
from pickcli.trial.loop import run_trial
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.order_file import BINS
from pickcli.trial.output_file import claim
from pickcli.trial.score import score, told_by_copies
from pickcli.trial.trial_interfaces import ExecutionResult
from pickcli.trial.trial_record import trial_record
from pickcli.trial.trial_result import Outcome, TrialResult
from pickcli.trial.trial_settings import TrialSettings
from pickcli.trial.trial_summary import rows, summary
from support.scripted_trial import ScriptedTrial, scene_of

CARDS, BAR, DVD = "staples_index_cards", "dove_beauty_bar", "jane_eyre_dvd"
CONTENTS = dict.fromkeys(BINS, (BAR,)) | {"bin_C": (BAR,) * 5, "bin_K": (BAR,) * 3}
ORDER = Order(OrderKind.STOW, 2016, CONTENTS, (DVD, CARDS, CARDS), ())
LOST = ExecutionResult(4.0, stopped="vacuum lost in transfer", has_item=False)


def play(fake: ScriptedTrial, **settings: object) -> TrialResult:
    return run_trial(ORDER, fake.interfaces(), TrialSettings(**settings))  # type: ignore[arg-type]


def test_everything_goes_into_the_bin_that_started_fullest(cell: Cell) -> None:
    result = play(ScriptedTrial(scene_of(ORDER, cell)))
    assert result.score.total == result.score.maximum == 60 and result.is_clean
    assert [t.outcome for t in result.targets] == [Outcome.DELIVERED] * 3
    assert [t.target.item for t in result.targets] == list(ORDER.tote_contents)
    assert result.final.claim == claim(ORDER, result.after.items)
    assert {row.into for row in rows(result)} == {"bin_C"}
    assert "score 60 of 60 by the rules of 2016; 3 of 3 items in bins" in summary(result)


def test_what_a_bin_does_not_take_goes_into_the_next(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), full=frozenset({"bin_C"}))
    result = play(fake)
    assert result.score.total == 45
    assert fake.asked[:2] == [(DVD, "bin_C"), (DVD, "bin_K")]


@pytest.mark.parametrize("is_first_elsewhere", [False, True])
def test_of_two_copies_each_row_has_the_points_of_its_own(cell: Cell, is_first_elsewhere: bool) -> None:
    scene = scene_of(ORDER, cell)
    copies = [placed.id for placed in scene.in_location(TOTE) if placed.item.name == CARDS]
    result = play(ScriptedTrial(scene))
    own = {attempt.item: row for row, target in enumerate(result.targets) for attempt in target.attempts}
    other = copies[0] if is_first_elsewhere else copies[1]
    final = replace(result.final, items=tuple(
        replace(item, end="bin_K") if item.id == other else item for item in result.final.items
    ))  # fmt: skip
    lines = told_by_copies(
        score(ORDER, final, {}), [target.target for target in result.targets],
        {row: item for item, row in own.items()},
    ).lines  # fmt: skip
    assert [line.points for line in lines[: len(own)]].count(15) == 1
    assert lines[own[other]].points == 15 and lines[own[other]].subject == other
    assert sorted(lines, key=str) == sorted(score(ORDER, final, {}).lines, key=str)


def test_what_does_not_come_out_of_the_tote_is_not_asked_of_every_bin(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), no_plan=frozenset({DVD}))
    result = play(fake)
    assert {into for item, into in fake.asked if item == DVD} == {"bin_C"}
    assert result.targets[0].outcome is Outcome.NO_PLAN and result.score.total == 40
    assert [a.item for a in result.attempts].count(DVD) <= 4 * MOST_REFUSALS_OF_STOW


def test_what_failed_is_tried_again_at_once_only_if_what_was_in_the_way_has_gone(cell: Cell) -> None:
    scene = scene_of(ORDER, cell)
    hopeless = play(ScriptedTrial(scene, no_plan=frozenset({DVD})))
    assert [a.target.item for a in hopeless.attempts][:4] == [DVD, CARDS, CARDS, DVD]
    first = next(placed.id for placed in scene.in_location(TOTE) if placed.item.name == CARDS)
    freed = play(ScriptedTrial(scene, blocked={DVD: first}))
    assert [a.target.item for a in freed.attempts] == [DVD, CARDS, DVD, CARDS]


def test_what_is_in_the_way_is_stowed_rather_than_moved_aside(cell: Cell) -> None:
    order = replace(ORDER, tote_contents=(CARDS, DVD))
    fake = ScriptedTrial(scene_of(order, cell), blocked={CARDS: DVD})
    result = run_trial(order, fake.interfaces(), TrialSettings())
    played = [(a.item, a.outcome, a.is_aside) for a in result.attempts if a.execution is not None]
    assert played == [(DVD, Outcome.DELIVERED, False), (CARDS, Outcome.DELIVERED, False)]


def test_what_cannot_leave_the_tote_is_not_moved_aside_for_one_target_after_the_other(cell: Cell) -> None:
    """Two lie under a third that has no plan: as the heap was seen once, that is asked for once."""
    scene = scene_of(ORDER, cell)
    under = [placed.id for placed in scene.in_location(TOTE) if placed.item.name == CARDS]
    fake = ScriptedTrial(scene, no_plan=frozenset({DVD}), blocked=dict.fromkeys(under, DVD))
    result = play(fake)
    looks = [tick.t for tick in result.ticks if tick.node == "look"]
    aside = [attempt.t_start for attempt in result.attempts if attempt.is_aside and attempt.item == DVD]
    seen_in = Counter(bisect_right(looks, t) for t in aside)  # how many looks there were before
    assert aside and max(seen_in.values()) == 1


@pytest.mark.parametrize("strategy", packaged_strategies())
@pytest.mark.parametrize("time_limit", [5.0, 10.0, 14.0])
def test_an_item_for_which_no_time_is_left_is_not_called_too_large(
    strategy: str, time_limit: float, cell: Cell
) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), no_plan=frozenset({DVD}))
    result = play(fake, strategy=load_strategy(strategy), time_limit=time_limit)
    assert not any("large enough" in attempt.reason for attempt in result.attempts)


def test_a_plan_that_the_verifier_refuses_leads_to_the_next_bin(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), rejects=frozenset({f"{DVD} into bin_C"}))
    result = play(fake)
    assert result.targets[0].into == "bin_K" and result.targets[0].points == 15


def test_what_is_lost_is_stowed_again_and_what_lies_outside_is_not(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), executions={DVD: [LOST]})
    assert play(fake).score.total == 60
    fake = ScriptedTrial(scene_of(ORDER, cell), executions={DVD: [LOST]})
    execute = fake.execute

    def drop(plan):  # type: ignore[no-untyped-def]
        done = execute(plan)
        if done is LOST:
            fake.put(DVD, OUTSIDE)
        return done

    fake.execute = drop  # type: ignore[method-assign]
    result = play(fake)
    assert result.targets[0].outcome is Outcome.MISSING and result.score.total == 40 - 10


def test_what_falls_into_another_bin_than_meant_is_stowed(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), executions={DVD: [LOST]})
    execute = fake.execute

    def slip(plan):  # type: ignore[no-untyped-def]
        done = execute(plan)
        if done is LOST:
            fake.put(DVD, "bin_K")
        return done

    fake.execute = slip  # type: ignore[method-assign]
    result = play(fake)
    assert result.targets[0].outcome is Outcome.DELIVERED and result.n_misjudged == 0
    assert result.score.total == 15 + 40


def test_what_lies_on_an_item_and_no_bin_takes_is_put_elsewhere_in_the_tote(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), blocked={DVD: CARDS}, full=frozenset(BINS))
    execute = fake.execute

    def uncover(plan):  # type: ignore[no-untyped-def]
        if plan.query == f"pick {CARDS}":
            fake.blocked.clear()
            fake.full = frozenset()
        return execute(plan)

    fake.execute = uncover  # type: ignore[method-assign]
    result = play(fake)
    aside = next(a for a in result.attempts if a.is_aside)
    assert (aside.item, aside.out_of, aside.into, aside.outcome) == (CARDS, TOTE, TOTE, Outcome.MOVED)
    assert result.score.total == 60


def test_what_stays_in_the_cup_of_no_vacuum_was_not_put_elsewhere(cell: Cell) -> None:
    fake = ScriptedTrial(
        scene_of(ORDER, cell), blocked={DVD: CARDS}, full=frozenset(BINS), executions={CARDS: [LOST] * 50}
    )
    result = play(fake)
    asides = [a for a in result.attempts if a.is_aside and a.item == CARDS]
    assert asides and all(a.outcome is not Outcome.MOVED for a in asides)


def test_same_seed_same_bytes_but_for_statistics(cell: Cell) -> None:
    def told(seed: int) -> str:
        fake = ScriptedTrial(scene_of(ORDER, cell), full=frozenset({"bin_C"}), executions={DVD: [LOST]})
        record = trial_record(play(fake, seed=seed), "order.json", 1.0)
        del record["statistics"]
        return json.dumps(record)

    assert told(3) == told(3) != told(4)
