"""Flipped bits: is each found, or harmless? 1,000 at random places of both kinds of file.

python -m bench.flips [--flips 1000] [--seed 1]
"""

from __future__ import annotations

import argparse
import json
import os
import random
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.cell.cell_file import load_cell
from pickcli.errors import ApcError
from pickcli.precompute.artifact_cache import ensure_artifacts
from pickcli.roadmap.store import read_database, read_roadmap, surveyed

# What became of a flip; the exit code of the process that looked at it.
OUTCOMES = ("found", "harmless", "wrong motion served", "neither found nor harmless", "crash")
FOUND, HARMLESS, WRONG, MISSED, CRASH = range(5)


def measure(n_flips: int = 1000, seed: int = 1) -> dict[str, dict[str, int]]:
    """How many flips of each file had which outcome."""
    paths = ensure_artifacts(load_cell("apc2016_delft"))
    return {
        "roadmap": _counted(paths.roadmap, _roadmap, n_flips, seed),
        "trajectories": _counted(paths.trajectories, _motions, n_flips, seed),
    }


def _counted(path: Path, read: Callable[[Path], list[Any]], n_flips: int, seed: int) -> dict[str, int]:
    rng, content, right = random.Random(seed), path.read_bytes(), read(path)
    counts: Counter[int] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        flipped = Path(folder) / path.name
        for _ in range(n_flips):
            changed = bytearray(content)
            changed[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
            flipped.write_bytes(changed)
            counts[_in_a_process(lambda: _outcome(flipped, read, right))] += 1
    return {name: counts[code] for code, name in enumerate(OUTCOMES)}


def _outcome(path: Path, read: Callable[[Path], list[Any]], right: list[Any]) -> int:
    """What a reader and the check make of a file."""
    try:
        served = read(path)
        is_served = True
    except ApcError:
        is_served = False
    if is_served and not (len(served) == len(right) and all(map(np.array_equal, served, right))):
        return WRONG
    try:
        is_found = bool(surveyed(path).damage)
    except ApcError:
        is_found = True
    if is_found:
        return FOUND
    return HARMLESS if is_served else MISSED


def _in_a_process(look: Callable[[], int]) -> int:
    """The outcome, from a process of its own: HDF5 may crash on bytes that it does not expect."""
    pid = os.fork()
    if pid == 0:
        code = CRASH
        try:
            code = look()
        finally:
            os._exit(code)
    status = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    return status if 0 <= status < CRASH else CRASH


def _roadmap(path: Path) -> list[Any]:
    roadmap = read_roadmap(path)
    return [roadmap.configurations, roadmap.edges, roadmap.lengths, roadmap.waypoints, roadmap.offsets]


def _motions(path: Path) -> list[Any]:
    found: list[Any] = []
    for motion in read_database(path, points=True):
        timed = motion.trajectory
        assert timed is not None
        found += [motion.path.waypoints, timed.times, timed.positions, timed.velocities, timed.accelerations]
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--flips", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    print(json.dumps(measure(given.flips, given.seed), indent=2))
