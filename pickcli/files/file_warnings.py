"""Warnings for valid but implausible values in a file, with their positions; the file can accept them.

A file accepts a warning under ``accepted_warnings``, as KIND, or KIND:SUBJECT for a single one.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from pickcli.files.source import Key, Source, name_of
from pickcli.name_suggestion import shortened, suggestion

ACCEPTED = "accepted_warnings"  # key of a file under which warnings are accepted
FEW = 3  # up to this many warnings of one kind are reported one by one

_log = logging.getLogger(__name__)


@dataclass
class FileWarnings:
    """Warnings about one file, without those that it accepts.

    Attributes:
        source: The file, for positions.
        accepted: Accepted warnings: kinds, or kinds with a subject.
        lines: The warnings, each with its position and how to accept it.
        met: Accepted warnings that would have been given.
    """

    source: Source
    accepted: frozenset[str]
    lines: list[str] = field(default_factory=list)
    met: set[str] = field(default_factory=set)

    @classmethod
    def of(cls, source: Source) -> FileWarnings:
        """Create an empty list of warnings for a valid file.

        Args:
            source: The file.

        Returns:
            The warnings.
        """
        return cls(source, frozenset(source.data.get(ACCEPTED, ())))

    def add(self, kind: str, subject: str, key: Key, text: str) -> None:
        """Add a warning, unless the file accepts it.

        Args:
            kind: Kind of the warning.
            subject: Name of its subject.
            key: Key of the value; if it is not in the file, the position of its nearest parent is reported.
            text: The problem, and what was probably meant.
        """
        self.add_alike(kind, {subject: (key, text)}, key, "")

    def add_alike(self, kind: str, found: dict[str, tuple[Key, str]], key: Key, cause: str) -> None:
        """Add several warnings of one kind; more than a few are combined, as probably of the same cause.

        Args:
            kind: Kind of the warnings.
            found: Key and text by subject.
            key: Key of the probable common cause.
            cause: That cause, as a question or advice.
        """
        self.met |= self.accepted & {*(f"{kind}:{name}" for name in found), *([kind] if found else [])}
        if kind in self.accepted:
            return
        left = {name: each for name, each in found.items() if f"{kind}:{name}" not in self.accepted}
        if len(left) <= FEW:
            for name, (place, text) in left.items():
                self._note(place, text, f"{kind}:{name}")
        else:
            _, text = next(iter(left.values()))
            self._note(key, f"{text}, and {len(left) - 1} more are like it; {cause}", kind)

    def _note(self, key: Key, text: str, name: str) -> None:
        key = self.source.stated(key)
        path, line, column = self.source.place(key)
        where = f"{path or self.source.path}:{line}:{column}: {name_of(key)}"
        of_file = "" if path is None else f" of {self.source.path.name}"
        self.lines.append(f"{where}: {text} (if it is meant, add {name} to {ACCEPTED}{of_file})")

    def log(self) -> None:
        """Log every warning."""
        for line in self.lines:
            _log.warning("%s", line)


def refuse_unknown_kinds(names: Iterable[str], kinds: Collection[str]) -> None:
    """Refuse accepted warnings that do not exist.

    Args:
        names: Warnings accepted by a file.
        kinds: Kinds of warnings about such a file.

    Raises:
        ValueError: There is no such kind of warning; with suggestions.
    """
    for name in names:
        kind = name.partition(":")[0]
        if kind not in kinds:
            raise ValueError(f"no warning is called {shortened(kind)!r}; {suggestion(kind, kinds)}")
