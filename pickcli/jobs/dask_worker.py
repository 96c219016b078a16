"""Worker side of a cluster. It imports nothing that only the client needs."""

from __future__ import annotations

import importlib.metadata
import platform
import threading
from collections.abc import Mapping
from functools import cache

from pickcli.errors import InputError
from pickcli.jobs import job
from pickcli.jobs.job import Job, Key
from pickcli.jobs.worker import outcome

Software = Mapping[str, str]  # name -> version, of all software that may change a record's bytes

# OMPL has one stream of random numbers per process, which two simultaneous tasks would share.
_ONE_AT_A_TIME = threading.Lock()


def software() -> Software:
    """Return versions of all software in this process that may change the bytes of a record.

    Returns:
        Name to version.
    """
    return {"apc's code": job.code_digest()[:12], **_libraries()}


@cache
def _libraries() -> Software:
    libraries = ("ompl", "numpy", "distributed")
    python = ".".join(platform.python_version_tuple()[:2])
    return {"Python": python, **{name: importlib.metadata.version(name) for name in libraries}}


def check_software(theirs: Software, ours: Software, where: str) -> None:
    """Refuse a worker with other software than the client.

    Args:
        theirs: Versions of the worker.
        ours: Versions of the client.
        where: The worker, for the message.

    Raises:
        InputError: If a version differs.
    """
    differing = [name for name in ours if theirs.get(name) != ours[name]]
    differences = [f"{name} {theirs.get(name, 'none')}, here {ours[name]}" for name in differing]
    if differences:
        raise InputError(
            f"{where} runs another version: {'; '.join(differences)}; install the same there and restart it"
        )


def cluster_outcome(how: Job, key: Key, ours: Software) -> bytes | Exception:
    """Run one task on a worker of a cluster.

    The software is checked here, too, because the worker may have joined later, with another version.

    Args:
        how: The job of the task.
        key: The task.
        ours: Versions of the client.

    Returns:
        The bytes of the record, or the exception that was raised.
    """
    try:
        check_software(software(), ours, f"a worker on {platform.node()}")
    except InputError as error:
        return error
    with _ONE_AT_A_TIME:
        return outcome(how, key)
