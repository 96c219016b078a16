"""A job whose tasks take no time, fail, crash or raise, as their names say."""

from __future__ import annotations

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pickcli.errors import InputError, Reason
from pickcli.jobs.job import Key
from pickcli.jobs.job_result import JobResult
from pickcli.seeds import derived_rng

MANY: list[Key] = [("number", str(i)) for i in range(24)]


@dataclass(frozen=True)
class Toy:
    """Numbers from the key; special keys begin with what they do.

    folder: where "crash once" leaves its mark
    """

    folder: Path = Path()
    inputs: str = "0123456789abcdef"

    def effort(self, key: Key) -> float:
        """See Job."""
        return float(key[1]) + 1.0 if key[0] == "number" else 1.0

    def make(self, key: Key) -> JobResult:
        """See Job."""
        what, *_ = key
        if what == "none":
            return JobResult(reason=Reason("no path", "here", "ö"))
        if what == "raise":
            raise InputError("said by the task")
        if what == "crash" or (what == "crash once" and not (self.folder / "crashed").exists()):
            (self.folder / "crashed").touch()
            os.kill(os.getpid(), signal.SIGKILL)
        if what == "wait":
            time.sleep(0.02)
        if what == "sleep":
            time.sleep(60)
        if what == "misfit":
            return JobResult({"pid": 1})
        return JobResult({"pid": 0}, {"x": derived_rng(*key).normal(size=(3, 2)), "none": np.zeros((0, 2))})

    def misfit(self, key: Key, result: JobResult) -> str:
        """See Job."""
        return "" if result.reason or result.values == {"pid": 0} else "it has another pid"
