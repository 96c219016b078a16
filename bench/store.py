"""Stored motions: size of the files, opening one and fetching a motion, and how a build scales.

python -m bench.store [--build]

--build builds the default cell's files anew, on one process and on two, and compares their bytes.
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pickcli.cell.load import load_cell
from pickcli.cell.model import Cell
from pickcli.precompute.artifacts import Artifacts, ensure_artifacts
from pickcli.precompute.build import Means
from pickcli.precompute.make import make_roadmap, make_trajectories
from pickcli.precompute.runner import runner
from pickcli.roadmap.hdf5_survey import survey
from pickcli.roadmap.store import FORMATS, read_database, read_motion, read_roadmap


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
        "check_ms": _median_ms(lambda: survey(paths.trajectories, FORMATS), 5),
    }


def measure_builds() -> dict[str, Any]:
    """Seconds of whole builds on one process and on two, and whether they leave the same bytes."""
    cell = load_cell("apc2016_delft")
    with tempfile.TemporaryDirectory() as folder:
        one, two = (_built(cell, Path(folder) / str(n_jobs), n_jobs) for n_jobs in (1, 2))
        same = all(getattr(one[0], f).read_bytes() == getattr(two[0], f).read_bytes() for f in vars(one[0]))
    figures = {f"{name}_{n}_jobs_s": s for n, (_, spent) in ((1, one), (2, two)) for name, s in spent.items()}
    speed_up = {f"{name}_speed_up": one[1][name] / two[1][name] for name in one[1]}
    return {**figures, **speed_up, "same_bytes": same}


def _built(cell: Cell, folder: Path, n_jobs: int) -> tuple[Artifacts, dict[str, float]]:
    folder.mkdir()
    paths, means = Artifacts(folder / "roadmap.h5", folder / "trajectories.h5"), Means(runner(n_jobs))
    return paths, {
        "roadmap": _seconds(lambda: make_roadmap(cell, paths.roadmap, means=means)),
        "trajectories": _seconds(lambda: make_trajectories(cell, paths.trajectories, means=means)),
    }


def _median_ms(action: Callable[[], object], n_runs: int) -> float:
    return 1e3 * statistics.median(_seconds(action) for _ in range(n_runs))


def _seconds(action: Callable[[], object]) -> float:
    began = time.perf_counter()
    action()
    return time.perf_counter() - began


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", action="store_true")
    given = parser.parse_args()
    print(json.dumps(measure() | (measure_builds() if given.build else {}), indent=2))
