"""Orders that name moves from place to place: read, played with the machinery of picks, counted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.errors import InputError
from pickcli.scene.scene import PlacedItem
from pickcli.trial.final_state import FinalItem, FinalState
from pickcli.trial.loop import run_trial
from pickcli.trial.order import MOVE_TIME, Order, OrderKind, Target
from pickcli.trial.order_file import read_order
from pickcli.trial.score import score
from pickcli.trial.trial_result import Outcome, TrialResult
from support.scripted_trial import ScriptedTrial, scene_of

BAR, WAX = "dove_beauty_bar", "crayola_24_ct"


def order_of(contents: dict[str, tuple[str, ...]], *moves: tuple[str, str, str]) -> Order:
    return Order(OrderKind.MOVE, 2016, contents, (), tuple(Target(*move) for move in moves))


def written(folder: Path, contents: dict[str, Any], *moves: tuple[str, str, str]) -> Path:
    """The file of an order."""
    path = folder / "moves.json"
    listed = [dict(zip(("from", "item", "to"), move, strict=True)) for move in moves]
    path.write_text(json.dumps({"contents": contents, "moves": listed}))
    return path


def played(order: Order, cell: Cell, **script: Any) -> tuple[TrialResult, dict[str, PlacedItem]]:
    trial = ScriptedTrial(scene_of(order, cell), **script)
    result = run_trial(order, trial.interfaces())
    return result, {placed.id: placed for placed in trial.scene.items}


# Files


def test_moves_are_read(cell: Cell, tmp_path: Path) -> None:
    path = written(
        tmp_path, {"bin_A": [BAR, BAR], "tote": [WAX]}, ("bin_A", BAR, "tote"), ("tote", WAX, "bin_B")
    )
    assert read_order(path, cell) == order_of(
        {"bin_A": (BAR, BAR), "tote": (WAX,)}, ("bin_A", BAR, "tote"), ("tote", WAX, "bin_B")
    )


@pytest.mark.parametrize(
    ("contents", "move", "told"),
    [
        ({"bin_A": [BAR]}, ("bin_B", BAR, "tote"), "is not there (it is in bin_A)"),
        ({"bin_A": [BAR]}, ("bin_A", WAX, "tote"), "is not there (it is in no bin)"),
        (
            {"bin_A": [BAR]},
            ("bin_A", BAR, "totee"),
            "moves[0].to: unknown place 'totee'; did you mean 'tote'",
        ),
        ({"bin_A": [BAR]}, ("bin_A", BAR, "bin_A"), "is in bin_A already"),
        ({"bin_Z": [BAR]}, ("bin_A", BAR, "tote"), "contents.bin_Z: unknown place 'bin_Z'"),
        ({"bin_A": ["bar"]}, ("bin_A", BAR, "tote"), "contents.bin_A[0]: unknown item 'bar'"),
        ({"bin_A": BAR}, ("bin_A", BAR, "tote"), "contents.bin_A"),
    ],
)
def test_mistakes_in_moves_are_told(
    contents: dict[str, Any], move: tuple[str, str, str], told: str, cell: Cell, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as caught:
        read_order(written(tmp_path, contents, move), cell)
    assert told in str(caught.value)


@pytest.mark.parametrize("move", [("bin_A", "bar", "tote"), ("bin_Z", BAR, "tote"), ("bin_A", BAR, "tot")])
def test_one_mistake_in_a_move_is_one_problem(move: tuple[str, str, str], cell: Cell, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_order(written(tmp_path, {"bin_A": [BAR]}, move), cell)
    assert str(caught.value).count("unknown") == str(caught.value).count("moves[0]") == 1


def test_the_order_that_comes_with_the_crates_is_sound() -> None:
    crates = load_cell("ur5e_crates")
    order = read_order(data_path() / "cells" / "ur5e_crates" / "moves_24.json", crates)
    assert len(order.work_order) == sum(map(len, order.bin_contents.values())) == 24
    assert all(crates.item(target.item).suction for target in order.work_order)


def test_a_cell_without_bins_has_no_official_orders() -> None:
    with pytest.raises(InputError, match=r"has no pod and no tote; name an order of moves, e\.g\. moves_24"):
        read_order(Path("jsk_pick_sample"), load_cell("ur5e_crates"))


# Playing


def test_every_item_goes_where_it_is_wanted(cell: Cell) -> None:
    order = order_of({"bin_A": (BAR, WAX)}, ("bin_A", BAR, "bin_B"), ("bin_A", WAX, "tote"))
    result, after = played(order, cell)
    assert {name: placed.location for name, placed in after.items()} == {BAR: "bin_B", WAX: "tote"}
    assert result.items_in_tote == result.score.total == result.score.maximum == 2
    assert [target.outcome for target in result.targets] == [Outcome.DELIVERED, Outcome.IN_TOTE]
    assert result.final.claim is None and result.n_misjudged == 0


def test_copies_with_several_destinations_are_moved_once_each(cell: Cell) -> None:
    order = order_of({"bin_A": (BAR, BAR)}, ("bin_A", BAR, "bin_B"), ("bin_A", BAR, "bin_F"))
    result, after = played(order, cell)
    assert sorted(placed.location for placed in after.values()) == ["bin_B", "bin_F"]
    assert result.items_in_tote == len(result.attempts) == 2


def test_what_no_move_names_stays(cell: Cell) -> None:
    """What is in the way of a move is not brought elsewhere; once it has moved itself, the way is free."""
    contents: dict[str, tuple[str, ...]] = {"bin_A": (BAR, WAX)}
    alone, after = played(order_of(contents, ("bin_A", BAR, "bin_B")), cell, blocked={BAR: WAX})
    assert alone.items_in_tote == 0 and {placed.location for placed in after.values()} == {"bin_A"}
    both = order_of(contents, ("bin_A", BAR, "bin_B"), ("bin_A", WAX, "bin_B"))
    assert played(both, cell, blocked={BAR: WAX})[0].items_in_tote == 2


def test_the_time_is_so_much_for_each_move(cell: Cell) -> None:
    order = order_of({"bin_A": (BAR, WAX)}, ("bin_A", BAR, "bin_B"), ("bin_A", WAX, "bin_B"))
    result, _ = played(order, cell, duration=MOVE_TIME + 1.0)
    assert result.items_in_tote == 1 and result.clock <= 2 * MOVE_TIME


# Counting


def test_only_the_place_that_is_named_counts() -> None:
    order = order_of({"bin_A": (BAR, BAR)}, ("bin_A", BAR, "bin_B"), ("bin_A", BAR, "tote"))
    items = (FinalItem(BAR, BAR, "bin_A", "bin_C"), FinalItem(f"{BAR}#2", BAR, "bin_A", "tote"))
    found = score(order, FinalState(items), {})
    assert [line.points for line in found.lines] == [0, 1] and found.maximum == 2
