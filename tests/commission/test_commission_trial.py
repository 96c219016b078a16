"""A truck takes a pallet, its arm fills it, and it is delivered; what fails has a reason and a next step."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.commission import commission_truck
from pickcli.commission.commission import LOAD, PALLET
from pickcli.commission.commission_arm import CommissionArm, CommissionTransfer
from pickcli.commission.commission_record import commission_record
from pickcli.commission.commission_result import ActionError, CommissionedOutcome
from pickcli.commission.commission_station import CommissionStation, with_thing_at
from pickcli.commission.commission_trial import CommissionRequest, PlayedCommission
from pickcli.commission.commission_truck import CommissionTruck
from pickcli.driving.drive_plan import DrivePlan
from pickcli.driving.driving_area import DrivingArea
from pickcli.driving.free_space_proof import clearances
from pickcli.driving.simulated_drives import DriveNoise, NoisyTruck
from pickcli.files.packed_array import unpacked
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.page.commission_page import commission_page
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import PoseNoise
from pickcli.simulation.reality import IDEAL
from pickcli.strategy.node_types import TrialKind
from pickcli.strategy.strategy_file import load_strategy
from pickcli.trial.motion_record import motion_values, parse_motion
from support.command_line import apc, misused, refused
from support.commissions import SHIPPED, few, play, station_of, written

APPROACH = ["enter_pallet", "lift_pallet", "drive load", "look_at_load"]
HAND = 0.09  # m around the tip of the hand that it is within, seen from above
DELIVERY = ["home_arm", "drive delivery", "set_down_pallet", "drive end"]


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("two"), lambda data: few(data, "coke", "box_45"))


@pytest.fixture(scope="module")
def station(two: Path) -> CommissionStation:
    return station_of(two)


@pytest.fixture(scope="module")
def played(two: Path) -> PlayedCommission:
    return play(two, seed=5)


def test_the_whole_chain_is_played_in_its_order_and_succeeds(played: PlayedCommission) -> None:
    result = played.result
    assert result.is_success and result.is_clean and not result.aborted and result.n_stops == 0
    assert [each.action for each in result.steps] == [
        *APPROACH, *["choose_item", "transfer_item"] * 2, *DELIVERY
    ]  # fmt: skip
    assert all(each.is_success and not each.reason for each in result.steps)
    for before, after in zip(result.steps, result.steps[1:], strict=False):
        assert before.t_end == after.t_start
    assert 40.0 < result.duration < 100.0 and 10.0 < result.handling < 40.0
    assert result.delivered is not None and result.delivered.distance < 0.04


def test_items_stand_in_their_places_after_the_last_drive(played: PlayedCommission) -> None:
    for each in played.result.items:
        assert each.outcome is CommissionedOutcome.PLACED and each.attempts == 1
        assert each.at_end is not None and each.at_end.aside < 0.01 and abs(each.at_end.height) < 0.002


def test_the_arm_plans_for_where_the_truck_truly_stands(
    played: PlayedCommission, station: CommissionStation
) -> None:
    """Load and pallet are displaced in the arm's frame by the error of the drives, and seen with errors."""
    assert played.before is not None
    for name in (LOAD, PALLET):
        carrier = station.cell.carriers[name]
        truly = played.before.pose_of(carrier).T_world_carrier
        assert 1e-4 < np.abs(truly - carrier.T_world_carrier)[:2, 3].max() < 0.05
        for each in played.plans:
            seen = each.seen.pose_of(carrier)
            assert seen.error.allows(np.linalg.inv(seen.T_world_carrier) @ truly)
            assert np.abs(seen.T_world_carrier - truly).max() > 1e-5
    stood = played.drives[1].drive.poses[-1]
    load = played.before.pose_of(station.cell.carriers[LOAD]).T_world_carrier
    where = with_thing_at(
        station.commission.load, np.array([*load[:2, 3], np.arctan2(load[1, 0], load[0, 0])])
    )
    np.testing.assert_allclose(where, stood, atol=1e-6)


def test_every_motion_of_the_arm_is_certified(played: PlayedCommission) -> None:
    assert len(played.plans) == 3
    for each in played.plans:
        assert each.plan.certificate is not None and each.plan.certificate.min_clearance >= 0.003


