"""Fetching of results from the workers of a cluster, robust against the death of workers or the scheduler."""

from __future__ import annotations

import asyncio
import concurrent.futures
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from typing import Any

from pickcli.errors import InputError, WorkerLostError

_PAUSE = 0.02  # s before lost results are requested again
MOST_AT_ONCE = 256  # results per request, few enough for the timeout

_KEPT = "finished tasks are kept; run the same command again to continue"


def results(client: Any, futures: Sequence[Any], address: str, timeout: float) -> Iterator[tuple[Any, bytes]]:
    """Yield results of futures as they finish; a future whose result was fetched is released.

    Args:
        client: Connection to the scheduler.
        futures: The submitted futures.
        address: Address of the scheduler, for messages.
        timeout: s without results after which the presence of workers is checked.

    Yields:
        Futures with their results.

    Raises:
        WorkerLostError: If workers died while they ran a task.
        InputError: If a worker could not read a task, all workers have left, or the scheduler is lost.
    """
    fetching = _Fetching(client, address, timeout)
    fetching.watch(futures)
    n_left = len(futures)
    while n_left:
        for future, result in fetching.next_results():
            n_left -= 1
            yield future, result


@dataclass(frozen=True, eq=False)
class _Fetching:
    client: Any
    address: str
    timeout: float
    ended: SimpleQueue[Any] = field(default_factory=SimpleQueue)  # finished or failed futures

    def watch(self, futures: Sequence[Any]) -> None:
        """Queue each future when it finishes; futures already finished are queued immediately."""
        for future in futures:
            future.add_done_callback(self.ended.put)

    def next_results(self) -> Iterator[tuple[Any, bytes]]:
        """Yield some results of one request; failures are raised after them."""
        batch = self._batch()
        failed = [future for future in batch if future.status == "error"]
        again = [future for future in batch if future.status in ("lost", "pending")]
        done = [future for future in batch if future not in failed and future not in again]
        if again and not done and not failed:  # Dask would report them again at once, in an endless loop
            self._check_that_somebody_works()
            time.sleep(_PAUSE)
        self.watch(again)
        try:
            answers = self._fetched(done)
        except TimeoutError:  # a worker died with some of them: they are done again by another worker
            self._check_that_somebody_works()
            self.watch([*done, *failed])
            return
        raised = [answer for answer in answers if isinstance(answer, Exception)]
        for future, answer in zip(done, answers, strict=True):
            if isinstance(answer, bytes):
                future.release()
                yield future, answer
        for error in raised:
            raise error
        for future in failed:
            raise self._task_error(", ".join(future.key[1:]), future.exception())

    def _batch(self) -> list[Any]:
        """Return futures that have finished, at least one; their worker may have died since."""
        batch: list[Any] = []
        while not batch:
            try:
                batch.append(self.ended.get(timeout=self.timeout))
            except Empty:
                self._check_that_somebody_works()
        while len(batch) < MOST_AT_ONCE and not self.ended.empty():
            batch.append(self.ended.get())
        return batch

    def _fetched(self, futures: Sequence[Any]) -> list[Any]:
        """Fetch results. Raises TimeoutError if that takes too long: Dask waits for repeated tasks."""

        async def gather() -> list[Any]:
            return list(await self.client.gather(list(futures), asynchronous=True))

        # Not by client.sync: its timeout waits for a cancellation that may never happen.
        fetching = asyncio.run_coroutine_threadsafe(gather(), self.client.loop.asyncio_loop)
        try:
            return fetching.result(self.timeout)
        except TimeoutError:
            fetching.cancel()
            raise
        except (concurrent.futures.CancelledError, asyncio.CancelledError, OSError):
            raise self._lost() from None

    def _check_that_somebody_works(self) -> None:
        try:
            workers = self.client.nthreads()
        except OSError:
            raise self._lost() from None
        if not workers:
            raise InputError(f"{self.address}: all workers have left; start some; {_KEPT}")

    def _lost(self) -> InputError:
        return InputError(f"{self.address}: the scheduler was lost; start it again; {_KEPT}")

    def _task_error(self, task: str, error: Exception) -> Exception:
        """Convert Dask's exception of a task to one of this package."""
        from distributed import KilledWorker

        if isinstance(error, KilledWorker):
            return WorkerLostError(
                f"{error.allowed_failures + 1} workers died with the task {task} in hand or next in line; "
                f"{_KEPT}: with --jobs 1 instead of --scheduler, to see why"
            )
        return InputError(
            f"{self.address}: a worker could not read the task {task} ({error}); install the same version "
            f"everywhere; {_KEPT}"
        )
