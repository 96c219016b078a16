"""How good the motions between Delft's pairs are, against what no motion could undercut.

    python -m bench.pairs [--jobs N] [--only delft,full,own] [--every N] [--json FILE]

Delft recorded 270 motions: 135 pairs, each both ways, 50 of them from or to a home of their own, which
stands in for ours here. Each pair is planned once (the way back is that motion backwards), with the empty
tool and with a 0.2 m cube centred on the cup, under three sets of limits: Delft's (0.2 of the velocities,
all of the accelerations, no jerk limit), full ones without jerk limit, and the cell's own. The bound of a
motion is the slowest joint alone, under the same limits; Delft's own recordings are held against that
under their limits. Pairs of which an end is not free for our tool have no motion.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import Reason
from pickcli.precompute.coarse_motion_planner import CoarseMotionPlanner
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.precompute.motion_pairs import delft_pairs
from pickcli.roadmap.trajectory_database import MotionKey, PayloadClass
from pickcli.trajopt.time_lower_bound import lower_bound
from pickcli.trajopt.trajectory_settings import TrajectorySettings

# s in which the acceleration may turn from one limit to the other where there is no jerk limit: a millisecond
# of a trajectory that is promised to keep its limits at every millisecond.
NO_JERK_LIMIT = 0.001

# Delft's home (from their robot's description, joints in our order); s that their 270 recordings sum up to.
DELFT_HOME = (0.2191, 0.0, -1.0945, 0.0, -1.7267, 0.0, -0.9443, 0.0)
DELFT_RECORDED = 1065.8

# Shares of the cell's velocities and accelerations, and whether its jerk limit holds.
LIMITS = {"delft": (0.2, 1.0, False), "full": (1.0, 1.0, False), "own": (1.0, 1.0, True)}
PAYLOADS = (PayloadClass.EMPTY, PayloadClass.CENTRED_CUBE)
NEAR = 1.1  # times its own bound: what counts as a good motion


@dataclass(frozen=True)
class Made:
    """One motion: s it takes, s of its bound, whether its straight line is blocked, s that making it took.

    reason: why there is none, "" if there is
    is_end_free: False if an end itself is in collision
    """

    key: MotionKey
    duration: float
    bound: float
    is_blocked: bool
    took: float
    clearance: float
    reason: str
    is_end_free: bool


def limited(name: str) -> Cell:
    """The default cell with Delft's home, under one of the sets of limits."""
    velocity, acceleration, has_jerk_limit = LIMITS[name]
    cell = load_cell("apc2016_delft")
    old = cell.robot.limits
    jerk = old.jerk if has_jerk_limit else 2 * acceleration * old.acceleration / NO_JERK_LIMIT
    limits = replace(
        old, velocity=velocity * old.velocity, acceleration=acceleration * old.acceleration, jerk=jerk
    )
    home = replace(cell.configurations["home"], q=np.array(DELFT_HOME))
    configurations = {**cell.configurations, "home": home}
    return replace(cell, robot=replace(cell.robot, limits=limits), configurations=configurations)


@cache
def _maker(name: str) -> CoarseMotionPlanner:
    return CoarseMotionPlanner(limited(name), TrajectorySettings())


def make(name: str, key: MotionKey) -> Made:
    """One motion under a set of limits."""
    maker = _maker(name)
    q0, q1 = (maker.cell.configurations[end].q for end in (key.start, key.goal))
    bound = lower_bound(maker.cell.robot.limits, q0, q1, has_jerk_limit=LIMITS[name][2])
    tests = checker(CollisionModel(maker.cell), maker.cell.robot.tool.default_state, key.payload)
    began = time.perf_counter()
    motion = maker.make(key)
    took = time.perf_counter() - began
    is_end_free, is_blocked = tests.is_valid(q0) and tests.is_valid(q1), not tests.is_valid_edge(q0, q1)
    if isinstance(motion, Reason):
        return Made(key, np.nan, bound, is_blocked, took, np.nan, str(motion), is_end_free)
    return Made(key, motion.duration, bound, is_blocked, took, motion.clearance, "", is_end_free)