def test_drives_are_on_the_clock_and_keep_away_from_everything(played: PlayedCommission) -> None:
    names = [each.drive.name for each in played.drives]
    assert names == ["enter_pallet", "drive load", "drive delivery", "drive end"]
    for each in played.drives:
        assert each.drive.figures["clearance_m"] > 0.0
        assert len(each.drive.poses) == pytest.approx(each.drive.duration / 0.02 + 1, abs=1.5)
    loaded = [len(each.drive.felt) > 0 for each in played.drives]
    assert loaded == [False, True, True, False]
    assert all(len(each.drive.felt) in (0, len(each.drive.poses) - 1) for each in played.drives)
    ends = {each.action: each.t_end for each in played.result.steps}
    assert all(
        each.t_start + each.drive.duration == pytest.approx(ends[each.drive.name])
        for each in played.drives[1:]
    )
    assert all(played.drives[k].drive.figures["pallet_gap_m"] > 0.0 for k in (0, 3))


def test_the_page_shows_the_whole_trial_from_the_truck(
    played: PlayedCommission, station: CommissionStation
) -> None:
    """Load and items pass the truck without a jump, and items stay on the pallet that is left behind."""
    record = commission_record(CommissionRequest(seed=5), station, played, "two.json", "0")
    motion = parse_motion(motion_values(played.recorder, [station.cell]))
    page = commission_page(record, station, played.before, motion)
    assert page.motion is not None and page.motion.duration == played.result.duration
    tracks = {each.item: (unpacked(each.times), unpacked(each.poses)) for each in page.motion.tracks}
    assert {"load stand", "pallet deck", "wall -x", "coke", "box_45"} <= tracks.keys()
    for times, poses in tracks.values():
        assert (np.diff(times) >= 0.0).all()
        speed = np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1) / np.maximum(np.diff(times), 0.02)
        assert speed.max() < 3.0
    at_load = played.arm_from
    assert played.before is not None
    wanted = played.before.pose_of(station.cell.carriers[LOAD]).T_world_carrier[:2, 3]
    np.testing.assert_allclose(_at(tracks["load stand"], at_load)[:2], wanted, atol=2e-3)
    for name in ("coke", "box_45"):
        before, end = (
            _at(tracks[name], t)[:2] - _at(tracks["pallet deck"], t)[:2] for t in (at_load - 1.0, 1e3)
        )
        assert np.linalg.norm(before) > 0.5 and np.abs(end).max() < 0.6
    assert {lane.name for lane in page.lanes} == {"steps", "segments"}
    assert [each.title for each in page.chapters][:3] == ["enter_pallet", "lift_pallet", "drive load"]
    assert all(each.outcome == "done" for each in page.chapters)


def _at(track: tuple[Any, Any], t: float) -> Any:
    times, poses = track
    return np.array([np.interp(t, times, column) for column in poses.T])


# What fails ------------------------------------------------------------------------------------------


def test_without_a_pallet_the_truck_tries_twice_and_ends_where_it_stands(tmp_path: Path) -> None:
    result = play(written(tmp_path, lambda data: data["pallet"].update(there=False)), seed=1).result
    assert [each.action for each in result.steps] == ["enter_pallet"] * 2 + ["home_arm", "end_here"]
    assert not result.is_success and result.is_clean
    assert result.aborted.startswith("enter_pallet: the pallet was not seen")
    assert {each.outcome for each in result.items} == {CommissionedOutcome.LEFT} and result.delivered is None


