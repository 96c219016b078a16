"""Names of modules and public classes are built from the words of docs/glossary.md, one name to a thing."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "pickcli"
TERMS, PLAIN = (ROOT / "docs" / "glossary.md").read_text().split("## Plain words")

# Public names that occur in two packages, and why.
MIRRORED = {
    "execute": "the command and the function that it calls",
    "export": "the command and the package of the formats",
    "make_order": "the command and the function that it calls",
    "make_stream": "the command and the function that it calls",
    "make_scene": "the command and the function that it calls",
    "pod_shift": "the command's options and what they ask for",
    "roll_out": "the command and the function that it calls",
    "verify": "the command and the function that it calls",
}


def inflected(word: str) -> set[str]:
    """The forms of an English word that a name may use."""
    stem = word[:-1] if word[-1] in "ey" else word
    doubled = word + word[-1]
    endings = {word + ending for ending in ("s", "es", "d", "ed", "r", "er", "or", "ing", "al")}
    return {word, *endings} | {
        form
        for start in (stem, doubled)
        for form in (start + "ing", start + "ed", start + "er", start + "or", start + "ies")
    }


def glossary() -> set[str]:
    """Every word, in all its forms, that a name may be built from."""
    terms = " ".join(row.split("|")[1] for row in TERMS.splitlines() if row.startswith("| "))
    words = re.findall(r"[a-z]+", f"{terms} {PLAIN.split(chr(10), 3)[3]}".lower())
    return set().union(*map(inflected, words))


def words_of(name: str) -> list[str]:
    """The words of a snake_case or CamelCase name, lower case."""
    return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z0-9]+", name)]


def public_names() -> Iterator[tuple[str, str]]:
    """(package, name) of every module and of every public class."""
    for path in sorted(PACKAGE.rglob("*.py")):
        package = path.parent.name
        if path.name == "__init__.py":
            yield package, package
        elif not path.stem.startswith("_"):
            yield package, path.stem
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                yield package, node.name


NAMES = [pair for pair in public_names() if pair != ("pickcli", "pickcli")]
WORDS = glossary()


def missing(name: str) -> list[str]:
    """The words of a name that the glossary lacks."""
    return [word for word in words_of(name) if word not in WORDS]


def test_there_is_something_to_test() -> None:
    assert len(NAMES) > 400
    assert missing("ParabolicSegment") == []
    assert missing("FrobnicatedSegment") == ["frobnicated"]


@pytest.mark.parametrize("package", sorted({package for package, _ in NAMES}))
def test_names_of_a_package_are_built_from_the_glossary(package: str) -> None:
    lacking = {name: missing(name) for of, name in NAMES if of == package}
    assert {name: words for name, words in lacking.items() if words} == {}


def test_no_name_stands_in_two_packages() -> None:
    packages = defaultdict(set)
    for package, name in NAMES:
        packages[name].add(package)
    twice = {name for name, where in packages.items() if len(where) > 1}
    assert twice == set(MIRRORED)


def test_every_term_has_a_meaning() -> None:
    rows = [row.split("|")[1:-1] for row in TERMS.splitlines() if re.match(r"\| (?!term )\S", row)]
    assert len(rows) > 150
    assert [row for row in rows if len(row) != 3 or not row[1].strip()] == []
    terms = [row[0].strip() for row in rows]
    assert sorted({term for term in terms if terms.count(term) > 1}) == []
