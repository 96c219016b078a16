"""apc make-pallet-order and apc plan-pallet: files, output, and mistakes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.errors import InputError
from pickcli.palletizing.pallet_order_file import read_pallet_order, write_pallet_order
from pickcli.palletizing.random_pallet_order import random_pallet_order
from support.command_line import apc, misused, refused

CARTON = {"id": "box", "size": [0.4, 0.3, 0.2], "mass": 3.0}
GOOD = {
    "format": "apc pallet",
    "version": 1,
    "pallet": {"size": [1.2, 0.8]},
    "cartons": [CARTON | {"count": 3}],
}


def test_an_order_is_drawn_stacked_and_told(tmp_path: Path) -> None:
    order, stack = tmp_path / "pallet.json", tmp_path / "stack.json"
    apc("make-pallet-order", "--cartons", "12", "--seed", "3", "-o", order)
    told = apc("plan-pallet", order, "-o", stack)
    written = json.loads(stack.read_text())
    assert written["format"] == "apc stacked pallet" and written["drop_test"]["sinking_m"] <= 0.01
    assert f"{len(written['placements'])} of 12 cartons" in told.out
    for placed in written["placements"]:
        assert placed["comes_down_from"] > placed["position"][2]
        assert len(placed["borne_within"]) >= 3
    online = json.loads(apc("plan-pallet", order, "--online", "--json", "-o", tmp_path / "o.json").out)
    assert online["placed"] + len(online["left"]) == online["of"] == 12


def test_an_order_is_read_as_it_was_written(tmp_path: Path) -> None:
    order = random_pallet_order(20, 5)
    write_pallet_order(tmp_path / "p.json", order)
    assert read_pallet_order(tmp_path / "p.json") == order


def test_a_count_makes_several(tmp_path: Path) -> None:
    (tmp_path / "p.json").write_text(json.dumps(GOOD))
    assert [carton.id for carton in read_pallet_order(tmp_path / "p.json").cartons] == [
        "box_1",
        "box_2",
        "box_3",
    ]


@pytest.mark.parametrize(
    ("carton", "told"),
    [
        ({"size": [1.3, 0.3, 0.2]}, "larger than the pallet"),
        ({"size": [0.9, 0.85, 0.2]}, "larger than the pallet"),
        ({"size": [0.4, 0.3, 1.9]}, "1.856 m are over the deck"),
        ({"size": [0.4, 0.3]}, "size"),
        ({"mass": -1.0}, "mass"),
        ({"mass": 990.0, "count": 1}, None),
        ({"mass": "3 kg"}, "mass"),
        ({"count": 0}, "count"),
        ({"count": 201}, "count"),
        ({"size": [0.4, 0.3, 0.005]}, "size"),
        ({"mass": 0.001}, "mass"),
        ({"weight": 3.0}, "unknown key"),
    ],
)
def test_mistakes_are_told_with_their_place(
    tmp_path: Path, carton: dict[str, object], told: str | None
) -> None:
    path = tmp_path / "p.json"
    path.write_text(json.dumps(GOOD | {"cartons": [CARTON | carton]}))
    if told is None:
        read_pallet_order(path)
        return
    with pytest.raises(InputError, match=told) as error:
        read_pallet_order(path)
    assert str(path) in str(error.value)


def test_two_cartons_of_one_name_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "p.json"
    path.write_text(json.dumps(GOOD | {"cartons": [CARTON, CARTON]}))
    with pytest.raises(InputError, match="2 cartons are called box"):
        read_pallet_order(path)


def test_an_order_of_too_many_is_refused_before_they_are_made(tmp_path: Path) -> None:
    (tmp_path / "p.json").write_text(json.dumps(GOOD | {"cartons": [CARTON | {"count": 200}] * 100}))
    with pytest.raises(InputError, match="20000 cartons, at most 200 are stacked"):
        read_pallet_order(tmp_path / "p.json")


def test_a_carton_may_fill_the_room_to_its_end(tmp_path: Path) -> None:
    tight = {"pallet": {"size": [1.2, 0.8], "deck": 0.1, "height": 0.3}}
    (tmp_path / "p.json").write_text(json.dumps(GOOD | tight))
    assert len(read_pallet_order(tmp_path / "p.json").cartons) == 3


def test_a_pallet_that_bears_too_little_is_told(tmp_path: Path) -> None:
    path, stack = tmp_path / "p.json", tmp_path / "stack.json"
    weak = GOOD | {"pallet": {"size": [1.2, 0.8], "bears": 2.0}}
    path.write_text(json.dumps(weak))
    refused(apc("plan-pallet", path, "-o", stack), 3, path, "weighs 3 kg, the pallet bears 2")
    assert not stack.exists()
    path.write_text(
        json.dumps(weak | {"cartons": [CARTON | {"mass": 1.5}, CARTON | {"id": "b", "mass": 1.0}]})
    )
    answer = apc("plan-pallet", path, "-o", stack)
    assert answer.code == 0 and "left: b: too heavy: the pallet bears 2 kg in all" in answer.out


def test_looking_ahead_is_for_what_comes_one_by_one(tmp_path: Path) -> None:
    (tmp_path / "p.json").write_text(json.dumps(GOOD))
    misused(
        apc("plan-pallet", tmp_path / "p.json", "--look-ahead", "2", "-o", tmp_path / "s.json"), "--online"
    )
