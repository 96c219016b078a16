"""Small faults in a module: one operator, one constant or one check at a time."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, cast

_COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip
_SUMS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
}  # fmt: skip
_CALLS = {"max": "min", "min": "max", "any": "all", "all": "any", "maximum": "minimum", "minimum": "maximum"}

# Calls whose arguments are texts for people, the closest name among them, or declarations.
_SAID = ("Reason", "Damage", "Field", "error", "add", "Len", "get_close_matches")

Edit = Callable[[Any], ast.AST]


@dataclass(frozen=True)
class Mutant:
    """One fault.

    line: of the original
    last: line of the original where what is changed ends
    was, now: the piece of code before and after
    tree: of the whole module, without the fault
    place: where the fault is put
    fault: what is put there
    """

    line: int
    last: int
    was: str
    now: str
    tree: ast.Module = field(compare=False, repr=False)
    place: _Place = field(compare=False, repr=False)
    fault: ast.AST = field(compare=False, repr=False)

    def __str__(self) -> str:
        return f"{self.line}: {self.was} -> {self.now}"

    def source(self) -> str:
        """The whole module with the fault."""
        was = self.place.put(self.fault)
        try:
            return ast.unparse(self.tree)
        finally:
            self.place.put(was)


@dataclass(frozen=True)
class _Place:
    """A part of a syntax tree: a field of a node, or an entry of a list there."""

    parent: ast.AST
    field: str
    index: int | None

    def put(self, new: ast.AST) -> ast.AST:
        """Put another part here; returns the one that was."""
        held = getattr(self.parent, self.field)
        if self.index is None:
            setattr(self.parent, self.field, new)
            return cast(ast.AST, held)
        was, held[self.index] = held[self.index], new
        return cast(ast.AST, was)


def mutants(source: str) -> list[Mutant]:
    """Every fault that can be put into a module, in the order of its lines."""
    tree = ast.parse(source)
    found = []
    for place, node, edit in _sites(tree):
        fault = ast.fix_missing_locations(ast.copy_location(edit(node), node))
        last = (node.test if isinstance(node, ast.If) else node).end_lineno or node.lineno
        found.append(Mutant(node.lineno, last, _source_line(node), _source_line(fault), tree, place, fault))
    return sorted(found, key=lambda mutant: (mutant.line, mutant.was, mutant.now))


def _sites(node: ast.AST) -> Iterator[tuple[_Place, Any, Edit]]:
    """Places where something can be changed, what is there, and how; nothing that is only said to people."""
    for name, value in ast.iter_fields(node):
        children = value if isinstance(value, list) else [value]
        for i, child in enumerate(children):
            if not isinstance(child, ast.AST) or _is_words(node, name, child):
                continue
            place = _Place(node, name, i if isinstance(value, list) else None)
            yield from ((place, child, edit) for edit in _edits(child))
            yield from _sites(child)


def _is_words(parent: ast.AST, field: str, child: ast.AST) -> bool:
    """Whether a part of the tree is text, type, declaration or the like: no test can see a change there."""
    if field in ("annotation", "returns", "decorator_list", "type_params") or isinstance(
        child, ast.JoinedStr
    ):
        return True
    if isinstance(parent, ast.Raise) or isinstance(child, (ast.Import, ast.ImportFrom)):
        return True
    if isinstance(parent, ast.Call) and _name(parent.func) in _SAID:
        return True
    if isinstance(parent, ast.Call) and _name(parent.func) == "reshape" and _source_line(child) == "-1":
        return True  # whatever fits: NumPy takes any negative size for that
    if isinstance(parent, ast.Assign) and _source_line(parent.targets[0]).startswith("_SHORT."):
        return True  # how much of a value is shown
    return isinstance(child, ast.If) and _source_line(child.test) == "TYPE_CHECKING"


def _edits(node: ast.AST) -> Iterator[Edit]:
    if isinstance(node, ast.Compare):
        for k, op in enumerate(node.ops):
            if type(op) in _COMPARISONS:
                yield _with_op(k, _COMPARISONS[type(op)])
    elif isinstance(node, ast.BoolOp):
        yield lambda n: ast.BoolOp(ast.Or() if isinstance(n.op, ast.And) else ast.And(), n.values)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.Not, ast.USub)):
        yield lambda n: n.operand
    elif isinstance(node, ast.BinOp) and type(node.op) in _SUMS and not _is_text(node):
        yield lambda n: ast.BinOp(n.left, _SUMS[type(n.op)](), n.right)
    elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
        yield lambda n: ast.Constant(_other_number(n.value))
    elif isinstance(node, ast.Call) and _name(node.func) in _CALLS:
        yield _other_call
    elif isinstance(node, ast.Raise) or (
        isinstance(node, ast.Expr) and isinstance(node.value, (ast.Yield, ast.YieldFrom))
    ):
        yield lambda n: ast.If(ast.Constant(False), [n], [])
    elif isinstance(node, (ast.If, ast.IfExp)):
        yield lambda n: _with_test(n, False)


def _with_op(k: int, op: type[ast.cmpop]) -> Edit:
    return lambda n: ast.Compare(n.left, [op() if i == k else o for i, o in enumerate(n.ops)], n.comparators)


def _with_test(node: ast.If | ast.IfExp, value: bool) -> ast.AST:
    return type(node)(ast.Constant(value), node.body, node.orelse)  # type: ignore[arg-type]


def _other_number(value: float) -> float:
    return value + 1 if isinstance(value, int) else 2.0 * value if value else 1.0


def _other_call(node: ast.Call) -> ast.AST:
    name = _CALLS[_name(node.func)]
    if isinstance(node.func, ast.Attribute):
        return ast.Call(ast.Attribute(node.func.value, name, ast.Load()), node.args, node.keywords)
    return ast.Call(ast.Name(name, ast.Load()), node.args, node.keywords)


def _is_text(node: ast.BinOp) -> bool:
    return any(
        isinstance(side, ast.JoinedStr) or (isinstance(side, ast.Constant) and isinstance(side.value, str))
        for side in (node.left, node.right)
    )


def _name(function: ast.AST) -> str:
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _source_line(node: ast.AST) -> str:
    first = ast.unparse(node).split("\n")
    return first[0][:100] + (" ..." if len(first) > 1 else "")
