"""Time of hierarchical QPs, and how far each of their levels is from its optimum.

    python -m bench.hierarchies [--problems 2000] [--seed 0]

Random problems of five levels, half of them in conflict: velocity limits, 20 obstacles, 4 planes, 2 cones and
a posture. Off the optimum is the largest residual of the conditions of Karush, Kuhn and Tucker of any level,
with multipliers found by scipy. Times are those of a process that shares the machine.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.optimize import nnls

from pickcli.control.hierarchical_qp import BoundedRows, solve
from pickcli.geometry import Array

HELD, TOUCHES = 1e-9, 1e-8  # violation that later levels keep; distance from a bound that is none
WRONG = 1e-6


def random_levels(rng: np.random.Generator, n: int, is_in_conflict: bool) -> list[BoundedRows]:
    """Draw a problem of n joints."""
    shift = -0.5 if is_in_conflict else 0.5
    limits = BoundedRows(np.eye(n), np.full(n, -1.0), np.full(n, 1.0))
    obstacles = BoundedRows.at_most(rng.normal(size=(20, n)), rng.uniform(0.0, 1.0, 20) + shift)
    planes = BoundedRows(rng.normal(size=(4, n)), rng.uniform(-2.0, 0.0, 4), rng.uniform(0.0, 1.0, 4))
    cones = BoundedRows.at_most(rng.normal(size=(2, n)), rng.uniform(-1.0, 1.0, 2))
    posture = BoundedRows.equal(np.eye(n), rng.uniform(-1.5, 1.5, n))
    return [limits, obstacles, planes, cones, posture]


def off_optimum(levels: list[BoundedRows], x: Array) -> float:
    """Return the largest residual of the conditions of optimality of any level.

    The gradient of each level's violation is balanced by rows that levels before it keep: by those with a
    violation and equalities in either direction, by those at a bound only away from it.
    """
    kept: list[Array] = []
    worst = 0.0
    for level in levels:
        at = level.rows @ x
        violation = np.maximum(0.0, at - level.upper) - np.maximum(0.0, level.lower - at)
        gradient = level.rows.T @ violation
        residual = nnls(np.array(kept).T, -gradient, maxiter=5000)[1] if kept else np.linalg.norm(gradient)
        worst = max(worst, float(residual))
        for a, b, v, low, high in zip(level.rows, at, violation, level.lower, level.upper, strict=True):
            is_held = low == high or abs(v) > HELD
            kept += [a] if is_held or b >= high - TOUCHES else []
            kept += [-a] if is_held or b <= low + TOUCHES else []
    return worst


def main() -> None:
    """Solve the problems, and print a row for each number of joints."""
    parser = argparse.ArgumentParser(description="time of hierarchical QPs, and how far they are from optima")
    parser.add_argument("--problems", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    table = Table("joints", "ms, median", "99 %", "worst", "off the optimum, worst", "wrong")
    for n in (8, 16):
        rng = np.random.default_rng([options.seed, n])
        times, off = [], []
        for i in range(options.problems // 2):
            levels = random_levels(rng, n, i % 2 == 1)
            before = time.process_time()
            found = solve(levels, np.zeros(n))
            times.append(1e3 * (time.process_time() - before))
            off.append(off_optimum(levels, found.x))
        figures = [np.median(times), np.quantile(times, 0.99), max(times)]
        wrong = sum(each > WRONG for each in off)
        table.add_row(str(n), *(f"{each:.3f}" for each in figures), f"{max(off):.1e}", str(wrong))
    Console().print(table)


if __name__ == "__main__":
    main()
