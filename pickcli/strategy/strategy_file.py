"""Strategies in files, and those under data/strategies. The format: docs/formats/strategy.md."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pickcli.cell.data_path import data_path
from pickcli.errors import InputError, UnknownNameError
from pickcli.files.file_kind import STRATEGY
from pickcli.files.source import Key, Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.name_suggestion import shortened, suggestion
from pickcli.strategy.node_types import (
    MAX_COUNT,
    MAX_SECONDS,
    NODE_TYPES,
    Criterion,
    NodeKind,
    NodeType,
    Parameter,
    ParameterType,
    TrialKind,
)
from pickcli.strategy.strategy_tree import Argument, Strategy, StrategyNode

DEFAULT_STRATEGY = "points"
FORMAT, VERSION = "apc strategy", 1
KEYS = ("format", "version", "name", "description", "tree")
SUFFIXES = (".yaml", ".yml", ".json")
MAX_TEXT = 2000  # characters
MAX_NODES = 500
CHILD = "child"  # key of a decorator's child
LISTS = {"items": Criterion.ITEM_PRIORITY, "bins": Criterion.BIN_PRIORITY}  # criteria that use a list
_CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f]")


def packaged_strategies(kind: TrialKind = TrialKind.ORDER) -> tuple[str, ...]:
    """Return the names of the strategies that come with the program, in alphabetical order.

    Args:
        kind: The trials that they play.

    Returns:
        The names.
    """
    return tuple(sorted(path.stem for path in _folder(kind).glob("*.yaml")))


def _folder(kind: TrialKind) -> Path:
    folder = data_path() / "strategies"
    return folder / "commissions" if kind is TrialKind.COMMISSION else folder


def load_strategy(name: str, kind: TrialKind = TrialKind.ORDER) -> Strategy:
    """Read a strategy by its name or from a file.

    Args:
        name: Name of a packaged strategy, or path of a file.
        kind: The trials that it is to play.

    Returns:
        The strategy.

    Raises:
        InputError: There is no such strategy, or the file is invalid: with every mistake and its position; or
            it plays other trials.
    """
    strategy = find_strategy(name, kind)
    if strategy.kind is not kind:
        raise InputError(
            f"{name}: is a strategy of trials of the kind {strategy.kind}, not of the kind {kind}; name "
            f"another, such as {packaged_strategies(kind)[0]}"
        )
    return strategy


def find_strategy(name: str, first: TrialKind | None = None) -> Strategy:
    """Read a strategy of any kind by its name or from a file.

    Args:
        name: Name of a packaged strategy, or path of a file.
        first: Of which kind it is if there are several of the name; None if any will do.

    Returns:
        The strategy.

    Raises:
        InputError: There is no such strategy, or the file is invalid: with every mistake and its position.
    """
    kinds = tuple(TrialKind) if first is None else (first,)
    for kind in (*kinds, *TrialKind):
        if name in packaged_strategies(kind):
            return read_strategy(_folder(kind) / f"{name}.yaml")
    path = Path(name)
    if path.suffix.lower() in SUFFIXES or (name and path.exists()):
        return read_strategy(path)
    known = [each for kind in kinds for each in packaged_strategies(kind)]
    meant = suggestion(name, known)
    hint = f"{meant}{' Or' if meant.endswith('?') else '; or'} name a file (.yaml)"
    raise UnknownNameError("strategy", name, known, hint=hint)


def read_strategy(path: Path) -> Strategy:
    """Read a strategy from a file.

    Args:
        path: The file.

    Returns:
        The strategy.

    Raises:
        InputError: The file cannot be read or is invalid: with every mistake and its position.
    """
    source = read_yaml(path, STRATEGY)
    strategy = _Reader(source).strategy()
    source.check()
    return strategy


class _Reader:
    """Reads the values of a file, and adds every mistake to its problems."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._n_nodes = 0
        self._kind: TrialKind | None = None

    def strategy(self) -> Strategy:
        data = self._source.data
        if not isinstance(data, dict):
            self._source.add((), f"expected the keys {', '.join(KEYS)}; see docs/formats/strategy.md")
            self._source.check()
        for key in data:
            if key not in KEYS:
                self._source.add((key,), f"unknown key; {suggestion(str(key), KEYS)}")
        for key in KEYS:
            if key not in data:
                self._source.add((), f"the key {key} is missing")
        for key, wanted in (("format", FORMAT), ("version", VERSION)):
            if key in data and (data[key] != wanted or type(data[key]) is not type(wanted)):
                self._source.add((key,), f"expected {wanted!r}, got {shortened(repr(data[key]))}")
        texts = [self._text((key,), data.get(key)) for key in ("name", "description")]
        root = self._node(("tree",), data.get("tree")) if "tree" in data else None
        self._source.check()
        assert root is not None
        return Strategy(texts[0], texts[1], root)

    def _text(self, key: Key, value: Any) -> str:
        if key[0] in self._source.data and not (
            isinstance(value, str) and 0 < len(value) <= MAX_TEXT and not _CONTROL.search(value)
        ):
            self._source.add(key, f"expected one line of text, 1 to {MAX_TEXT} characters")
        return str(value)

    def _node(self, key: Key, value: Any) -> StrategyNode | None:
        """Read one node: a name, or a mapping from a name to children or parameters."""
        self._n_nodes += 1
        if self._n_nodes > MAX_NODES:
            if self._n_nodes == MAX_NODES + 1:
                self._source.add(key, f"more than {MAX_NODES} nodes")
            return None
        if isinstance(value, str):
            name, content, here = value, None, key
        elif isinstance(value, dict) and len(value) == 1 and isinstance(name := next(iter(value)), str):
            content, here = value[name], (*key, name)
        else:
            self._source.add(key, "expected one node: a name such as pick, or `sequence: [...]`")
            return None
        if name not in NODE_TYPES:
            self._source.add(here, f"unknown node {shortened(name)!r}; {suggestion(name, NODE_TYPES)}")
            return None
        return self._read(here, NODE_TYPES[name], content)

    def _refuse_mixed(self, key: Key, type_: NodeType) -> None:
        """Note a node that has no meaning in the trials of the nodes before it."""
        self._kind = self._kind or type_.trial
        if type_.trial not in (None, self._kind):
            kinds = f"the kind {type_.trial}, nodes before it of the kind {self._kind}"
            self._source.add(key, f"{type_.name} is of trials of {kinds}; write two strategies")

    def _read(self, key: Key, type_: NodeType, content: Any) -> StrategyNode | None:
        self._refuse_mixed(key, type_)
        if type_.kind is NodeKind.CONTROL:
            if not isinstance(content, list) or not content:
                self._source.add(key, f"expected a list of nodes, as in `{type_.name}: [look, pick]`")
                return None
            found = [self._node((*key, k), child) for k, child in enumerate(content)]
            return StrategyNode(type_.name, {}, tuple(child for child in found if child is not None))
        content = {} if content is None else content
        needs_child = type_.kind is NodeKind.DECORATOR
        if not isinstance(content, dict):
            self._source.add(key, f"expected {_example(type_)}")
            return None
        children: tuple[StrategyNode, ...] = ()
        if needs_child and CHILD not in content:
            self._source.add(key, f"the key {CHILD} is missing: expected {_example(type_)}")
        elif needs_child and (child := self._node((*key, CHILD), content[CHILD])) is not None:
            children = (child,)
        stated = {name: value for name, value in content.items() if not (needs_child and name == CHILD)}
        return StrategyNode(type_.name, self._arguments(key, type_, stated), children)

    def _arguments(self, key: Key, type_: NodeType, stated: dict[str, Any]) -> dict[str, Argument]:
        for name in stated:
            if name not in type_.parameters:
                keys = (*type_.parameters, *((CHILD,) if type_.kind is NodeKind.DECORATOR else ()))
                known = suggestion(str(name), keys) if keys else "it has no parameters"
                self._source.add((*key, name), f"unknown parameter of {type_.name}; {known}")
        found: dict[str, Argument] = {}
        for name, parameter in type_.parameters.items():
            if name in stated:
                value = self._argument((*key, name), parameter, stated[name])
                if value is not None:
                    found[name] = value
            elif parameter.is_required and stated.keys() <= type_.parameters.keys():  # else it is misspelled
                self._source.add(key, f"the parameter {name} is missing: expected {_example(type_)}")
        self._check_lists(key, found)
        return found

    def _check_lists(self, key: Key, arguments: Mapping[str, Argument]) -> None:
        """Report a criterion without its list, and a list without its criterion."""
        by = arguments.get("by", ())
        for name, criterion in LISTS.items():
            is_used = isinstance(by, tuple) and criterion in by
            if is_used and name not in arguments:
                self._source.add(key, f"the criterion {criterion} needs a list `{name}: [...]`")
            if name in arguments and not is_used:
                self._source.add((*key, name), f"is used only by the criterion {criterion}: add that to `by`")

    def _argument(self, key: Key, parameter: Parameter, value: Any) -> Argument | None:
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        match parameter.type:
            case ParameterType.COUNT if is_number and isinstance(value, int) and 1 <= value <= MAX_COUNT:
                return value
            case ParameterType.SECONDS if is_number and 0 <= value <= MAX_SECONDS:
                return float(value)
            case ParameterType.CHOICE if value in parameter.choices:
                return str(value)
            case ParameterType.CRITERIA | ParameterType.NAMES if isinstance(value, list) and value:
                return self._names(key, parameter, value)
        got = shortened(repr(value))
        if parameter.choices and parameter.type is ParameterType.CHOICE:
            self._source.add(key, f"expected one of {', '.join(parameter.choices)}, got {got}")
        else:
            self._source.add(key, f"expected {parameter.type.value}, got {got}")
        return None

    def _names(self, key: Key, parameter: Parameter, values: list[Any]) -> tuple[str, ...]:
        for k, value in enumerate(values):
            if not isinstance(value, str) or _CONTROL.search(value):
                self._source.add((*key, k), f"expected a name, got {shortened(repr(value))}")
            elif value in values[:k]:
                self._source.add((*key, k), f"{shortened(value)} is listed twice")
            elif parameter.choices and value not in parameter.choices:
                what = f"unknown criterion {shortened(value)!r}; {suggestion(value, parameter.choices)}"
                self._source.add((*key, k), what)
        return tuple(str(value) for value in values)


def _example(type_: NodeType) -> str:
    """An example of a node with all required parameters."""
    samples = {
        ParameterType.COUNT: "3", ParameterType.SECONDS: "60", ParameterType.CRITERIA: "[points, order]",
        ParameterType.NAMES: "[crayola_24_ct]",
    }  # fmt: skip
    parts = [
        f"{name}: {samples.get(parameter.type) or parameter.choices[0]}"
        for name, parameter in type_.parameters.items()
        if parameter.is_required
    ]
    parts += [f"{CHILD}: pick"] if type_.kind is NodeKind.DECORATOR else []
    return f"`{type_.name}: {{{', '.join(parts)}}}`" if parts else f"only the name, `{type_.name}`"
