"""Folders of trials as results of jobs: nothing is taken from a result but what such a trial writes."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pickcli.errors import Reason
from pickcli.jobs.job_result import JobResult
from pickcli.monte_carlo.packed_folder import files_of, misfit_of_folder, packed_folder
from pickcli.stream_trials.stream_folder import NAMES
from pickcli.stream_trials.stream_record import RECORDS
from pickcli.trial.trial_folder import is_name_of_trial
from support.scripted_streams import scripted_record

MADE_FROM = {"stream": "a.json", "seed": 0}


def written(folder: Path) -> list[Path]:
    (folder / "trial.json").write_text(json.dumps(scripted_record("a", 0, 0.3)))
    (folder / "stream.json").write_bytes(bytes(range(256)))
    return sorted(folder.iterdir())


def fault(result: JobResult) -> str:
    return misfit_of_folder(result, NAMES.__contains__, RECORDS, MADE_FROM)


def with_files(change: Callable[[dict[str, Any]], object]) -> JobResult:
    files = dict(packed_folder(written).values["files"])
    change(files)
    return JobResult({"files": files})


def with_record(**fields: Any) -> JobResult:
    text = json.dumps(scripted_record("a", 0, 0.3) | fields)
    return with_files(lambda files: files.update({"trial.json": base64.b64encode(text.encode()).decode()}))


def test_a_folder_comes_back_to_the_byte() -> None:
    result = packed_folder(written)
    assert fault(result) == ""
    assert files_of(result)["stream.json"] == bytes(range(256))


@pytest.mark.parametrize(
    "name", ["../victim.txt", "/victim.txt", "sub/trial.json", "..", "", "motion.json.gz/", "notes.txt"]
)
def test_a_file_that_no_such_trial_writes_is_refused(name: str) -> None:
    result = with_files(lambda files: files.update({name: files["trial.json"]}))
    assert f"has the file {name!r}, which no such trial writes" in fault(result)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda files: files.pop("trial.json"), "it has no trial.json"),
        (lambda files: files.update({"trial.json": ""}), "the file is empty"),
        (
            lambda files: files.update({"stream.json": "%%%"}),
            "its files are not in base64, or its trial.json is no text",
        ),
        (
            lambda files: files.update({"trial.json": "AAAAA"}),
            "its files are not in base64, or its trial.json is no text",
        ),
        (
            lambda files: files.update({"trial.json": "/////w=="}),
            "its files are not in base64, or its trial.json is no text",
        ),
        (
            lambda files: files.update({"stream.json": None}),
            "its files are not in base64, or its trial.json is no text",
        ),
        (lambda files: files.update({"trial.json": "bm9uc2Vuc2U="}), "its trial.json:1:1: not JSON"),
        (lambda files: files.update({"trial.json": "e30="}), "no record of a stream"),
    ],
)
def test_a_result_without_a_record_is_refused(change: Callable[[dict[str, Any]], object], told: str) -> None:
    assert told in fault(with_files(change))


@pytest.mark.parametrize("values", [{}, {"files": None}, {"files": ["trial.json"]}])
def test_a_result_without_files_is_refused(values: dict[str, Any]) -> None:
    assert fault(JobResult(values)) == "it has no files"


def test_a_record_of_another_trial_is_refused() -> None:
    made = scripted_record("a", 0, 0.3)["made_from"]
    assert fault(with_record(made_from=made | {"seed": 7})) == "its trial.json is of seed 7 and not 0"
    assert "stream 'b.json' and not 'a.json'" in fault(with_record(made_from=made | {"stream": "b.json"}))


def test_a_record_with_false_counts_is_refused() -> None:
    assert "presented is 9, but items has 4" in fault(with_record(presented=9))


def test_a_reason_instead_of_a_folder_is_refused() -> None:
    assert "instead of files" in fault(JobResult(reason=Reason("no time")))


def test_trials_of_orders_write_pictures_of_looks_and_no_plans() -> None:
    assert is_name_of_trial("look_001_bin_A.png") and is_name_of_trial("after.json")
    others = ["plan_001.json", "look_001_../../x.png", "look_001_a/b.png", "look_001_bin_A.png\n", "x.png"]
    assert not any(map(is_name_of_trial, others))