def measure(names: list[str], every: int, jobs: int) -> dict[str, Any]:
    """All motions of every set of limits and payload."""
    pairs = {load: delft_pairs(limited("own"), load)[::every] for load in PAYLOADS}
    tasks = [(name, key) for name in names for load in PAYLOADS for key in pairs[load]]
    began = time.perf_counter()
    if jobs == 1:
        made = [make(*task) for task in tasks]
    else:
        with ProcessPoolExecutor(jobs, get_context("spawn")) as pool:
            made = list(pool.map(make, *zip(*tasks, strict=True), chunksize=4))
    sets: dict[str, list[Made]] = {}
    for (name, key), one in zip(tasks, made, strict=True):
        sets.setdefault(f"{name}, {key.payload}", []).append(one)
    return {
        "machine": {"python": platform.python_version(), "jobs": jobs},
        "wall_s": time.perf_counter() - began,
        "delft_recorded_ratio": DELFT_RECORDED / (2 * _delft_bound()),
        "sets": {name: figures(some) for name, some in sets.items()},
    }


def _delft_bound() -> float:
    """s that the bounds of all of Delft's pairs sum up to, one way, under their limits."""
    cell = limited("delft")
    ends = [
        (cell.configurations[k.start].q, cell.configurations[k.goal].q)
        for k in delft_pairs(cell, PAYLOADS[0])
    ]
    return sum(lower_bound(cell.robot.limits, *both, has_jerk_limit=False) for both in ends)


def figures(made: list[Made]) -> dict[str, Any]:
    """The figures of one set, and its motions."""
    found = [one for one in made if not one.reason]
    blocked = [one for one in found if one.is_blocked]
    return {
        "pairs": len(made),
        "end_not_free": sum(not one.is_end_free for one in made),
        "unsolved": sum(bool(one.reason) and one.is_end_free for one in made),
        "blocked": len(blocked),
        "ratio": _ratio(found),
        "ratio_blocked": _ratio(blocked),
        "near_bound": float(np.mean([one.duration <= NEAR * one.bound for one in found])),
        "worst": max(one.duration / one.bound for one in found),
        "duration_s": sum(one.duration for one in found),
        "bound_s": sum(one.bound for one in found),
        "took_s": sum(one.took for one in made),
        "took_worst_s": max(one.took for one in made),
        "motions": [
            {
                "start": one.key.start,
                "goal": one.key.goal,
                "ratio": one.duration / one.bound if not one.reason else None,
                "clearance_m": one.clearance if not one.reason else None,
                "is_blocked": one.is_blocked,
                "took_s": one.took,
                "reason": one.reason,
            }
            for one in made
        ],
    }


def _ratio(made: list[Made]) -> float:
    """Sum of the durations over the sum of the bounds."""
    return sum(one.duration for one in made) / sum(one.bound for one in made) if made else float("nan")


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", default=",".join(LIMITS), help="sets of limits, by comma")
    parser.add_argument("--every", type=int, default=1, help="only every so many pairs")
    parser.add_argument("--json", type=Path, default=Path("runs/pairs.json"), metavar="FILE")
    given = parser.parse_args()
    result = measure(given.only.split(","), given.every, given.jobs)
    table = Table("limits, payload", "pairs", "end hit", "unsolved", "ratio", "blocked", "ratio of these",
                  "within 1.1", "worst", "s", "worst s")  # fmt: skip
    for name, f in result["sets"].items():
        counts = [str(f[key]) for key in ("pairs", "end_not_free", "unsolved")]
        table.add_row(name, *counts, f"{f['ratio']:.4f}", str(f["blocked"]), f"{f['ratio_blocked']:.4f}",
                      f"{f['near_bound']:.1%}", f"{f['worst']:.3f}", f"{f['took_s']:.0f}",
                      f"{f['took_worst_s']:.1f}")  # fmt: skip
    console = Console(width=130)
    console.print(table)
    console.print(f"Delft's recordings over the bound, delft limits: {result['delft_recorded_ratio']:.4f}")
    reasons = {(m["start"], m["goal"], m["reason"]) for f in result["sets"].values() for m in f["motions"]}
    for start, goal, reason in sorted(r for r in reasons if r[2]):
        console.print(f"no motion: {start} to {goal}: {reason}", highlight=False)
    given.json.parent.mkdir(parents=True, exist_ok=True)
    given.json.write_text(json.dumps(result, indent=2) + "\n")
    console.print(f"{result['wall_s']:.0f} s with {given.jobs} jobs; wrote {given.json}")


if __name__ == "__main__":
    main()
