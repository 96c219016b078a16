"""What a trial leaves on disk is whole, readable again, and never replaces anything unasked."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.errors import InputError
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.trial.loop import run_trial
from pickcli.trial.order import OrderKind
from pickcli.trial.order_file import read_order
from pickcli.trial.trial_folder import (
    NAMES,
    numbered_files,
    pictures_of_looks,
    read_look_pictures,
    refuse_existing_folder,
    write_folder,
)
from pickcli.trial.trial_perception import LookRecord
from pickcli.trial.trial_record import record_text, trial_record
from pickcli.trial.trial_settings import TrialSettings
from support.order_builders import pick_order
from support.scripted_trial import ScriptedTrial, scene_of

CELL = load_cell("apc2016_delft")
ORDER = pick_order({"bin_A": ("crayola_24_ct", "jane_eyre_dvd")}, ("bin_A", "crayola_24_ct"))


def test_the_official_output_says_what_was_delivered(tmp_path: Path) -> None:
    result = run_trial(ORDER, ScriptedTrial(scene_of(ORDER, CELL)).interfaces())
    record = trial_record(result, "order.json", wall_s=0.5)
    picture = np.zeros((4, 6, 3), np.uint8)
    folder = tmp_path / "runs" / "order-0"
    pictures = {"before": picture, "after": picture}
    paths = write_folder(folder, result, record, pictures, {"format": "apc motion"})
    assert {p.name for p in paths} == {p.name for p in folder.iterdir()} == set(NAMES)
    output = read_order(folder / "output.json", CELL)
    assert output.bin_contents["bin_A"] == ("jane_eyre_dvd",)
    assert output.tote_contents == ("crayola_24_ct",)
    assert "work_order" not in json.loads((folder / "output.json").read_text())
    assert (folder / "trial.json").read_text() == record_text(record)


def test_an_empty_output_is_read_as_such(tmp_path: Path) -> None:
    fake = ScriptedTrial(scene_of(ORDER, CELL), rejects=frozenset({"pick"}))
    result = run_trial(ORDER, fake.interfaces())
    write_folder(tmp_path, result, trial_record(result, "order.json", wall_s=0.5), {})
    output = read_order(tmp_path / "output.json", CELL)
    assert output.kind is OrderKind.OUTPUT
    assert output.bin_contents == ORDER.bin_contents


def test_the_record_keeps_the_levels_of_reality(tmp_path: Path) -> None:
    levels = replace(DEFAULT, mass_error=0.25, look_time=3.0)
    result = run_trial(
        ORDER, ScriptedTrial(scene_of(ORDER, CELL)).interfaces(), TrialSettings(reality=levels)
    )
    written = json.loads(record_text(trial_record(result, "order.json", wall_s=0.5)))
    assert Reality(**written["reality"]) == levels


def test_a_folder_with_files_needs_a_word(tmp_path: Path) -> None:
    refuse_existing_folder(tmp_path / "new", overwrite=False)
    refuse_existing_folder(tmp_path, overwrite=False)
    (tmp_path / "a").write_text("")
    with pytest.raises(InputError, match="--overwrite"):
        refuse_existing_folder(tmp_path, overwrite=False)
    refuse_existing_folder(tmp_path, overwrite=True)


@pytest.mark.parametrize("overwrite", [False, True])
def test_a_link_to_nothing_is_refused_before_any_work(tmp_path: Path, overwrite: bool) -> None:
    link = tmp_path / "runs"
    link.symlink_to(tmp_path / "gone")
    with pytest.raises(InputError, match="runs: is a link to what is not there"):
        refuse_existing_folder(link, overwrite)


def test_a_folder_that_cannot_be_made_is_an_input_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    result = run_trial(ORDER, ScriptedTrial(scene_of(ORDER, CELL)).interfaces())
    with pytest.raises(InputError, match="cannot be made"):
        write_folder(tmp_path / "file" / "sub", result, {}, {})


def test_a_folder_that_was_filled_meanwhile_stays_as_it_is(tmp_path: Path) -> None:
    result = run_trial(ORDER, ScriptedTrial(scene_of(ORDER, CELL)).interfaces())
    picture = np.zeros((4, 6, 3), np.uint8)
    record, pictures = trial_record(result, "order.json", wall_s=0.5), {"before": picture, "after": picture}
    for name in NAMES:
        (tmp_path / name).write_text("theirs")
    with pytest.raises(InputError, match="exists by now"):
        write_folder(tmp_path, result, record, pictures, {}, replace=False)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == dict.fromkeys(NAMES, "theirs")


def test_what_could_not_be_written_keeps_nothing_else_back(tmp_path: Path) -> None:
    result = run_trial(ORDER, ScriptedTrial(scene_of(ORDER, CELL)).interfaces())
    (tmp_path / "after.json").mkdir()
    with pytest.raises(InputError) as told:
        write_folder(tmp_path, result, trial_record(result, "order.json", wall_s=0.5), {})
    assert "after.json: is a folder" in str(told.value) and "--overwrite" in str(told.value)
    assert "written: output.json, scene.json, trial.json; not written: after.json; " in str(told.value)
    assert {p.name for p in tmp_path.iterdir() if p.is_file()} == {"output.json", "scene.json", "trial.json"}


def test_pictures_of_looks_are_read_again_and_those_of_an_earlier_trial_are_gone(tmp_path: Path) -> None:
    result = run_trial(ORDER, ScriptedTrial(scene_of(ORDER, CELL)).interfaces())
    record = trial_record(result, "order.json", wall_s=0.5)
    rng = np.random.default_rng(1)
    first, second = (rng.integers(0, 255, (8, 6, 3), dtype=np.uint8) for _ in range(2))
    looks = [LookRecord(k, {"bin_A": ("hand", "cam_A")}, (), {"bin_A": first}) for k in (1, 2)]
    write_folder(tmp_path, result, record, pictures_of_looks(looks))
    told = [{"number": k, "cameras": {"bin_A": ["hand", "cam_A"]}} for k in (1, 2, 3)]
    found = read_look_pictures(tmp_path, told)
    assert found.keys() == {(1, "bin_A"), (2, "bin_A")} and (found[2, "bin_A"] == first).all()
    once = [replace(looks[0], pictures={"bin_A": second})]
    write_folder(tmp_path, result, record, pictures_of_looks(once))
    found = read_look_pictures(tmp_path, told)
    assert found.keys() == {(1, "bin_A")} and (found[1, "bin_A"] == second).all()


def test_plans_of_attempts_are_kept_on_request_and_those_of_an_earlier_trial_are_gone(tmp_path: Path) -> None:
    result = run_trial(ORDER, ScriptedTrial(scene_of(ORDER, CELL)).interfaces())
    record = trial_record(result, "order.json", wall_s=0.5)
    (tmp_path / "plan_900.json").write_text("of an earlier trial")
    others = ("plan_mine.json", "seen_1.json", "look_mine.png", "plan_007.txt")
    for name in others:
        (tmp_path / name).write_text("mine")
    write_folder(tmp_path, result, record, {}, with_plans=True)
    planned = [k for k, attempt in enumerate(result.attempts, start=1) if attempt.plan is not None]
    assert planned
    numbered = [path.name for path in numbered_files(tmp_path) if path.name.startswith("plan")]
    assert numbered == [f"plan_{k:03}.json" for k in planned]
    for k in planned:
        attempt = result.attempts[k - 1]
        assert attempt.plan is not None and attempt.seen is not None
        kept = json.loads((tmp_path / f"plan_{k:03}.json").read_text())
        assert kept["query"] == attempt.plan.query and kept["statistics"] == {}
        seen = json.loads((tmp_path / f"seen_{k:03}.json").read_text())
        assert [placed["id"] for placed in seen["items"]] == [placed.id for placed in attempt.seen.items]
    write_folder(tmp_path, result, record, {})
    assert not numbered_files(tmp_path)
    assert all((tmp_path / name).read_text() == "mine" for name in others)
