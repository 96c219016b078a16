"""What is well-formed in a file and probably wrong: told where it stands, and silenced by the file itself.

A file accepts a warning under ``accepted_warnings``: KIND, or KIND:SUBJECT for one of several.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from pickcli.files.yaml_reader import Key, Source, name_of
from pickcli.name_suggestion import shortened, suggestion

ACCEPTED = "accepted_warnings"  # the key of a file that silences warnings
FEW = 3  # warnings of one kind that are told one by one

_log = logging.getLogger(__name__)


@dataclass
class FileWarnings:
    """Warnings about one file, without those that it accepts.

    Attributes:
        source: The file, for places.
        accepted: What it accepts: kinds, or kinds with a subject.
        lines: The warnings, each with its place and how to silence it.
    """

    source: Source
    accepted: frozenset[str]
    lines: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, source: Source) -> FileWarnings:
        """Begin with no warnings about a file that is valid.

        Args:
            source: The file.

        Returns:
            The warnings.
        """
        return cls(source, frozenset(source.data.get(ACCEPTED, ())))

    def add(self, kind: str, subject: str, key: Key, text: str) -> None:
        """Note one warning, unless the file accepts it.

        Args:
            kind: Of warning, a name.
            subject: What it is about, by name.
            key: Where the value stands; the nearest parent that stands in the file is told.
            text: What is odd, and what is probably meant.
        """
        self.add_alike(kind, {subject: (key, text)}, key, "")

    def add_alike(self, kind: str, found: dict[str, tuple[Key, str]], key: Key, cause: str) -> None:
        """Note several warnings of one kind; more than a few as one, as they have one cause.

        Args:
            kind: Of warning, a name.
            found: By subject its place and text.
            key: Where the probable cause of many stands.
            cause: What that is, as a question or advice.
        """
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
        self.lines.append(f"{where}: {text} (if it is meant, add {name} to {ACCEPTED})")

    def log(self) -> None:
        """Log every warning."""
        for line in self.lines:
            _log.warning("%s", line)


def refuse_unknown_kinds(names: Iterable[str], kinds: Collection[str]) -> None:
    """Refuse what would silence nothing.

    Args:
        names: What a file accepts.
        kinds: The kinds of warnings that there are about such a file.

    Raises:
        ValueError: No warning is called so; with what was meant.
    """
    for name in names:
        kind = name.partition(":")[0]
        if kind not in kinds:
            raise ValueError(f"no warning is called {shortened(kind)!r}; {suggestion(kind, kinds)}")
