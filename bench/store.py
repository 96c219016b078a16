"""Stored motions: size of the files, opening one and fetching a motion.

python -m bench.store
"""

from __future__ import annotations

import json
import statistics
import time
from collections.abc import Callable

from pickcli.cell.cell_file import load_cell
from pickcli.precompute.artifact_cache import ensure_artifacts
from pickcli.roadmap.store import read_database, read_motion, read_roadmap, surveyed


def measure(n_runs: int = 300) -> dict[str, float]:
    """Sizes in MB; medians in ms of what a command does with the files."""
    cell = load_cell("apc2016_delft")
    paths = ensure_artifacts(cell)
    keys = read_database(paths.trajectories, cell).keys
    motions = iter([*keys] * (n_runs // len(keys) + 1))
    return {
        "size_mb": sum(path.stat().st_size for path in (paths.roadmap, paths.trajectories)) / 1e6,
        "motions": len(keys),
        "fetch_ms": _median_ms(lambda: read_motion(paths.trajectories, next(motions), cell), n_runs),
        "open_paths_ms": _median_ms(lambda: read_database(paths.trajectories, cell), n_runs // 10),
        "open_roadmap_ms": _median_ms(lambda: read_roadmap(paths.roadmap, cell), n_runs // 10),
        "check_ms": _median_ms(lambda: surveyed(paths.trajectories), 5),
    }


def _median_ms(action: Callable[[], object], n_runs: int) -> float:
    return 1e3 * statistics.median(_seconds(action) for _ in range(n_runs))


def _seconds(action: Callable[[], object]) -> float:
    began = time.perf_counter()
    action()
    return time.perf_counter() - began


if __name__ == "__main__":
    print(json.dumps(measure(), indent=2))
