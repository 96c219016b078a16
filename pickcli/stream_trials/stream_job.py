"""Trials of streams as jobs: one per stream and seed, as those of orders."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pickcli.cell.fingerprint import digest
from pickcli.jobs.job import Key, refuse_other_sources
from pickcli.jobs.job_result import JobResult
from pickcli.monte_carlo.packed_folder import misfit_of_folder, packed_folder
from pickcli.planning.planning_context import PlanningContext
from pickcli.stream_trials.stream_folder import NAMES, write_stream_folder
from pickcli.stream_trials.stream_record import RECORDS, stream_record
from pickcli.stream_trials.stream_trial import play_stream
from pickcli.stream_trials.stream_trial_request import StreamTrialRequest


@dataclass(frozen=True, eq=False)
class StreamTask:
    """A stream that is played with several seeds.

    Attributes:
        request: The stream and the conditions of its trials, whose seed is not used.
        file_name: Name of its file.
        content: Its file, as it was read.
        sha256: Digest of that file.
        contexts: Of each arm, the preferred one first: the cell as it sees it, its models and its precomputed
            files.
    """

    request: StreamTrialRequest
    file_name: str
    content: bytes
    sha256: str
    contexts: tuple[PlanningContext, ...]


@dataclass(frozen=True, eq=False)
class StreamJob:
    """Trials of streams; the key of a job is the stream's name and the seed.

    A result contains the files of the trial's folder. Except for wall-clock figures in its ``trial.json`` it
    depends only on key and job.

    Attributes:
        streams: By name.
        read: Digest of the files of cells, items, streams and stored motions.
        sources: Digest of the program.
    """

    streams: Mapping[str, StreamTask]
    read: str
    sources: str

    @property
    def inputs(self) -> str:
        """SHA-256 over everything that trials depend on besides the key."""
        cells = [
            (context.cell.fingerprint, repr(context.settings))
            for each in self.streams.values()
            for context in each.contexts
        ]
        conditions = [(each.sha256, _conditions(each.request)) for each in self.streams.values()]
        return digest(["stream", cells, conditions, self.read, self.sources])

    def keys(self, seeds: Sequence[int]) -> list[Key]:
        """List the keys of all combinations of streams and seeds.

        Args:
            seeds: Seeds for each stream.

        Returns:
            Keys, stream by stream.
        """
        return [(name, str(seed)) for name in self.streams for seed in seeds]

    def effort(self, key: Key) -> float:
        """Estimate the cost of a job.

        Args:
            key: The key.

        Returns:
            The number of items.
        """
        return float(max(1, len(self.streams[key[0]].request.stream.items)))

    def make(self, key: Key) -> JobResult:
        """Play one trial.

        Args:
            key: The key.

        Returns:
            The trial's files (base64, by name).

        Raises:
            InputError: This process runs another version of the program than the caller.
        """
        refuse_other_sources(self.sources)
        name, seed = key
        each = self.streams[name]
        request = replace(each.request, seed=int(seed))
        played = play_stream(request, each.contexts)
        record = stream_record(request, played.result, each.contexts[0], each.file_name, each.sha256)
        cells = tuple(context.cell for context in each.contexts)
        return packed_folder(lambda folder: write_stream_folder(folder, each.content, cells, played, record))

    def misfit(self, key: Key, result: JobResult) -> str:
        """Tell why a result cannot be one of a trial.

        Args:
            key: The key.
            result: A result that was read, of whatever content.

        Returns:
            The fault, as a phrase; "" if there is none.
        """
        made_from = {"stream": self.streams[key[0]].file_name, "seed": int(key[1])}
        return misfit_of_folder(result, NAMES.__contains__, RECORDS, made_from)

    def __reduce__(self) -> tuple[Any, ...]:
        # Without caches, which belong to this process.
        bare = {
            name: replace(each, contexts=tuple(replace(context) for context in each.contexts))
            for name, each in self.streams.items()
        }
        return StreamJob, (bare, self.read, self.sources)


def _conditions(request: StreamTrialRequest) -> str:
    """Return what a request states besides stream and seed."""
    stated = request.noise, request.speed_error, request.camera, request.reality, request.rule
    return repr(stated)
