"""Building: seconds on one process and on two, what a task costs, and what Dask adds to it.

python -m bench.builds [--dask]

The default cell's motions are built on two processes and then on one: the machine should be quiet.
"""

from __future__ import annotations

import argparse
import json
import os
import pickle
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.jobs.dask_executor import DaskExecutor
from pickcli.jobs.executors import Executor, ProcessExecutor, SerialExecutor
from pickcli.jobs.job import Key
from pickcli.jobs.job_result import JobResult
from pickcli.jobs.job_run import RunOptions
from pickcli.jobs.journal import Journal
from pickcli.precompute.artifact_files import make_roadmap
from pickcli.precompute.coarse_motion_job import CoarseMotionJob, task_key
from pickcli.precompute.motion_pairs import coarse_pairs
from pickcli.trajopt.trajectory_settings import TrajectorySettings


def measure() -> dict[str, Any]:
    """Seconds of a build on two processes, the speed-up over one, and what the tasks cost."""
    cell = load_cell("apc2016_delft")
    job, keys = CoarseMotionJob(cell, TrajectorySettings()), [task_key(key) for key in coarse_pairs(cell)]
    keys.sort(key=job.effort, reverse=True)  # as a build does them
    costs: list[float] = []
    two_s, by_two = _done(ProcessExecutor(2), job, keys, [])
    one_s, by_one = _done(SerialExecutor(), job, keys, costs)
    return {
        "motions": len(keys),
        "build_1_job_s": one_s,
        "build_2_jobs_s": two_s,
        "speed_up": one_s / two_s,
        "same_records": by_one == by_two,
        "roadmap_2_jobs_s": _roadmap_seconds(cell),
        "task_s": {
            "mean": statistics.mean(costs),
            "median": statistics.median(costs),
            "p99": float(np.percentile(costs, 99)),
            "max": max(costs),
        },
        "record_bytes_mean": statistics.mean(map(len, by_one.values())),
        "recipe_bytes": len(pickle.dumps(job)),
    }


def _roadmap_seconds(cell: Cell) -> float:
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        make_roadmap(cell, Path(folder) / "roadmap.h5", run_options=RunOptions(ProcessExecutor(2)))
    return time.perf_counter() - began


def _done(
    runner: Executor, job: CoarseMotionJob, keys: list[Key], costs: list[float]
) -> tuple[float, dict[Key, bytes]]:
    """Seconds, and records by key; the seconds between one record and the next go to ``costs``."""
    began = last = time.perf_counter()
    records = {}
    for key, record in runner.run(job, keys):
        now = time.perf_counter()
        costs.append(now - last)
        last = now
        records[key] = record
    return last - began, records


@dataclass(frozen=True)
class Nothing:
    """A job whose tasks take no time and leave as many bytes as a motion does."""

    n_numbers: int = 800
    inputs: str = "nothing"

    def effort(self, key: Key) -> float:
        """See Job."""
        return 1.0

    def make(self, key: Key) -> JobResult:
        """See Job."""
        return JobResult(arrays={"numbers": np.zeros(self.n_numbers)})

    def misfit(self, key: Key, result: JobResult) -> str:
        """See Job."""
        return ""


def measure_dask(n_tasks: int = 1000) -> dict[str, float]:
    """What a build on Dask pays besides its tasks.

    s to connect; ms per task by the clock, with two workers and all else on this machine; ms of processor
    time per task in the scheduler and in the client, of which there is one each; ms to keep a record in the
    journal.
    """
    keys = [("nothing", str(i)) for i in range(n_tasks)]
    with _scheduler(n_workers=2) as (address, scheduler):
        run = DaskExecutor(address).run
        list(run(Nothing(), keys[:10]))  # the first loads our code
        began = time.perf_counter()
        list(run(Nothing(), keys[:1]))
        connected, client_spent, scheduler_spent = time.perf_counter(), time.process_time(), _spent(scheduler)
        records = list(run(Nothing(), keys))
        ended = time.perf_counter()
        client_spent = time.process_time() - client_spent
        scheduler_spent = _spent(scheduler) - scheduler_spent
    ms = {
        "clock_ms": ended - connected - (connected - began),
        "scheduler_ms": scheduler_spent,
        "client_ms": client_spent,
    }
    per_task = {name: 1e3 * seconds / n_tasks for name, seconds in ms.items()}
    return {"connect_s": connected - began, **per_task, "journal_ms": _journal_ms(records[:300])}


def _journal_ms(records: list[tuple[Key, bytes]]) -> float:
    with tempfile.TemporaryDirectory(dir=".") as folder:
        journal = Journal(Path(folder) / "out", "inputs")
        began = time.perf_counter()
        for key, record in records:
            journal.append(key, record)
        return 1e3 * (time.perf_counter() - began) / len(records)


def _spent(pid: int) -> float:
    """Processor time of a process, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@contextmanager
def _scheduler(n_workers: int) -> Iterator[tuple[str, int]]:
    """A scheduler and its workers on the loopback: its address and process."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    with tempfile.TemporaryDirectory() as folder:
        worker = ("worker", address, "--nthreads", "1", "--no-nanny", "--local-directory", folder)
        commands = [("scheduler", "--host", "127.0.0.1", "--port", str(port)), *[worker] * n_workers]
        processes = [
            subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.dask_{what}", *options, "--no-dashboard"],
                stderr=subprocess.DEVNULL,
            )
            for what, *options in commands
        ]
        try:
            yield address, processes[0].pid
        finally:
            for process in reversed(processes):
                process.terminate()
                process.wait()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--dask", action="store_true", help="only what Dask adds")
    given = parser.parse_args()
    # As a module, so that workers find the job under its name.
    from bench import builds

    print(json.dumps(builds.measure_dask() if given.dask else builds.measure(), indent=2))
