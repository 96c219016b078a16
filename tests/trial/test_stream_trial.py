"""Trials of streams: every item is decided, with a reason, and the same trial gives the same record."""

from __future__ import annotations

from typing import Any

import pytest

from pickcli.random_scenes.make_stream import StreamRequest, make_stream
from pickcli.scene.item_stream import ItemStream
from pickcli.trial.stream_result import ItemOutcome, StreamTrialResult
from pickcli.trial.stream_trial import StreamTrialRequest, play_stream
from support.belt_picks import cell, context


def of(n: int, speed: float, gap: tuple[float, float], seed: int = 3) -> ItemStream:
    return make_stream(cell(), StreamRequest(n, speed, gap), seed)


@pytest.fixture(scope="module")
def result() -> StreamTrialResult:
    """Two items that come far apart, so that the arm has time for both."""
    return play_stream(StreamTrialRequest(of(2, 0.33, (2.0, 2.2))), context())


def test_items_that_come_far_apart_are_delivered(result: StreamTrialResult) -> None:
    assert result.is_clean and result.n_stops == 0
    assert [each.outcome for each in result.items] == [ItemOutcome.DELIVERED] * 2
    assert result.n_attempted == 2


def test_the_cup_meets_its_place_at_the_speed_of_the_belt(result: StreamTrialResult) -> None:
    for each in result.items:
        assert each.met is not None
        assert each.met.slip < 0.005 and each.met.offset < 0.008 and abs(each.met.late) < 0.05


def test_the_record_has_what_the_result_says(result: StreamTrialResult) -> None:
    record = result.record()
    assert (record["presented"], record["attempted"], record["delivered"]) == (2, 2, 2)
    assert (record["collisions"], record["limit_violations"]) == (0, 0)
    assert record["offset_m"]["worst"] == max(each.met.offset for each in result.items if each.met)


def test_the_same_trial_gives_the_same_record(result: StreamTrialResult) -> None:
    again = play_stream(StreamTrialRequest(of(2, 0.33, (2.0, 2.2))), context())
    assert _timeless(again.record()) == _timeless(result.record())


def _timeless(record: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in record.items() if key != "statistics"}


def test_what_comes_too_fast_is_not_attempted_and_says_why() -> None:
    items = of(3, 0.5, (0.03, 0.05))
    result = play_stream(StreamTrialRequest(items), context())
    left = [each for each in result.items if each.outcome is ItemOutcome.NOT_ATTEMPTED]
    assert left and all(each.reason and each.attempts == 0 and each.met is None for each in left)
    assert sum(map(result.count, ItemOutcome)) == 3


def test_from_a_belt_that_stands_all_items_are_taken() -> None:
    result = play_stream(StreamTrialRequest(of(2, 0.0, (0.2, 0.3))), context())
    assert result.count(ItemOutcome.DELIVERED) == 2 and result.is_clean
