"""What a look costs in a process of its own, and in one that has looked before.

    python -m bench.warm_looks --seed 921010 [--bins 4]

A fresh scene; into each of its first bins a look by ``apc perceive``, by ``Planner.perceive`` in one process,
and by the same again with other noise, so that all models are known. Models of prints are in the cache before
any of that is measured. Printed are medians of processor seconds, with those of the start of the program in
the first case.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from bench.perceived import fresh_scene
from pickcli import Planner, write_scene


def by_command(scene: Path, at: str, out: Path) -> float:
    """Processor seconds of one call of ``apc perceive``."""
    program = "from pickcli.commands.main import main; main()"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = ("perceive", "--scene", str(scene), "--camera", "hand", "--at", at, "-o", str(out), "--overwrite")
    subprocess.run([sys.executable, "-c", program, *words], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def seconds(call: Callable[[], object]) -> float:
    """Processor seconds of a call."""
    start = process_time()
    call()
    return process_time() - start


def main() -> None:
    """Look, and print the times."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=921010, help="of the scene")
    parser.add_argument("--bins", type=int, default=4, help="how many are looked into")
    given = parser.parse_args()
    planner = Planner.load("apc2016_delft")
    scene = fresh_scene(planner.cell, given.seed)
    views = [f"cam_{name.removeprefix('bin_')}" for name in list(planner.cell.pod.bins)[: given.bins]]
    with TemporaryDirectory() as folder:
        path, out = Path(folder) / "scene.json", Path(folder) / "p.json"
        write_scene(scene, path)
        for at in views:
            by_command(path, at, out)
        own = [by_command(path, at, out) for at in views]
    first = [seconds(lambda at=at: planner.perceive(scene, "hand", at)) for at in views]  # type: ignore[misc]
    again = [seconds(lambda at=at: planner.perceive(scene, "hand", at, seed=1)) for at in views]  # type: ignore[misc]
    for what, found in (("a process each", own), ("one process", first), ("again", again)):
        print(f"{what}: {np.median(found):.2f} s a look, of {', '.join(f'{each:.2f}' for each in found)}")


if __name__ == "__main__":
    main()
