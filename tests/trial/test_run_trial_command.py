"""``apc run-trial``: what is wrong is refused before any work, with the right exit code."""

from __future__ import annotations

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.cell.pod_tolerance import Displacement
from pickcli.commands.options.pod_shift import parse_pod_shift
from pickcli.commands.options.trial_options import parse_noise
from pickcli.commands.run_trial import command
from pickcli.errors import ApcError
from pickcli.simulation.reality import DEFAULT
from pickcli.trial.pod_shift import NONE, RANDOM, standing
from support.command_line import apc

TASKS = Path(__file__).parents[2] / "data" / "tasks"


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(command, [str(a) for a in arguments])


def refused(result: Result) -> str:
    assert isinstance(result.exception, ApcError), result.output
    assert result.exception.exit_code == 3
    assert result.stdout == ""
    return str(result.exception)


def test_help_has_an_example() -> None:
    result = run("--help")
    assert result.exit_code == 0
    assert "apc run-trial jsk_pick_sample" in result.output


@pytest.mark.parametrize("text", ["2", "2,1,3", "a,b", "-1,1", "2,nan", "inf,1", "2,90"])
def test_impossible_noise_is_a_usage_error(text: str) -> None:
    result = run(TASKS / "jsk_pick_sample.json", f"--pose-noise={text}")
    assert result.exit_code == 2
    assert "--pose-noise" in result.output


def test_noise_is_read_in_millimetres_and_degrees() -> None:
    noise = parse_noise(None, None, "3,0.5")
    assert noise.position == pytest.approx(0.003)
    assert noise.angle == pytest.approx(math.radians(0.5))


def test_the_state_after_a_task_is_refused_before_any_work(tmp_path: Path) -> None:
    state = json.loads((TASKS / "jsk_stow_sample.json").read_text()) | {"tote_contents": []}
    (tmp_path / "after.json").write_text(json.dumps(state))
    message = refused(run(tmp_path / "after.json", "-o", tmp_path / "out"))
    assert "after.json" in message and "nothing to do" in message
    assert not (tmp_path / "out").exists()


def test_a_pick_order_with_a_filled_tote_is_refused_before_any_work(tmp_path: Path) -> None:
    order = json.loads((TASKS / "jsk_pick_sample.json").read_text()) | {"tote_contents": ["jane_eyre_dvd"]}
    (tmp_path / "order.json").write_text(json.dumps(order))
    message = refused(run(tmp_path / "order.json", "-o", tmp_path / "out"))
    assert "order.json: tote_contents names 1 items (jane_eyre_dvd)" in message
    assert not (tmp_path / "out").exists()


def test_a_name_beside_its_file_is_told_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine.json").write_text("{}")
    monkeypatch.chdir(tmp_path)
    assert "did you mean the file 'mine.json'?" in refused(run("mine"))
    assert f"did you mean the file '{tmp_path}/mine.json'?" in refused(run(tmp_path / "mine"))
    assert "unknown order 'other'; known: apple_belts_commission, apple_cluster_commission" in refused(
        run("other")
    )
    assert "did you mean 'apple_commission'?" in refused(run("apple_comission"))


def test_no_name_at_all_is_told_so() -> None:
    assert "no order is named; give the path of a JSON file, or one of delft_pick_2" in refused(run(""))


def test_a_folder_is_no_order_and_is_told_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert ".: is a folder" in refused(run("."))


def test_too_much_for_a_bin_is_told_with_the_file_before_any_work(tmp_path: Path) -> None:
    order = json.loads((TASKS / "jsk_pick_sample.json").read_text())
    order["bin_contents"]["bin_L"] += ["kleenex_tissue_box"] * 40
    (tmp_path / "order.json").write_text(json.dumps(order))
    message = refused(run(tmp_path / "order.json", "-o", tmp_path / "out"))
    assert f"{tmp_path / 'order.json'}: bin_L: its 4" in message and "litres, the place has" in message
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("text", ["Random", "NONE", "random", "none"])
def test_words_for_the_pod_shift_are_read_in_any_case(text: str) -> None:
    assert parse_pod_shift(None, None, text) == text.lower()


