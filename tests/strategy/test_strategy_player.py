"""Control nodes and decorators do what behaviour trees say, with the trial's clock as the only clock."""

from __future__ import annotations

from pathlib import Path

from pickcli.strategy.strategy_file import read_strategy
from pickcli.strategy.strategy_player import MAX_IDLE_TICKS, StrategyPlayer
from support.scripted_actions import ScriptedActions, scripted

HEAD = "format: apc strategy\nversion: 1\nname: own\ndescription: made for a test\ntree:\n"


def played(tree: str, actions: ScriptedActions, tmp_path: Path) -> StrategyPlayer:
    path = tmp_path / "own.yaml"
    path.write_text(HEAD + "".join(f"  {line}\n" for line in tree.strip("\n").split("\n")))
    player = StrategyPlayer(read_strategy(path), actions)
    player.play()
    return player


def test_a_retry_goes_on_at_its_child_until_it_succeeds_or_its_attempts_are_used_up(tmp_path: Path) -> None:
    tree = """
sequence:
  - choose_target: {by: [order]}
  - fallback:
      - {retry: {attempts: 3, child: pick}}
      - give_up
"""
    actions = scripted({0: "ffd", 1: "fff"})
    played(tree, actions, tmp_path)
    assert actions.calls == ["pick 0"] * 3 + ["pick 1"] * 3 + ["give up 1"]


def test_a_deadline_is_one_of_the_trials_clock(tmp_path: Path) -> None:
    tree = """
sequence:
  - has_time_to_plan
  - choose_target: {by: [order]}
  - fallback:
      - {deadline: {seconds_left: 75, child: pick}}
      - give_up
"""
    actions = scripted({0: "ffffffffff"}, limit=100.0)
    played(tree, actions, tmp_path)
    assert actions.calls == [
        "pick 0",
        "give up 0",
    ]  # the tree fails at the first failed pick, 90 s before the end


def test_a_tree_that_tries_nothing_is_ended(tmp_path: Path) -> None:
    player = played("sequence: [has_time_to_plan]", scripted({0: "d"}), tmp_path)
    assert str(MAX_IDLE_TICKS) in player.stuck and len(player.ticks) == MAX_IDLE_TICKS


def test_a_tree_that_only_looks_is_ended_long_before_the_trial(tmp_path: Path) -> None:
    actions = scripted({0: "d"}, limit=1e5)
    player = played("look", actions, tmp_path)
    assert player.stuck and len(player.ticks) == MAX_IDLE_TICKS and actions.now < 1e4


def test_inverted_and_forced_results_are_those_of_the_child(tmp_path: Path) -> None:
    tree = """
sequence:
  - choose_target: {by: [order], attempts_below: 2}
  - force_success: {child: pick}
  - invert: {child: {attempts_below: {count: 2}}}
"""
    actions = scripted({0: "ffff"})
    player = played(tree, actions, tmp_path)
    assert actions.calls == ["pick 0"]  # one attempt is below two: inverted, that fails
    assert [(t.node, t.is_success) for t in player.ticks] == [
        ("choose_target (by order, attempts_below 2)", True),
        ("pick", False),
        ("attempts_below (count 2)", True),
    ]


def test_without_a_chosen_target_nothing_is_picked(tmp_path: Path) -> None:
    actions = scripted({0: "d"})
    played("sequence: [pick]", actions, tmp_path)
    played("sequence: [clear]", actions, tmp_path)
    assert actions.calls == []
