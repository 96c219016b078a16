"""The record of a trial is read strictly: what its readers need is there, in the form that they need."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from pickcli.errors import StaleError
from pickcli.perception.items.item_observation import ItemObservation
from pickcli.perception.items.routing import ItemRoute
from pickcli.perception.textures.opencv import VERSION
from pickcli.perception.textures.sift_views import SiftViews
from pickcli.trial.loop import run_trial
from pickcli.trial.trial_perception import LookRecord, PerceivedItem
from pickcli.trial.trial_record import read_record, record_text, trial_record, write_record
from pickcli.trial.trial_result import TrialResult
from support.handmade_plans import CRAYOLA, cell
from support.order_builders import pick_order
from support.scripted_trial import ScriptedTrial, scene_of

Refused = Callable[[Callable[[], object]], str]


@pytest.fixture(scope="module")
def result() -> TrialResult:
    """Of a trial with a target that was delivered and one without a plan."""
    order = pick_order(
        {"bin_B": (CRAYOLA, "dove_beauty_bar")}, ("bin_B", CRAYOLA), ("bin_B", "dove_beauty_bar")
    )
    script = ScriptedTrial(scene_of(order, cell()), no_plan=frozenset({"dove_beauty_bar"}))
    return run_trial(order, script.interfaces())


@pytest.fixture(scope="module")
def text(result: TrialResult) -> str:
    """The record of that trial."""
    return record_text(trial_record(result, "order.json", wall_s=0.5))


def test_what_was_written_is_read_again(text: str, tmp_path: Path) -> None:
    record = json.loads(text)
    write_record(tmp_path / "trial.json", record)
    assert read_record(tmp_path / "trial.json") == record


@pytest.mark.parametrize(
    ("route", "has_opencv"),
    [(ItemRoute(SiftViews.ALL), True), (ItemRoute(None, "prints are left out"), False), (None, False)],
)
def test_opencv_is_among_the_versions_if_a_print_was_looked_for(
    result: TrialResult, route: ItemRoute | None, has_opencv: bool
) -> None:
    answer = ItemObservation(CRAYOLA, cell().item(CRAYOLA), None, 0.0, "no pose", None, None, route=route)
    look = LookRecord(1, {}, (PerceivedItem("bin_B", answer, None, None),), {})
    versions = trial_record(replace(result, looks=(look,)), "order.json", wall_s=0.5)["made_from"]["versions"]
    assert versions.get("opencv") == (VERSION if has_opencv else None)
    assert {"apc-pick", "python", "numpy", "scipy", "pybullet"} <= set(versions)


FAULTS: dict[str, tuple[Callable[[Any], object], str]] = {
    "a score of half points": (lambda r: r.update(score=0.5), "score: expected"),
    "no shift of the pod": (lambda r: r.pop("pod_shift"), "pod_shift: expected"),
    "attempts that are no list": (lambda r: r.update(attempts=7), "attempts: expected"),
    "an attempt without an execution": (lambda r: r["attempts"][0].pop("execution"), "attempts[0].execution"),
    "a text for a force": (
        lambda r: r["attempts"][0]["execution"].update(
            collisions=[{"a": "x", "b": "y", "t_start": 0.0, "depth": 0.0, "force": "hard"}]
        ),
        "attempts[0].execution.collisions[0].force: expected",
    ),
    "so many reasons that nobody lists them": (
        lambda r: r["attempts"][1]["reasons"][0].update(count=10**15),
        "attempts[1].reasons[0].count: expected",
    ),
    "a line of the score without points": (
        lambda r: r["score_lines"][0].pop("points"), "score_lines[0].points",
    ),
    "another score than that of its lines": (
        lambda r: r.update(score=r["score"] + 5), "score is 15, but score_lines add up to 10",
    ),
    "a target with other points than its line": (
        lambda r: r["items"][1].update(points=30), "items[1].points is 30, but score_lines[1].points 0",
    ),
    "fewer lines of the score than targets": (
        lambda r: r.update(score_lines=r["score_lines"][:1]), "score_lines has 1 lines for 2 items",
    ),
    "a scene without a hash": (lambda r: r["made_from"].pop("scene_hash"), "made_from.scene_hash"),
}  # fmt: skip


@pytest.mark.parametrize("what", FAULTS)
def test_every_fault_is_told_with_its_field(text: str, what: str, tmp_path: Path, refused: Refused) -> None:
    spoil, said = FAULTS[what]
    record, path = json.loads(text), tmp_path / "trial.json"
    spoil(record)
    path.write_text(json.dumps(record))
    message = refused(lambda: read_record(path))
    assert f"{path}: no sound record of a trial" in message and said in message


def test_of_many_faults_the_first_are_told(text: str, tmp_path: Path, refused: Refused) -> None:
    record, path = json.loads(text), tmp_path / "trial.json"
    record["items"] = 20 * [{}]
    path.write_text(json.dumps(record))
    lines = refused(lambda: read_record(path)).splitlines()
    assert len(lines) == 10 and lines[-1].strip() == "and 12 more"


def test_another_version_is_stale(text: str, tmp_path: Path) -> None:
    path = tmp_path / "trial.json"
    path.write_text(text.replace('"version": 2', '"version": 1'))
    with pytest.raises(StaleError, match="version 1"):
        read_record(path)
