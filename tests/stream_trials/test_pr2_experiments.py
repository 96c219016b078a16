"""The two experiments of the PR2 paper of 2013 (Cowley et al.), by the first items of each stream."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pickcli.cell.data_path import data_path
from pickcli.planning.pick_settings import DropPlace
from pickcli.scene.stream_file import read_stream
from pickcli.stream_trials.stream_result import ItemOutcome
from pickcli.stream_trials.stream_trial import play_stream
from pickcli.stream_trials.stream_trial_request import StreamTrialRequest
from support.pr2_picks import context


@pytest.mark.slow
@pytest.mark.parametrize(("name", "speed"), [("pr2_belt_static", 0.0), ("pr2_belt_moving", 0.33)])
def test_the_first_items_are_taken_off_the_belt(name: str, speed: float) -> None:
    stream = read_stream(data_path() / "tasks" / f"{name}.json", context("left").cell)
    assert (len(stream.items), stream.speed, stream.one_by_one) == (100, speed, speed == 0.0)
    contexts = [context(arm).dropping_from(DropPlace.RIM) for arm in ("left", "right")]
    few = replace(stream, items=stream.items[:3])
    result = play_stream(StreamTrialRequest(few, seed=1), contexts).result
    assert result.is_clean and result.n_stops == 0
    assert result.count(ItemOutcome.DELIVERED) >= 2
    assert all(each.arm and each.met for each in result.items if each.outcome is ItemOutcome.DELIVERED)


@pytest.mark.slow
def test_the_right_arm_takes_what_only_it_reaches() -> None:
    stream = read_stream(data_path() / "tasks" / "pr2_belt_static.json", context("left").cell)
    far = next(each for each in stream.items if each.T_belt_item[0, 3] > 1.45)
    contexts = [context(arm).dropping_from(DropPlace.RIM) for arm in ("left", "right")]
    (told,) = play_stream(StreamTrialRequest(replace(stream, items=(far,))), contexts).result.items
    assert (told.outcome, told.arm) == (ItemOutcome.DELIVERED, "right")
