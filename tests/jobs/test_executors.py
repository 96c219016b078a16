"""Tasks get done, each once, whatever happens to those who do them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pickcli.errors import InputError, WorkerLostError
from pickcli.jobs import executors as runner_module
from pickcli.jobs.executors import Executor, ProcessExecutor, SerialExecutor, available_cores, runner
from support.toy_job import MANY, Toy


@pytest.mark.parametrize("n_jobs", [2, 3])
def test_processes_leave_the_bytes_that_this_process_leaves(n_jobs: int) -> None:
    keys = [*MANY, ("none",)]
    here = dict(SerialExecutor().run(Toy(), keys))
    there = list(ProcessExecutor(n_jobs).run(Toy(), keys))
    assert len(there) == len(keys) and dict(there) == here


def test_a_task_alone_is_done_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner_module._Worker, "start", None)
    assert list(ProcessExecutor(2).run(Toy(), MANY[:1])) == list(SerialExecutor().run(Toy(), MANY[:1]))


def test_a_worker_that_dies_is_replaced_and_its_task_done_again(tmp_path: Path) -> None:
    keys = [("crash once",), *MANY]
    assert {key for key, _ in ProcessExecutor(2).run(Toy(tmp_path), keys)} == set(keys)
    assert (tmp_path / "crashed").exists()


def test_a_task_that_ends_its_workers_is_blamed_by_name(tmp_path: Path) -> None:
    with pytest.raises(WorkerLostError, match="the task crash, here ended 3 processes"):
        list(ProcessExecutor(2).run(Toy(tmp_path), [("crash", "here"), *MANY]))


@pytest.mark.parametrize("by", [SerialExecutor(), ProcessExecutor(2)])
def test_what_a_task_raises_is_raised(by: Executor) -> None:
    with pytest.raises(InputError, match="said by the task") as raised:
        list(by.run(Toy(), [*MANY[:3], ("raise",)]))
    if isinstance(by, ProcessExecutor):
        assert "in the task raise:" in raised.value.__notes__[0]


def test_closing_ends_the_workers_at_once() -> None:
    before = _children()
    running = ProcessExecutor(2).run(Toy(), [MANY[0], ("sleep", "1"), ("sleep", "2")])
    assert next(running)[0] == MANY[0]
    children = _children() - before
    assert len(children) == 2
    running.close()
    assert _children() & children == set()


def test_no_more_workers_than_tasks() -> None:
    before = _children()
    running = ProcessExecutor(8).run(Toy(), MANY[:2])
    next(running)
    assert len(_children() - before) <= 2
    running.close()
    assert list(ProcessExecutor(2).run(Toy(), [])) == []


def test_a_worker_ends_with_the_process_that_asked(tmp_path: Path) -> None:
    """Also when that was killed: the end of the pipe ends it."""
    reading = os.fork()
    if reading == 0:
        running = ProcessExecutor(1).run(Toy(), MANY)
        next(running)
        (tmp_path / "worker").write_text(" ".join(map(str, _children())))
        os._exit(9)
    os.waitpid(reading, 0)
    (worker,) = (tmp_path / "worker").read_text().split()
    for _ in range(200):
        if not _is_running(int(worker)):
            return
        time.sleep(0.05)
    raise AssertionError("the worker goes on")


def test_one_job_needs_no_process() -> None:
    assert isinstance(runner(1), SerialExecutor) and runner(2) == ProcessExecutor(2)
    assert available_cores() >= 1


def _children(parent: int | None = None) -> set[int]:
    pid = parent or os.getpid()
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return {int(pid) for pid in text.split()}


def _is_running(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


PARENT = """
import os, sys
sys.path[:0] = {paths}
from support.toy_job import MANY, Toy
from pickcli.jobs.executors import ProcessExecutor
running = ProcessExecutor(2).run(Toy(), [MANY[0], ("sleep", "1"), ("sleep", "2")])
next(running)
print("working", flush=True)
list(running)
"""


@pytest.mark.parametrize("sign", [signal.SIGKILL, signal.SIGTERM, signal.SIGABRT])
def test_workers_end_with_their_parent_however_it_ends(sign: signal.Signals) -> None:
    """In the middle of a task of a minute, within two seconds."""
    source = PARENT.format(paths=[str(Path(__file__).parents[1])])
    with subprocess.Popen([sys.executable, "-c", source], stdout=subprocess.PIPE) as parent:
        assert parent.stdout is not None and parent.stdout.readline() == b"working\n"
        workers = _children(parent.pid)
        assert len(workers) == 2
        parent.send_signal(sign)
        parent.wait(timeout=10)
        deadline = time.monotonic() + 2.0
        while alive := [pid for pid in workers if _is_running(pid)]:
            assert time.monotonic() < deadline, alive
            time.sleep(0.02)
