"""An item of a bin makes room for one of the tote, if that is all that keeps it from being stowed."""

from __future__ import annotations

from dataclasses import replace

from pickcli.cell.cell import Cell
from pickcli.errors import NoPlanError, Reason
from pickcli.motion.plan import Certify, Plan
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, Scene
from pickcli.trial.loop import run_trial
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.order_file import BINS
from pickcli.trial.room_making import MOST_TRIED
from pickcli.trial.trial_interfaces import TrialInterfaces
from pickcli.trial.trial_result import Outcome, TrialResult
from pickcli.trial.trial_settings import TrialSettings
from support.scripted_trial import ScriptedTrial, scene_of

BAR, DVD, CARDS = "dove_beauty_bar", "jane_eyre_dvd", "staples_index_cards"
ORDER = Order(OrderKind.STOW, 2016, dict.fromkeys(BINS, (BAR,)), (DVD, CARDS), ())


def crowded(fake: ScriptedTrial, item: str, most: int) -> TrialInterfaces:
    """The item finds a place on the floor of a bin only if at most so many others are there."""

    def plan(scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        if query.item == item and query.into != TOTE and len(scene.in_location(query.into)) > most:
            fake.asked.append((item, query.into))
            raise NoPlanError(f"pick {item}", [Reason("no free place on the floor", query.into)])
        return fake.plan(scene, query, start, seed, certify)

    return replace(fake.interfaces(), plan=plan)


def played(fake: ScriptedTrial, most: int) -> TrialResult:
    return run_trial(ORDER, crowded(fake, DVD, most), TrialSettings())


def outcome(result: TrialResult, item: str) -> Outcome:
    return next(target.outcome for target in result.targets if target.target.item == item)


def test_one_item_moves_to_another_bin_and_the_other_takes_its_place(cell: Cell) -> None:
    result = played(ScriptedTrial(scene_of(ORDER, cell)), most=0)
    assert outcome(result, DVD) is outcome(result, CARDS) is Outcome.DELIVERED
    moved = [attempt for attempt in result.attempts if attempt.is_aside and attempt.plan is not None]
    assert [attempt.outcome for attempt in moved] == [Outcome.MOVED]
    stowed = next(a for a in result.attempts if a.item == DVD and a.outcome is Outcome.DELIVERED)
    assert moved[0].item.startswith(BAR) and moved[0].out_of == stowed.into
    assert moved[0].into in BINS and moved[0].into != stowed.into
    assert result.after.find(moved[0].item).location == moved[0].into


def test_nothing_is_moved_for_what_cannot_leave_the_tote(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), no_plan=frozenset({DVD}))
    result = run_trial(ORDER, fake.interfaces(), TrialSettings())
    assert outcome(result, DVD) is Outcome.NO_PLAN
    assert not any(item.startswith(BAR) for item, _ in fake.asked)


def test_nothing_is_moved_where_it_would_not_help_and_that_is_asked_once(cell: Cell) -> None:
    """No bin takes the item, however empty it is: the items tried are few, and not tried again."""
    fake = ScriptedTrial(scene_of(ORDER, cell))
    result = played(fake, most=-1)
    assert outcome(result, DVD) is Outcome.NO_PLAN
    assert not any(item.startswith(BAR) for item, _ in fake.asked)
    n_attempts = sum(attempt.item == DVD and not attempt.is_aside for attempt in result.attempts)
    assert fake.asked.count((DVD, "bin_A")) <= n_attempts + MOST_TRIED


def test_what_has_no_other_bin_stays(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), full=frozenset(BINS))
    result = played(fake, most=0)
    assert outcome(result, DVD) is Outcome.NO_PLAN
    assert not any(a.outcome is Outcome.MOVED and a.item.startswith(BAR) for a in result.attempts)


POINTS = Order(
    OrderKind.STOW, 2016,
    {name: (BAR,) * (5 if name in ("bin_A", "bin_B") else 1) for name in BINS}, (DVD, CARDS), (),
)  # fmt: skip


def exchanged(fake: ScriptedTrial, most: int, time_limit: float | None = None) -> TrialResult:
    return run_trial(POINTS, crowded(fake, DVD, most), TrialSettings(time_limit=time_limit))


def where(result: TrialResult, item: str) -> str:
    return next(placed.location for placed in result.after.items if placed.item.name == item)


def test_an_item_moves_out_of_a_bin_in_which_another_gives_more_points(cell: Cell) -> None:
    result = exchanged(ScriptedTrial(scene_of(POINTS, cell)), most=4)
    assert where(result, DVD) in ("bin_A", "bin_B")
    moved = [attempt for attempt in result.attempts if attempt.is_aside]
    assert [attempt.outcome for attempt in moved] == [Outcome.MOVED] and moved[0].out_of == where(result, DVD)
    assert result.score.total == result.score.maximum


def test_no_time_is_spent_on_points_that_open_targets_may_need(cell: Cell) -> None:
    result = exchanged(ScriptedTrial(scene_of(POINTS, cell)), most=4, time_limit=60.0)
    assert outcome(result, DVD) is Outcome.DELIVERED and where(result, DVD) not in ("bin_A", "bin_B")
    assert not any(attempt.is_aside for attempt in result.attempts)


def test_what_was_stowed_stays_where_it_gives_its_points(cell: Cell) -> None:
    """The DVD could take the place of nothing but the cards, which were stowed before."""
    order = replace(POINTS, bin_contents={name: (BAR,) * (5 if name == "bin_A" else 1) for name in BINS})
    fake = ScriptedTrial(scene_of(order, cell))

    def plan(scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        has_cards = CARDS in {placed.item.name for placed in scene.in_location("bin_A")}
        if query.item == DVD and (not fake.executed or (has_cards and query.into == "bin_A")):
            fake.asked.append((DVD, "bin_A"))
            raise NoPlanError(f"pick {DVD}", [Reason("no free place on the floor", query.into)])
        return fake.plan(scene, query, start, seed, certify)

    result = run_trial(order, replace(fake.interfaces(), plan=plan), TrialSettings())
    assert where(result, CARDS) == "bin_A" and where(result, DVD) != "bin_A"
    assert (DVD, "bin_A") in fake.asked
    assert not any(attempt.is_aside for attempt in result.attempts)
