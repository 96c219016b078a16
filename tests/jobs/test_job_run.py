"""One build: which tasks are begun first, and what is told of the work that is left."""

from __future__ import annotations

from pathlib import Path

import pytest

from pickcli.errors import DamagedError, InputError
from pickcli.jobs.job_result import JobResult
from pickcli.jobs.job_run import Build, BuildProgress, RunOptions
from pickcli.jobs.journal import Journal
from support.toy_job import MANY, Toy


def test_what_takes_long_is_begun_first_and_records_come_in_the_order_asked_for() -> None:
    told: list[BuildProgress] = []
    records = Build(Toy(), RunOptions(report=told.append)).records(MANY)
    assert [progress.what for progress in told[1:]] == [", ".join(key) for key in reversed(MANY)]
    assert [record.to_bytes() for record in records] == [Toy().make(key).to_bytes() for key in MANY]


def test_the_work_told_is_that_of_the_tasks_to_be_done_now() -> None:
    told: list[BuildProgress] = []
    kept = {key: Toy().make(key) for key in MANY[12:]}
    build = Build(Toy(), RunOptions(report=told.append, kept=kept))
    build.records(MANY)
    assert told[0].effort_total == told[-1].effort_done == sum(range(1, 13))
    assert told[1].effort_done == 12.0 and told[-1].n_kept == 12
    build.records([("one", "more")])
    assert told[-1].effort_done == told[-1].effort_total == sum(range(1, 13)) + 1


@pytest.mark.parametrize("record", [JobResult({"pid": 1}).to_bytes(), b"[1, 2]\n", b""])
def test_a_record_in_the_journal_that_is_no_result_of_its_task_is_refused(
    tmp_path: Path, record: bytes
) -> None:
    journal = Journal(tmp_path / "out", Toy().inputs)
    journal.append(("number", "3"), record)
    build = Build(Toy(), RunOptions(output=tmp_path / "out"))
    assert len(build.records([("number", "2")])) == 1, "which is not the task of that record"
    told = rf"{journal.path}: its record of the task number, 3 is not a result of it: .*; delete this journal"
    with pytest.raises(DamagedError, match=told):
        build.records(MANY)


def test_a_worker_that_returns_no_result_of_its_task_is_refused_and_leaves_no_record(tmp_path: Path) -> None:
    build = Build(Toy(), RunOptions(output=tmp_path / "out"))
    with pytest.raises(InputError, match=r"the task misfit: .* it has another pid; install the same version"):
        build.records([("misfit",)])
    assert not build.journal or build.journal.read() == {}
