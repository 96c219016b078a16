"""A tree of any kind of trial is ticked until it succeeds or fails, with each tick recorded."""

from __future__ import annotations

from collections.abc import Mapping

from pickcli.strategy.node_types import TrialKind
from pickcli.strategy.strategy_file import load_strategy
from pickcli.strategy.strategy_tree import Argument
from pickcli.strategy.tree_player import TreePlayer

CHAIN = ["enter_pallet", "lift_pallet", "drive load", "look_at_load"]
END = ["home_arm", "drive delivery", "set_down_pallet", "drive end"]


class Scripted:
    """Carries out a commission of two items; actions fail as often as they are scripted to."""

    def __init__(self, **failures: int) -> None:
        self.failures, self.done = failures, list[str]()
        self.open = ["a", "b"]
        self.chosen, self.loses = "", False
        self.now, self.time_left = 0.0, 100.0

    def run(self, name: str, arguments: Mapping[str, Argument]) -> tuple[bool, str]:
        label = " ".join([name, *map(str, arguments.values())])
        self.now += 1.0
        if name == "has_open_items":
            return bool(self.open), ""
        if name == "is_item_open":
            return self.chosen in self.open, ""
        self.done.append(label)
        key = label.replace(" ", "_")
        if self.failures.get(key, 0) > 0:
            self.failures[key] -= 1
            if name == "transfer_item" and self.loses:
                self.open.remove(self.chosen)
            return False, ""
        if name == "choose_item":
            self.chosen = self.open[0]
        if name in ("transfer_item", "skip_item") and self.chosen in self.open:
            self.open.remove(self.chosen)
        return True, ""


def played(scripted: Scripted) -> bool | None:
    player = TreePlayer(load_strategy("apple", TrialKind.COMMISSION).root, scripted)
    for _ in range(200):
        if (done := player.tick()) is not None:
            assert len(player.ticks) >= len(scripted.done)
            return done
    return None


def test_the_chain_of_apple_runs_from_pallet_to_end() -> None:
    scripted = Scripted()
    assert played(scripted) is True
    assert scripted.done == [*CHAIN, *["choose_item", "transfer_item"] * 2, *END]


def test_a_drive_is_tried_twice_and_then_the_arm_goes_home_and_all_ends() -> None:
    scripted = Scripted(drive_delivery=1)
    assert played(scripted) is True and scripted.done[-4:] == [
        "drive delivery", "drive delivery", "set_down_pallet", "drive end"
    ]  # fmt: skip
    scripted = Scripted(drive_delivery=2)
    played(scripted)
    assert scripted.done[-4:] == ["drive delivery", "drive delivery", "home_arm", "end_here"]


def test_an_item_is_looked_at_again_and_then_skipped() -> None:
    scripted = Scripted(transfer_item=2)
    assert played(scripted) is True
    first = ["choose_item", "transfer_item", "look_at_load", "transfer_item", "skip_item"]
    assert scripted.done == [*CHAIN, *first, "choose_item", "transfer_item", *END]


def test_an_item_that_is_lost_is_not_tried_again() -> None:
    scripted = Scripted(transfer_item=1)
    scripted.loses = True
    assert played(scripted) is True
    lost = ["choose_item", "transfer_item", "skip_item"]
    assert scripted.done == [*CHAIN, *lost, "choose_item", "transfer_item", *END]


def test_a_look_that_tells_of_a_bad_stand_has_the_truck_drive_again() -> None:
    scripted = Scripted(look_at_load=1)
    assert played(scripted) is True
    assert scripted.done[2:6] == ["drive load", "look_at_load", "drive load", "look_at_load"]
