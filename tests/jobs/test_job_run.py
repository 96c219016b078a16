"""One build: which tasks are begun first, and what is told of the work that is left."""

from __future__ import annotations

from pickcli.jobs.job_run import Build, BuildProgress, RunOptions
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
