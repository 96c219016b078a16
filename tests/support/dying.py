"""Processes that die in the middle of writing: what a kill, or a machine that goes off, does to files."""

from __future__ import annotations

import mmap
import os
from collections.abc import Callable
from typing import Any
from unittest import mock

from pickcli.jobs.journal import Journal


def dies(n_calls: int, action: Callable[[], object]) -> int:
    """Do it in a process that ends, without a word, at its n-th call that changes a disk.

    Returns how many records were appended to a journal before.
    """
    n_appended = mmap.mmap(-1, 1)
    pid = os.fork()
    if pid == 0:
        with _mortal(n_calls), mock.patch.object(Journal, "append", _counting(n_appended)):
            try:
                action()
            finally:
                os._exit(0)
    os.waitpid(pid, 0)
    return n_appended[0]


def _counting(n_appended: mmap.mmap) -> Callable[..., None]:
    append = Journal.append

    def counting(*arguments: Any) -> None:
        append(*arguments)
        n_appended[0] += 1

    return counting


def _mortal(n_calls: int) -> Any:
    """Patches of the calls that change a disk; the n-th ends the process, writing half of what it should."""

    def mortal(call: Callable[..., Any]) -> Callable[..., Any]:
        def wrapped(*arguments: Any) -> Any:
            nonlocal n_calls
            n_calls -= 1
            if n_calls == 0:
                if len(arguments) == 2 and isinstance(arguments[1], bytes):
                    call(arguments[0], arguments[1][: len(arguments[1]) // 2])
                os._exit(9)
            return call(*arguments)

        return wrapped

    patches: dict[str, Any] = {
        name: mortal(getattr(os, name)) for name in ("write", "fsync", "replace", "unlink")
    }
    return mock.patch.multiple(os, **patches)
