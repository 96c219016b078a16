"""Names of items and bins in a strategy's lists that a cell does not have: such an entry has no effect."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from pickcli.name_suggestion import suggestion
from pickcli.strategy.strategy_tree import Strategy

MOST_NAMED = 3  # unknown names of one list with a suggestion of their own


def unknown_names(strategy: Strategy, items: Collection[str], bins: Collection[str]) -> tuple[str, ...]:
    """Find the names in the lists of a strategy that mean nothing in a cell.

    Args:
        strategy: The strategy.
        items: Names of the cell's items.
        bins: Names of its bins or other places.

    Returns:
        One sentence for each, or one for a list with many.
    """
    known = {"items": items, "bins": bins}
    return tuple(
        line
        for node in strategy.root.walk()
        for name, names in node.arguments.items()
        if name in known and isinstance(names, tuple)
        for line in _unknown(f"{node.name}.{name}", names, known[name])
    )


def _unknown(where: str, names: tuple[str, ...], known: Collection[str]) -> Iterator[str]:
    unknown = [name for name in names if name not in known]
    if len(unknown) > MOST_NAMED:
        few = ", ".join(unknown[:MOST_NAMED])
        yield f"{where}: {len(unknown)} of {len(names)} names are unknown in this cell: {few}, ..."
        return
    for name in unknown:
        yield f"{where}: {name!r} is unknown in this cell; {suggestion(name, known)}"
