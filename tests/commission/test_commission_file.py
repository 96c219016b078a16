"""A file of a commission is read whole, or refused with every mistake, its place, and what to do."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.commission.commission_file import read_commission
from pickcli.driving.pallet_entry import entered_pose
from pickcli.errors import InputError
from support.command_line import apc, refused
from support.commissions import SHIPPED, Change, station_of, written

MISTAKES: dict[str, tuple[Change, str]] = {
    "walls": (lambda d: d.update(walls={"low": [5, 0], "high": [0, 3]}), "walls: low is not below high"),
    "hall": (lambda d: d.update(walls={"low": [0, 0], "high": [50, 3]}), "at most 40 m are planned in"),
    "start": (lambda d: d["start"].update(position=[4.9, 1.1]), "start: the truck at the start is -"),
    "end": (lambda d: d["end"].update(position=[3.2, 0.3]), "end: the truck at the end is "),
    "boxed": (
        lambda d: d.update(boxes=[{"name": "crate", "centre": [4.0, 1.1], "size": [0.3, 0.3]}]),
        "the truck at the start is 0.000 m from walls, a box or the pallet",
    ),
    "start_on_pallet": (lambda d: d["start"].update(position=[1.1, 1.1]), "start: the truck at the "),
    "end_on_pallet": (lambda d: d["end"].update(position=[1.1, 1.9]), "end: the truck at the end is "),
    "product": (
        lambda d: d["items"][1].update(product="cola"),
        "items[1].product: no product is named 'cola'; known: beer",
    ),
    "shapeless": (lambda d: d["products"].update(beer={"mass": 1}), "exactly one of box and cylinder"),
    "two_shapes": (
        lambda d: d["products"]["beer"].update(box=[0.1, 0.1, 0.1]),
        "products.beer: expected exactly one of box and cylinder",
    ),
    "mass": (lambda d: d["products"]["beer"].update(mass=-0.5), "products.beer.mass: expected"),
    "no_items": (lambda d: d.update(items=[]), "items: "),
    "many": (lambda d: d.update(items=d["items"] * 7), "items: "),
    "in_each_other": (
        lambda d: d["items"][1].update(position=[-0.17, -0.08]),
        "coke stands in beer (line 1); put them 0.062 m apart",
    ),
    "loaded": (lambda d: d["pallet"].update(load=0.5), "pallet.load: expected an empty pallet"),
    "off_deck": (lambda d: d["filled"].update(high=[0.7, 0.3]), "filled: is not on the deck, which is from"),
    "half_deck": (
        lambda d: (d["pallet"].update(kind="half"), d["filled"].update(low=[0.2, -0.3]))[0],
        "pallet.kind: what is filled is not on a half one, from -0.3 to 0.3 and -0.4 to 0.4 m; state ano",
    ),
    "no_deck": (lambda d: d["filled"].update(high=[0.1, 0.3]), "filled: low is not below high"),
    "kind": (lambda d: d["pallet"].update(kind="quarter"), "pallet.kind: expected"),
    "key": (lambda d: d.update(colour="red"), "colour: unknown key"),
    "missing": (lambda d: d.pop("load"), "load: "),
    "version": (lambda d: d.update(version=2), "version: expected"),
    "nan": (lambda d: d["load"].update(yaw=float("nan")), "NaN is not JSON; write a finite number"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_refused_with_its_place(mistake: str, tmp_path: Path) -> None:
    change, told = MISTAKES[mistake]
    path = written(tmp_path, change)
    with pytest.raises(InputError, match=re.escape(told)) as refused:
        read_commission(path)
    assert str(path) in str(refused.value)


def test_all_mistakes_are_told_at_once(tmp_path: Path) -> None:
    def change(data: dict[str, Any]) -> None:
        data["items"][0]["product"], data["items"][2]["product"] = "cola", "bear"

    with pytest.raises(InputError) as refused:
        read_commission(written(tmp_path, change))
    assert "items[0]" in str(refused.value) and "items[2]" in str(refused.value)


def test_the_commission_that_ships_is_read() -> None:
    commission = read_commission(SHIPPED)
    names = [each.id for each in commission.items]
    assert names == ["beer", "coke", "bull", "box_45", "beer#2", "box_50"]
    assert commission.items[0].item.shape.size == (0.033, 0.168) and commission.items[0].item.mass == 0.522
    np.testing.assert_array_equal(commission.area.goal, entered_pose(commission.area, commission.pallet))
    assert not commission.items[0].item.suction


REFUSALS: dict[str, tuple[Change, str]] = {
    "wide": (
        lambda d: d["products"].update(beer={"box": [0.12, 0.11, 0.1], "mass": 1}),
        "beer, 0.12 x 0.11 x 0.1 m and 1 kg, which the gripper cannot hold",
    ),
    "heavy": (
        lambda d: d["products"]["beer"].update(mass=19),
        "beer, 0.066 x 0.066 x 0.168 m and 19 kg, which the gripper cannot hold",
    ),
    "load_in_wall": (
        lambda d: d["load"].update(position=[3.05, 2.9]),
        "the load reaches through the walls; move load",
    ),
    "load_in_box": (
        lambda d: d.update(boxes=[{"name": "shelf", "centre": [3.05, 2.62], "size": [0.2, 0.2]}]),
        "the load stands in shelf; move load or the box",
    ),
    "pallet_at_wall": (
        lambda d: d["pallet"].update(position=[0.85, 0.3]),
        "the truck with its pallet has no room where it takes it: ",
    ),
    "edge": (
        lambda d: d["items"][0].update(position=[-0.29, 0]),
        "beer at -0.29, 0, which stands 23 mm over the edge of the load, 0.6 x 0.4 m",
    ),
    "turned_edge": (  # level by its sides it would be 3 mm inside
        lambda d: d["items"][3].update(position=[0.2745, 0], yaw=0.785398),
        "box_45 at 0.2745, 0, which stands 6 mm over the edge of the load, 0.6 x 0.4 m",
    ),
    "room": (
        lambda d: d.update(filled={"low": [0.35, -0.05], "high": [0.55, 0.05]}),
        "the part of the deck that is filled, 0.2 x 0.1 m, has no room for",
    ),
    "narrow": (
        lambda d: d.update(filled={"low": [0.5, -0.02], "high": [0.55, 0.02]}),
        "has no room for beer, coke, bull, box_45, beer#2, box_50",
    ),
    "at_load": (
        lambda d: d["load"].update(position=[3.05, 1.15]),
        "the truck with its pallet has no room at the load: ",
    ),
    "at_delivery": (
        lambda d: d["delivery"].update(position=[0.85, 0.3]),
        "the truck with its pallet has no room where it delivers: -0.100 m to the walls",
    ),
    "half": (
        lambda d: (d["pallet"].update(kind="half"), d.pop("filled"))[0],
        "the half pallet is 0.6 x 0.8 m, that of cell apple_booth is 1.2 x 0.8 m; state another kind",
    ),
    "margin": (
        lambda d: d.update(margin=0.02),
        "forks take the pallet 30 mm from where cell apple_booth has it",
    ),
}


@pytest.mark.parametrize("refusal", REFUSALS)
def test_what_the_cell_cannot_do_is_refused_before_anything_moves(refusal: str, tmp_path: Path) -> None:
    change, told = REFUSALS[refusal]
    with pytest.raises(InputError, match=re.escape(told)):
        station_of(written(tmp_path, change))


def test_a_misspelt_format_is_told_and_not_judged_as_an_order(tmp_path: Path) -> None:
    path = written(tmp_path, lambda d: d.update(format="apc comission"))
    answer = apc("run-trial", path, "-o", tmp_path / "out")
    refused(answer, 3, path, "format: unknown 'apc comission'; did you mean 'apc commission'?")
    assert "work_order" not in answer.err and not (tmp_path / "out").exists()
