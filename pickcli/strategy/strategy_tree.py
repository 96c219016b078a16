"""A strategy: a behaviour tree as data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from pickcli.cell.fingerprint import digest
from pickcli.strategy.node_types import NODE_TYPES, NodeType, TrialKind

MAX_LISTED = 7  # names of a list that a text has in full

Argument: TypeAlias = int | float | str | tuple[str, ...]


@dataclass(frozen=True)
class StrategyNode:
    """One node of a strategy.

    Attributes:
        name: Name of its type.
        arguments: Values of its parameters, by name; those that are not stated are missing.
        children: Its children, in order; a decorator has one.
    """

    name: str
    arguments: Mapping[str, Argument] = field(default_factory=dict)
    children: tuple[StrategyNode, ...] = ()

    @property
    def type(self) -> NodeType:
        """The type of the node."""
        return NODE_TYPES[self.name]

    def walk(self) -> Iterator[StrategyNode]:
        """Iterate over the node and everything below it, parents before children."""
        yield self
        for child in self.children:
            yield from child.walk()

    def values(self) -> dict[str, Any]:
        """Return the node as JSON values: ``node``, ``arguments`` and ``children``."""
        children = [child.values() for child in self.children]
        return {"node": self.name, "arguments": dict(self.arguments), "children": children}

    def __str__(self) -> str:
        stated = ", ".join(f"{name} {_text(value)}" for name, value in self.arguments.items())
        return f"{self.name} ({stated})" if stated else self.name


@dataclass(frozen=True)
class Strategy:
    """A strategy of trials.

    Attributes:
        name: Its name.
        description: What it does and where it comes from.
        root: The root of the tree.
    """

    name: str
    description: str
    root: StrategyNode

    @property
    def kind(self) -> TrialKind:
        """The trials that it plays: those of its first condition or action; of orders if it has none."""
        kinds = (node.type.trial for node in self.root.walk())
        return next((kind for kind in kinds if kind is not None), TrialKind.ORDER)

    @property
    def digest(self) -> str:
        """SHA-256 of the tree, hexadecimal; name and description do not count."""
        return digest(self.root.values())


def _text(value: Argument) -> str:
    if not isinstance(value, tuple):
        return f"{value:g}" if isinstance(value, float) else f"{value}"
    few = value if len(value) <= MAX_LISTED else (*value[:2], f"... {len(value)} in all")
    return ", ".join(few)
