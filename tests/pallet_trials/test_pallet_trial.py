"""An arm stacks the cartons of a pallet: all, cleanly, where they are planned, and the same way each time."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pickcli.files.packed_array import unpacked
from pickcli.page.page_scene import Tone
from pickcli.page.pallet_trial_page import pallet_trial_page
from pickcli.pallet_trials import pallet_trial
from pickcli.pallet_trials.pallet_folder import write_pallet_folder
from pickcli.pallet_trials.pallet_record import pallet_record
from pickcli.pallet_trials.pallet_result import CartonOutcome
from pickcli.pallet_trials.pallet_station import PalletStation
from pickcli.pallet_trials.pallet_trial import PalletTrialRequest, PlayedPallet, play_pallet
from pickcli.palletizing.pallet_stack_file import write_stacked_pallet
from pickcli.planning.planning_context import PlanningContext
from pickcli.simulation import supervision
from pickcli.simulation.execution import Execution
from pickcli.trial.motion_record import read_motion
from support.command_line import apc, misused, refused
from support.pallet_stacks import CARTONS, LOW, PALLET, pallet_cell, stack_of, station

ORDER: dict[str, Any] = {
    "format": "apc pallet",
    "version": 1,
    "pallet": {"container": "half_pallet", "height": 0.694, "edge": 0.01},
    "clearance": 0.015,
    "fall": 0.006,
    "cartons": [
        {"id": "milk", "size": [0.3, 0.2, 0.2], "mass": 5.0, "bears": 30.0, "count": 3},
        {"id": "crisps", "size": [0.4, 0.3, 0.2], "mass": 1.5, "bears": 5.0, "count": 2},
    ],
}


@pytest.fixture(scope="module")
def played() -> PlayedPallet:
    return play_pallet(
        PalletTrialRequest(stack_of(*CARTONS)), station(), PlanningContext(station().cell)
    )  # fmt: skip


def test_every_carton_is_put_up_at_its_place_and_nothing_collides(played: PlayedPallet) -> None:
    result = played.result
    assert [each.outcome for each in result.cartons] == [CartonOutcome.PLACED] * 3
    assert result.is_clean and result.n_stops == 0 and not result.has_collapsed and result.score == 1.0
    for each in result.cartons:
        assert each.set_down is not None and each.at_end is not None
        assert each.set_down.aside < 0.004 and abs(each.set_down.height) < 0.001 and each.set_down.turn < 0.01
        assert each.sinking < 1e-3
    assert result.boxes_an_hour > 400.0
    assert {p.location for p in played.after.items} == {"pallet"}


def test_each_plan_is_certified_for_what_truly_stands_within_the_errors(played: PlayedPallet) -> None:
    assert [len(each.seen.items) for each in played.plans] == [1, 2, 3]
    for each in played.plans:
        assert each.plan.certificate is not None and each.plan.certificate.min_clearance >= 0.003
        for placed in each.seen.items:
            truly = next(other for other in played.after.items if other.id == placed.id)
            if placed.location == "pallet":
                off = placed.T_world_item[:3, 3] - truly.T_world_item[:3, 3]
                assert 0.0 < float((off @ off) ** 0.5) <= each.seen.bound(placed) + 1e-4


def test_the_record_has_what_the_result_says(played: PlayedPallet) -> None:
    record = played.result.record()
    assert (record["ordered"], record["placed"], record["score"], record["collapsed"]) == (3, 3, 1.0, False)
    assert [each["carton"] for each in record["cartons"]] == [each.carton for each in played.result.cartons]
    assert record["aside_m"]["worst"] == max(each["set_down"]["aside"] for each in record["cartons"])
    assert not {"planning_ms", "verifying_ms"} & record["cartons"][0].keys()
    assert record["statistics"]["planning_ms"]["worst"] > 0.0


def test_what_rests_on_a_carton_that_was_lost_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """The arm never moves: what it does not take stays on the infeed, and is taken away by hand."""

    def idle(plan: Any, world: Any, **_: Any) -> Execution:
        world.wait(0.1)
        return Execution(
            t_start=world.t - 0.1, t_end=world.t, stop=None, stopped_in=None, events=(), missed=(),
            limit_violations=(), max_lag=0.0, collisions=(), releases=(), falls=(), held=None, max_load=0.0,
        )  # fmt: skip

    monkeypatch.setattr(pallet_trial, "execute", idle)
    stack = stack_of(*LOW, CARTONS[0])
    own = PalletStation.of(pallet_cell(), stack)
    result = play_pallet(PalletTrialRequest(stack), own, PlanningContext(own.cell)).result
    assert [each.outcome for each in result.cartons] == [CartonOutcome.LOST] * 2 + [CartonOutcome.LEFT]
    assert [each.attempts for each in result.cartons] == [pallet_trial.MOST_ATTEMPTS] * 2 + [0]
    assert "aside" in result.cartons[0].reason
    assert result.cartons[2].reason.startswith("rests on low_")
    assert result.score == 0.0 and result.n_placed == 0


def test_what_is_held_at_a_stop_is_taken_away_by_hand_and_the_arm_brought_home(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A supervisor that knows of no payload takes the weight of a carton for a contact."""
    monkeypatch.setattr(supervision, "PAYLOAD_FACTOR", 0.0)
    stack = stack_of(CARTONS[0])
    own = PalletStation.of(pallet_cell(), stack)
    trial = play_pallet(PalletTrialRequest(stack), own, PlanningContext(own.cell))
    (carton,) = trial.result.cartons
    assert carton.outcome is CartonOutcome.LOST and carton.attempts == 1 and trial.result.n_stops == 1
    assert carton.reason.startswith("stopped in ") and "unexpected contact" in carton.reason
    assert trial.after.items == () and trial.result.is_clean and not trial.result.has_collapsed
    assert np.abs(trial.recorder.joints[-1] - own.cell.home.q).max() < 1e-3


