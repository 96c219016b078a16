"""All exceptions that the package raises on purpose, in one tree.

ApcError
├── InputError            3  a file, name or value from outside is not usable
│   ├── UnknownNameError  3  a name that is not in the cell, the items or the scene
│   └── StartError        3  a robot that is not where the plan begins (``simulation.start_check``)
├── ArtifactError         4  a stored file is stale, damaged or rejected
│   ├── StaleError        4  made for another cell, scene or version (the message names both)
│   ├── DamagedError      4  truncated, flipped bits, wrong checksums
│   └── RejectedError     4  the verifier said no
├── NoPlanError           5  no motion exists that the planner could find; carries every reason
│   └── NoExtractionError 5  no grasp leads an item out of its place, wherever it is to be brought
├── TrialAbortedError     6  a trial, or an execution of plans, in which a motion went wrong
├── WorkerLostError       1  a task of a build that ended the processes which tried it
└── LimitError            1  our own bug: timing made no trajectory that keeps the limits

The number is the exit code of a command that ends with the exception. Any other exception is a bug: exit 1.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from pickcli.name_suggestion import shortened, suggestion


class ApcError(Exception):
    """Base of all deliberate failures. ``exit_code`` is the exit code of the process."""

    exit_code = 1


class InputError(ApcError):
    """Input from outside is wrong; the message states the fault, its place, and a remedy."""

    exit_code = 3


def not_installed(package: str, extra: str, purpose: str) -> InputError:
    """Return the error of a missing extra.

    Args:
        package: The package that cannot be imported.
        extra: Name of the extra that installs it.
        purpose: The feature that needs it.

    Returns:
        The error, to be raised.
    """
    return InputError(f"{purpose} needs {package}; install it with: pip install 'apc-pick[{extra}]'")


MAX_PATH = 300  # characters of a name that may be a path


class UnknownNameError(InputError):
    """An unknown name. The message suggests known names.

    Args:
        kind: Kind of the name, e.g. "item".
        name: The name.
        known: Names that exist.
        where: Place of the name, e.g. a file with its line.
        hint: Text instead of the suggested name.
        text: Text instead of the whole message, if the name is known, but not here.
    """

    def __init__(
        self, kind: str, name: str, known: Sequence[str], where: str = "", hint: str = "", text: str = ""
    ) -> None:
        hint = hint or suggestion(name, known)
        unknown = f"unknown {kind} {shortened(name, MAX_PATH)!r}; {hint}"
        super().__init__(f"{where + ': ' if where else ''}{text or unknown}")
        self.kind, self.name, self.known = kind, name, tuple(known)


class ArtifactError(ApcError):
    """A file written by this program that must not be used."""

    exit_code = 4


class StaleError(ArtifactError):
    """The file was made for another cell, scene or version than the one that it is used with."""


class DamagedError(ArtifactError):
    """The file's bytes are not the bytes that were written."""


class RejectedError(ArtifactError):
    """The independent verifier rejects the plan.

    Args:
        what: The plan.
        reasons: Every fault that the verifier found.
        advice: Advice for the user.
    """

    def __init__(self, what: str, reasons: Sequence[Reason] = (), advice: str = "plan it again") -> None:
        listed = "".join(f"\n  {reason}" for reason in reasons)
        super().__init__(f"{what}: rejected, {advice}{':' if listed else ''}{listed}")
        self.what, self.reasons = what, tuple(reasons)


def printable(text: str) -> str:
    """Escape everything in a text that would move a terminal's cursor or cannot be encoded.

    Args:
        text: Text from outside.

    Returns:
        The text, safe to print.
    """
    return "".join(c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in text)


@dataclass(frozen=True)
class Reason:
    """Why one candidate failed, as a value.

    Attributes:
        what: Short cause, e.g. "collision", "no IK solution", "does not hold", "joint limit".
        where: Candidate and segment, e.g. "grasp 3 (frontal), lift".
        detail: Link, obstacle and depth, or the limit and the excess.
        in_the_way: Id of the blocking item, if there is one.
    """

    what: str
    where: str = ""
    detail: str = ""
    in_the_way: str = ""

    def at(self, where: str) -> Reason:
        """Return the reason with another place.

        Args:
            where: The new place.

        Returns:
            The changed reason.
        """
        return replace(self, where=where)

    def within(self, where: str) -> Reason:
        """Return the reason with its place as a part of a larger one.

        Args:
            where: The larger place, e.g. the grasp of a segment.

        Returns:
            The changed reason.
        """
        return self.at(", ".join(part for part in (where, self.where) if part))

    def __str__(self) -> str:
        return ": ".join(part for part in (self.where, self.what, self.detail) if part)