def test_an_item_without_room_for_the_fingers_is_skipped_and_the_rest_delivered(tmp_path: Path) -> None:
    """Two boxes side by side, closer than a finger: neither can be taken, after two looks."""

    def change(data: dict[str, Any]) -> None:
        few(data, "coke", "box_45", "box_50")
        walls = [[x, y] for x, y in ((0.0, 0.05), (0.047, 0.05), (-0.047, 0.05), (0.0, 0.097), (0.0, 0.003))]
        data["products"]["post"] = {"box": [0.045, 0.045, 0.2], "mass": 0.2}
        data["items"] = [data["items"][0], *({"product": "post", "position": each} for each in walls)]
        data["items"][0]["position"] = [-0.2, -0.1]

    result = play(written(tmp_path, change), seed=2).result
    outcomes = {each.id: each.outcome for each in result.items}
    assert outcomes["coke"] is CommissionedOutcome.PLACED and outcomes["post"] is CommissionedOutcome.LEFT
    tried = [each for each in result.steps if each.target == "post"]
    assert [each.action for each in tried if each.action != "choose_item"][-3:] == [
        "transfer_item", "transfer_item", "skip_item"
    ]  # fmt: skip
    assert all(each.reason for each in tried if each.action == "transfer_item")
    assert [each.action for each in result.steps[-4:]] == DELIVERY
    assert result.is_delivered and not result.is_success and result.is_clean and not result.aborted


def test_a_delivery_that_is_blocked_ends_with_the_arm_at_home(tmp_path: Path) -> None:
    """The truck has room there, but a post stands where it would begin to drive straight backwards."""

    def change(data: dict[str, Any]) -> None:
        few(data, "coke")
        data["delivery"] = {"position": [0.85, 1.1], "yaw": 1.5708}
        data["boxes"] = [{"name": "post", "centre": [0.85, 2.7], "size": [0.1, 0.1]}]

    path = written(tmp_path, change)
    result = play(path, seed=3).result
    assert [each.action for each in result.steps[-5:]] == [
        "home_arm", "drive delivery", "drive delivery", "home_arm", "end_here"
    ]  # fmt: skip
    assert result.aborted.startswith("drive delivery: no plan for a drive to the goal")
    assert [each.outcome for each in result.items] == [
        CommissionedOutcome.PLACED
    ] and result.delivered is None


def test_a_truck_that_stands_too_far_off_is_told_by_the_look(station: CommissionStation) -> None:
    arm = _arm(station)
    off = station.at_load + np.array([0.0, -0.08, 0.0])
    with pytest.raises(ActionError, match=r"the load stands 0 and 80 mm and 0\.0 degrees off, farther"):
        arm.put_up(off, station.pallet_in_truck)
    with pytest.raises(ActionError, match="the pallet stands 70 and 0 mm"):
        arm.put_up(station.at_load, station.pallet_in_truck + np.array([0.07, 0.0, 0.0]))
    assert arm.before is None


def test_actions_out_of_order_fail_with_their_reasons(station: CommissionStation) -> None:
    truck, arm = CommissionTruck(station, DriveNoise(), 0), _arm(station)
    with pytest.raises(ActionError, match="no pallet is on the forks"):
        truck.raise_forks()
    with pytest.raises(ActionError, match="no pallet is raised"):
        truck.to_load()
    with pytest.raises(ActionError, match="no pallet is raised"):
        truck.set_down()
    with pytest.raises(ActionError, match="the pallet is not set down"):
        truck.leave()
    with pytest.raises(ActionError, match="did not stand at the load yet"):
        arm.look()
    assert arm.is_home


def _arm(station: CommissionStation) -> CommissionArm:
    return CommissionArm(station, PlanningContext(station.cell), PoseNoise(), IDEAL, 0)


def test_what_is_too_slender_falls_as_the_truck_brakes(station: CommissionStation) -> None:
    """A box of 45 x 140 mm tips over from 3.2 m/s^2 on; its friction with the table bears more than that."""
    arm = _arm(station)
    try:
        arm.put_up(station.at_load, station.pallet_in_truck)
        arm.ride(np.tile([1.0, 0.0], (50, 1)))
        assert arm._there().engine.pose("box_45")[2, 2] > 0.999
        arm.ride(np.tile([4.5, 0.0], (50, 1)))
        assert arm._there().engine.pose("box_45")[2, 2] < 0.9
    finally:
        arm.close()


