"""Fresh orders, each played once by ``apc run-trial`` with a seed of its own, and what came of them.

    python -m bench.fresh [--orders 20] [--seed 0] [--task pick] [--year 2016] [--cell apc2016_delft]
                          [--reality FILE] [--approach lines] [--processes 2]

Orders are those of ``apc make-order`` with the seeds from --seed on. Every finished trial is kept under
runs/fresh, so that the same command goes on where it was interrupted; other code, data or levels of reality
begin again. An order with a bin that its items cannot be stowed in is left out, and counted. Times by the
wall clock are those of processes that share the machine.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.table import Table

from bench.deliverable import (
    CANNOT_BE_CLEARED,
    CANNOT_BE_HELD,
    NO_ORDER,
    NO_ORDER_AS_KNOWN,
    NO_PLAN_WHEN_CLEARED,
    why_not_deliverable,
)
from bench.played import OVER_BY, OVER_PLAN, Played, balls, read_played
from bench.warm import planners
from pickcli.cell.data_path import data_path
from pickcli.jobs.job import sources_digest
from pickcli.planning.pick_settings import DEFAULTS, GraspApproach
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import read_scene
from pickcli.trial.make_order import make_order
from pickcli.trial.order import OrderKind
from pickcli.trial.output_file import write_output

FOLDER = Path("runs/fresh")
CELL = "apc2016_delft"
DELIVERED = ("in tote", "delivered")  # outcomes of a pick, of a stow
ENDED = (0, 6)  # exit codes of a trial that was played, clean or not
JUDGES = ("deliverable", "fresh", "played")  # the files that say what the figures are
DO_NOT_FIT = "do not fit at rest"  # what run-trial tells of a bin that its items cannot be stowed in


@dataclass(frozen=True)
class Job:
    """One trial to be played: the seed of its order and scene, the cell, where it is kept, and its grasps."""

    seed: int
    year: int
    folder: Path
    reality: Path | None
    cell: str = CELL
    task: OrderKind = OrderKind.PICK
    approach: GraspApproach = DEFAULTS.approach

    @property
    def is_played(self) -> bool:
        """Whether the trial was played to its end: its pictures are written last."""
        return (self.folder / "after.png").exists()

    @property
    def not_stowed(self) -> Path:
        """What was reported of a bin that its items cannot be stowed in, if one cannot."""
        return self.folder.with_suffix(".not_stowed")

    @property
    def judged(self) -> Path:
        """Where the figures are kept, by what they are judged with."""
        sources = [Path(__file__).with_name(f"{name}.py").read_bytes() for name in JUDGES]
        return self.folder / f"judged_{hashlib.sha256(b''.join(sources)).hexdigest()[:12]}.json"


def jobs(
    seeds: Sequence[int], year: int, reality: Path | None, folder: Path = FOLDER, cell: str = CELL,
    task: OrderKind = OrderKind.PICK, approach: GraspApproach = DEFAULTS.approach,
) -> list[Job]:  # fmt: skip
    """One trial per seed, kept apart from those of other tasks, code, data, cells and levels."""
    parts = [sources_digest().encode(), *(p.read_bytes() for p in sorted(data_path().rglob("*.yaml")))]
    if reality is not None:
        parts.append(reality.read_bytes())
    made_with = hashlib.sha256(b"\x1f".join(parts))
    home = folder / made_with.hexdigest()[:12]
    prefix = ("" if cell == CELL else f"{cell}-") + ("" if task is OrderKind.PICK else f"{task}-")
    prefix += "" if approach is DEFAULTS.approach else f"{approach}-"
    return [Job(seed, year, home / f"{prefix}{year}-{seed}", reality, cell, task, approach) for seed in seeds]


def play(job: Job) -> str:
    """Play and judge one trial, as far as it is not; what went wrong with the program itself, or ""."""
    failed = "" if job.is_played or job.not_stowed.exists() else _run(job)
    if job.is_played and not job.judged.exists():
        job.judged.write_text(json.dumps(judged(job.folder, _planners(job.cell)), indent=2) + "\n")
    return failed


def _run(job: Job) -> str:
    job.folder.parent.mkdir(parents=True, exist_ok=True)
    order = job.folder.with_suffix(".json")
    write_output(order, make_order(job.task, job.year, job.seed))
    options = ["--cell", job.cell, "--seed", str(job.seed), "-o", str(job.folder), "--overwrite"]
    options += ["--approach", str(job.approach), "--perception", "noise"]
    if job.reality is not None:
        options += ["--reality", str(job.reality)]
    command = [sys.executable, "-m", "pickcli", "run-trial", str(order), *options]
    done = subprocess.run(command, capture_output=True, text=True)
    if DO_NOT_FIT in done.stderr:
        job.not_stowed.write_text(done.stderr)
    elif done.returncode not in ENDED:
        return f"order {job.seed}: exit code {done.returncode}: {done.stderr.strip()[-500:]}"
    return ""


@cache
def _planners(cell: str) -> tuple[PlanningContext, ...]:
    return planners(cell)


def judged(folder: Path, warm: Sequence[PlanningContext]) -> dict[str, Any]:
    """The figures of one trial.

    warm: a planner for each arm that plays, that of the arm that acted first before others
    """
    cell = warm[0].cell
    played = read_played(folder, balls(cell.items))
    missed = undelivered(played, read_scene(folder / "scene.json", cell), warm)
    record, statistics = played.record, played.record["statistics"]["attempts"]
    planned = [(a["plan"] is not None, s.get("planning_ms")) for a, s in
               zip(record["attempts"], statistics, strict=True)]  # fmt: skip
    return {
        "seed": record["made_from"]["seed"],
        "items_in_tote": record["items_in_tote"],
        "targets": len(record["items"]),
        "score": record["score"],
        "max_score": record["max_score"],
        "aborted": record["aborted"],
        "clock_s": record["clock_s"],
        "contacts": played.contacts,
        "limit_violations": record["limit_violations"],
        "neighbours_moved": played.neighbours_moved,
        "drops": record["drops"],
        "loads": played.loads,
        "certified": played.n_certified,
        "rejected": played.n_rejected,
        "missed": missed,
        "delivered_by": delivered_by(record),
        "by_region": by_region(record),
        "delivery_s": played.delivery_times,
        "event_distance_mm": 1e3 * max(played.event_distances, default=0.0),
        # The first call of a process is left out: a planner is warm ever after.
        "planning_ms": [ms for is_planned, ms in planned[1:] if is_planned and ms is not None],
        "planning_failed_ms": [ms for is_planned, ms in planned[1:] if not is_planned and ms is not None],
        "verification_ms": [s["verification_ms"] for s in statistics[1:] if "verification_ms" in s],
    }


def delivered_by(record: Mapping[str, Any]) -> dict[str, int]:
    """How many targets each arm delivered; nothing in a cell with one arm."""
    done = (a["arm"] for a in record["attempts"] if a["outcome"] in DELIVERED and "arm" in a)
    return dict(sorted(Counter(done).items()))


def by_region(record: Mapping[str, Any]) -> int:
    """How many items were delivered by a grasp that a region query found."""
    done = (a["plan"]["grasp"] for a in record["attempts"] if a["outcome"] in DELIVERED)
    return sum("envelope" in grasp for grasp in done if grasp is not None)


def undelivered(played: Played, scene: Scene, warm: Sequence[PlanningContext]) -> list[dict[str, Any]]:
    """Every target that was not delivered, with its reason and why it is not deliverable, "" if it is."""
    found = []
    for line in played.record["items"]:
        if line["outcome"] in DELIVERED:
            continue
        copies = [p for p in scene.in_location(line["bin"]) if p.item.name == line["item"]]
        line_of_target = {key: line[key] for key in ("bin", "item", "outcome", "reason")}
        found.append(line_of_target | {"why_not": why_not_deliverable(copies, scene, warm)})
    return found


def play_all(wanted: Sequence[Job], processes: int) -> list[dict[str, Any]]:
    """The figures of all trials whose order could be stowed, in their order.

    Raises RuntimeError naming those that did not end.
    """
    with ProcessPoolExecutor(processes, get_context("spawn")) as pool:
        failed = []
        for job, error in zip(wanted, pool.map(play, wanted), strict=True):
            done = "not stowed" if job.not_stowed.exists() else "played"
            print(f"{job.folder}: {error or done}", file=sys.stderr, flush=True)
            failed += [error] if error else []
    if failed:
        raise RuntimeError("\n".join(failed))
    return [json.loads(job.judged.read_text()) for job in wanted if not job.not_stowed.exists()]


def summary(trials: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """What the trials have in common."""
    delivered = [trial["items_in_tote"] for trial in trials]
    missed = [target["why_not"] for trial in trials for target in trial["missed"]]
    planned, measured = np.array([load for t in trials for load in t["loads"]]).reshape(-1, 2).T
    rejected, certified = (sum(trial[key] for trial in trials) for key in ("rejected", "certified"))
    as_known = sum(delivered) + missed.count("")
    by_plans = as_known + missed.count(NO_ORDER_AS_KNOWN)
    clearable = by_plans + missed.count(NO_ORDER)
    deliverable = clearable + missed.count(CANNOT_BE_CLEARED)
    return {
        "trials": len(trials),
        "items_in_tote_mean": float(np.mean(delivered)),
        "items_in_tote_least": min(delivered),
        "delivered_by": dict(sorted(sum((Counter(t["delivered_by"]) for t in trials), Counter()).items())),
        "by_region": sum(trial["by_region"] for trial in trials),
        "score_mean": float(np.mean([trial["score"] for trial in trials])),
        "score_least": min(trial["score"] for trial in trials),
        "score_share": sum(t["score"] for t in trials) / sum(t["max_score"] for t in trials),
        "with_contact": sum(bool(trial["contacts"]) for trial in trials),
        "with_limit_violation": sum(trial["limit_violations"] > 0 for trial in trials),
        "neighbours_moved": sum(len(trial["neighbours_moved"]) for trial in trials),
        "aborted": sum(bool(trial["aborted"]) for trial in trials),
        "delivered_share": sum(delivered) / max(deliverable, 1),
        "delivered_share_of_clearable": sum(delivered) / max(clearable, 1),
        "delivered_share_by_plans": sum(delivered) / max(by_plans, 1),
        "delivered_share_as_known": sum(delivered) / max(as_known, 1),
        "missed_deliverable": deliverable - sum(delivered),
        "missed_cannot_be_cleared": missed.count(CANNOT_BE_CLEARED),
        "missed_no_order": missed.count(NO_ORDER),
        "missed_no_order_as_known": missed.count(NO_ORDER_AS_KNOWN),
        "missed_cannot_be_held": missed.count(CANNOT_BE_HELD),
        "missed_no_plan_when_cleared": missed.count(NO_PLAN_WHEN_CLEARED),
        "holds": len(planned),
        "holds_over_plan_share": _share(measured > OVER_PLAN * planned),
        "holds_over_by_share": _share(measured > planned + OVER_BY),
        "load_worst": float(measured.max(initial=0.0)),
        "drops": sum(trial["drops"] for trial in trials),
        "plans": certified + rejected,
        "rejected_share": rejected / (certified + rejected) if certified + rejected else 0.0,
        "clock_s_mean": float(np.mean([trial["clock_s"] for trial in trials])),
        "delivery_s_mean": _mean(trials, "delivery_s"),
        "event_distance_mm_max": max(trial["event_distance_mm"] for trial in trials),
        **{name: _spread(trials, name) for name in ("planning_ms", "planning_failed_ms", "verification_ms")},
    }


def _share(holds: npt.NDArray[np.bool_]) -> float | None:
    """Of how many it is so; None of none at all."""
    return float(np.mean(holds)) if len(holds) else None


def _values(trials: Sequence[dict[str, Any]], name: str) -> list[float]:
    return [value for trial in trials for value in trial[name]]


def _mean(trials: Sequence[dict[str, Any]], name: str) -> float | None:
    values = _values(trials, name)
    return float(np.mean(values)) if values else None


def _spread(trials: Sequence[dict[str, Any]], name: str) -> dict[str, float]:
    values = _values(trials, name)
    if not values:
        return {"n": 0}
    median, p95, p99 = np.percentile(values, [50, 95, 99])
    return {
        "n": len(values),
        "median": float(median),
        "p95": float(p95),
        "p99": float(p99),
        "max": max(values),
    }


def rows(figures: dict[str, Any]) -> Iterator[tuple[str, str, float, bool]]:
    """Figure, what it is to be, what it is, and whether that was reached."""
    n = figures["trials"]
    at_most = {
        f"trials of {n} with an unplanned contact over 0.5 N or 0.1 mm": (0, figures["with_contact"]),
        f"trials of {n} with a limit violation": (0, figures["with_limit_violation"]),
        f"neighbours carried, toppled or dropped in {n} trials": (0, figures["neighbours_moved"]),
        f"trials of {n} aborted": (0, figures["aborted"]),
        "holds with over 1.1 times the planned load, %": (2, _percent(figures["holds_over_plan_share"])),
        "the same, by over 0.1 of what the cup bears, %": (2, _percent(figures["holds_over_by_share"])),
        "drops per 100 trials": (3, 100.0 * figures["drops"] / n),
        "plans that the verifier rejected, %": (0.2, _percent(figures["rejected_share"])),
        "events: distance from where they were due, mm": (2, figures["event_distance_mm_max"]),
    }  # fmt: skip
    share = _percent(figures["delivered_share"])
    yield "targets that can be held and reached: delivered, %", ">= 95", share, share >= 95.0
    for what, (most, value) in at_most.items():
        yield what, f"<= {most:g}", value, value <= most


def _percent(share: float | None) -> float:
    return float("nan") if share is None else 100.0 * share


def show(figures: dict[str, Any], console: Console) -> None:
    """The table, and the figures without a promise."""
    table = Table("figure", "to be", "is", "")
    for what, wanted, value, is_kept in rows(figures):
        table.add_row(what, wanted, f"{value:.3g}", "" if is_kept else "missed")
    console.print(table)
    for key in ("not_stowed", "items_in_tote_mean", "items_in_tote_least", "delivered_by", "by_region",
                "score_mean", "score_least", "score_share",
                "missed_cannot_be_held", "missed_no_plan_when_cleared", "missed_deliverable",
                "missed_cannot_be_cleared", "missed_no_order", "missed_no_order_as_known",
                "delivered_share_of_clearable", "delivered_share_by_plans", "delivered_share_as_known",
                "holds", "load_worst", "clock_s_mean", "delivery_s_mean", "planning_ms",
                "verification_ms"):  # fmt: skip
        console.print(f"{key}: {figures[key]}", highlight=False)


def measure(
    seeds: Sequence[int],
    year: int = 2016,
    reality: Path | None = None,
    processes: int = 2,
    cell: str = CELL,
    task: OrderKind = OrderKind.PICK,
    approach: GraspApproach = DEFAULTS.approach,
) -> dict[str, Any]:
    """Play what is not played yet; the summary, with every trial's figures."""
    trials = play_all(jobs(seeds, year, reality, cell=cell, task=task, approach=approach), processes)
    return {**summary(trials), "not_stowed": len(seeds) - len(trials), "each": trials}


def main() -> None:
    """Play, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--orders", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0, help="of the first order")
    parser.add_argument("--task", choices=("pick", "stow"), default="pick")
    parser.add_argument("--year", type=int, choices=(2015, 2016), default=2016)
    parser.add_argument("--cell", default=CELL, help="a name under data/cells; all of its arms play")
    parser.add_argument("--reality", type=Path, metavar="FILE")
    parser.add_argument(
        "--approach", type=GraspApproach, choices=list(GraspApproach), default=DEFAULTS.approach
    )
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--json", type=Path, default=Path("runs/fresh.json"), metavar="FILE")
    given = parser.parse_args()
    seeds = range(given.seed, given.seed + given.orders)
    task = OrderKind(given.task)
    figures = measure(seeds, given.year, given.reality, given.processes, given.cell, task, given.approach)
    show(figures, Console(width=110))
    given.json.parent.mkdir(parents=True, exist_ok=True)
    given.json.write_text(json.dumps(figures, indent=2) + "\n")
    print(f"wrote {given.json}")


if __name__ == "__main__":
    main()
