"""A process that does tasks for another one: ``python -m pickcli.precompute.worker FD``.

FD is one end of a pipe. First comes ``sys.path`` of the process that asks, then a recipe, then key after key;
for each key goes back its record, or the exception that was raised. The end of the pipe is the end of the
worker: it outlives a killed parent by one task at most.
"""

from __future__ import annotations

import contextlib
import pickle
import sys
import traceback
from multiprocessing.connection import Connection

from pickcli.precompute.recipe import Key, Recipe


def serve(pipe: Connection) -> None:
    """Do what comes until nothing comes any more."""
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        sys.path[:] = pipe.recv()
        recipe: Recipe = pipe.recv()
        while True:
            pipe.send(outcome(recipe, pipe.recv()))


def outcome(recipe: Recipe, key: Key) -> bytes | Exception:
    """The record of a task, or the exception it raised, with the place as a note."""
    try:
        return recipe.make(key).to_bytes()
    except Exception as error:
        told = f"in the task {', '.join(key)}:\n{''.join(traceback.format_exception(error))}"
        return _portable(error, told)


def _portable(error: Exception, told: str) -> Exception:
    """The exception, or one that says the same if it cannot travel."""
    try:
        copy = pickle.loads(pickle.dumps(error))
    except Exception:
        copy = RuntimeError(str(error))
    copy.add_note(told)
    return copy if isinstance(copy, Exception) else RuntimeError(told)


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
