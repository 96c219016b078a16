"""Out of a heap a trial plans to push what is in the way, if there is no plan that avoids it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import NoExtractionError, NoPlanError, Reason
from pickcli.geometry import pose
from pickcli.motion.plan import Certify, Plan
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.pick_settings import Neighbours
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, Scene
from pickcli.trial.loop import run_trial
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.order_file import BINS
from pickcli.trial.trial_record import trial_record
from pickcli.trial.trial_result import Outcome
from pickcli.trial.trial_settings import TrialSettings
from support.order_builders import pick_order
from support.scripted_trial import ScriptedTrial, scene_of

BAR, DVD, CARDS = "dove_beauty_bar", "jane_eyre_dvd", "staples_index_cards"
BOX = "kleenex_tissue_box"
STOW = Order(OrderKind.STOW, 2016, dict.fromkeys(BINS, (BAR,)), (DVD, CARDS), ())
PICK = pick_order({"bin_A": (DVD, CARDS)}, ("bin_A", DVD))


@pytest.mark.parametrize("needs_push", [True, False])
def test_it_is_planned_after_what_avoids_and_is_charged(cell: Cell, needs_push: bool) -> None:
    fake = ScriptedTrial(scene_of(STOW, cell), heaped={DVD: CARDS} if needs_push else {})
    result = run_trial(STOW, fake.interfaces(), TrialSettings())
    ways = [way for item, way in fake.ways if item == DVD]
    assert ways == [Neighbours.AVOID, Neighbours.PUSH][: 1 + needs_push]
    assert [target.outcome for target in result.targets] == [Outcome.DELIVERED] * 2
    assert len(fake.ways) == 2 + needs_push
    pushed = [
        a["plan"]["pushing"] for a in trial_record(result, "o.json", 0.0)["attempts"] if a["item"] == DVD
    ]
    assert pushed == [[CARDS] if needs_push else []]


def test_what_lies_in_a_bin_is_never_pushed(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(PICK, cell), heaped={DVD: CARDS})
    run_trial(PICK, fake.interfaces(), TrialSettings())
    assert (DVD, Neighbours.AVOID) in fake.ways
    assert all(way is Neighbours.AVOID for _, way in fake.ways)


def test_nothing_is_pushed_for_what_no_item_is_in_the_way_of(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(STOW, cell), no_plan=frozenset({DVD}))
    run_trial(STOW, fake.interfaces(), TrialSettings())
    assert (DVD, Neighbours.AVOID) in fake.ways
    assert all(way is Neighbours.AVOID for _, way in fake.ways)


def failure(query: PickQuery) -> NoPlanError:
    """In a heap, of an item whose bin is full; no grasp of it holds what is pushed."""
    if query.neighbours is Neighbours.PUSH:
        return NoExtractionError("pick", [Reason("does not hold", "lift")])
    full = Reason("no free place", query.into)
    return NoPlanError("pick", [Reason("collision", "lift", "", CARDS), full])


def test_a_push_that_fails_hides_no_reason_and_closes_no_other_bin(cell: Cell) -> None:
    """The first bin is full: that other grasps do not hold what is pushed does not change it."""
    fake = ScriptedTrial(scene_of(STOW, cell))
    full: list[str] = []

    def plan(scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        if query.item != DVD or query.into not in (full or (query.into,)):
            return fake.plan(scene, query, start, seed, certify)
        full.append(query.into)
        fake.ways.append((DVD, query.neighbours))
        raise failure(query)

    result = run_trial(STOW, replace(fake.interfaces(), plan=plan), TrialSettings())
    assert [way for item, way in fake.ways if item == DVD][:2] == [Neighbours.AVOID, Neighbours.PUSH]
    into = [attempt.into for attempt in result.attempts if attempt.item == DVD]
    assert into and into[-1] not in full
    assert [target.outcome for target in result.targets] == [Outcome.DELIVERED] * 2


def test_where_every_bin_fails_the_reasons_of_both_calls_are_told(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(STOW, cell))

    def plan(scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        if query.item != DVD:
            return fake.plan(scene, query, start, seed, certify)
        raise failure(query)

    result = run_trial(STOW, replace(fake.interfaces(), plan=plan), TrialSettings())
    first = next(attempt for attempt in result.attempts if attempt.item == DVD)
    assert [reason.what for reason in first.reasons] == ["collision", "no free place", "does not hold"]
    assert first.in_the_way == (CARDS,) and first.has_way_out


def test_what_others_lean_on_is_planned_to_push_them_first(cell: Cell) -> None:
    """As it is lifted friction may take them along."""
    order = Order(OrderKind.STOW, 2016, dict.fromkeys(BINS, (BAR,)), (BOX, DVD), ())
    scene = scene_of(order, cell)
    T_tote, lean = cell.T_world_place(cell.places[TOTE]), 0.65
    thin, tall = (float(cell.item(DVD).shape.extents[k]) for k in (2, 1))
    reach, height = (float(cell.item(BOX).shape.extents[k]) / 2 for k in (1, 2))
    y = -(reach + np.sin(lean) * tall / 2 + np.cos(lean) * thin / 2)
    z = np.cos(lean) * tall / 2 + np.sin(lean) * thin / 2
    at = {
        BOX: T_tote @ pose((0.0, 0.0, height)),
        DVD: T_tote @ pose((0.0, y, z), rpy=(np.pi / 2 - lean, 0.0, 0.0)),
    }
    items = tuple(replace(p, T_world_item=at.get(p.id, p.T_world_item)) for p in scene.items)
    fake = ScriptedTrial(replace(scene, items=items))
    run_trial(order, fake.interfaces(), TrialSettings())
    assert next(way for item, way in fake.ways if item == BOX) is Neighbours.PUSH
    assert next(way for item, way in fake.ways if item == DVD) is Neighbours.AVOID
