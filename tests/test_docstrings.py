"""Docstrings name every parameter in the order of the signature, and their first lines stand alone."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "pickcli"

# Its functions are native: their stubs are generated from the docstrings of the bindings.
NATIVE = {"kernel"}

# The modules beside the packages, and the packages.
MODULES = sorted(path.stem for path in PACKAGE.glob("[a-z]*.py"))
PACKAGES = sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py"))
DOCUMENTED = [*MODULES, *(name for name in PACKAGES if name not in NATIVE)]

# First words of a sentence that leans on another one, which neither help() nor an editor shows beside it.
LEANING = re.compile(
    r"(The same|Those|These|They|It|Its|Likewise|Also|The way back|The other way|What happened\.|See [A-Z])\b"
)


def public(body: list[ast.stmt], of: str = "") -> Iterator[tuple[str, ast.FunctionDef]]:
    """(qualified name, definition) of the public functions and methods in a module or class."""
    for node in body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            yield from public(node.body, f"{of}{node.name}.")
            yield from constructor(node, f"{of}{node.name}")
        elif isinstance(node, ast.FunctionDef) and not node.name.startswith("_") and not is_command(node):
            yield f"{of}{node.name}", node


def is_command(function: ast.FunctionDef) -> bool:
    """Whether click calls it: its docstring is the help that users read, and options tell their own part."""
    return any(
        isinstance(decorator, ast.Call) and ast.unparse(decorator.func) in ("click.command", "click.group")
        for decorator in function.decorator_list
    )


def constructor(node: ast.ClassDef, name: str) -> Iterator[tuple[str, ast.FunctionDef]]:
    """The class's own `__init__`, if it has one, with the docstring of the class, which tells them."""
    for function in node.body:
        if isinstance(function, ast.FunctionDef) and function.name == "__init__":
            yield name, ast.FunctionDef(name, function.args, node.body[:1], [])


def parameters(function: ast.FunctionDef) -> list[str]:
    """Names of the parameters, in their order, without the instance or class."""
    arguments = function.args
    named = [*arguments.posonlyargs, *arguments.args]
    star = [arguments.vararg] if arguments.vararg else []
    stars = [arguments.kwarg] if arguments.kwarg else []
    names = [argument.arg for argument in (*named, *star, *arguments.kwonlyargs, *stars)]
    return names[1:] if names and names[0] in ("self", "cls") else names


def documented(function: ast.FunctionDef) -> list[str]:
    """Names under `Args` of a docstring, in their order."""
    section = re.search(r"^Args:\n((?:    .*\n?|\n)+)", ast.get_docstring(function) or "", re.MULTILINE)
    return re.findall(r"^    \*{0,2}(\w+): \S", section[1], re.MULTILINE) if section else []


@pytest.mark.parametrize("name", DOCUMENTED)
def test_every_parameter_is_documented(name: str) -> None:
    functions = [
        (f"{path.name}: {qualified}", function)
        for path in sorted((PACKAGE / name).rglob("*.py")) or [PACKAGE / f"{name}.py"]
        for qualified, function in public(ast.parse(path.read_text()).body)
    ]
    assert functions
    wrong = [where for where, function in functions if documented(function) != parameters(function)]
    assert wrong == []


@pytest.mark.parametrize("name", ["", *PACKAGES])
def test_first_lines_do_not_lean_on_a_neighbour(name: str) -> None:
    paths = sorted((PACKAGE / name).rglob("*.py")) if name else sorted(PACKAGE.glob("*.py"))
    kinds = (ast.FunctionDef, ast.ClassDef, ast.Module)
    summaries = [
        (f"{path.name}: {getattr(node, 'name', '')}", docstring.partition("\n")[0])
        for path in paths
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, kinds) and (docstring := ast.get_docstring(node))
    ]
    assert summaries
    assert [(where, summary) for where, summary in summaries if LEANING.match(summary)] == []


LEAST_WORDS = 3


@pytest.mark.parametrize("name", DOCUMENTED)
def test_first_lines_say_more_than_a_word_or_two(name: str) -> None:
    """A reader who sees one line learns nothing from "None."."""
    paths = sorted((PACKAGE / name).rglob("*.py")) or [PACKAGE / f"{name}.py"]
    definitions = [node for path in paths for _, node in public(ast.parse(path.read_text()).body)]
    assert definitions
    first_lines = [(node.name, (ast.get_docstring(node) or "").partition("\n")[0]) for node in definitions]
    assert [(of, line) for of, line in first_lines if len(line.split()) < LEAST_WORDS] == []


UNIT_FIRST = re.compile(
    r"(M|S|Rad|Kg|Pa|M/s|Nm) (and|at|below|between|by|for|from|of the|of all|over|that|until|which)\b"
)  # M is mega, S is siemens
PLAIN_POWER = re.compile(r"\b(?<!\()(m|rad|deg)/s[23]\b")  # "(m/s2)2" is a power itself


def test_units_keep_their_letters_and_powers() -> None:
    """A summary says "Length (m) by which", and accelerations are in m/s^2."""
    kinds = (ast.FunctionDef, ast.ClassDef, ast.Module)
    docstrings = [
        (f"{path.name}: {getattr(node, 'name', '')}", docstring)
        for path in sorted(PACKAGE.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, kinds) and (docstring := ast.get_docstring(node))
    ]
    assert len(docstrings) > 1000
    wrong = [where for where, text in docstrings if UNIT_FIRST.match(text) or PLAIN_POWER.search(text)]
    assert wrong == []
