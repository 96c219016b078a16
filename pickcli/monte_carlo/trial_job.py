"""Trials as jobs: one per order and seed, executed serially, in processes or on a cluster."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pickcli.cell.fingerprint import digest
from pickcli.errors import InputError, Reason
from pickcli.jobs.job import Key, refuse_other_sources
from pickcli.jobs.job_result import JobResult
from pickcli.monte_carlo.packed_folder import misfit_of_folder, packed_folder
from pickcli.trial.order import Order
from pickcli.trial.played_trial import TrialConditions, TrialRequest, play_trial, stowed_scene
from pickcli.trial.simulated_cell import TrialArm
from pickcli.trial.trial_folder import is_name_of_trial, write_folder
from pickcli.trial.trial_record import RECORDS

NOT_STOWED = "cannot be stowed"


@dataclass(frozen=True, eq=False)
class TrialJob:
    """Trials of one cell under common conditions; the key of a job is order name and seed.

    A result contains the files of the trial's folder. Except for wall-clock figures in its ``trial.json`` it
    depends only on key and job: no planned motion is reused by later trials.

    Attributes:
        orders: By name.
        order_files: File names of the orders, by name.
        arms: All arms, that of the arm that moves first in front.
        conditions: Conditions of the trials.
        read: Digest of the files of cell, items, orders and stored motions.
        sources: Digest of the program.
    """

    orders: Mapping[str, Order]
    order_files: Mapping[str, str]
    arms: tuple[TrialArm, ...]
    conditions: TrialConditions
    read: str
    sources: str

    @property
    def inputs(self) -> str:
        """SHA-256 over everything that trials depend on besides the key."""
        cells = [(arm.context.cell.fingerprint, repr(arm.context.settings)) for arm in self.arms]
        return digest(["trial", cells, repr(self.conditions), self.read, self.sources])

    def keys(self, seeds: Sequence[int]) -> list[Key]:
        """List the keys of all combinations of orders and seeds.

        Args:
            seeds: Seeds for each order.

        Returns:
            Keys, order by order.
        """
        return [(name, str(seed)) for name in self.orders for seed in seeds]

    def effort(self, key: Key) -> float:
        """Estimate the cost of a job.

        Args:
            key: The key.

        Returns:
            The number of targets.
        """
        return float(max(1, len(self.orders[key[0]].targets)))

    def make(self, key: Key) -> JobResult:
        """Play one trial.

        Args:
            key: The key.

        Returns:
            The trial's files (base64, by name), or the reason why its items cannot be stowed.

        Raises:
            InputError: This process runs another version of the program than the caller.
        """
        refuse_other_sources(self.sources)
        name, seed = key
        request = TrialRequest(self.orders[name], self.order_files[name], self.conditions, int(seed))
        try:
            scene = stowed_scene(request, self.arms[0].context.cell)
        except InputError as error:
            return JobResult(reason=Reason(NOT_STOWED, name, str(error)))
        played = play_trial(request, scene, self.arms)
        return packed_folder(
            lambda folder: write_folder(folder, played.result, played.record, played.pictures, played.motion)
        )

    def misfit(self, key: Key, result: JobResult) -> str:
        """Tell why a result cannot be one of a trial.

        Args:
            key: The key.
            result: A result that was read, of whatever content.

        Returns:
            The fault, as a phrase; "" if there is none.
        """
        name, seed = key
        if result.reason is not None:
            return "" if result.reason.what == NOT_STOWED else f"it has the reason {result.reason}"
        made_from = {"order": self.order_files[name], "seed": int(seed)}
        return misfit_of_folder(result, is_name_of_trial, RECORDS, made_from)

    def __reduce__(self) -> tuple[Any, ...]:
        # Without caches, which belong to this process.
        arms = tuple(replace(arm, context=replace(arm.context)) for arm in self.arms)
        return TrialJob, (
            self.orders, self.order_files, arms, self.conditions, self.read, self.sources,
        )  # fmt: skip
