"""Refreshing the default cell's stored motions after one wall of the pod moved by 10 mm.

    python -m bench.refresh [--every N] [--json FILE]

The motions are built first, in the same run, as their time is what a refresh is compared with: both are
seconds of one processor, in one process. Only every third of the named configurations of a kind takes part
(--every), which leaves a fifth of the motions, so that this takes minutes. Each wall between two bins and
each side wall is moved in turn, along y; the figures are those of the worst.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.fingerprint import fingerprint
from pickcli.geometry import pose
from pickcli.precompute.artifact_files import make_trajectories
from pickcli.precompute.refreshing import Refresh, refresh
from pickcli.roadmap.store import surveyed

MOVED = pose((0.0, 0.01, 0.0))  # m


def measure(every: int = 3) -> dict[str, Any]:
    """Per wall what was done again; of the worst the shares of motions and of the build's time."""
    cell = sampled(load_cell("apc2016_delft"), every)
    walls = [body.name for body in cell.pod.bodies if "divider" in body.name or "wall_" in body.name]
    with tempfile.TemporaryDirectory() as folder:
        built, path = Path(folder) / "built.h5", Path(folder) / "motions.h5"
        build_s, _ = _timed(lambda: make_trajectories(cell, built))
        done = {}
        for wall in walls:
            path.write_bytes(built.read_bytes())
            done[wall] = _refreshed(path, with_moved(cell, wall))
    return {
        "build_s": build_s,
        "proven_again_share": max(each["proven_again"] / each["stored"] for each in done.values()),
        "time_share": max(each["s"] for each in done.values()) / build_s,
        "walls": done,
    }


def sampled(cell: Cell, every: int) -> Cell:
    """The cell with every so many of its named configurations of each kind."""
    by_kind: dict[str, list[str]] = {}
    for name, named in cell.configurations.items():
        by_kind.setdefault(named.kind, []).append(name)
    wanted = {name for names in by_kind.values() for name in names[::every]}
    return replace(cell, configurations={k: v for k, v in cell.configurations.items() if k in wanted})


def with_moved(cell: Cell, wall: str) -> Cell:
    """The cell with one body of its pod elsewhere."""
    bodies = tuple(
        replace(body, T_parent_shape=MOVED @ body.T_parent_shape) if body.name == wall else body
        for body in cell.pod.bodies
    )
    changed = replace(cell, pod=replace(cell.pod, bodies=bodies))
    return replace(changed, fingerprint=fingerprint(changed))


def _refreshed(path: Path, cell: Cell) -> dict[str, float]:
    seconds, done = _timed(lambda: refresh(path, surveyed(path), cell))
    assert isinstance(done, Refresh)
    return {
        "s": seconds,
        "stored": done.n_stored,
        "proven_again": done.n_proven,
        "kept": done.n_kept,
        "planned": done.n_planned,
    }


def _timed(action: Callable[[], object]) -> tuple[float, object]:
    began = time.process_time()
    result = action()
    return time.process_time() - began, result


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--every", type=int, default=3, help="named configurations of a kind that take part")
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    text = json.dumps(measure(given.every), indent=2)
    print(text)
    if given.json is not None:
        given.json.write_text(text + "\n")


if __name__ == "__main__":
    main()
