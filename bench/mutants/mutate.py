"""Small faults in a module: one operator, one constant or one check at a time."""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

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
    was, now: the piece of code before and after
    source: the whole module with the fault
    """

    line: int
    was: str
    now: str
    source: str

    def __str__(self) -> str:
        return f"{self.line}: {self.was} -> {self.now}"


def mutants(source: str) -> list[Mutant]:
    """Every fault that can be put into a module, in the order of its lines."""
    tree = ast.parse(source)
    found = []
    for path, edit in _sites(tree):
        changed = copy.deepcopy(tree)
        parent, field, index = _followed(changed, path)
        node = getattr(parent, field) if index is None else getattr(parent, field)[index]
        was, line = _told(node), node.lineno
        new = ast.copy_location(edit(node), node)
        if index is None:
            setattr(parent, field, new)
        else:
            getattr(parent, field)[index] = new
        found.append(Mutant(line, was, _told(new), ast.unparse(ast.fix_missing_locations(changed))))
    return sorted(found, key=lambda mutant: (mutant.line, mutant.was, mutant.now))


Step = tuple[str, int | None]


def _sites(node: ast.AST, path: tuple[Step, ...] = ()) -> Iterator[tuple[tuple[Step, ...], Edit]]:
    """Places where something can be changed, and how; nothing that is only said to people."""
    for field, value in ast.iter_fields(node):
        children = value if isinstance(value, list) else [value]
        for i, child in enumerate(children):
            if not isinstance(child, ast.AST) or _is_words(node, field, child):
                continue
            step = (*path, (field, i if isinstance(value, list) else None))
            yield from ((step, edit) for edit in _edits(child))
            yield from _sites(child, step)


def _followed(tree: ast.AST, path: tuple[Step, ...]) -> tuple[ast.AST, str, int | None]:
    node = tree
    for field, index in path[:-1]:
        value = getattr(node, field)
        node = value if index is None else value[index]
    return node, *path[-1]


def _is_words(parent: ast.AST, field: str, child: ast.AST) -> bool:
    """Whether a part of the tree is text, type or declaration: no test can or should see a change there."""
    if field in ("annotation", "returns", "decorator_list", "type_params") or isinstance(
        child, ast.JoinedStr
    ):
        return True
    if isinstance(parent, ast.Raise) or isinstance(child, (ast.Import, ast.ImportFrom)):
        return True
    if isinstance(parent, ast.Call) and _name(parent.func) in _SAID:
        return True
    if isinstance(parent, ast.Assign) and _told(parent.targets[0]).startswith("_SHORT."):
        return True  # how much of a value is told
    return isinstance(child, ast.If) and _told(child.test) == "TYPE_CHECKING"


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
        yield lambda n: ast.If(ast.Constant(False), [copy.deepcopy(n)], [])
    elif isinstance(node, (ast.If, ast.IfExp)):
        yield lambda n: _with_test(n, False)


def _with_op(k: int, op: type[ast.cmpop]) -> Edit:
    return lambda n: ast.Compare(n.left, [op() if i == k else o for i, o in enumerate(n.ops)], n.comparators)


def _with_test(node: ast.If | ast.IfExp, value: bool) -> ast.AST:
    changed: ast.If | ast.IfExp = copy.deepcopy(node)
    changed.test = ast.Constant(value)
    return changed


def _other_number(value: float) -> float:
    return value + 1 if isinstance(value, int) else 2.0 * value if value else 1.0


def _other_call(node: ast.Call) -> ast.AST:
    changed = copy.deepcopy(node)
    if isinstance(changed.func, ast.Attribute):
        changed.func.attr = _CALLS[changed.func.attr]
    elif isinstance(changed.func, ast.Name):
        changed.func.id = _CALLS[changed.func.id]
    return changed


def _is_text(node: ast.BinOp) -> bool:
    return any(
        isinstance(side, ast.JoinedStr) or (isinstance(side, ast.Constant) and isinstance(side.value, str))
        for side in (node.left, node.right)
    )


def _name(function: ast.AST) -> str:
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _told(node: ast.AST) -> str:
    first = ast.unparse(node).split("\n")
    return first[0][:100] + (" ..." if len(first) > 1 else "")
