"""``apc run-trial``: what is wrong is refused before any work, with the right exit code."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from pickcli.commands.run_trial import command, parse_noise
from pickcli.errors import ApcError

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


def test_stow_orders_are_refused_before_any_work(tmp_path: Path) -> None:
    message = refused(run(TASKS / "jsk_stow_sample.json", "-o", tmp_path / "out"))
    assert "jsk_stow_sample.json" in message and "stow" in message
    assert not (tmp_path / "out").exists()


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


def test_a_bad_reality_is_refused_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "hall.yaml").write_text("format: apc reality\nversion: 1\nlook_tme: 2\n")
    order, levels = TASKS / "jsk_pick_sample.json", tmp_path / "hall.yaml"
    assert "hall.yaml:3:1: look_tme" in refused(run(order, "--reality", levels, "-o", tmp_path / "out"))
    assert not (tmp_path / "out").exists()
