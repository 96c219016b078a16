"""``apc check`` reads orders of all kinds: by name, streams, pallets, commissions and driving areas."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.cell.data_path import data_path
from support.command_line import apc, refused

AREA = "format: apc driving area\nversion: 1\nwalls: {low: [0, 0], high: [10, 8]}\nboxes: []\n"
AREA += "start: {position: [2, 2], yaw: 0}\ngoal: {position: [6, 2], yaw: 0}\n"
PALLET = "format: apc pallet\nversion: 1\npallet: {container: eur_pallet}\n"
PALLET += "cartons: [{id: a, size: [0.3, 0.2, 0.2], mass: 2, bears: 20}]\n"


@pytest.mark.parametrize(
    ("name", "told"),
    [("apple_commission", "a commission of 6 items in apple_booth"), ("pr2_belt_static", "a stream of ")],
)
def test_streams_and_commissions_are_read(name: str, told: str) -> None:
    assert f"without mistakes; {told}" in apc("check", data_path() / "tasks" / f"{name}.json").out


def test_orders_go_by_name() -> None:
    assert "an order of 12 targets" in apc("check", "jsk_pick_sample").out


@pytest.mark.parametrize(
    ("text", "told", "change", "mistake"),
    [
        (AREA, "a driving area with 0 boxes", ("yaw: 0", "yaw: 400"), "start.yaw: expected "),
        (PALLET, "a pallet of 1 carton", ("mass: 2", "mass: -2"), "cartons[0].mass: expected "),
    ],
)
def test_areas_and_pallets_are_read(
    tmp_path: Path, text: str, told: str, change: tuple[str, str], mistake: str
) -> None:
    path = tmp_path / "order.yaml"
    path.write_text(text)
    assert told in apc("check", path).out
    path.write_text(text.replace(*change, 1))
    result = apc("check", path)
    assert result.code == 3
    assert mistake in result.err


def test_the_mistakes_of_a_commission_are_told(tmp_path: Path) -> None:
    commission = json.loads((data_path() / "tasks/apple_commission.json").read_text())
    commission["start"]["yaw"] = "east"
    path = tmp_path / "commission.json"
    path.write_text(json.dumps(commission))
    result = apc("check", path)
    assert result.code == 3
    assert "start.yaw: expected " in result.err


def test_what_a_cell_cannot_do_of_a_commission_is_told(tmp_path: Path) -> None:
    """Its arm, its room and its truck are those of the cell."""
    commission = json.loads((data_path() / "tasks/apple_commission.json").read_text())
    commission["products"]["coke"]["mass"] = 9.0
    path = tmp_path / "commission.json"
    path.write_text(json.dumps(commission))
    refused(apc("check", path), 3, path, "apple_booth cannot take coke")
    other = apc("check", data_path() / "tasks/apple_commission.json", "--cell", "ur5e_crates")
    refused(other, 3, "no table called load")


def test_people_are_drawn_or_stated(tmp_path: Path) -> None:
    area, scene = tmp_path / "area.yaml", tmp_path / "scene.yaml"
    area.write_text(AREA)
    scene.write_text("format: apc watched scene\nversion: 1\n")
    result = apc("watch-zone", area, "--people", "2", "--watched", scene, "-o", tmp_path / "watch.json")
    assert result.code == 2
    assert "--people is for a drawn scene" in result.err
