"""Names in a cell file that refer to each other: each must exist, and exist once."""

from __future__ import annotations

from collections.abc import Sequence

from pickcli.files.yaml_reader import Key, Source
from pickcli.name_suggestion import shortened, suggestion


def refer(source: Source, key: Key, kind: str, name: str, known: Sequence[str]) -> None:
    """Note a name that does not exist.

    Args:
        source: Collects the mistakes with their places in the file.
        key: Where the name stands.
        kind: What the name should be of, e.g. "link".
        name: The name.
        known: Names that exist.
    """
    if name not in known:
        hint = "" if source.is_full else f"; {suggestion(name, known)}"
        source.add(key, f"no {kind} is named {shortened(name)!r}{hint}")


def unique(source: Source, keys: Sequence[Key], names: Sequence[str]) -> None:
    """Note names that stand twice.

    Args:
        source: Collects the mistakes with their places in the file.
        keys: Where each name stands.
        names: The names.
    """
    seen: set[str] = set()
    for key, name in zip(keys, names, strict=True):
        if name in seen:
            source.add(key, f"the name {name!r} stands twice; rename one")
        seen.add(name)