@pytest.mark.parametrize(
    ("shift", "level", "is_shifted", "told"),
    [(NONE, True, False, False), (RANDOM, False, True, True), (None, True, True, True),
     (None, False, False, False), (Displacement(0.02, 0.0, 0.0), True, True, False)],
)  # fmt: skip
def test_the_level_that_is_told_is_the_one_that_is_played(
    shift: Displacement | str | None, level: bool, is_shifted: bool, told: bool
) -> None:
    cell = load_cell("apc2016_delft")
    T_world_pod, reality = standing(shift, replace(DEFAULT, pod_shift=level), cell, 3)
    assert bool((T_world_pod != cell.T_world_pod).any()) == is_shifted
    assert reality.pod_shift is told


def test_a_missing_order_is_refused(tmp_path: Path) -> None:
    assert "no such file" in refused(run(tmp_path / "none.json"))


@pytest.mark.parametrize(
    "path", sorted((Path(__file__).parent / "invalid_orders").glob("*.json")), ids=lambda p: p.stem
)
def test_bad_orders_leave_nothing_behind(path: Path, tmp_path: Path) -> None:
    assert "not JSON" in refused(run(path, "-o", tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_existing_results_are_not_replaced_unasked(tmp_path: Path) -> None:
    (tmp_path / "trial.json").write_text("mine")
    message = refused(run(TASKS / "jsk_pick_sample.json", "-o", tmp_path))
    assert "--overwrite" in message
    assert (tmp_path / "trial.json").read_text() == "mine"
    message = refused(run(TASKS / "jsk_pick_sample.json", "-o", tmp_path / "trial.json", "--overwrite"))
    assert "is a file" in message


@pytest.mark.parametrize("name", ["plan_003.json", "seen_012.json", "trial.json"])
def test_an_order_that_the_trial_would_replace_is_refused(name: str, tmp_path: Path) -> None:
    order = tmp_path / name
    shutil.copy(TASKS / "delft_pick_2.json", order)
    told = refused(run(order, "--overwrite", "-o", tmp_path))
    assert "is an input of this command" in told and order.exists()


def test_a_folder_where_a_file_would_be_is_refused_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "plan_050.json").mkdir()
    (tmp_path / "trial.json").write_text("old")
    told = refused(run(TASKS / "delft_pick_2.json", "--overwrite", "-o", tmp_path))
    assert "plan_050.json: is a folder" in told and (tmp_path / "trial.json").read_text() == "old"


def test_a_bad_reality_is_refused_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "hall.yaml").write_text("format: apc reality\nversion: 1\nlook_tme: 2\n")
    order, levels = TASKS / "jsk_pick_sample.json", tmp_path / "hall.yaml"
    assert "hall.yaml:3:1: look_tme" in refused(run(order, "--reality", levels, "-o", tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_a_trial_in_a_cell_without_home_is_refused_before_any_work(tmp_path: Path) -> None:
    cell = tmp_path / "crates"
    shutil.copytree(data_path() / "cells" / "ur5e_crates", cell)
    text = (cell / "cell.yaml").read_text().replace("{name: home, kind: home", "{name: rest, kind: midway")
    (cell / "cell.yaml").write_text(text)
    out = tmp_path / "trial"
    answer = apc("run-trial", cell / "moves_24.json", "--cell", cell, "-o", out)
    assert answer.code == 3 and "no configuration is named home" in answer.err and not out.exists()


@pytest.mark.slow
def test_every_plan_that_is_kept_is_accepted_for_the_scene_beside_it(tmp_path: Path) -> None:
    order = tmp_path / "order.json"
    bins: dict[str, list[str]] = {f"bin_{letter}": [] for letter in "ABCDEFGHIJKL"}
    bins |= {"bin_C": ["dove_beauty_bar"], "bin_K": ["crayola_24_ct", "jane_eyre_dvd"]}
    wanted = [{"bin": "bin_C", "item": "dove_beauty_bar"}, {"bin": "bin_K", "item": "jane_eyre_dvd"}]
    order.write_text(json.dumps({"bin_contents": bins, "tote_contents": [], "work_order": wanted}))
    played = run(order, "--seed", "5", "--perception", "noise", "--plans", "-o", tmp_path / "trial")
    assert played.exit_code == 0, played.output
    plans = sorted((tmp_path / "trial").glob("plan_*.json"))
    assert len(plans) >= 2 and f"plan_*.json, seen_*.json: {len(plans)} of each" in played.stdout
    for plan in plans:
        seen = plan.with_name(plan.name.replace("plan_", "seen_"))
        assert apc("verify", plan, "--scene", seen).code == 0
