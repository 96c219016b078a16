"""Trials played twice from one seed: are they the same bytes?

    python -m bench.repeat [--trials 10] [--seed 0] [--time-limit SECONDS]
    python -m bench.repeat --kept FOLDER

Each of the fresh orders of ``apc make-order`` is played in two processes at once, which share the machine
with a third that keeps it busy. They differ in all that must not matter: the seed of Python's string hashes
(the order of sets), the layout of the heap (the addresses of the engine's bodies), and pictures: one takes
none, the other before the start and before every attempt. Compared is all of trial.json but its
``statistics``, which hold the wall clock.

With --kept, trials that ``bench.fresh`` kept (FOLDER: one of those below runs/fresh) are played once more by
``apc run-trial``, with other string hashes, and compared in the same way.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import random
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bench.warm import context, fresh_scene
from pickcli.cell.cell_file import load_cell
from pickcli.planning.planning_context import PlanningContext
from pickcli.progress import Progress
from pickcli.trial.loop import run_trial
from pickcli.trial.simulated_cell import SimulatedArena, TrialArm, interfaces_of
from pickcli.trial.trial_record import record_text, trial_record
from pickcli.trial.trial_settings import TrialSettings

FRAGMENTS, KEPT = 50_000, 15_000  # blocks of the size of the engine's own, allocated first, then left
BLOCKS = (48, 64, 80, 96, 112, 128, 144)  # bytes
BUSY = "while True: pass"
HASH_SEED = 4242  # of a trial that is played again
ENDED = (0, 6)  # exit codes of a trial that was played, clean or not


@dataclass(frozen=True)
class Manner:
    """How a process plays: everything that must make no difference.

    hash_seed: of Python's strings
    heap_seed: of the fragments its heap begins with, None for none
    takes_pictures: before the start, and before every attempt
    """

    hash_seed: int
    heap_seed: int | None
    takes_pictures: bool


MANNERS = (Manner(1, None, False), Manner(2, 7, True))


def play(seed: int, time_limit: float | None, takes_pictures: bool, is_bare: bool = False) -> str:
    """The record of one trial of a fresh order as JSON text, without its statistics.

    is_bare: whether the planner goes without the cell's precomputed files
    """
    warm = PlanningContext(load_cell("apc2016_delft")) if is_bare else context()
    order, scene = fresh_scene(warm.cell, seed)
    arena = SimulatedArena(scene, seed=seed)

    def look(progress: Progress, /) -> None:
        if takes_pictures:
            arena.picture()

    look(Progress(0, 0))
    result = run_trial(
        order, interfaces_of([TrialArm(warm)], arena), TrialSettings(seed, time_limit=time_limit), look
    )
    record = trial_record(result, order.kind, 0.0)
    del record["statistics"]
    return record_text(record)


def fragment_heap(seed: int) -> None:
    """Let what is allocated from here on get addresses in another order than in a fresh process."""
    libc, rng = ctypes.CDLL(None), random.Random(seed)
    libc.malloc.restype, libc.malloc.argtypes = ctypes.c_void_p, [ctypes.c_size_t]
    libc.free.restype, libc.free.argtypes = None, [ctypes.c_void_p]
    blocks = [libc.malloc(rng.choice(BLOCKS)) for _ in range(FRAGMENTS)]
    rng.shuffle(blocks)
    for block in blocks[KEPT:]:
        libc.free(block)


def is_repeated(
    seed: int, time_limit: float | None, is_bare: bool = False, manners: Sequence[Manner] = MANNERS
) -> bool:
    """Whether a trial is the same bytes in every manner, each in a process of its own, all at once."""
    with TemporaryDirectory() as folder:
        paths = [Path(folder) / f"{k}.json" for k in range(len(manners))]
        busy = subprocess.Popen([sys.executable, "-c", BUSY])
        try:
            players = [
                _started(seed, time_limit, is_bare, manner, path)
                for manner, path in zip(manners, paths, strict=True)
            ]
            codes = [player.wait() for player in players]
        finally:
            busy.kill()
            busy.wait()
        if any(codes):
            raise RuntimeError(f"order {seed}: a process ended with {codes}")
        return len({path.read_bytes() for path in paths}) == 1


def _started(
    seed: int, time_limit: float | None, is_bare: bool, manner: Manner, path: Path
) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "bench.repeat", "--play", str(path), "--seed", str(seed)]
    command += [] if time_limit is None else ["--time-limit", str(time_limit)]
    command += [] if manner.heap_seed is None else ["--heap", str(manner.heap_seed)]
    command += ["--bare"] if is_bare else []
    command += ["--pictures"] if manner.takes_pictures else []
    return subprocess.Popen(command, env={**os.environ, "PYTHONHASHSEED": str(manner.hash_seed)})


def is_repeated_later(folder: Path) -> bool:
    """Whether a kept trial is the same bytes when it is played again."""
    kept = json.loads((folder / "trial.json").read_text())
    with TemporaryDirectory() as again:
        order, seed = folder.with_suffix(".json"), str(kept["made_from"]["seed"])
        command = [sys.executable, "-m", "pickcli", "run-trial", str(order), "--seed", seed]
        command += ["--perception", "noise"]
        environment = {**os.environ, "PYTHONHASHSEED": str(HASH_SEED)}
        done = subprocess.run([*command, "-o", again, "--overwrite"], env=environment, capture_output=True)
        if done.returncode not in ENDED:
            raise RuntimeError(f"{folder}: exit code {done.returncode}")
        played = json.loads((Path(again) / "trial.json").read_text())
    for record in (kept, played):
        del record["statistics"]
    return bool(kept == played)


def measure_kept(folder: Path) -> dict[str, Any]:
    """How many of the trials kept in a folder were the same bytes, and which were not."""
    differing, folders = [], sorted(path.parent for path in folder.glob("*/after.png"))
    for kept in folders:
        same = is_repeated_later(kept)
        print(f"{kept.name}: {'same bytes' if same else 'DIFFERENT'}", flush=True)
        differing += [] if same else [kept.name]
    return {"trials": len(folders), "same": len(folders) - len(differing), "differing": differing}


def measure(seeds: Sequence[int], time_limit: float | None = None) -> dict[str, Any]:
    """How many trials were the same bytes, and which were not."""
    differing = []
    for seed in seeds:
        same = is_repeated(seed, time_limit)
        print(f"order {seed}: {'same bytes' if same else 'DIFFERENT'}", flush=True)
        differing += [] if same else [seed]
    return {"trials": len(seeds), "same": len(seeds) - len(differing), "differing": differing}


def main() -> None:
    """Play, compare, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0, help="of the first order")
    parser.add_argument("--time-limit", type=float, help="s on the trial's clock, to play only its beginning")
    parser.add_argument("--kept", type=Path, metavar="FOLDER", help="play the trials kept there once more")
    parser.add_argument("--play", type=Path, metavar="FILE", help="play one trial and write its record")
    parser.add_argument("--pictures", action="store_true", help="with --play: take pictures on the way")
    parser.add_argument("--bare", action="store_true", help="with --play: plan without the cell's files")
    parser.add_argument("--heap", type=int, help="with --play: seed of a fragmented heap")
    given = parser.parse_args()
    if given.play is None:
        seeds = range(given.seed, given.seed + given.trials)
        figures = measure(seeds, given.time_limit) if given.kept is None else measure_kept(given.kept)
        print(f"{figures['same']} of {figures['trials']} the same bytes")
        sys.exit(bool(figures["differing"]))
    if given.heap is not None:
        fragment_heap(given.heap)
    given.play.write_text(play(given.seed, given.time_limit, given.pictures, given.bare))


if __name__ == "__main__":
    main()
