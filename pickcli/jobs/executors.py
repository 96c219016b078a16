"""Executors: this process, or several workers beside it."""

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

MAX_DEATHS = 3  # workers that a task may cost before it is blamed

# One thread each: several would fight for the same cores, and sums could come in another order.
_ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1"
)

Finished: TypeAlias = Generator[tuple[Key, bytes], None, None]


class Executor(Protocol):
    """Something that runs tasks."""

    def run(self, job: Job, keys: Sequence[Key]) -> Finished:
        """Run tasks. Closing the iterator ends all work.

        Args:
            job: How the tasks are done.
            keys: The tasks.

        Yields:
            Records by key, in the order in which they are finished.
        """


def available_cores() -> int:
    """Number of cores that this process may use.

    Returns:
        At least 1.
    """
    return len(os.sched_getaffinity(0))


def runner(n_jobs: int) -> Executor:
    """An executor with a number of processes; one means this process.

    Args:
        n_jobs: Number of processes.

    Returns:
        The executor.
    """
    return SerialExecutor() if n_jobs == 1 else ProcessExecutor(n_jobs)


@dataclass(frozen=True)
class SerialExecutor:
    """Serial executor: this process runs one task after the other."""

    def run(self, job: Job, keys: Sequence[Key]) -> Finished:
        """Run tasks in this process.

        Args:
            job: How the tasks are done.
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
        """Run tasks on workers. A task alone is run here: a worker would only begin to be ready by then.

        Args:
            job: How the tasks are done.
            keys: The tasks.

        Yields:
            Records by key, in the order in which they are finished.

        Raises:
            WorkerLostError: If a task ended several workers. What a task raises is raised, too.
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
    """The key, to be done again, unless it has cost too many workers."""
    deaths[key] += 1
    if deaths[key] >= MAX_DEATHS:
        raise WorkerLostError(
            f"the task {', '.join(key)} ended {MAX_DEATHS} processes, by a crash or for lack of memory; "
            "what is finished is kept: run the same command again with --jobs 1 to see why"
        )
    return key


@dataclass(frozen=True, eq=False)
class _Worker:
    """A worker seen from outside."""

    process: subprocess.Popen[bytes]
    pipe: Connection

    @classmethod
    def start(cls, job: Job) -> _Worker:
        """A new worker, in a session of its own: Ctrl-C in a terminal reaches only us."""
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
        """Hand it a task."""
        self._send(key)
        return key

    def take(self) -> bytes | None:
        """The record of the task in hand, or None if the worker has died. Raises what the task raised."""
        try:
            answer = self.pipe.recv()
        except (EOFError, OSError):
            return None
        if isinstance(answer, Exception):
            raise answer
        assert isinstance(answer, bytes)
        return answer

    def end(self) -> None:
        """End it, at once."""
        self.process.kill()
        self.process.wait()
        self.pipe.close()

    def _send(self, what: object) -> None:
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):  # if it has died, take() will tell
            self.pipe.send(what)
