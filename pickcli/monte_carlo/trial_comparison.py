"""Compares two Monte Carlo runs, paired by order and seed, with a significance test."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pickcli.errors import InputError
from pickcli.monte_carlo.sign_flips import FEWEST, SignFlipTest
from pickcli.monte_carlo.trial_statistics import Record, score_share


@dataclass(frozen=True)
class ComparedKind:
    """What is compared of trials of one kind.

    Attributes:
        task: Key of ``made_from`` under which a record has the name of what was played.
        figures: Figures of one trial, by name.
        decisive: The one of them that decides, a share.
        verb: What a run does with ``unit``, for the sentence.
        unit: Of a hundredth of the decisive figure.
        difference: Why two records of one task and seed cannot be compared; "" if they can.
        advice: What to do then.
    """

    task: str
    figures: Mapping[str, Callable[[Record], float]]
    decisive: str
    verb: str
    unit: str
    difference: Callable[[Record, Record], str]
    advice: str


def _other_targets(one: Record, other: Record) -> str:
    if _targets(one) != _targets(other):
        return "names other targets in the one than in the other"
    if one["max_score"] != other["max_score"]:
        return f"is worth {one['max_score']} points in the one and {other['max_score']} in the other"
    return ""


ORDERS = ComparedKind(
    "order",
    {
        "score_share": score_share,
        "delivered": lambda record: float(record["items_in_tote"]),
        "clock_s": lambda record: float(record["clock_s"]),
        "collisions": lambda record: float(record["collisions"]),
        "drops": lambda record: float(record["drops"]),
    },
    "score_share",
    "scores",
    "points in 100",
    _other_targets,
    "so the scores cannot be compared; play the same order",
)


@dataclass(frozen=True)
class FigureComparison:
    """One figure of two runs.

    Attributes:
        name: One of the figures of the kind.
        mean_a: Mean over the pairs in the first run.
        mean_b: Mean in the second.
        test: Test of the differences, second minus first.
    """

    name: str
    mean_a: float
    mean_b: float
    test: SignFlipTest


@dataclass(frozen=True)
class TrialComparison:
    """Comparison of two runs over the trials that both contain.

    Attributes:
        names: Names of the two runs.
        kind: What is compared.
        figures: Comparisons of all figures.
        n_unpaired: Numbers of trials that only the first or only the second run contains.
    """

    names: tuple[str, str]
    kind: ComparedKind
    figures: tuple[FigureComparison, ...]
    n_unpaired: tuple[int, int]

    @classmethod
    def of(
        cls, names: tuple[str, str], first: Mapping[str, Record], second: Mapping[str, Record],
        kind: ComparedKind = ORDERS,
    ) -> TrialComparison:  # fmt: skip
        """Compare two runs.

        Args:
            names: Names of the runs.
            first: Records of the first run's trials, with any keys.
            second: Records of the second run's trials, with any keys.
            kind: What is compared of them.

        Returns:
            The comparison.

        Raises:
            InputError: The runs have no task and seed in common, a task differs between them, or a run
                contains a trial twice.
        """
        a, b = (_by_key(name, records, kind) for name, records in zip(names, (first, second), strict=True))
        pairs = sorted(a.keys() & b.keys())
        if not pairs:
            raise InputError(
                f"{names[0]}, {names[1]}: no {kind.task} was played with the same seed in both; play them "
                "with the same --seeds"
            )
        for key in pairs:
            if found := kind.difference(a[key], b[key]):
                raise InputError(f"{names[0]}, {names[1]}: {key[0]} {found}, {kind.advice}")
        figures = [
            _compared(name, figure, [a[key] for key in pairs], [b[key] for key in pairs])
            for name, figure in kind.figures.items()
        ]
        return cls(names, kind, tuple(figures), (len(a) - len(pairs), len(b) - len(pairs)))

    @property
    def decisive(self) -> FigureComparison:
        """Comparison of the figure that decides."""
        return next(each for each in self.figures if each.name == self.kind.decisive)

    @property
    def better(self) -> str:
        """Name of the significantly better run, "" if there is none."""
        test = self.decisive.test
        return self.names[test.mean > 0] if test.is_significant else ""

    @property
    def sentence(self) -> str:
        """The result in one sentence."""
        test, (a, b), unit = self.decisive.test, self.names, self.kind.unit
        pairs = f"{test.n} pair{'s' if test.n > 1 else ''}"
        if test.n < FEWEST:
            return (
                f"{pairs} of trials are too few to tell a difference, here {100 * test.mean:+.1f} {unit} "
                f"for {b}, from chance: play {FEWEST} at least"
            )
        ends = sorted((100 * test.low, 100 * test.high), key=abs) if test.is_significant else (
            100 * test.low, 100 * test.high
        )  # fmt: skip
        figures = f"p = {test.p_value:.2g}, {pairs}"
        if not self.better:
            return (
                f"no difference beyond chance: {b} {self.kind.verb} {100 * test.mean:+.1f} {unit} more than "
                f"{a} (95 %: {ends[0]:+.1f} to {ends[1]:+.1f}; {figures})"
            )
        other = a if self.better == b else b
        low, high = (abs(end) for end in ends)
        return (
            f"{self.better} is better than {other} by {abs(100 * test.mean):.1f} {unit} "
            f"(95 %: {low:.1f} to {high:.1f}), more than chance has it ({figures})"
        )

    def values(self) -> dict[str, Any]:
        """Return the comparison as JSON values.

        Returns:
            Values by name; an unbounded interval is null.
        """
        return {
            "a": self.names[0],
            "b": self.names[1],
            "better": self.better or None,
            "sentence": self.sentence,
            "pairs": self.decisive.test.n,
            "only_in_a": self.n_unpaired[0],
            "only_in_b": self.n_unpaired[1],
            "figures": {each.name: _values(each) for each in self.figures},
        }


def _by_key(name: str, records: Mapping[str, Record], kind: ComparedKind) -> dict[tuple[str, int], Record]:
    """Index records by task and seed."""
    found: dict[tuple[str, int], Record] = {}
    for where, record in records.items():
        key = str(record["made_from"][kind.task]), int(record["made_from"]["seed"])
        if key in found:
            raise InputError(f"{name}: {where} plays {key[0]} with seed {key[1]} a second time; remove one")
        found[key] = record
    return found


def _targets(record: Record) -> list[tuple[str, str]]:
    return [(target["bin"], target["item"]) for target in record["items"]]


def _compared(
    name: str, figure: Callable[[Record], float], first: list[Record], second: list[Record]
) -> FigureComparison:
    a, b = (np.array([figure(record) for record in records]) for records in (first, second))
    return FigureComparison(name, float(a.mean()), float(b.mean()), SignFlipTest.of(b - a))


def _values(each: FigureComparison) -> dict[str, Any]:
    test = each.test
    return {
        "mean_a": round(each.mean_a, 6),
        "mean_b": round(each.mean_b, 6),
        "difference": round(test.mean, 6),
        "interval": [round(test.low, 6), round(test.high, 6)] if test.n >= FEWEST else None,
        "p_value": round(test.p_value, 6),
    }
