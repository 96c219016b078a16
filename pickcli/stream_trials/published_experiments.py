"""The two experiments of the PR2 system of 2013 (Cowley et al., V and VI), beside trials of their streams.

Items, gaps and robot are others than theirs: what is set side by side are results of experiments, not robots.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from pickcli.cell.data_path import data_path
from pickcli.monte_carlo.trial_statistics import Record
from pickcli.stream_trials.stream_statistics import StreamStatistics

COLUMNS = ("", "PR2, 2013", "here")


@dataclass(frozen=True)
class PublishedExperiment:
    """What the paper states of an experiment.

    Attributes:
        task: Name of the stream after it under data/tasks.
        title: What it is.
        presented: Items set on the belt.
        attempted: Items for which an arm moved.
        delivered: Items that were brought to a bin.
        seconds: s for each pick and place; None where it is not stated.
    """

    task: str
    title: str
    presented: int
    attempted: int
    delivered: int
    seconds: float | None


EXPERIMENTS = (
    PublishedExperiment("pr2_belt_static", "The PR2's experiment with the belt at rest", 100, 100, 91, 6.7),
    PublishedExperiment(
        "pr2_belt_moving", "The PR2's experiment with the belt at 0.33 m/s", 100, 94, 87, None
    ),
)


@dataclass(frozen=True)
class ExperimentTable:
    """An experiment of the paper beside trials of the stream after it.

    Attributes:
        title: What it is.
        rows: What is compared, in the paper, and here.
    """

    title: str
    rows: tuple[tuple[str, str, str], ...]


def beside_paper(records: Mapping[str, Record]) -> Iterator[ExperimentTable]:
    """Set the experiments of the paper beside trials.

    Args:
        records: Contents of ``trial.json`` files of streams, by name; those of other streams are left out.

    Yields:
        An experiment whose stream was played, with the trials of that stream.
    """
    for experiment in EXPERIMENTS:
        content = (data_path() / "tasks" / f"{experiment.task}.json").read_bytes()
        sha256 = hashlib.sha256(content).hexdigest()
        ours = {
            name: record
            for name, record in records.items()
            if record["made_from"].get("stream_sha256") == sha256
        }
        if ours:
            yield ExperimentTable(experiment.title, tuple(_rows(experiment, StreamStatistics(ours))))


def _rows(theirs: PublishedExperiment, ours: StreamStatistics) -> Iterator[tuple[str, str, str]]:
    presented, attempted = ours.total("presented"), ours.total("attempted")
    delivered = ours.total("delivered")
    yield "presented", f"{theirs.presented}", f"{presented}"
    yield (
        "delivered of those",
        _share(theirs.delivered, theirs.presented),
        _share(delivered, presented),
    )
    yield "attempted", f"{theirs.attempted}", f"{attempted}"
    yield (
        "delivered of those",
        _share(theirs.delivered, theirs.attempted),
        _share(delivered, attempted),
    )
    if theirs.seconds is not None and attempted:
        seconds = sum(record["duration_s"] for record in ours.records.values()) / attempted
        yield "s for each pick and place", f"{theirs.seconds:.1f}", f"{seconds:.1f}"
    yield "collisions", "not stated", f"{ours.total('collisions')}"


def _share(part: int, whole: int) -> str:
    return f"{part}, {part / whole:.0%}" if whole else f"{part}"
