"""``apc show``: a page of whatever is named, told, the same again, and refused before any work."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest

from pickcli.scene.scene_file import write_scene
from pickcli.trial.loop import run_trial
from pickcli.trial.motion_record import motion_values, write_motion
from pickcli.trial.trial_record import trial_record, write_record
from support.command_line import Made, apc, refused
from support.handmade_plans import CRAYOLA, pick
from support.order_builders import pick_order
from support.page_files import document_of
from support.recorded_pick import play
from support.scripted_trial import ScriptedTrial


def test_a_plan_is_shown_in_its_scene(made: Made, tmp_path: Path) -> None:
    pages = [tmp_path / "one.html", tmp_path / "two.html"]
    for page in pages:
        answer = apc("show", made.plan, "--scene", made.scene, "-o", page, "--json")
        assert answer.code == 0, answer.err
        told = json.loads(answer.out)
        assert told["path"] == str(page) and told["kind"] == "plan" and told["bytes"] == page.stat().st_size
    assert pages[0].read_bytes() == pages[1].read_bytes()
    shown = document_of(pages[0].read_bytes())
    assert shown["kind"] == "plan" and shown["motion"]["carried"] and "marks" not in shown


@pytest.mark.parametrize("what", ["scene", "move", "cell", "apc2016_delft"])
def test_other_things_are_shown(made: Made, what: str, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    named = {"scene": (made.scene,), "move": (made.move, "--scene", made.scene)}
    from pickcli.cell.data_path import data_path

    words = named.get(what, (data_path() / "cells" / "panda_table" if what == "cell" else what,))
    answer = apc("show", *words, "-o", page)
    assert answer.code == 0, answer.err
    assert answer.out.startswith(f"wrote {page}: ")
    assert document_of(page.read_bytes())["robot"]["links"]


def test_what_cannot_be_shown_is_refused(made: Made, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    for words, code, text in (
        ((made.plan, "-o", page), 2, "no surroundings"),
        ((made.order, "-o", page), 3, "is an order, but a roadmap"),
        ((made.scene, "--scene", made.scene, "-o", page), 2, "--scene applies only to a plan"),
        ((made.scene, "-o", tmp_path / "page.png"), 3, "a page is written as .html"),
        ((made.scene, "-o", tmp_path / "page.htm"), 3, "a page is written as .html"),
        ((tmp_path / "nothing.json", "-o", page), 3, "no such file"),
        ((made.plan, "--cell", "apc2016_delft", "-o", page), 4, "the plan was made for the scene"),
    ):
        answer = apc("show", *words)
        assert (answer.code, page.exists()) == (code, False), answer.err
        assert text in answer.err
    page.write_text("mine")
    answer = apc("show", made.scene, "-o", page)
    assert answer.code == 3 and "exists already" in answer.err and page.read_text() == "mine"


@pytest.fixture
def trial(tmp_path: Path) -> Path:
    """The folder of a trial of one target."""
    scene, folder = pick()[1], tmp_path / "trial"
    place = scene.find(CRAYOLA).location
    order = pick_order({place: (CRAYOLA,)}, (place, CRAYOLA))
    folder.mkdir()
    result = run_trial(order, ScriptedTrial(scene).interfaces())
    record, motion = trial_record(result, "order.json", 0.0), motion_values(play()[0], [scene.cell])
    record["attempts"][0]["plan"]["query"] = motion["executions"][0]["query"]  # one trial's, of two doubles
    write_record(folder / "trial.json", record)
    write_scene(result.before, folder / "scene.json")
    write_motion(folder / "motion.json.gz", motion)
    return folder


def test_a_trial_is_shown_in_its_own_scene_alone(made: Made, trial: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    answer = apc("show", trial, "-o", page, "--json")
    assert answer.code == 0 and json.loads(answer.out)["kind"] == "trial"
    page.unlink()
    (trial / "scene.json").write_bytes(made.scene.read_bytes())
    refused(apc("show", trial, "-o", page), 4, f"{trial / 'scene.json'}: is not the scene of")
    assert not page.exists()


def test_what_is_no_trial_and_no_cell_is_told_as_that(tmp_path: Path) -> None:
    page, folder = tmp_path / "page.html", tmp_path / "nothing"
    folder.mkdir()
    told = f"{folder}: is a folder without a finished trial (trial.json) and without a cell (cell.yaml)"
    refused(apc("show", folder, "-o", page), 3, told)
    refused(apc("show", "/dev/zero", "-o", page), 3, "/dev/zero: is a device, not a regular file")
    assert not page.exists()


def test_a_motion_of_another_trial_is_refused(trial: Path, tmp_path: Path) -> None:
    path = trial / "motion.json.gz"
    values = json.loads(gzip.decompress(path.read_bytes()))
    values["executions"][0]["query"] = "pick something else"
    write_motion(path, values)
    refused(apc("show", trial, "-o", tmp_path / "page.html"), 4, f"{path}: is the motion of another trial")
    assert not (tmp_path / "page.html").exists()


def test_a_motion_of_arms_that_the_cell_lacks_is_refused(trial: Path, tmp_path: Path) -> None:
    path = trial / "motion.json.gz"
    values = json.loads(gzip.decompress(path.read_bytes()))
    write_motion(path, values | {"arms": ["thumb"]})
    answer = apc("show", trial, "-o", tmp_path / "page.html")
    assert (
        answer.code == 3
        and "one arm" in answer.err
        and "thumb" in answer.err
        and not (tmp_path / "page.html").exists()
    )


def test_a_trial_that_was_edited_is_bad_input(trial: Path, tmp_path: Path) -> None:
    record = json.loads((trial / "trial.json").read_text())
    del record["attempts"][0]["execution"]
    (trial / "trial.json").write_text(json.dumps(record))
    for shown in (trial, trial.parent):
        refused(apc("show", shown, "-o", tmp_path / "page.html"), 3, "attempts[0].execution")
