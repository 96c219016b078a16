"""Executor on the workers of a Dask scheduler, on this machine or many. See docs/cluster.md."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pickcli.errors import InputError
from pickcli.jobs.dask_client import connected
from pickcli.jobs.dask_results import results
from pickcli.jobs.dask_worker import check_software, cluster_outcome, software
from pickcli.jobs.executors import Finished
from pickcli.jobs.job import Job, Key


@dataclass(frozen=True)
class DaskExecutor:
    """Workers of a Dask scheduler. If one dies, its tasks are done again by others.

    Attributes:
        address: Address of the scheduler, e.g. tcp://host:8786.
        timeout: s to wait for the scheduler, and for a worker if there is none.
    """

    address: str
    timeout: float = 10.0

    def run(self, job: Job, keys: Sequence[Key]) -> Finished:
        """Run tasks on the workers of the cluster.

        Args:
            job: The job of the tasks.
            keys: The tasks.

        Yields:
            Records by key, in the order in which they are finished.

        Raises:
            WorkerLostError: If workers died while they ran a task.
            InputError: If Dask, the scheduler or workers are missing, or a worker has another version.
        """
        if keys:
            with connected(self.address, self.timeout) as client:
                self._check_workers(client)
                futures = _submitted(client, job, keys)
                for future, record in results(client, futures, self.address, self.timeout):
                    yield future.key[1:], record

    def _check_workers(self, client: Any) -> None:
        """Raise InputError unless there are workers with the same software, each for one task at a time."""
        start = f"dask worker {self.address} --nworkers auto --nthreads 1"
        try:
            client.wait_for_workers(1, timeout=self.timeout)
        except TimeoutError:
            raise InputError(f"{self.address}: the scheduler has no workers; start some: {start}") from None
        for where, n_threads in client.nthreads().items():
            if n_threads != 1:
                raise InputError(
                    f"the worker {where} has {n_threads} threads, but tasks need a process each; "
                    f"start it again: {start}"
                )
        for where, theirs in client.run(software, on_error="return").items():
            if not isinstance(theirs, Mapping):
                raise InputError(
                    f"the worker {where} cannot run apc ({theirs}); install the same version there"
                )
            check_software(theirs, software(), f"the worker {where}")


def _submitted(client: Any, job: Job, keys: Sequence[Key]) -> list[Any]:
    """Submit one future per task; builds with equal inputs share results.

    The key of a future in Dask contains the inputs of the job and the key of the task.
    """
    # The job is the result of a task, too: if all workers that hold it die, it is made again.
    shared = client.submit(pickle.loads, pickle.dumps(job), key=("apc-job", job.inputs))
    names = [(f"apc-task-{job.inputs}", *key) for key in keys]
    n = len(keys)
    return list(client.map(cluster_outcome, [shared] * n, keys, [software()] * n, key=names))
