"""Other planners on our coarse queries, in one run: ``make bench-peers``.

    python -m bench.peers [--scenes N] [--limit S] [--json FILE] [--write FILE]

Prints the table, writes it into docs/benchmarks.md and all figures to runs/peers.json. The peers live in an
environment of their own (.venv-peers), each in its own process; one query goes to all of them before the
next comes, so that load from elsewhere falls on all alike. What does not install or dies becomes a row that
says so.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from bench.peers import ours
from bench.peers.judge import Judgement, judge
from bench.peers.process import PeerProcess
from bench.peers.queries import Query, exchange, queries, scenes
from bench.peers.table import OURS, Row, replace_section, section
from pickcli import __version__
from pickcli.cell.cell_file import load_cell
from pickcli.errors import ArtifactError, InputError
from pickcli.jobs.executors import available_cores, runner
from pickcli.jobs.job_run import RunOptions
from pickcli.planning.planning_context import PlanningContext
from pickcli.precompute.artifact_cache import default_paths
from pickcli.precompute.artifact_files import make_roadmap
from pickcli.roadmap.store import read_database, read_roadmap
from pickcli.scene.scene import Scene

ROOT = Path(__file__).parents[2]
PYTHON = ROOT / ".venv-peers" / "bin" / "python"
PEERS = {
    "roboplan_rrt": (
        "roboplan",
        "RRT-Connect in C++ with coal; states 0.05 apart (its default), bisected; `PathShortcutter` with its "
        "defaults.",
    ),
    "ompl_pybullet": (
        "OMPL + pybullet",
        "RRTConnect, states 0.05 apart (its own default would be 0.14) tested by pybullet from Python; "
        "`simplifyMax`.",
    ),
    "ompl_fcl": (
        "OMPL + python-fcl",
        "the same, states tested by python-fcl with one broad phase and numpy kinematics.",
    ),
    "mplib_rrt": (
        "mplib",
        "its OMPL RRTConnect with FCL in C++ at its own resolution, without TOPP; it simplifies only as a "
        "part of planning, so for `short` it plans again and simplifies.",
    ),
}
HOW_OURS = (
    "every edge proven between samples. `first`: straight edge, else RRT-Connect in the kernel; `short`: "
    "straight edge, else the quickest of the path through the precomputed roadmap and up to four of "
    "RRT-Connect, each shortened."
)


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--limit", type=float, default=2.0, help="s per query and planner")
    parser.add_argument("--json", type=Path, default=Path("runs/peers.json"), metavar="FILE")
    parser.add_argument("--write", type=Path, default=ROOT / "docs" / "benchmarks.md", metavar="FILE")
    given = parser.parse_args()
    context = _planner()
    in_scenes, asked = _asked(context, given.scenes)
    rows, margin = _measured(context, in_scenes, asked, given.limit)
    _judged(rows, in_scenes, asked)
    figures = [row.figures() for row in rows]
    meta = {
        "scenes": len(in_scenes),
        "queries": len(asked),
        "held": sum(query.held is not None for query in asked),
        "margin": margin,
        "time_limit": given.limit,
    }
    text = section(figures, meta, {row.name: row.how for row in rows})
    print(text)
    replace_section(given.write, text)
    given.json.parent.mkdir(parents=True, exist_ok=True)
    details = [{"query": query.name, **_details(rows, i)} for i, query in enumerate(asked)]
    everything = {"meta": meta, "planners": figures, "queries": details}
    given.json.write_text(json.dumps(everything, indent=2) + "\n")
    print(f"wrote {given.write} and {given.json}")


def _planner() -> PlanningContext:
    """Warm, with the cell's roadmap, built where it is missing or stale, and its database if there is one.

    No query here lies between two named configurations, so the database never has an answer.
    """
    cell = load_cell("apc2016_delft")
    paths = default_paths(cell)
    try:
        roadmap = read_roadmap(paths.roadmap, cell)
    except (ArtifactError, InputError):
        _note("building the roadmap")
        paths.roadmap.parent.mkdir(parents=True, exist_ok=True)
        make_roadmap(cell, paths.roadmap, run_options=RunOptions(runner(available_cores())))
        roadmap = read_roadmap(paths.roadmap, cell)
    try:
        return PlanningContext(cell, roadmap, read_database(paths.trajectories, cell))
    except (ArtifactError, InputError):
        return PlanningContext(cell, roadmap)


def _asked(context: PlanningContext, count: int) -> tuple[list[Scene], list[Query]]:
    in_scenes: list[Scene] = []
    asked: list[Query] = []
    for number, scene in enumerate(scenes(context.cell, count)):
        _note(f"scene {number + 1} of {count}")
        in_scenes.append(scene)
        asked += queries(context, scene, number)
    return in_scenes, asked


def _measured(
    context: PlanningContext, in_scenes: list[Scene], asked: list[Query], limit: float
) -> tuple[list[Row], float]:
    """Every query to every planner, in turns, each time another one first."""
    content = exchange(context.cell, in_scenes, asked, limit)
    mine, rows = Row(OURS, HOW_OURS, versions={"apc": __version__}), [Row(*PEERS[name]) for name in PEERS]
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(content, file)
        file.flush()
        peers = [PeerProcess(name, PYTHON, Path(file.name), limit) for name in PEERS]
        for number, query in enumerate(asked):
            _note(f"query {number + 1} of {len(asked)}")
            for k in np.roll(np.arange(len(peers) + 1), number):
                if k == len(peers):
                    mine.answers.append(ours.answer(context, query, number))
                else:
                    rows[k].answers.append(peers[k].ask(number))
        for row, peer in zip(rows, peers, strict=True):
            row.versions, row.broken = peer.versions, peer.broken
            peer.close()
    return [mine, *rows], content["margin"]


def _judged(rows: list[Row], in_scenes: list[Scene], asked: list[Query]) -> None:
    """Have every path looked at, by one process per core: nothing is timed any more."""
    work = (rows, in_scenes, asked)
    # Forked, they have the scenes without being sent them.
    with ProcessPoolExecutor(available_cores(), get_context("fork"), _set_work, work) as pool:
        for number, verdicts in enumerate(pool.map(_judgements, range(len(asked)))):
            _note(f"judged query {number + 1} of {len(asked)}")
            for row, (first, short) in zip(rows, verdicts, strict=True):
                row.first.append(first)
                row.short.append(short)


_work: tuple[list[Row], list[Scene], list[Query]]


def _set_work(*work: Any) -> None:
    global _work
    _work = work


def _judgements(number: int) -> list[tuple[Judgement | None, Judgement | None]]:
    """Of every planner's answer to one query: first path, shortened path."""
    rows, in_scenes, asked = _work
    scene, query = in_scenes[asked[number].scene], asked[number]
    verdicts = []
    for answer in (row.answers[number] for row in rows):
        first = _judgement(scene, query, answer, "first")
        is_same = answer is not None and answer["short"] == answer["first"]
        verdicts.append((first, first if is_same else _judgement(scene, query, answer, "short")))
    return verdicts


def _judgement(scene: Scene, query: Query, answer: dict[str, Any] | None, which: str) -> Judgement | None:
    if answer is None or answer[which] is None:
        return None
    return judge(scene, query, np.array(answer[which]))


def _details(rows: list[Row], i: int) -> dict[str, Any]:
    """What one query gave, without the paths."""
    out = {}
    for row in rows:
        answer, first, short = row.answers[i], row.first[i], row.short[i]
        if answer is not None:
            out[row.name] = {
                "first_ms": 1e3 * answer["first_s"],
                "short_ms": 1e3 * answer["short_s"],
                "first_cpu_ms": 1e3 * answer["first_cpu_s"],
                "first": None if first is None else vars(first),
                "short": None if short is None else vars(short),
                "source": answer.get("source", ""),
            }
    return out


def _note(what: str) -> None:
    """Progress, on one line of a terminal."""
    if sys.stderr.isatty():
        print(f"\r{what:<40}", end="", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
