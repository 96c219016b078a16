"""apc make-pallet-order and apc plan-pallet: files, output, and mistakes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.errors import InputError
from pickcli.palletizing.pallet_order import Pallet
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
    apc("make-pallet-order", "--cartons", "8", "--seed", "3", "-o", order)
    told = apc("plan-pallet", order, "-o", stack)
    assert told.code == 0
    assert apc("plan-pallet", order, "-o", tmp_path / "again.json").code == 0
    assert (tmp_path / "again.json").read_bytes() == stack.read_bytes()
    written = json.loads(stack.read_text())
    assert written["format"] == "apc stacked pallet" and written["drop_test"]["sinking_m"] <= 0.01
    assert f"{len(written['placements'])} of 8 cartons" in told.out
    for placed in written["placements"]:
        assert placed["comes_down_from"] > placed["position"][2]
        assert len(placed["borne_within"]) >= 3
    answer = apc("plan-pallet", order, "--online", "--json", "-o", tmp_path / "o.json")
    online = json.loads(answer.out)
    assert online["placed"] + len(online["left"]) == online["of"] == 8
    assert answer.code == online["exit_code"] == (5 if online["left"] else 0)


@pytest.mark.parametrize("container", ["eur_pallet", "half_pallet", "roll_container"])
def test_no_carton_is_drawn_higher_than_what_may_stand_there(container: str, tmp_path: Path) -> None:
    path = tmp_path / "low.json"
    run = apc("make-pallet-order", "--container", container, "--height", 0.42, "--cartons", 40, "-o", path)
    order = read_pallet_order(path)
    assert run.code == 0 and len({carton.size[2] for carton in order.cartons}) > 1
    assert max(carton.size[2] for carton in order.cartons) <= order.pallet.height - order.pallet.deck + 1e-9


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
        ({"mass": float("nan")}, "NaN is not JSON"),
        ({"size": [0.4, float("inf"), 0.2]}, "Infinity is not JSON"),
        ({"bears": -1.0}, "bears"),
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


@pytest.mark.parametrize(
    ("pallet", "told"),
    [
        ({"container": "eur_palet"}, "unknown container 'eur_palet'; did you mean 'eur_pallet'"),
        ({}, "size is missing; state it, or a container: eur_pallet, half_pallet, roll_container"),
        ({"container": "eur_pallet", "walls": ["left"]}, "walls"),
        ({"container": "roll_container", "bears": 0}, "bears"),
        ({"size": [0.42, 0.304], "walls": ["-x", "+x", "-y"]}, "with 0.005 m to its walls"),
    ],
)
def test_mistakes_of_a_pallet_are_told(tmp_path: Path, pallet: dict[str, object], told: str) -> None:
    (tmp_path / "p.json").write_text(json.dumps(GOOD | {"pallet": pallet}))
    with pytest.raises(InputError, match=told):
        read_pallet_order(tmp_path / "p.json")


def test_a_container_is_named_and_its_figures_replaced(tmp_path: Path) -> None:
    (tmp_path / "p.json").write_text(json.dumps(GOOD | {"pallet": {"container": "half_pallet"}}))
    assert read_pallet_order(tmp_path / "p.json").pallet == Pallet((0.8, 0.6), 0.144, 2.0, 500.0)
    changed = {"container": "roll_container", "height": 1.7, "walls": ["-y"]}
    (tmp_path / "p.json").write_text(json.dumps(GOOD | {"pallet": changed}))
    assert read_pallet_order(tmp_path / "p.json").pallet == Pallet((0.8, 0.7), 0.2, 1.7, 500.0, ("-y",))


def test_a_carton_bears_a_column_of_its_own_kind_if_nothing_is_stated(tmp_path: Path) -> None:
    """Ten of 0.2 m have room over a deck of 0.1 m below 2.1 m: nine of 3 kg stand on the lowest."""
    pallet = {"size": [1.2, 0.8], "deck": 0.1, "height": 2.1}
    (tmp_path / "p.json").write_text(json.dumps(GOOD | {"pallet": pallet}))
    assert {carton.bears for carton in read_pallet_order(tmp_path / "p.json").cartons} == {27.0}


def test_an_unknown_container_is_told_before_anything_is_drawn(tmp_path: Path) -> None:
    path = tmp_path / "o.json"
    refused(
        apc("make-pallet-order", "--container", "rollcontainer", "-o", path),
        3,
        "did you mean 'roll_container'",
    )
    assert not path.exists()


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
    refused(
        apc("plan-pallet", path, "-o", stack), 5, "1 of 2 cartons are left", "the pallet bears 2 kg in all",
        "1 of 2 cartons, 0.34 m high", stack,
    )  # fmt: skip
    assert [each["id"] for each in json.loads(stack.read_text())["placements"]] == ["box"]


def test_looking_ahead_is_for_what_comes_one_by_one(tmp_path: Path) -> None:
    (tmp_path / "p.json").write_text(json.dumps(GOOD))
    misused(
        apc("plan-pallet", tmp_path / "p.json", "--look-ahead", "2", "-o", tmp_path / "s.json"), "--online"
    )