@dataclass(frozen=True)
class Failures:
    """Reasons why none of several candidates led to a motion, in the order of the candidates.

    Reasons that are costly to determine can be given as functions, which are only called when reasons are
    read: if another candidate leads to a motion, they are not.

    Attributes:
        parts: Reasons, and functions that return more of them, in the order in which the candidates were
            tried.
    """

    parts: tuple[Reason | Callable[[], Iterable[Reason]], ...] = ()

    @cached_property
    def reasons(self) -> tuple[Reason, ...]:
        """Every reason, in the order in which the candidates were tried."""
        return tuple(
            reason for part in self.parts for reason in ((part,) if isinstance(part, Reason) else part())
        )

    @classmethod
    def of(cls, *reasons: Reason) -> Failures:
        """Build failures from reasons.

        Args:
            *reasons: In the order in which the candidates were tried.

        Returns:
            The failures.
        """
        return cls(reasons)

    def __add__(self, other: Failures | Reason) -> Failures:
        """Concatenate the reasons of both."""
        more = (other,) if isinstance(other, Reason) else other.parts
        return Failures((*self.parts, *more))

    def within(self, where: str) -> Failures:
        """Return the failures with their places as parts of a larger one.

        Args:
            where: The larger place.

        Returns:
            The changed failures.
        """
        return Failures((lambda: (reason.within(where) for reason in self.reasons),))

    def __iter__(self) -> Iterator[Reason]:
        """Iterate over the reasons in their order."""
        return iter(self.reasons)

    @property
    def in_the_way(self) -> tuple[str, ...]:
        """Ids of the blocking items, the most frequent first, ties in their order."""
        found = Counter(reason.in_the_way for reason in self.reasons if reason.in_the_way)
        return tuple(name for name, _ in found.most_common())

    def summary(self, n_most: int = 3) -> str:
        """Summarise the most frequent causes with one example each.

        Args:
            n_most: Most causes.

        Returns:
            One line.
        """
        groups: dict[str, list[Reason]] = {}
        for reason in self.reasons:
            groups.setdefault(reason.what, []).append(reason)
        ranked = sorted(groups.items(), key=lambda kv: (-len(kv[1]), kv[0]))[:n_most]
        if not ranked:
            return "no candidate was even tried"
        return "; ".join(_reasons_text(reasons) for _, reasons in ranked)


class NoPlanError(ApcError):
    """No motion was found. Carries all reasons, grouped in the message by frequency.

    Args:
        query: The query, e.g. "pick crayola_24_ct from bin_B".
        reasons: Every reason, in the order in which the candidates were tried.
        text: Text instead of the most frequent reasons, by default their summary.
        blockers: Ids of items without which there is a plan; () if no such items are known.
    """

    exit_code = 5

    def __init__(
        self, query: str, reasons: Iterable[Reason], text: str = "", blockers: Sequence[str] = ()
    ) -> None:
        self.query, self.failures, self.blockers = query, Failures(tuple(reasons)), tuple(blockers)
        self.text = text or self.summary()
        super().__init__(f"no plan for {query}: {self.text}")

    @staticmethod
    def of_alternatives(query: str, alternatives: Sequence[tuple[str, NoPlanError | None]]) -> NoPlanError:
        """Return the error of several alternatives (arms, bins) without a plan, with a line for each.

        Args:
            query: The query.
            alternatives: In their order, each in words, and its error; None for one that was not tried.

        Returns:
            The error, with the reasons and blockers of all; a NoExtractionError if all errors are.
        """
        told = ((each, "" if error is None else error._in_a_line()) for each, error in alternatives)
        lines = [each if why in each else f"{each}: {why}" for each, why in told]  # none is told twice
        errors = [error for _, error in alternatives if error is not None]
        is_stuck = bool(errors) and all(isinstance(error, NoExtractionError) for error in errors)
        reasons = (reason for error in errors for reason in error.reasons)
        blockers = tuple(dict.fromkeys(name for error in errors for name in error.blockers))
        text = "".join(f"\n  {line}" for line in lines)
        return (NoExtractionError if is_stuck else NoPlanError)(query, reasons, text, blockers)

    @property
    def reasons(self) -> tuple[Reason, ...]:
        """Every reason, in the order in which the candidates were tried."""
        return self.failures.reasons

    @property
    def in_the_way(self) -> tuple[str, ...]:
        """Ids of the blocking items, the most frequent first, ties in their order."""
        return self.failures.in_the_way

    def summary(self) -> str:
        """Summarise the most frequent causes with one example each.

        Returns:
            One line.
        """
        return self.failures.summary()

    def _in_a_line(self) -> str:
        """Return the text; of one of several lines the summary."""
        return self.summary() if "\n" in self.text else self.text


class NoExtractionError(NoPlanError):
    """No grasp leads an item out of its place, wherever it is to be brought. With all reasons."""


def _reasons_text(reasons: Sequence[Reason]) -> str:
    """Format the first of several reasons of one kind, and their number."""
    return (
        str(reasons[0]) if len(reasons) == 1 else f"{len(reasons)} times {reasons[0].what}, e.g. {reasons[0]}"
    )


class TrialAbortedError(ApcError):
    """A trial had to be aborted, or a motion of a trial or of executed plans collided or broke a limit."""

    exit_code = 6


class WorkerLostError(ApcError):
    """A task crashed the processes that ran it, or the machine has too little memory for it."""


class LimitError(ApcError):
    """Timing made no trajectory that keeps the limits; raised instead of returning one that breaks them."""
