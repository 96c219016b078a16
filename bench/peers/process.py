"""A peer's process as we see it: asked one query at a time, and given up when it dies too often."""

from __future__ import annotations

import contextlib
import json
import select
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]  # where the worker is imported from: its environment has no pickcli
SETTING_UP = 60.0  # s that a peer may take on top of its time limits before it counts as hung
DEATHS = 3  # that a peer may die


@dataclass
class PeerProcess:
    """One peer.

    python: of the environment that it is installed in
    exchange: the queries' file, an absolute path
    broken: why it answers no more, "" as long as it does
    """

    module: str
    python: Path
    exchange: Path
    time_limit: float
    versions: dict[str, str] = field(default_factory=dict)
    broken: str = ""
    deaths: int = 0
    _process: subprocess.Popen[str] | None = None

    def ask(self, number: int) -> dict[str, Any] | None:
        """Its answer to a query, see ``worker``; None if it has none, died or hung."""
        if self.broken or not self._is_running():
            return None
        assert self._process is not None and self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.write(f"{number}\n")
            self._process.stdin.flush()
        answer = self._line(SETTING_UP + 3 * self.time_limit)
        if answer is None:
            self._bury()
        return answer

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def _is_running(self) -> bool:
        """Whether it runs, started if need be."""
        if self._process is not None:
            return True
        if not self.python.exists():
            self.broken = f"not installed: no {self.python}"
            return False
        command = [str(self.python), "-m", "bench.peers.worker", self.module, str(self.exchange)]
        pipe, nowhere = subprocess.PIPE, subprocess.DEVNULL
        self._process = subprocess.Popen(
            command, cwd=ROOT, stdin=pipe, stdout=pipe, stderr=nowhere, text=True
        )
        hello = self._line(SETTING_UP)
        if hello is None or "error" in hello:
            self.broken = "does not start: " + (hello or {"error": "it ended without a word"})["error"]
            self.close()
            return False
        self.versions = hello["versions"]
        return True

    def _line(self, seconds: float) -> dict[str, Any] | None:
        assert self._process is not None and self._process.stdout is not None
        if not select.select([self._process.stdout], [], [], seconds)[0]:
            return None
        line = self._process.stdout.readline()
        return dict(json.loads(line)) if line.endswith("\n") else None

    def _bury(self) -> None:
        self.close()
        self.deaths += 1
        if self.deaths >= DEATHS:
            self.broken = f"died or hung {DEATHS} times"
