"""Executors: this process, or several worker processes."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections import Counter, deque
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Protocol, TypeAlias

from pickcli.errors import WorkerLostError
from pickcli.jobs.job import Job, Key

MAX_DEATHS = 3  # workers that a task may end before it is reported

# One thread per worker: several would compete for the cores, and sums could have another order.
_ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1"
)

Finished: TypeAlias = Generator[tuple[Key, bytes], None, None]


class Executor(Protocol):
    """Interface of executors."""

    def run(self, job: Job, keys: Sequence[Key]) -> Finished:
        """Run tasks. Closing the iterator ends all work.

        Args:
            job: The job of the tasks.
            keys: The tasks.

        Yields:
            Records by key, in the order in which they are finished.
        """


def available_cores() -> int:
    """Return the number of cores that this process may use.

    Returns:
        At least 1.
    """
    return len(os.sched_getaffinity(0))


def runner(n_jobs: int) -> Executor:
    """Return an executor with a number of processes; 1 stands for this process.

    Args:
        n_jobs: Number of processes.

    Returns:
        The executor.
    """
    return SerialExecutor() if n_jobs == 1 else ProcessExecutor(n_jobs)


@dataclass(frozen=True)
class SerialExecutor:
    """Serial executor: this process runs the tasks one after the other."""

    def run(self, job: Job, keys: Sequence[Key]) -> Finished:
        """Run tasks in this process.

        Args:
            job: The job of the tasks.
            keys: The tasks.

        Yields:
            Records by key, in their order.
        """
        return ((key, job.make(key).to_bytes()) for key in keys)


@dataclass(frozen=True)
class ProcessExecutor:
    """Process executor: workers on this machine. A worker that dies is replaced and its task done again.

    Attributes:
        n_jobs: Number of workers.
    """

    n_jobs: int

    def run(self, job: Job, keys: Sequence[Key]) -> Finished:
        """Run tasks on workers. A single task is run in this process, which is faster than starting a worker.

        Args:
            job: The job of the tasks.
            keys: The tasks.

        Yields:
            Records by key, in the order in which they are finished.

        Raises:
            WorkerLostError: If a task ended several workers. Exceptions of tasks are raised, too.
        """
        if len(keys) == 1:
            yield from SerialExecutor().run(job, keys)
            return
        waiting, in_hand, deaths = deque(keys), dict[Connection, Key](), Counter[Key]()
        workers = [_Worker.start(job) for _ in range(min(self.n_jobs, len(keys)))]
        by_pipe = {worker.pipe: worker for worker in workers}
        try:
            for worker in workers:
                in_hand[worker.pipe] = worker.give(waiting.popleft())
            while in_hand:
                for pipe in wait(list(in_hand)):
                    assert isinstance(pipe, Connection)
                    worker, key = by_pipe[pipe], in_hand.pop(pipe)
                    record = worker.take()
                    if record is None:
                        waiting.appendleft(_blamed(key, deaths))
                        worker.end()
                        del by_pipe[pipe]
                        worker = _Worker.start(job)
                        by_pipe[worker.pipe] = worker
                    if waiting:
                        in_hand[worker.pipe] = worker.give(waiting.popleft())
                    if record is not None:
                        yield key, record
        finally:
            for worker in by_pipe.values():
                worker.end()


def _blamed(key: Key, deaths: Counter[Key]) -> Key:
    """Return the key, to be done again, unless it has ended too many workers."""
    deaths[key] += 1
    if deaths[key] >= MAX_DEATHS:
        raise WorkerLostError(
            f"the task {', '.join(key)} ended {MAX_DEATHS} processes, by a crash or for lack of memory; "
            "what is finished is kept: run the same command again with --jobs 1 to see why"
        )
    return key


@dataclass(frozen=True, eq=False)
class _Worker:
    """Handle of a worker process."""

    process: subprocess.Popen[bytes]
    pipe: Connection

    @classmethod
    def start(cls, job: Job) -> _Worker:
        """Start a worker in its own session, so that Ctrl-C in a terminal reaches only this process."""
        ours, theirs = Pipe()
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "pickcli.jobs.worker", str(theirs.fileno()), str(os.getpid())],
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            env=os.environ | _ONE_THREAD,
        )
        theirs.close()
        worker = cls(process, ours)
        worker._send(sys.path)
        worker._send(job)
        return worker

    def give(self, key: Key) -> Key:
        """Send a task to the worker."""
        self._send(key)
        return key

    def take(self) -> bytes | None:
        """Return the record of the current task, or None if the worker died. Raises the task's exception."""
        try:
            answer = self.pipe.recv()
        except (EOFError, OSError):
            return None
        if isinstance(answer, Exception):
            raise answer
        assert isinstance(answer, bytes)
        return answer

    def end(self) -> None:
        """Kill the worker at once."""
        self.process.kill()
        self.process.wait()
        self.pipe.close()

    def _send(self, what: object) -> None:
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):  # a dead worker: take() returns None
            self.pipe.send(what)
