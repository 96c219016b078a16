"""A real Dask scheduler and its workers on the loopback, for tests."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# As if each had been installed again: someone may be editing the sources while the tests run.
# None of them outlives the tests, however those end.
_PROGRAM = f"""
import os, sys, threading, time
parent = os.getppid()
def watch():
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)
threading.Thread(target=watch, daemon=True).start()
sys.path.insert(0, {str(Path(__file__).parents[1])!r})
{{before}}
from distributed.cli.dask_{{what}} import main
main(sys.argv[1:])
"""
_CODE = """
from pickcli.jobs import job
job.code_digest = lambda: {code!r}
"""
_START = 30.0  # s that a process may take to start


class DaskCluster:
    """A scheduler and its workers, each a process that does one task at a time.

    address: of the scheduler
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._start("scheduler", "import pickcli", "--host", "127.0.0.1", "--port", "0")
        self.address = self._line("scheduler", "Scheduler at:")

    def add_worker(self, name: str, code: str = "the same", n_threads: int = 1) -> None:
        """Start a worker whose code has that digest."""
        options = ("--nthreads", str(n_threads), "--no-nanny", "--local-directory", str(self._folder))
        self._start(name, _CODE.format(code=code), self.address, *options)
        self._line(name, "Registered to:")

    def add_stranger(self, name: str) -> None:
        """Start a worker that does not know our package at all."""
        options = ("--nthreads", "1", "--no-nanny", "--local-directory", str(self._folder))
        self._start(name, "sys.modules['pickcli'] = None", self.address, *options)
        self._line(name, "Registered to:")

    def kill(self, name: str) -> None:
        """At once, without a word."""
        self._processes[name].send_signal(signal.SIGKILL)
        self._processes.pop(name).wait()

    def close(self) -> None:
        """End everything that was started."""
        for name in list(self._processes):
            self.kill(name)

    def _start(self, name: str, before: str, *options: str) -> None:
        what = "scheduler" if name == "scheduler" else "worker"
        program = _PROGRAM.format(before=before, what=what)
        with (self._folder / f"{name}.log").open("wb") as log:
            self._processes[name] = subprocess.Popen(
                [sys.executable, "-c", program, *options, "--no-dashboard"],
                stdout=log,
                stderr=log,
                env=os.environ | {"OMP_NUM_THREADS": "1"},
            )

    def _line(self, name: str, wanted: str) -> str:
        """What follows those words in a process's log."""
        log, ends = self._folder / f"{name}.log", time.monotonic() + _START
        while time.monotonic() < ends and self._processes[name].poll() is None:
            for line in log.read_text().splitlines():
                if wanted in line:
                    return line.partition(wanted)[2].strip()
            time.sleep(0.02)
        raise AssertionError(f"{name} has not started: {log.read_text()}")


@contextmanager
def dask_cluster(folder: Path) -> Iterator[DaskCluster]:
    """A scheduler without workers, ended with all that was added."""
    cluster = DaskCluster(folder)
    try:
        yield cluster
    finally:
        cluster.close()