def test_cartons_come_a_little_off_the_middle_of_the_infeed_and_differently(played: PlayedPallet) -> None:
    infeed = station().cell.T_world_place(station().cell.places["infeed"])
    came = [placed for each in played.plans for placed in each.seen.items if placed.location == "infeed"]
    off = [(placed.T_world_item - infeed)[:2, 3] for placed in came]
    assert len(came) == 3 and len({tuple(each) for each in off}) == 3
    assert all(1e-4 < np.abs(each).max() < pallet_trial.ARRIVES_OFF + 0.001 for each in off)


def test_its_page_shows_each_carton_wait_come_and_stand(played: PlayedPallet, tmp_path: Path) -> None:
    stack, own = stack_of(*CARTONS), station()
    record = pallet_record(PalletTrialRequest(stack), own, played, "o.json", "0")
    write_pallet_folder(tmp_path, stack, own, played, record)
    page = pallet_trial_page(record, stack, own, read_motion(tmp_path / "motion.json.gz"))
    assert page.motion is not None and page.clearance is not None
    assert [chapter.tone for chapter in page.chapters] == [Tone.GOOD] * 3
    infeed = own.cell.T_world_place(own.cell.places["infeed"])[:3, 3]
    for track, each in zip(
        page.motion.tracks, sorted(played.result.cartons, key=lambda c: c.carton), strict=True
    ):
        times, poses = unpacked(track.times), unpacked(track.poses)
        came = next(k for k, row in enumerate(poses) if np.hypot(*(row[:2] - infeed[:2])) < 0.01)
        assert track.item == each.carton and times[came] == pytest.approx(each.t_start, abs=0.05)
        assert came == 0 or np.hypot(*(poses[0][:2] - infeed[:2])) > 0.9
        end = next(placed for placed in played.after.items if placed.id == each.carton).T_world_item[:3, 3]
        assert poses[-1][:3] == pytest.approx(end, abs=1e-3)
    distances = unpacked(page.clearance.values)
    assert distances.min() > -0.005
    assert apc("show", tmp_path, "-o", tmp_path / "p.html").code == 0
    (tmp_path / "trial.json").write_text(json.dumps(record | {"placed": 2}))
    refused(apc("show", tmp_path, "-o", tmp_path / "q.html"), 4, "is the motion of another trial")
    (tmp_path / "trial.json").write_text(json.dumps({k: v for k, v in record.items() if k != "cartons"}))
    refused(apc("show", tmp_path, "-o", tmp_path / "q.html"), 3, "cartons missing")