def test_the_arm_at_home_is_within_the_truck(station: CommissionStation) -> None:
    """The truck drives as a rectangle, with the arm at home."""
    cell, truck = station.cell, station.commission.area.truck
    tip = Arm(cell.robot).tip(cell.home.q, cell.home.tool_state)[:3, 3]
    assert -truck.back < tip[0] - HAND and abs(tip[1]) + HAND < truck.width / 2
    assert cell.robot.T_world_base[0, 3] + 0.15 < truck.front


@pytest.mark.parametrize(("name", "size"), [("box_45", [0.045, 0.045, 0.14]), ("box", [0.045, 0.06, 0.14])])
def test_a_square_box_may_be_turned_by_quarters_and_another_by_halves(
    name: str, size: list[float], tmp_path: Path
) -> None:
    turns = []
    for quarters in range(4):

        def change(data: dict[str, Any], yaw: float = 0.3 + quarters * np.pi / 2) -> None:
            data["products"][name] = {"box": size, "mass": 0.146}
            data["items"] = [{"product": name, "position": [0.0, 0.0], "yaw": yaw}]

        arm = _arm(station_of(written(tmp_path, change)))
        try:
            arm.put_up(arm.station.at_load, arm.station.pallet_in_truck)
            turns.append(arm.item_off(name).turn)
        finally:
            arm.close()
    quarter = 0.3 if name == "box_45" else np.pi / 2 - 0.3
    assert turns == pytest.approx([0.3, quarter] * 2, abs=0.01)


@pytest.mark.parametrize(("share", "planner"), [
    (0.2, "plan_exit"), (0.4, "plan_exit"), (0.9, "plan_exit"), (1.1, "plan_drive"),
])  # fmt: skip
def test_the_truck_leaves_the_pallet_it_delivered_and_keeps_away_from_it(
    station: CommissionStation, monkeypatch: pytest.MonkeyPatch, share: float, planner: str
) -> None:
    truck = CommissionTruck(station, DriveNoise(), 3)
    inside = with_thing_at(station.commission.delivery, station.pallet_in_truck)
    truck.on_forks, truck.is_raised = station.pallet_in_truck, True
    _stand(truck, inside)
    truck.set_down()
    first = truck.leave()
    assert first is not None and first.figures["pallet_gap_m"] > 0.0 and truck.leave() is None
    out = np.array([share * station.commission.pallet.shape.length, 0.0, 0.0])
    _stand(truck, inside + out)  # as if it had braked there
    planned, plan = list[DrivingArea](), getattr(commission_truck, planner)

    def noted(area: DrivingArea, *args: Any) -> DrivePlan:
        planned.append(area)
        found: DrivePlan = plan(area, *args)
        return found

    monkeypatch.setattr(commission_truck, planner, noted)
    again = truck.leave()
    assert len(planned) == 1
    assert planner == "plan_exit" or len(planned[0].boxes) == len(station.leaving(inside).boxes) + 1
    assert again is not None and again.figures["pallet_gap_m"] > 0.0 and truck.n_collisions == 0


