"""A commission in the cell whose arm has the hand with belts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pickcli.commission.commission_file import read_commission
from pickcli.commission.commission_station import CommissionStation
from pickcli.commission.commission_trial import CommissionRequest, play_commission
from pickcli.planning.planning_context import PlanningContext
from pickcli.verification.verify import verify
from support.command_line import apc, refused
from support.commissions import belts_booth, few, written


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Path:
    def two_with_room(data: dict[str, Any]) -> None:
        few(data, "coke", "bull")
        data["apart"] = 0.11

    return written(tmp_path_factory.mktemp("two"), two_with_room)


def belts_station(path: Path) -> CommissionStation:
    """A commission in the cell of the hand with belts."""
    return CommissionStation.of(belts_booth(), read_commission(path))


@pytest.mark.slow
def test_the_whole_chain_succeeds_with_the_hand_at_the_arm(two: Path) -> None:
    station = belts_station(two)
    played = play_commission(CommissionRequest(seed=2), station, PlanningContext(station.cell))
    result = played.result
    assert result.is_success and result.is_clean and result.n_stops == 0, result.steps
    queries = [each.plan.query for each in played.plans]
    assert set(queries) == {"pre-grasp", "transfer", "home"} and queries.count("transfer") == 2
    assert all(verify(each.plan, each.seen).certificate is not None for each in played.plans)
    transfers = [each for each in result.steps if each.action == "transfer_item"]
    stages = [each["kind"] for each in transfers[0].figures["segments"]]
    assert stages == [
        "opening",
        "closing",
        "pull-in",
        "firm grasp",
        "lift",
        "lowering",
        "opening",
        "backing off",
    ]
    # The recorder follows the arm and what it carries.
    assert set(played.recorder.items) >= {"coke", "bull"}
    assert len(played.recorder.runs) == len(played.plans)


@pytest.mark.slow
def test_of_a_cluster_whatever_the_hand_gets_takes_the_place_of_what_was_chosen(tmp_path: Path) -> None:
    def three(data: dict[str, Any]) -> None:
        few(data, "coke")
        at = [[0.0, -0.02], [0.0585, -0.02], [0.0292, -0.0707]]
        data["items"] = [{"product": "coke", "position": each} for each in at]
        data["apart"] = 0.11

    station = belts_station(written(tmp_path, three))
    played = play_commission(CommissionRequest(seed=5), station, PlanningContext(station.cell))
    result = played.result
    assert result.is_success and result.is_clean and result.n_stops == 0, result.steps
    grasps = [each.plan.query for each in played.plans if each.plan.query not in ("transfer", "home")]
    assert grasps == ["cluster", "cluster", "pre-grasp"]  # the last one stands alone
    assert all(verify(each.plan, each.seen).certificate is not None for each in played.plans)
    taken = [each.target for each in result.steps if each.action == "transfer_item"]
    assert sorted(taken) == ["coke", "coke#2", "coke#3"]
    assert all(each.attempts == 1 and each.is_placed for each in result.items)


def test_places_are_of_one_size_and_filled_from_the_front_of_the_load(two: Path) -> None:
    station = belts_station(two)
    placed = {each.carton.id: each for each in station.placements}
    for each in station.commission.items:
        assert placed[each.id].size == pytest.approx(each.item.shape.extents)
        assert placed[each.id].low[2] == 0.0
    fronts = [each.at[1] for name in placed for each in station.commission.items if each.id == name]
    assert fronts == sorted(fronts)


def test_a_product_for_which_the_hand_has_no_currents_is_refused(tmp_path: Path) -> None:
    def with_jar(data: dict[str, Any]) -> None:
        data["products"]["jar"] = {"cylinder": [0.03, 0.12], "mass": 0.3}
        data["items"] = [{"product": "jar", "position": [0.0, 0.0]}]

    path = written(tmp_path, with_jar)
    answer = apc("run-trial", path, "--cell", "apple_booth_belts", "-o", tmp_path / "out")
    refused(answer, 3, path, "cannot take jar, for which the hand apple has no currents", "beer")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "product",
    [
        {"cylinder": [0.029, 0.2], "mass": 0.358},
        {"cylinder": [0.029, 0.146], "mass": 0.5},
        {"box": [0.058, 0.058, 0.146], "mass": 0.358},
    ],
    ids=["higher", "heavier", "square"],
)
def test_a_product_that_is_not_the_object_of_its_name_is_refused(product: Any, tmp_path: Path) -> None:
    def other(data: dict[str, Any]) -> None:
        few(data, "coke")
        data["products"]["coke"] = product

    path = written(tmp_path, other)
    answer = apc("run-trial", path, "--cell", "apple_booth_belts", "-o", tmp_path / "out")
    refused(
        answer,
        3,
        path,
        "has the currents of another object, a cylinder 0.058 m wide and 0.146 m high, 0.358 kg",
    )
