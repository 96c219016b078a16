"""Wall time of one-shot commands, the best of several runs.

python -m bench.startup
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from bench.warm import fresh_scene
from pickcli.cell.cell_file import load_cell
from pickcli.precompute.artifact_cache import ensure_artifacts
from pickcli.scene.scene_file import write_scene

APC = [str(Path(sys.executable).with_name("apc"))]


def measure(n_runs: int = 5) -> dict[str, float]:
    """Seconds of ``import pickcli`` in a new interpreter, ``apc --help`` and ``apc plan-pick``."""
    cell = load_cell("apc2016_delft")
    ensure_artifacts(cell)
    with tempfile.TemporaryDirectory() as folder:
        scene, plan = Path(folder) / "scene.json", Path(folder) / "plan.json"
        order, stowed = fresh_scene(cell, seed=0)
        write_scene(stowed, scene)
        picks = (
            [
                *APC,
                "plan-pick",
                "--scene",
                str(scene),
                "--bin",
                target.bin,
                "--item",
                target.item,
                "-o",
                str(plan),
            ]
            for target in order.work_order
        )
        pick = next(p for p in picks if subprocess.run(p, capture_output=True).returncode == 0)
        return {
            "import_s": _best([sys.executable, "-c", "import pickcli"], n_runs),
            "help_s": _best([*APC, "--help"], n_runs),
            "plan_pick_s": _best([*pick, "--overwrite"], n_runs),
        }


def _best(command: list[str], n_runs: int) -> float:
    seconds = []
    for _ in range(n_runs):
        began = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        seconds.append(time.perf_counter() - began)
    return min(seconds)


if __name__ == "__main__":
    print(json.dumps(measure(), indent=2))
