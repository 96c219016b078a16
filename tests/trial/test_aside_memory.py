"""What was moved aside for a target that is still open is neither brought back nor shuffled again."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import NoExtractionError, NoPlanError, Reason
from pickcli.motion.plan import Certify, Plan
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, Scene
from pickcli.trial.loop import run_trial
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.order_file import BINS
from pickcli.trial.trial_result import Outcome, TrialResult
from pickcli.trial.trial_settings import TrialSettings
from support.order_builders import pick_order
from support.scripted_trial import ScriptedTrial, scene_of

FIRST, SECOND, BETWEEN = "crayola_24_ct", "dasani_water_bottle", "jane_eyre_dvd"
CARDS, BAR = "staples_index_cards", "dove_beauty_bar"


def moves_of(result: TrialResult, item: str) -> list[tuple[str, str]]:
    moved = (attempt for attempt in result.attempts if attempt.outcome is Outcome.MOVED)
    return [(attempt.out_of, attempt.into) for attempt in moved if attempt.item == item]


class Misjudged(ScriptedTrial):
    """Two targets have a plan only where an item is thought away, wherever that item lies."""

    def plan(self, scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        if query.item in (FIRST, SECOND) and BETWEEN in {placed.id for placed in scene.items}:
            here = {placed.id for placed in scene.in_location(query.out_of)}
            blamed = BETWEEN if BETWEEN in here else ""
            raise NoExtractionError("pick", [Reason("collision", "lift", "", blamed)])
        return super().plan(scene, query, start, seed, certify)


# A target waits in every bin; those beside the first two take nothing, and hold more.
OTHERS = tuple(name for name in BINS if name not in ("bin_A", "bin_B"))
ORDER = pick_order(
    {"bin_A": (FIRST, BETWEEN), "bin_B": (SECOND,), **dict.fromkeys(OTHERS, (BAR, BAR, BAR))},
    ("bin_A", FIRST),
    ("bin_B", SECOND),
    *((name, BAR) for name in OTHERS),
)
BARS = frozenset({BAR, *(f"{BAR}#{k}" for k in range(2, 31))})


def test_no_item_comes_back_to_a_bin_that_it_left_for_a_target_that_waits_there(cell: Cell) -> None:
    fake = Misjudged(scene_of(ORDER, cell), full=frozenset(OTHERS), no_plan=BARS)
    result = run_trial(ORDER, fake.interfaces(), TrialSettings())
    assert moves_of(result, BETWEEN) == [("bin_A", "bin_B"), ("bin_B", TOTE)]


def test_an_item_may_come_back_once_the_target_is_delivered(cell: Cell) -> None:
    """It makes room for the first, which is picked then, and goes back to where that was for the second."""
    blocked = {FIRST: BETWEEN, SECOND: BETWEEN}
    fake = ScriptedTrial(scene_of(ORDER, cell), full=frozenset(OTHERS), no_plan=BARS, blocked=blocked)
    plan = fake.plan

    def first_before_second(
        scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify
    ) -> Plan:
        if query.item == SECOND and fake.scene.find(FIRST).location != TOTE:
            raise NoExtractionError("pick", [Reason("collision", "lift", "")])
        return plan(scene, query, start, seed, certify)

    result = run_trial(ORDER, replace(fake.interfaces(), plan=first_before_second), TrialSettings())
    assert moves_of(result, BETWEEN) == [("bin_A", "bin_B"), ("bin_B", "bin_A")]
    assert result.items_in_tote == 2


@pytest.mark.parametrize(("is_delivered", "n_moves"), [(False, 1), (True, 2)])
def test_the_heap_is_shuffled_again_only_once_something_has_left_it(
    cell: Cell, is_delivered: bool, n_moves: int
) -> None:
    """No bin takes the film, and the cards wait for it to leave the tote; a bar may leave in between."""
    order = Order(OrderKind.STOW, 2016, dict.fromkeys(BINS, (BAR,)), (BETWEEN, CARDS, FIRST), ())
    fake = ScriptedTrial(scene_of(order, cell), blocked={CARDS: BETWEEN})

    def plan(scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        if query.item == BETWEEN and query.into != TOTE:
            raise NoPlanError("pick", [Reason("no free place on the floor", query.into)])
        was_moved = any(each.query == f"pick {BETWEEN}" for each in fake.executed)
        if query.item == FIRST and not (is_delivered and was_moved):
            raise NoExtractionError("pick", [Reason("no face within reach", FIRST)])
        return fake.plan(scene, query, start, seed, certify)

    result = run_trial(order, replace(fake.interfaces(), plan=plan), TrialSettings())
    assert moves_of(result, BETWEEN) == [(TOTE, TOTE)] * n_moves
    assert result.items_in_tote == is_delivered
