"""Worker process that runs tasks for another one: ``python -m pickcli.jobs.worker FD PARENT``.

FD is one end of a pipe. PARENT is the process id of the parent: the worker ends with it in any case. The
worker receives ``sys.path`` of that process, then a job, then one key after the other; for each key it sends
the record, or the exception that was raised. The worker ends when the pipe is closed.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import pickle
import signal
import sys
import traceback
from multiprocessing.connection import Connection

from pickcli.jobs.job import Job, Key

_PR_SET_PDEATHSIG = 1  # of prctl(2)


def serve(pipe: Connection) -> None:
    """Run tasks from the pipe until it is closed.

    Args:
        pipe: Connection to the parent.
    """
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        sys.path[:] = pipe.recv()
        job: Job = pipe.recv()
        while True:
            pipe.send(outcome(job, pipe.recv()))


def outcome(job: Job, key: Key) -> bytes | Exception:
    """Run one task and catch its exception.

    Args:
        job: The job of the task.
        key: The task.

    Returns:
        The bytes of the record, or the exception that was raised, with the traceback as a note.
    """
    try:
        return job.make(key).to_bytes()
    except Exception as error:
        note = f"in the task {', '.join(key)}:\n{''.join(traceback.format_exception(error))}"
        return _portable(error, note)


def _portable(error: Exception, note: str) -> Exception:
    """Return the exception, or one with the same message if it cannot be pickled."""
    try:
        copy = pickle.loads(pickle.dumps(error))
    except Exception:
        copy = RuntimeError(str(error))
    copy.add_note(note)
    return copy if isinstance(copy, Exception) else RuntimeError(note)


def end_with(parent: int) -> None:
    """Make the system end this process when its parent ends, even during a task.

    If the system does not support that (it is not Linux), the worker outlives a killed parent by at most one
    task.

    Args:
        parent: Process id.
    """
    with contextlib.suppress(AttributeError, OSError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # the parent ended before
        os._exit(0)


if __name__ == "__main__":
    end_with(int(sys.argv[2]))
    serve(Connection(int(sys.argv[1])))
