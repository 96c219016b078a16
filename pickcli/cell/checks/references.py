"""Checks of names in a cell file: referenced names must exist, and names must be unique."""

from __future__ import annotations

from collections.abc import Sequence

from pickcli.files.source import Key, Source
from pickcli.name_suggestion import shortened, suggestion


def refer(source: Source, key: Key, kind: str, name: str, known: Sequence[str]) -> None:
    """Report a reference to a name that does not exist.

    Args:
        source: Collects the mistakes with their places in the file.
        key: Where the name stands.
        kind: Kind of the named thing, e.g. "link".
        name: The name.
        known: Names that exist.
    """
    if name not in known:
        hint = "" if source.is_full else f"; {suggestion(name, known)}"
        source.add(key, f"no {kind} is named {shortened(name)!r}{hint}")


def unique(source: Source, keys: Sequence[Key], names: Sequence[str]) -> None:
    """Report names that occur twice.

    Args:
        source: Collects the mistakes with their places in the file.
        keys: Key of each name in the file.
        names: The names.
    """
    seen: set[str] = set()
    for key, name in zip(keys, names, strict=True):
        if name in seen:
            source.add(key, f"the name {name!r} stands twice; rename one")
        seen.add(name)
