"""Every exception the suite raises on purpose, in one tree.

ApcError
├── InputError            3  a file, name or value from outside is not usable
│   └── UnknownNameError  3  a name that is not in the cell, the items or the scene
├── ArtifactError         4  a stored file is stale, damaged or rejected
│   ├── StaleError        4  made for another cell (both fingerprints are named)
│   ├── DamagedError      4  truncated, flipped bits, wrong checksums
│   └── RejectedError     4  the verifier said no
├── NoPlanError           5  no motion exists that the planner could find; carries every reason
├── TrialAbortedError     6  a trial that had to stop
├── WorkerLostError       1  a task of a build that ended the processes which tried it
└── LimitError            1  our own bug: a trajectory that breaks a limit reached the end of timing

The number is the exit code of the command that meets it. Anything outside the tree is a bug: exit 1.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace


class ApcError(Exception):
    """Base of all deliberate failures. ``exit_code`` is what the process returns."""

    exit_code = 1


class InputError(ApcError):
    """Something from outside is wrong: says what, where, and what to do."""

    exit_code = 3


class UnknownNameError(InputError):
    """A name nobody knows. ``known`` lists what could have been meant; a ``hint`` says it better."""

    def __init__(self, kind: str, name: str, known: Sequence[str], where: str = "", hint: str = "") -> None:
        import difflib

        close = difflib.get_close_matches(name, known, n=1)
        listed = ", ".join(sorted(known)[:12]) + (", ..." if len(known) > 12 else "")
        hint = hint or (f"did you mean {close[0]!r}?" if close else f"known: {listed or 'none'}")
        super().__init__(f"{where + ': ' if where else ''}unknown {kind} {name!r}; {hint}")
        self.kind, self.name, self.known = kind, name, tuple(known)


class ArtifactError(ApcError):
    """A file of ours that must not be used."""

    exit_code = 4


class StaleError(ArtifactError):
    """The file depends on something that has changed since."""


class DamagedError(ArtifactError):
    """The file's bytes are not the bytes that were written."""


class RejectedError(ArtifactError):
    """The independent verifier does not accept the plan."""


def printable(text: str) -> str:
    """The text with everything escaped that would move a terminal's cursor or cannot be encoded."""
    return "".join(c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in text)


@dataclass(frozen=True)
class Reason:
    """Why one candidate failed: failure as a value.

    what: short cause, e.g. "collision", "no IK solution", "does not hold", "joint limit"
    where: candidate and segment, e.g. "grasp 3 (frontal), lift"
    detail: link, obstacle and depth, or the limit and by how much
    in_the_way: id of the item that stands in the way, if it is one
    """

    what: str
    where: str = ""
    detail: str = ""
    in_the_way: str = ""

    def at(self, where: str) -> Reason:
        """The reason with another place."""
        return replace(self, where=where)

    def within(self, where: str) -> Reason:
        """The reason with its place told as a part of a larger one."""
        return self.at(", ".join(part for part in (where, self.where) if part))

    def __str__(self) -> str:
        return ": ".join(part for part in (self.where, self.what, self.detail) if part)


@dataclass(frozen=True)
class Failures:
    """Why none of several candidates led to a motion: what tries several returns a result or this.

    Attributes:
        reasons: Every reason, in the order in which the candidates were tried.
    """

    reasons: tuple[Reason, ...] = ()

    @classmethod
    def of(cls, *reasons: Reason) -> Failures:
        """Failures of the reasons given."""
        return cls(reasons)

    def __add__(self, other: Failures | Reason) -> Failures:
        """All reasons of both, in their order."""
        more = (other,) if isinstance(other, Reason) else other.reasons
        return Failures((*self.reasons, *more))

    def within(self, where: str) -> Failures:
        """The reasons with their places told as parts of a larger one."""
        return Failures(tuple(reason.within(where) for reason in self.reasons))

    def __iter__(self) -> Iterator[Reason]:
        """The reasons, in their order."""
        return iter(self.reasons)

    @property
    def in_the_way(self) -> tuple[str, ...]:
        """Ids of the items that stood in the way, the most frequent first, of those the first named."""
        found = Counter(reason.in_the_way for reason in self.reasons if reason.in_the_way)
        return tuple(name for name, _ in found.most_common())


class NoPlanError(ApcError):
    """No motion was found. Carries all reasons, grouped in the message by frequency."""

    exit_code = 5

    def __init__(self, query: str, reasons: Iterable[Reason]) -> None:
        self.query, self.failures = query, Failures(tuple(reasons))
        super().__init__(f"no plan for {query}: {self.summary()}")

    @property
    def reasons(self) -> tuple[Reason, ...]:
        """Every reason, in the order in which the candidates were tried."""
        return self.failures.reasons

    @property
    def in_the_way(self) -> tuple[str, ...]:
        """Ids of the items that stood in the way, the most frequent first, of those the first named."""
        return self.failures.in_the_way

    def summary(self, n_most: int = 3) -> str:
        """The most frequent causes with one example each."""
        groups: dict[str, list[Reason]] = {}
        for reason in self.reasons:
            groups.setdefault(reason.what, []).append(reason)
        ranked = sorted(groups.items(), key=lambda kv: (-len(kv[1]), kv[0]))[:n_most]
        if not ranked:
            return "no candidate was even tried"
        return "; ".join(_told(reasons) for _, reasons in ranked)


def _told(reasons: Sequence[Reason]) -> str:
    """The first of several reasons of one kind, and how many there are."""
    return (
        str(reasons[0]) if len(reasons) == 1 else f"{len(reasons)} times {reasons[0].what}, e.g. {reasons[0]}"
    )


class TrialAbortedError(ApcError):
    """The trial could not go on."""

    exit_code = 6


class WorkerLostError(ApcError):
    """A task crashed the processes that tried it, or the machine has too little memory for it."""


class LimitError(ApcError):
    """A timed trajectory breaks a limit: raised instead of handing it on."""