def test_what_another_motion_took_along_is_lost_and_not_tried(
    two: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def taking_both(arm: CommissionArm, name: str) -> CommissionTransfer:
        for each in ("coke", "box_45"):
            arm._there().take_out(each)  # type: ignore[attr-defined]
        return CommissionTransfer(name, None, "stopped", ())

    monkeypatch.setattr(CommissionArm, "transfer", taking_both)
    result = play(two, seed=5).result
    assert {each.outcome for each in result.items} == {CommissionedOutcome.LOST}
    assert [each.action for each in result.steps].count("transfer_item") == 1


def _stand(truck: CommissionTruck, at: Array) -> None:
    truck._truck.true[0] = truck._truck.believed[0] = at


def test_a_pallet_that_is_met_is_not_on_the_forks(
    station: CommissionStation, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(commission_truck, "pallet_gap", lambda *_: -0.01)
    truck = CommissionTruck(station, DriveNoise(), 3)
    with pytest.raises(ActionError, match="met the pallet, 10 mm deep"):
        truck.enter()
    assert truck.on_forks is None and truck.n_collisions == 1


# The command -----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_command_plays_a_commission_again_and_writes_its_folder(
    played: PlayedCommission, two: Path, station: CommissionStation, tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    answer = apc("run-trial", two, "--seed", 5, "-o", folder, "--plans")
    assert answer.code == 0 and "success: 2 of 2 items on the pallet" in answer.out
    names = {path.name for path in folder.iterdir()}
    assert {
        "trial.json",
        "commission.yaml",
        "items.yaml",
        "scene.json",
        "motion.json.gz",
        "plan_003.json",
    } <= names
    record = json.loads((folder / "trial.json").read_text())
    assert record["success"] and record["made_from"]["seed"] == 5 and len(record["drives"]) == 4
    again = json.loads(json.dumps(commission_record(CommissionRequest(seed=5), station, played, "x", "y")))
    assert {**record, "made_from": 0} == {**again, "made_from": 0}
    assert (folder / "commission.yaml").read_bytes() == two.read_bytes()
    plan, seen = folder / "plan_001.json", folder / "seen_001.json"
    assert apc("verify", plan, "--scene", seen, "--items", folder / "items.yaml").code == 0
    refused(apc("run-trial", two, "-o", folder), 3, folder, "exists already")
    assert apc("show", folder, "-o", tmp_path / "run.html").code == 0
    scene = (folder / "scene.json").read_text()
    moved = json.loads(scene)
    moved["items"][0]["position"][0] += 0.01
    (folder / "scene.json").write_text(json.dumps(moved))
    refused(apc("show", folder, "-o", tmp_path / "other.html"), 4, "scene.json: is not the scene of")
    (folder / "scene.json").write_text(scene)
    (folder / "commission.yaml").write_text(json.dumps({**json.loads(two.read_text()), "apart": 0.05}))
    refused(apc("show", folder, "-o", tmp_path / "other.html"), 4, "is not the commission that the record")


@pytest.mark.parametrize(("key", "position", "told"), [
    ("start", [3.05, 2.3], "the truck has no room at its start: 0.000 m to the load"),
    ("end", [3.05, 2.4], "the truck has no room at its end: 0.000 m to the load"),
])  # fmt: skip
def test_a_truck_that_would_stand_in_the_load_is_refused(
    key: str, position: list[float], told: str, tmp_path: Path
) -> None:
    path = written(tmp_path, lambda data: data[key].update(position=position, yaw=0.0))
    refused(apc("run-trial", path, "-o", tmp_path / "run"), 3, told)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("seed", [1, 4])
def test_a_truck_that_comes_askew_to_the_pallet_stops_before_it_and_tries_again(
    station: CommissionStation, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    """Right before the pockets its wheel turns by a radian for a quarter of a second, once."""
    move, swung = NoisyTruck.move, list[bool]()

    def swinging(truck: NoisyTruck, steering: Array, way: Array) -> None:
        is_before = 1.95 < truck.true[0, 0] < 2.05 and len(swung) < 12
        swung.extend([True] if is_before else [])
        move(truck, steering + float(is_before), way)

    monkeypatch.setattr(NoisyTruck, "move", swinging)
    truck = CommissionTruck(station, DriveNoise(), seed)
    entered = truck.enter()
    assert len(swung) == 12
    assert entered.figures["stops"] >= 1 and entered.figures["pallet_gap_m"] > 0.0
    assert truck.n_collisions == 0 and truck.on_forks is not None


def test_who_gave_an_entry_up_begins_the_next_one_where_the_pallet_was_seen(
    station: CommissionStation, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The wheel turns in each approach of the first entry, until that is given up right before the pallet."""
    move = NoisyTruck.move

    def swinging(truck: NoisyTruck, steering: Array, way: Array) -> None:
        move(truck, steering + float(1.95 < truck.true[0, 0] < 2.05), way)

    truck = CommissionTruck(station, DriveNoise(), 1)
    with (
        monkeypatch.context() as patched,
        pytest.raises(ActionError, match="no path into it where it was seen"),
    ):
        patched.setattr(NoisyTruck, "move", swinging)
        truck.enter()
    entered = truck.enter()
    assert entered.figures["pallet_gap_m"] > 0.0 and truck.n_collisions == 0


def test_forks_that_met_the_pallet_fail_the_entry_and_say_so(
    station: CommissionStation, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pickcli.commission.commission_truck.pallet_gap", lambda *_: -0.065)
    truck = CommissionTruck(station, DriveNoise(), 5)
    with pytest.raises(ActionError, match="the forks or the truck met the pallet, 65 mm deep"):
        truck.enter()
    assert truck.n_collisions == 1 and truck.drives[-1].figures["pallet_gap_m"] == -0.065


def test_a_tree_that_fails_without_an_end_of_its_own_ends_the_trial_early(tmp_path: Path, two: Path) -> None:
    tree = tmp_path / "early.yaml"
    tree.write_text(
        "format: apc strategy\nversion: 1\nname: early\ndescription: It chooses before it looked.\n"
        "tree: {sequence: [enter_pallet, look_at_load]}\n"
    )
    strategy = load_strategy(str(tree), TrialKind.COMMISSION)
    result = play(two, seed=5, strategy=strategy).result
    assert result.aborted.startswith("look_at_load: ") and not result.is_success


def test_an_aborted_commission_has_exit_code_6(tmp_path: Path) -> None:
    path = written(tmp_path, lambda data: data["pallet"].update(there=False))
    answer = apc("run-trial", path, "--seed", 1, "-o", tmp_path / "run")
    assert answer.code == 6 and "enter_pallet" in answer.out
    assert "ended where the truck stood after enter_pallet" in answer.err
    assert {path.name for path in (tmp_path / "run").iterdir()} == {
        "trial.json", "commission.yaml", "items.yaml"
    }  # fmt: skip
    assert apc("show", tmp_path / "run", "-o", tmp_path / "run.html").code == 0


def test_options_and_strategies_of_orders_are_refused(tmp_path: Path) -> None:
    misused(
        apc("run-trial", SHIPPED, "--stow-rule", "points", "-o", tmp_path / "a"), "--stow-rule", "commissions"
    )
    misused(apc("run-trial", SHIPPED, "--perception", "camera", "-o", tmp_path / "a"), "--perception camera")
    refused(
        apc("run-trial", SHIPPED, "--strategy", "kth", "-o", tmp_path / "a"), 3,
        "kth: is a strategy of trials of the kind order, not of the kind commission; name another",
    )  # fmt: skip
    refused(
        apc("run-trial", "jsk_pick_sample", "--strategy", "apple", "-o", tmp_path / "a"), 3,
        "apple: is a strategy of trials of the kind commission, not of the kind order",
    )  # fmt: skip
    refused(
        apc("run-trial", SHIPPED, "--cell", "ur5e_crates", "-o", tmp_path / "a"), 3, "no table called load"
    )
    bad = written(tmp_path, lambda data: data["start"].update(position=[9, 9]))
    refused(apc("run-trial", bad, "-o", tmp_path / "a"), 3, bad, "start: the truck at the start is")
    assert not (tmp_path / "a").exists()


def test_a_deviation_decides_whether_the_pallet_is_delivered(played: PlayedCommission) -> None:
    result = played.result
    assert result.delivered is not None and result.is_delivered
    far = replace(result, delivered=replace(result.delivered, distance=0.07))
    turned = replace(result, delivered=replace(result.delivered, turn=0.04))
    assert not far.is_success and not turned.is_success and not replace(result, n_collisions=1).is_success


def test_the_clearance_of_a_loaded_drive_counts_the_pallet_where_it_truly_is(
    station: CommissionStation,
) -> None:
    truck = CommissionTruck(station, DriveNoise(), 0)
    area = station.loaded(station.at_load, station.at_load, 0.0)
    poses, entered = np.array([[0.6, 1.1, 0.0]]), station.pallet_in_truck
    assert truck._clearance(area, poses) == pytest.approx(float(clearances(area, poses).min()))
    truck.on_forks, truck.is_raised = entered, True
    as_planned = truck._clearance(area, poses)
    assert as_planned == pytest.approx(float(clearances(area, poses).min()), abs=1e-6)
    truck.on_forks = entered - np.array([0.006, 0.0, 0.0])  # towards the wall
    assert truck._clearance(area, poses) == pytest.approx(as_planned - 0.006, abs=1e-6)
