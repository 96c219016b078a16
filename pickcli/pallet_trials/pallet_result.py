"""Result of a trial of a pallet: what became of every carton, and how well the stack stands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from pickcli.geometry import Array, rotation_axis_angle
from pickcli.palletizing.drop_test import MOST_SHIFT, MOST_SINKING
from pickcli.palletizing.pallet_stack import Placement


class CartonOutcome(StrEnum):
    """What became of a carton."""

    PLACED = "placed"
    LEFT = "left"  # the arm did not move for it
    LOST = "lost"  # the arm moved, and it is not in its place


@dataclass(frozen=True)
class SetDownDeviation:
    """How far a carton is from its planned place.

    Attributes:
        aside: m, of its middle, sideways.
        height: m, of its middle; positive if it is higher.
        turn: rad, of its orientation.
    """

    aside: float
    height: float
    turn: float

    @classmethod
    def of(cls, placement: Placement, T_pallet_item: Array) -> SetDownDeviation:
        """Measure a carton.

        Args:
            placement: Its planned place.
            T_pallet_item: (4, 4) where it is, in the frame of the pallet.

        Returns:
            The deviation.
        """
        off = T_pallet_item[:3, 3] - placement.centre
        planned = rotation_axis_angle((0.0, 0.0, 1.0), np.pi / 2 if placement.is_turned else 0.0)
        cosine = (np.trace(planned.T @ T_pallet_item[:3, :3]) - 1.0) / 2.0
        turn = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
        return cls(float(np.linalg.norm(off[:2])), float(off[2]), turn)

    @property
    def is_in_place(self) -> bool:
        """Whether it is where others may be put up on it and beside it."""
        return self.aside <= MOST_SHIFT and abs(self.height) <= MOST_SINKING

    def __str__(self) -> str:
        return f"{1e3 * self.aside:.0f} mm aside and {1e3 * self.height:.0f} mm in height off its place"


@dataclass(frozen=True)
class CartonResult:
    """What became of a carton.

    Attributes:
        carton: Its id.
        outcome: What became of it.
        attempts: Number of executed motions.
        reason: Why it was not put up, or what went wrong on the way; "" if nothing did.
        t_start: s of the trial at which it came.
        t_end: s at which its last motion ended; None without one.
        set_down: SetDownDeviation soon after it was set down; None if nothing moved.
        at_end: SetDownDeviation at the end of the trial; None if it was not put up.
        planning_ms: Wall-clock ms of each query, without verification.
        verifying_ms: Wall-clock ms of verification in each.
    """

    carton: str
    outcome: CartonOutcome
    attempts: int
    reason: str
    t_start: float
    t_end: float | None
    set_down: SetDownDeviation | None
    at_end: SetDownDeviation | None
    planning_ms: tuple[float, ...]
    verifying_ms: tuple[float, ...]

    @property
    def sinking(self) -> float:
        """Length (m) by which its height changed after it was set down."""
        if self.set_down is None or self.at_end is None:
            return 0.0
        return abs(self.at_end.height - self.set_down.height)


@dataclass(frozen=True)
class PalletTrialResult:
    """Result of a trial.

    Attributes:
        cartons: Those that have a place in the stack, in its sequence.
        unplanned: Reasons against those that have none, by id.
        n_collisions: Number of unplanned contacts.
        n_limit_violations: Number of violated joint limits.
        n_stops: Number of protective stops, after each of which the arm was brought home by hand.
        t_end: s of the trial at which the last motion ended.
    """

    cartons: tuple[CartonResult, ...]
    unplanned: Mapping[str, tuple[str, ...]]
    n_collisions: int
    n_limit_violations: int
    n_stops: int
    t_end: float

    @property
    def is_clean(self) -> bool:
        """Whether nothing collided and no limit was broken."""
        return self.n_collisions == self.n_limit_violations == 0

    @property
    def n_placed(self) -> int:
        """Number of cartons that are put up."""
        return sum(each.outcome is CartonOutcome.PLACED for each in self.cartons)

    @property
    def n_ordered(self) -> int:
        """Number of cartons of the order."""
        return len(self.cartons) + len(self.unplanned)

    @property
    def has_collapsed(self) -> bool:
        """Whether a carton that was put up moved by more than BED-BPP allows, or is not in its place."""
        ends = [each for each in self.cartons if each.at_end is not None]
        return any(
            each.sinking > MOST_SINKING or (each.at_end is not None and not each.at_end.is_in_place)
            for each in ends
        )

    @property
    def score(self) -> float:
        """Share of the order that is put up, 0 if it has collapsed, as of BED-BPP."""
        return 0.0 if self.has_collapsed else self.n_placed / self.n_ordered

    @property
    def boxes_an_hour(self) -> float:
        """Cartons put up in an hour at the pace of the trial."""
        return 3600.0 * self.n_placed / self.t_end if self.t_end > 0.0 else 0.0

    def record(self) -> dict[str, Any]:
        """Return the record of the trial as JSON values.

        Returns:
            Figures and every carton; wall-clock times stand under ``statistics``.
        """
        down = [each.set_down for each in self.cartons if each.outcome is CartonOutcome.PLACED]
        placed = [each for each in down if each is not None]
        return {
            "ordered": self.n_ordered,
            "placed": self.n_placed,
            "score": self.score,
            "collapsed": self.has_collapsed,
            "boxes_per_hour": self.boxes_an_hour,
            "duration_s": self.t_end,
            "collisions": self.n_collisions,
            "limit_violations": self.n_limit_violations,
            "stops": self.n_stops,
            "aside_m": spread([each.aside for each in placed]),
            "height_m": spread([abs(each.height) for each in placed]),
            "turn_rad": spread([each.turn for each in placed]),
            "sinking_m": spread([each.sinking for each in self.cartons if each.at_end is not None]),
            "cartons": [_carton(each) for each in self.cartons],
            "left": [{"id": name, "reasons": list(reasons)} for name, reasons in self.unplanned.items()],
            "statistics": {
                "planning_ms": spread([ms for each in self.cartons for ms in each.planning_ms]),
                "verifying_ms": spread([ms for each in self.cartons for ms in each.verifying_ms]),
            },
        }


def _carton(each: CartonResult) -> dict[str, Any]:
    told = asdict(each)
    del told["planning_ms"], told["verifying_ms"]
    return {**told, "outcome": str(each.outcome)}


def spread(values: Sequence[float]) -> dict[str, float] | None:
    """Return median, 95th percentile and the largest of values.

    Args:
        values: The values.

    Returns:
        Figures by name; None without any value.
    """
    if not values:
        return None
    median, p95 = np.percentile(values, [50.0, 95.0]).tolist()
    return {"median": median, "p95": p95, "worst": float(max(values))}