def test_a_stack_that_was_changed_since_is_not_shown(played: PlayedPallet, tmp_path: Path) -> None:
    record = pallet_record(PalletTrialRequest(stack_of(*CARTONS)), station(), played, "o.json", "0")
    write_pallet_folder(tmp_path, stack_of(*CARTONS), station(), played, record)
    stack = json.loads((tmp_path / "stack.json").read_text())
    stack["placements"][0]["bears"] += 1.0
    (tmp_path / "stack.json").write_text(json.dumps(stack))
    refused(apc("show", tmp_path, "-o", tmp_path / "p.html"), 4, "is not the stack that the record was made")


@pytest.mark.slow
def test_an_order_is_stacked_its_plans_verify_and_its_bytes_are_those_of_the_seed(tmp_path: Path) -> None:
    order = tmp_path / "order.yaml"
    order.write_text(yaml.safe_dump(ORDER))
    first, again = tmp_path / "first", tmp_path / "again"
    told = apc("run-trial", order, "--seed", "2", "--plans", "-o", first)
    assert told.code == 0 and "5 of 5 cartons stacked, score 1.00" in told.out
    assert apc("run-trial", order, "--seed", "2", "--plans", "-o", again).code == 0
    names = sorted(path.name for path in first.iterdir())
    assert names == sorted(path.name for path in again.iterdir())
    for name in names:
        if name != "trial.json":
            assert (first / name).read_bytes() == (again / name).read_bytes(), name
    records = [json.loads((folder / "trial.json").read_text()) for folder in (first, again)]
    assert records[0] | {"statistics": 0} == records[1] | {"statistics": 0}
    assert records[0]["collisions"] == records[0]["limit_violations"] == records[0]["stops"] == 0
    for k in (1, 5):
        answer = apc(
            "verify", first / f"plan_{k:03}.json", "--scene", first / f"seen_{k:03}.json",
            "--items", first / "items.yaml",
        )  # fmt: skip
        assert answer.code == 0 and "accepted" in answer.out
    assert apc("verify", first / "stack.json", "--order", order).code == 0


def test_a_stack_that_was_edited_is_refused_before_anything_moves(tmp_path: Path) -> None:
    path, folder = tmp_path / "stack.json", tmp_path / "run"
    write_stacked_pallet(path, stack_of(*CARTONS))
    values = json.loads(path.read_text())
    values["placements"][2]["position"][0] += 0.1
    path.write_text(json.dumps(values))
    refused(apc("run-trial", path, "-o", folder), 4, path, "is not borne within its polygon")
    assert not folder.exists()


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"pallet": {"container": "eur_pallet"}}, "the stack is for a pallet of 1.2 x 0.8 m"),
        ({"cartons": [{"id": "bricks", "size": [0.3, 0.3, 0.3], "mass": 60.0}]}, "bricks may weigh 66 kg"),
        ({"cartons": [{"id": "tube", "size": [0.5, 0.05, 0.1], "mass": 1.0}]}, "is too narrow for the cup"),
        ({"cartons": [{"id": "box", "size": [0.3, 0.3], "mass": 1.0}]}, "size"),
    ],
)
def test_an_order_that_the_cell_cannot_stack_is_refused(
    changed: dict[str, Any], told: str, tmp_path: Path
) -> None:
    path, folder = tmp_path / "order.yaml", tmp_path / "run"
    path.write_text(yaml.safe_dump(ORDER | changed))
    refused(apc("run-trial", path, "-o", folder), 3, path, told)
    assert not folder.exists()


def test_options_of_other_trials_are_misuse(tmp_path: Path) -> None:
    path = tmp_path / "stack.json"
    write_stacked_pallet(path, stack_of(CARTONS[0], pallet=replace(PALLET, height=0.5)))
    for option, told in ((("--pod-shift", "none"), "--pod-shift applies to orders, not to pallets"),
                         (("--perception", "camera"), "not perceived by cameras")):  # fmt: skip
        misused(apc("run-trial", path, *option, "-o", tmp_path / "run"), told)
    refused(
        apc("run-trial", path, "--cell", "ur5e_crates", "-o", tmp_path / "run"), 3, "no place called pallet"
    )
