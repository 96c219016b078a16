"""A build that is killed at random moments: does its file always open, and what is lost?

python -m bench.kills [--kills 50] [--seed 1]

``apc build-roadmap`` on two processes is killed, and given again, over a file from before. Each time the file
is looked at, byte for byte, and every task that the build had reported as finished must be in its journal.
"""

from __future__ import annotations

import argparse
import json
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from pickcli.errors import ApcError
from pickcli.jobs.journal import Journal, journals
from pickcli.roadmap.store import surveyed

_APC = str(Path(sys.executable).with_name("apc"))
_OPTIONS = ("build-roadmap", "--planner", "RRTConnect", "--overwrite", "--json", "--jobs", "2")


def measure(n_kills: int = 50, seed: int = 1) -> dict[str, Any]:
    """Kills after which the file did not open or was another, and finished tasks that were lost."""
    rng = random.Random(seed)
    figures = {"kills": 0, "ended_before": 0, "unreadable": 0, "finished_tasks_lost": 0, "resumed_with": 0}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "roadmap.h5"
        began = time.monotonic()
        subprocess.run([_APC, *_OPTIONS, "-o", str(out)], check=True, capture_output=True)
        takes, good = time.monotonic() - began, out.read_bytes()
        while figures["kills"] < n_kills:
            before = out.stat().st_ino
            n_reported = _killed_after(rng.uniform(0.0, 1.1 * takes), out)
            if n_reported is None:
                figures["ended_before"] += 1
            else:
                figures["kills"] += 1
                n_kept = _n_kept(out)
                is_written = out.stat().st_ino != before  # and the journal may be gone
                figures["finished_tasks_lost"] += 0 if is_written else max(n_reported - n_kept, 0)
                figures["resumed_with"] = max(figures["resumed_with"], n_kept)
            figures["unreadable"] += not _is_whole(out, good)
        subprocess.run([_APC, *_OPTIONS, "-o", str(out)], check=True, capture_output=True)
        return {**figures, "same_bytes_at_the_end": out.read_bytes() == good}


def _killed_after(seconds: float, out: Path) -> int | None:
    """Build, kill; how many tasks the build had reported as finished by then. None if it ended before."""
    command = [_APC, *_OPTIONS, "-o", str(out)]
    log = out.with_name("log")
    with log.open("w") as stderr:
        building = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=stderr)
        try:
            building.wait(seconds)
        except subprocess.TimeoutExpired:
            building.kill()
    if building.wait() == 0:
        return None
    lines = [line for line in log.read_text().splitlines() if line.endswith("}")]
    return max((json.loads(line)["done"] for line in lines), default=0)


def _n_kept(out: Path) -> int:
    """Finished tasks in the journal."""
    return sum(len(Journal(out, path.name.split(".")[-2]).read()) for path in journals(out))


def _is_whole(out: Path, good: bytes) -> bool:
    try:
        return not surveyed(out).damage and out.read_bytes() == good
    except ApcError:
        return False


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    print(json.dumps(measure(given.kills, given.seed), indent=2))
