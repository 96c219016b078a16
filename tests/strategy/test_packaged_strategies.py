"""The packaged strategies, played against outcomes that are written by hand."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.strategy.node_types import ActionKind
from pickcli.strategy.strategy_file import load_strategy, packaged_strategies
from pickcli.strategy.strategy_player import StrategyPlayer
from support.scripted_actions import ACTION_TIME, ScriptedActions, scripted


def played(name: str, actions: ScriptedActions) -> list[str]:
    player = StrategyPlayer(load_strategy(name), actions)
    player.play()
    assert player.stuck == ""
    return actions.calls


def test_delft_brings_every_target_in_turn_with_the_fewest_neighbours_first() -> None:
    actions = scripted({0: "d", 1: "d", 2: "d"}, n_items={0: 5, 1: 2, 2: 2})
    assert played("delft", actions) == ["pick 1", "pick 2", "pick 0"]


def test_delft_moves_what_is_in_the_way_and_picks_again_at_once() -> None:
    actions = scripted({0: "nmd", 1: "d"})
    assert played("delft", actions) == ["pick 0", "clear 0", "pick 0", "pick 1"]


def test_delft_retries_failed_picks_after_all_others_without_limit() -> None:
    actions = scripted({0: "fffd", 1: "d"})
    assert played("delft", actions) == ["pick 0", "pick 1", "pick 0", "pick 0", "pick 0"]


def test_delft_looks_again_before_it_plans_in_a_scene_without_a_plan() -> None:
    actions = scripted({0: "nsd"})
    assert played("delft", actions) == ["pick 0", "clear 0", "look", "pick 0"]


def test_kth_follows_its_lists_of_objects_and_bins() -> None:
    items = {0: "jane_eyre_dvd", 1: "crayola_24_ct", 2: "unlisted", 3: "crayola_24_ct"}
    bins = {0: "bin_A", 1: "bin_L", 2: "bin_A", 3: "bin_B"}
    actions = scripted(dict.fromkeys(items, "d"), item=items, bin=bins)
    assert played("kth", actions) == ["pick 3", "pick 1", "pick 0", "pick 2"]


def test_kth_looks_more_often_before_every_attempt_and_gives_up_after_the_third() -> None:
    actions = scripted({0: "fff", 1: "d"}, bin={0: "bin_A", 1: "bin_B"})
    assert played("kth", actions) == [
        "pick 0", "look", "pick 0", "look", "look", "pick 0", "give up 0", "pick 1",
    ]  # fmt: skip


def test_kth_moves_nothing_aside() -> None:
    actions = scripted({0: "nnn"})
    calls = played("kth", actions)
    assert "pick 0" in calls and not any(call.startswith("clear") for call in calls)


def test_points_takes_what_promises_most_and_learns_from_failures() -> None:
    """Each failure of the script halves what its target promises."""
    rates = {0: {ActionKind.PICK: 1.0}, 1: {ActionKind.PICK: 0.4}}
    actions = scripted({0: "ffd", 1: "d"}, rates=rates)
    assert played("points", actions) == ["pick 0", "pick 0", "pick 1", "pick 0"]


@pytest.mark.parametrize("name", packaged_strategies())
@given(outcomes=st.dictionaries(st.integers(0, 5), st.text("dfnms", max_size=6), max_size=6))
def test_every_strategy_ends_in_time_whatever_happens(name: str, outcomes: dict[int, str]) -> None:
    actions = scripted(outcomes, limit=300.0)
    played(name, actions)
    assert actions.now <= actions.limit + 2 * ACTION_TIME + 5.0  # what was begun in time is finished


@pytest.mark.parametrize("name", packaged_strategies())
@given(outcomes=st.dictionaries(st.integers(0, 5), st.text("dfnms", max_size=6), max_size=6))
def test_every_action_is_among_the_ticks_with_its_target(name: str, outcomes: dict[int, str]) -> None:
    actions = scripted(outcomes, limit=200.0)
    player = StrategyPlayer(load_strategy(name), actions)
    player.play()
    ticks = iter([(tick.node, tick.target) for tick in player.ticks])
    for call in actions.calls:  # all are found in this order
        verb, _, index = call.partition(" ")
        if verb in ("pick", "clear"):
            assert (verb, f"bin_{index} item_{index}") in ticks
    assert [tick.t for tick in player.ticks] == sorted(tick.t for tick in player.ticks)
