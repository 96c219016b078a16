"""A trial topples what no tool can take as it stands, looks again, and goes on."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.errors import Reason
from pickcli.trial.loop import run_trial
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.order_file import BINS
from pickcli.trial.toppling_memory import MOST_JAMS, MOST_PUSHES, TopplingMemory
from pickcli.trial.trial_interfaces import ExecutionResult
from pickcli.trial.trial_record import trial_record
from pickcli.trial.trial_result import Attempt, Outcome, TrialResult
from pickcli.trial.trial_settings import TrialSettings
from support.scripted_trial import ScriptedTrial, scene_of

BAR, DVD, CARDS = "dove_beauty_bar", "jane_eyre_dvd", "staples_index_cards"
DUMBBELL = "fitness_gear_3lb_dumbbell"  # no vacuum holds it
STOW = Order(OrderKind.STOW, 2016, dict.fromkeys(BINS, (BAR,)), (DVD, CARDS), ())


def play(fake: ScriptedTrial) -> TrialResult:
    return run_trial(STOW, fake.interfaces(), TrialSettings(time_limit=2000.0))


def outcomes(result: TrialResult, item: str) -> list[Outcome]:
    return [attempt.outcome for attempt in result.attempts if attempt.item == item]


def test_it_is_toppled_after_the_first_attempt_and_then_delivered(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(STOW, cell), standing=frozenset({DVD}))
    result = play(fake)
    assert fake.toppled == [DVD]
    assert outcomes(result, DVD) == [Outcome.NO_PLAN, Outcome.TOPPLED, Outcome.DELIVERED]
    assert [target.outcome for target in result.targets] == [Outcome.DELIVERED] * 2


def test_the_record_says_what_was_done(cell: Cell) -> None:
    result = play(ScriptedTrial(scene_of(STOW, cell), standing=frozenset({DVD})))
    entry = next(a for a in trial_record(result, "o.json", 0.0)["attempts"] if a["outcome"] == "toppled")
    assert entry["plan"]["query"] == f"topple {DVD} in tote" and entry["plan"]["grasp"] is None
    assert (entry["out_of"], entry["into"], entry["is_aside"]) == ("tote", "tote", True)
    assert entry["topples"]


def test_what_needs_no_toppling_is_never_toppled(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(STOW, cell), no_plan=frozenset({DVD}))
    play(fake)
    assert fake.toppled == []


def test_without_effect_it_is_tried_a_few_times_only(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(STOW, cell), standing=frozenset({DVD}), firm=frozenset({DVD}))
    result = play(fake)
    assert outcomes(result, DVD).count(Outcome.NOT_TOPPLED) == MOST_JAMS == len(fake.toppled)
    assert any("tilted by 0 degrees" in a.reason or "tilted by 1" in a.reason for a in result.attempts)


def test_what_cannot_be_toppled_is_asked_again_only_after_something_moved(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(STOW, cell), standing=frozenset({DVD}), fixed=frozenset({DVD}))
    result = play(fake)
    n_executed = sum(attempt.execution is not None for attempt in result.attempts)
    assert 1 <= len(fake.toppled) <= 1 + n_executed
    assert result.targets[-1].outcome is Outcome.DELIVERED or result.targets[0].outcome is Outcome.DELIVERED


def test_what_stands_and_is_in_the_way_is_toppled_for_the_one_behind(cell: Cell) -> None:
    fake = ScriptedTrial(
        scene_of(STOW, cell), standing=frozenset({CARDS}), blocked={DVD: CARDS}, fixed=frozenset()
    )
    result = play(fake)
    assert fake.toppled == [CARDS]
    assert [target.outcome for target in result.targets] == [Outcome.DELIVERED] * 2


def test_what_no_tool_holds_is_pushed_where_it_is_in_the_way_only(cell: Cell) -> None:
    order = replace(STOW, tote_contents=(DVD, CARDS, DUMBBELL))
    fake = ScriptedTrial(scene_of(order, cell), no_plan=frozenset({DUMBBELL}), blocked={DVD: DUMBBELL})
    run_trial(order, fake.interfaces(), TrialSettings(time_limit=2000.0))
    assert set(fake.toppled) == {DUMBBELL} and 1 <= len(fake.toppled) <= MOST_PUSHES
    first = next(plan for plan in fake.executed if plan.query.startswith("topple"))
    assert fake.executed.index(first) <= 1  # after the cards at the latest
    alone = ScriptedTrial(scene_of(order, cell), no_plan=frozenset({DUMBBELL}))
    run_trial(order, alone.interfaces(), TrialSettings(time_limit=2000.0))
    assert not alone.toppled


def test_what_is_pushed_elsewhere_counts_as_moved(cell: Cell) -> None:
    fake = ScriptedTrial(
        scene_of(STOW, cell), standing=frozenset({DVD}), firm=frozenset({DVD}), sliding={DVD: 0.05}
    )
    assert Outcome.MOVED in outcomes(play(fake), DVD)
    fake = ScriptedTrial(
        scene_of(STOW, cell), standing=frozenset({DVD}), firm=frozenset({DVD}), sliding={DVD: 0.005}
    )
    assert {Outcome.NO_PLAN, Outcome.NOT_TOPPLED} == set(outcomes(play(fake), DVD))


def test_a_stopped_push_is_recovered_from(cell: Cell) -> None:
    stopped = ExecutionResult(2.0, stopped="unexpected contact", path_time=1.0)
    fake = ScriptedTrial(
        scene_of(STOW, cell), standing=frozenset({DVD}), firm=frozenset({DVD}),
        executions={f"topple {DVD} in tote": [stopped]},
    )  # fmt: skip
    result = play(fake)
    first = next(a for a in result.attempts if a.outcome is Outcome.NOT_TOPPLED)
    assert first.reason.startswith("unexpected contact; ") and first.recovery
    executed = [a for a in result.attempts if a.execution is not None]
    assert executed[executed.index(first) + 1].item != DVD, "it would jam again before something else moves"


def test_what_jams_is_pushed_a_few_times_only_and_not_as_long_as_nothing_else_moves(cell: Cell) -> None:
    memory, placed, tote = TopplingMemory(), scene_of(STOW, cell).find(DVD), cell.places["tote"]
    push = Attempt(
        STOW.targets[0], DVD, 1, 0.0, Outcome.NOT_TOPPLED, out_of="tote", topples=True,
        execution=ExecutionResult(2.0, stopped="unexpected contact"),
    )  # fmt: skip
    other = Attempt(STOW.targets[1], CARDS, 1, 0.0, Outcome.DELIVERED, execution=ExecutionResult(2.0))
    for _ in range(MOST_JAMS):
        memory.note(other)
        assert memory.is_due(placed, tote, can_be_held=False)
        memory.note(push)
        assert not memory.is_due(placed, tote, can_be_held=False)
    memory.note(other)
    assert not memory.is_due(placed, tote, can_be_held=False)


@pytest.mark.parametrize(("n_standing", "n_other", "is_due"), [(3, 1, True), (1, 3, False), (0, 2, False)])
def test_most_reasons_must_be_its_pose(cell: Cell, n_standing: int, n_other: int, is_due: bool) -> None:
    memory, placed = TopplingMemory(), scene_of(STOW, cell).find(DVD)
    against_walls = Reason("collision", "grasp 1, contact", "wrist against shelf")
    others = Reason("collision", "grasp 2, contact", "cup against cards", CARDS)
    reasons = (Reason("tips the item", ""), against_walls, against_walls)[:n_standing] + (others,) * n_other
    memory.note(Attempt(STOW.targets[0], DVD, 1, 0.0, Outcome.NO_PLAN, out_of="tote", reasons=reasons))
    assert memory.is_due(placed, cell.places["tote"]) is is_due
    assert memory.is_due(placed, cell.places["bin_A"]) is is_due
    assert not memory.is_due(placed, cell.places["bin_A"], can_be_held=False)
    assert memory.is_due(placed, cell.places["tote"], can_be_held=False)


def test_in_a_bin_walls_around_the_way_to_it_count(cell: Cell) -> None:
    memory, placed = TopplingMemory(), scene_of(STOW, cell).find(DVD)
    reason = Reason("no room for the tool", "side grasp, approach", "lance against post_left")
    memory.note(Attempt(STOW.targets[0], DVD, 1, 0.0, Outcome.NO_PLAN, out_of="bin_A", reasons=(reason,)))
    assert memory.is_due(placed, cell.places["bin_A"])
    assert not memory.is_due(placed, cell.places["tote"])


def test_what_blocks_a_turn_is_known_until_something_moves(cell: Cell) -> None:
    memory = TopplingMemory()
    refused = Attempt(
        STOW.targets[0], DVD, 1, 0.0, Outcome.NO_PLAN, out_of="bin_A", topples=True, in_the_way=(CARDS,)
    )
    memory.note(refused)
    assert memory.blocking == {DVD: (CARDS,)} and DVD in memory.in_vain
    memory.note(Attempt(STOW.targets[1], CARDS, 1, 0.0, Outcome.MOVED, execution=ExecutionResult(2.0)))
    assert not memory.blocking and not memory.in_vain


def test_without_a_tool_that_pushes_nothing_is_toppled() -> None:
    """As in a cell whose cups have no lance."""
    kth = load_cell("apc2016_kth_picking", arm="left")
    fake = ScriptedTrial(scene_of(STOW, kth), standing=frozenset({DVD}))
    play(fake)
    assert fake.toppled == []
