"""A real scheduler and its workers leave the bytes of one process, whoever of them dies."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pickcli.errors import InputError, WorkerLostError
from pickcli.jobs import job
from pickcli.jobs.dask_executor import DaskExecutor
from pickcli.jobs.executors import SerialExecutor
from pickcli.jobs.job_run import BuildProgress, RunOptions
from support.dask_cluster import DaskCluster, dask_cluster
from support.stored_kind import KINDS
from support.toy_job import MANY, Toy

SHORT = 2.0  # s: what is waited for here never comes


@pytest.fixture(autouse=True)
def same_code(monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers are started as if theirs were this, see ``dask_cluster``."""
    monkeypatch.setattr(job, "code_digest", lambda: "the same")


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DaskCluster]:
    """Two workers that no test may harm."""
    with dask_cluster(tmp_path_factory.mktemp("two")) as cluster:
        for name in ("one", "other"):
            cluster.add_worker(name)
        yield cluster


@pytest.fixture
def empty(tmp_path: Path) -> Iterator[DaskCluster]:
    """A scheduler without workers."""
    with dask_cluster(tmp_path) as cluster:
        yield cluster


def test_workers_leave_the_bytes_that_this_process_leaves(two: DaskCluster) -> None:
    keys = [*MANY, ("none",), ("with / and (", "'", "ö")]
    there = list(DaskExecutor(two.address).run(Toy(), keys))
    assert len(there) == len(keys) and dict(there) == dict(SerialExecutor().run(Toy(), keys))


@pytest.mark.parametrize("kind", KINDS)
def test_a_worker_is_killed_and_the_file_is_the_same(kind: str, empty: DaskCluster, tmp_path: Path) -> None:
    told = list[BuildProgress]()
    for name in ("one", "other"):
        empty.add_worker(name)

    def kill(progress: BuildProgress) -> None:
        told.append(progress)
        if progress.done == 3:
            empty.kill("one")

    KINDS[kind].make(tmp_path / "many.h5", RunOptions(DaskExecutor(empty.address, SHORT), report=kill))
    assert (tmp_path / "many.h5").read_bytes() == KINDS[kind].good()
    assert told[-1].done == told[-1].total > 3
    assert not list(tmp_path.glob("*.journal"))


def test_a_task_that_ends_its_workers_is_blamed_by_name(empty: DaskCluster, tmp_path: Path) -> None:
    for name in "abcd":
        empty.add_worker(name)
    with pytest.raises(WorkerLostError, match="4 workers died with the task crash, here in hand"):
        list(DaskExecutor(empty.address, SHORT).run(Toy(tmp_path), [("crash", "here")]))


def test_what_a_task_raises_is_raised_after_what_is_done(two: DaskCluster) -> None:
    with pytest.raises(InputError, match="said by the task") as raised:
        list(DaskExecutor(two.address).run(Toy(), [*MANY[:3], ("raise",)]))
    assert "in the task raise:" in raised.value.__notes__[0]


def test_closing_ends_what_is_left(two: DaskCluster) -> None:
    running = DaskExecutor(two.address).run(Toy(), [*MANY, *(("wait", str(i)) for i in range(500))])
    next(running)
    running.close()
    assert len(list(DaskExecutor(two.address).run(Toy(), MANY))) == len(MANY)


def test_nothing_to_do_needs_no_scheduler() -> None:
    assert list(DaskExecutor("tcp://127.0.0.1:1", SHORT).run(Toy(), [])) == []


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "tcp://no.host.invalid:1"])
def test_no_scheduler_is_one_error(address: str) -> None:
    with pytest.raises(
        InputError, match=rf"{address}: no scheduler answers .*; start one with dask scheduler"
    ):
        list(DaskExecutor(address, 0.3).run(Toy(), MANY))


def test_tls_without_certificates_is_one_error() -> None:
    with pytest.raises(
        InputError, match=r"tls://127.0.0.1:1: needs certificates; set distributed\.comm\.tls"
    ):
        list(DaskExecutor("tls://127.0.0.1:1").run(Toy(), MANY))


@pytest.mark.parametrize("address", ["", "host", "tcp://host", "http://host:1", "inproc://host:1"])
def test_what_is_no_address_is_one_error(address: str) -> None:
    with pytest.raises(InputError, match="not a scheduler's address; name one like tcp://host:8786"):
        list(DaskExecutor(address, 0.3).run(Toy(), MANY))


def test_no_dask_is_one_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"install the extra: pip install 'apc-pick\[cluster\]'"):
        list(DaskExecutor("tcp://127.0.0.1:1").run(Toy(), MANY))


def test_workers_that_are_not_ours_are_one_error(empty: DaskCluster) -> None:
    run = DaskExecutor(empty.address, SHORT).run
    with pytest.raises(InputError, match="has no workers; start some: dask worker tcp://"):
        list(run(Toy(), MANY))
    strangers: tuple[tuple[Callable[[], object], str], ...] = (
        (
            lambda: empty.add_worker("w", code="another"),
            "another version: apc's code another, here the same;",
        ),
        (lambda: empty.add_worker("w", n_threads=3), "has 3 threads, but tasks need a process each"),
        (lambda: empty.add_stranger("w"), "cannot run apc .*install the same version there"),
    )
    for add, wrong in strangers:
        add()
        with pytest.raises(InputError, match=wrong):
            list(run(Toy(), MANY))
        empty.kill("w")


def test_a_worker_of_another_version_that_comes_later_is_found_too(empty: DaskCluster) -> None:
    empty.add_worker("ours")
    running = DaskExecutor(empty.address).run(Toy(), [*MANY, *(("wait", str(i)) for i in range(2000))])
    next(running)
    empty.add_worker("theirs", code="another")
    with pytest.raises(InputError, match="another version: apc's code another"):
        list(running)


def test_a_scheduler_or_all_workers_that_go_away_are_one_error(empty: DaskCluster) -> None:
    forever = [*MANY, ("sleep", "1")]
    for gone, told in (("w", "all workers have left"), ("scheduler", "the scheduler was lost")):
        empty.add_worker("w")
        running = DaskExecutor(empty.address, SHORT).run(Toy(), forever)
        next(running)
        empty.kill(gone)
        with pytest.raises(InputError, match=rf"{told}; start .*; finished tasks are kept"):
            list(running)


def test_dask_keeps_quiet_meanwhile(two: DaskCluster) -> None:
    running = DaskExecutor(two.address).run(Toy(), MANY)
    next(running)
    assert logging.getLogger("distributed.client").disabled
    running.close()
    assert not logging.getLogger("distributed.client").disabled
