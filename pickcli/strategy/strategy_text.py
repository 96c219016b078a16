"""A strategy as indented text."""

from __future__ import annotations

from collections.abc import Iterator

from pickcli.strategy.node_types import NodeKind
from pickcli.strategy.strategy_tree import Strategy, StrategyNode

MARKS = {NodeKind.CONTROL: "", NodeKind.DECORATOR: "", NodeKind.CONDITION: "? ", NodeKind.ACTION: "! "}


def strategy_text(strategy: Strategy) -> str:
    """Format a strategy as a tree: one line for each node, conditions with a question mark.

    Args:
        strategy: The strategy.

    Returns:
        Lines without a line break at the end.
    """
    return "\n".join([f"{strategy.name}: {strategy.description}", "", *_lines(strategy.root, "", "")])


def _lines(node: StrategyNode, first: str, rest: str) -> Iterator[str]:
    """Yield the lines of a node, which begin with ``first`` and below it with ``rest``."""
    yield f"{first}{MARKS[node.type.kind]}{node}"
    for k, child in enumerate(node.children):
        is_last = k == len(node.children) - 1
        yield from _lines(child, rest + ("└─ " if is_last else "├─ "), rest + ("   " if is_last else "│  "))
