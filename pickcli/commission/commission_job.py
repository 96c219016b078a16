"""Trials of commissions as jobs: one per commission and seed, as those of orders."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pickcli.cell.fingerprint import digest
from pickcli.commission.commission_folder import NAMES, write_commission_folder
from pickcli.commission.commission_record import RECORDS, commission_record
from pickcli.commission.commission_station import CommissionStation
from pickcli.commission.commission_trial import CommissionRequest, play_commission
from pickcli.jobs.job import Key, refuse_other_sources
from pickcli.jobs.job_result import JobResult
from pickcli.monte_carlo.packed_folder import misfit_of_folder, packed_folder
from pickcli.planning.planning_context import PlanningContext


@dataclass(frozen=True, eq=False)
class CommissionTask:
    """A commission that is played with several seeds.

    Attributes:
        station: The commission in its cell.
        file_name: Name of its file.
        text: Its file, as it was read.
        sha256: Digest of that file.
        context: The station's cell, its models and its precomputed files.
    """

    station: CommissionStation
    file_name: str
    text: str
    sha256: str
    context: PlanningContext


@dataclass(frozen=True, eq=False)
class CommissionJob:
    """Trials of commissions under common conditions; the key of a job is the commission's name and the seed.

    A result contains the files of the trial's folder, and depends only on key and job.

    Attributes:
        commissions: By name.
        conditions: Conditions of the trials, whose seed is not used.
        read: Digest of the files of cell, commissions and stored motions.
        sources: Digest of the program.
    """

    commissions: Mapping[str, CommissionTask]
    conditions: CommissionRequest
    read: str
    sources: str

    @property
    def inputs(self) -> str:
        """SHA-256 over everything that trials depend on besides the key."""
        cells = [
            (each.context.cell.fingerprint, repr(each.context.settings)) for each in self.commissions.values()
        ]
        conditions = repr(replace(self.conditions, seed=0))
        return digest(["commission", cells, conditions, self.read, self.sources])

    def keys(self, seeds: Sequence[int]) -> list[Key]:
        """List the keys of all combinations of commissions and seeds.

        Args:
            seeds: Seeds for each commission.

        Returns:
            Keys, commission by commission.
        """
        return [(name, str(seed)) for name in self.commissions for seed in seeds]

    def effort(self, key: Key) -> float:
        """Estimate the cost of a job.

        Args:
            key: The key.

        Returns:
            The number of items, and as much again for the drives.
        """
        return 5.0 + len(self.commissions[key[0]].station.commission.items)

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
        each, request = self.commissions[name], replace(self.conditions, seed=int(seed))
        played = play_commission(request, each.station, each.context)
        record = commission_record(request, each.station, played, each.file_name, each.sha256)
        return packed_folder(
            lambda folder: write_commission_folder(folder, each.text, each.station, played, record)
        )

    def misfit(self, key: Key, result: JobResult) -> str:
        """Tell why a result cannot be one of a trial.

        Args:
            key: The key.
            result: A result that was read, of whatever content.

        Returns:
            The fault, as a phrase; "" if there is none.
        """
        made_from = {"commission": self.commissions[key[0]].file_name, "seed": int(key[1])}
        return misfit_of_folder(result, NAMES.__contains__, RECORDS, made_from)

    def __reduce__(self) -> tuple[Any, ...]:
        # Without caches, which belong to this process.
        bare = {name: replace(each, context=replace(each.context)) for name, each in self.commissions.items()}
        return CommissionJob, (bare, self.conditions, self.read, self.sources)
