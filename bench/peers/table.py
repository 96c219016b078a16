"""The figures of all planners as a Markdown section."""

from __future__ import annotations

import datetime
import os
import platform
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from bench.peers.judge import Judgement

HEADING = "## Planners of others"
OURS = "apc"
INTRODUCTION = (
    "{queries} coarse queries of {scenes} random scenes, {held} of them with the item held: from a named "
    "configuration to in front of a bin, and from there with the item to over the tote, as in `plan-pick`. "
    "Every planner got the same robot, tool, held item, world, margin ({millimetres:.0f} mm around the "
    "world) and time limit ({time_limit:g} s), one query at a time, in turns. The set-up of a scene is not "
    "counted. `first`: until the first path; `short`: with the planner's own shortening on top; for apc: the "
    "whole answer that a pick gets. Times and lengths are over the queries that each answered; lengths: "
    "median, Euclidean in joint space (rad, m). `invalid`: paths in which, by exact shapes, something "
    "touches, or that do not lead from start to goal."
)


@dataclass
class Row:
    """One planner's answers, in the order of the queries."""

    name: str
    how: str  # it is asked
    answers: list[dict[str, Any] | None] = field(default_factory=list)
    first: list[Judgement | None] = field(default_factory=list)
    short: list[Judgement | None] = field(default_factory=list)
    versions: dict[str, str] = field(default_factory=dict)
    broken: str = ""

    def figures(self) -> dict[str, Any]:
        """All figures: times in ms, lengths in rad and m mixed, over the queries that it answered."""
        found = [a for a in self.answers if a is not None and a["first"] and a["short"]]
        return {
            "planner": self.name,
            "versions": self.versions,
            "broken": self.broken,
            "answered": len(found),
            "failures": len(self.answers) - len(found),
            "first_ms": _spread([1e3 * a["first_s"] for a in found]),
            "first_cpu_ms": _spread([1e3 * a["first_cpu_s"] for a in found]),
            "short_ms": _spread([1e3 * a["short_s"] for a in found]),
            "first_length": _median([length(a["first"]) for a in found]),
            "short_length": _median([length(a["short"]) for a in found]),
            "first_invalid": sum(j is not None and not j.is_valid for j in self.first),
            "short_invalid": sum(j is not None and not j.is_valid for j in self.short),
            "sources": dict(Counter(a["source"] for a in found if "source" in a)),
        }


def length(path: list[list[float]]) -> float:
    """Euclidean length of a polyline in joint space, m of the rail and rad of the joints mixed."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def section(figures: list[dict[str, Any]], meta: dict[str, Any], hows: dict[str, str]) -> str:
    """The section of the document, with heading."""
    lines = [
        HEADING,
        "",
        f"Written by `make bench-peers` on {datetime.date.today():%Y-%m-%d}. {_machine()}",
        "",
        INTRODUCTION.format(**meta, millimetres=1e3 * meta["margin"]),
        "",
        "| planner | first: median / p95 / p99, ms | short: median / p95 / p99, ms | length first / short "
        "| failures | invalid first / short |",
        "|---|---|---|---|---|---|",
        *(_line(f) for f in figures),
        "",
        *(f"- {name}: {how}" for name, how in hows.items()),
        "",
        *_verdict(figures),
    ]
    return "\n".join(lines) + "\n"


def replace_section(path: Path, text: str) -> None:
    """Write the section into a document: in place of the one with the same heading, else at the end."""
    old = path.read_text() if path.exists() else "# Benchmarks\n"
    parts = old.split("\n## ")
    kept = [part for part in parts[1:] if f"## {part}".splitlines()[0] != HEADING]
    document = "\n## ".join([parts[0].rstrip() + "\n", *kept]).rstrip() + "\n"
    path.write_text(f"{document}\n{text}")


def _line(f: dict[str, Any]) -> str:
    name = " ".join([f["planner"], *(f"{v}" for v in f["versions"].values())][:2])
    if f["broken"] and not f["answered"]:
        return f"| {name} | {f['broken']} | | | | |"
    if not f["answered"]:
        return f"| {name} | no answer to any query | | | {f['failures']} | |"
    note = f" ({f['broken']})" if f["broken"] else ""
    return (
        f"| {name}{note} | {_times(f['first_ms'])} | {_times(f['short_ms'])} | {f['first_length']:.2f} / "
        f"{f['short_length']:.2f} | {f['failures']} | {f['first_invalid']} / {f['short_invalid']} |"
    )


def _verdict(figures: list[dict[str, Any]]) -> list[str]:
    """Our two promises against the best peer."""
    ours = next(f for f in figures if f["planner"] == OURS)
    peers = [f for f in figures if f["planner"] != OURS and f["answered"]]
    if not peers or not ours["answered"]:
        return ["No peer answered: nothing to compare with."]
    shortest = min(peers, key=lambda f: f["short_length"])
    share = ours["short_length"] / shortest["short_length"]
    who = ", ".join(f"{n} by {source}" for source, n in sorted(ours["sources"].items()))
    return [
        "- Promised: our p95 at least 5 times below that of the quickest peer. Measured: "
        f"{_times_below('first_ms', peers, ours)} until a first path, "
        f"{_times_below('short_ms', peers, ours)} until a shortened one. By processor time, which is less "
        f"sensitive to other load, the former is {_times_below('first_cpu_ms', peers, ours)}. Our whole "
        f"answer against a peer's first path: {_whole_below_first(peers, ours)}.",
        "- Promised: our median length at most 1.05 of that of the shortest peer. Measured: "
        f"{share:.3f} ({shortest['planner']}, shortened).",
        f"- Of our answers {who}.",
    ]


def _times_below(key: str, peers: list[dict[str, Any]], ours: dict[str, Any]) -> str:
    """Our p95 against the least of the peers'."""
    quickest = min(peers, key=lambda f: f[key][1])
    return f"{quickest[key][1] / ours[key][1]:.1f} times ({quickest['planner']})"


def _whole_below_first(peers: list[dict[str, Any]], ours: dict[str, Any]) -> str:
    """Our p95 until all is done against the least of the peers' until a path however long."""
    quickest = min(peers, key=lambda f: f["first_ms"][1])
    longer = quickest["first_length"] / ours["short_length"]
    return (
        f"{quickest['first_ms'][1] / ours['short_ms'][1]:.1f} times below ({quickest['planner']}, whose "
        f"first paths are {longer:.1f} times as long)"
    )


def _machine() -> str:
    """Facts about the machine."""
    info = Path("/proc/cpuinfo")
    model = [line.split(":")[1].strip() for line in info.read_text().splitlines() if "model name" in line]
    return f"{os.cpu_count()} cores ({model[0]}), Python {platform.python_version()}."


def _times(ms: list[float]) -> str:
    return " / ".join(f"{value:.3g}" if value < 1000 else f"{value:.0f}" for value in ms)


def _spread(values: list[float]) -> list[float]:
    return [float(value) for value in np.percentile(values, [50, 95, 99])] if values else []


def _median(values: list[float]) -> float:
    return float(np.median(values)) if values else float("nan")
