"""The names that scripts import: all there, all on the page, all typed, and none loaded before it is used."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

import pickcli

ROOT = Path(__file__).parents[2]


def test_the_page_lists_the_stable_names() -> None:
    page = (ROOT / "docs" / "reference" / "python.md").read_text()
    table = page.partition("## Stable names")[2]
    rows = [row.split("|")[1] for row in table.splitlines() if row.startswith("| `")]
    assert sorted(name for row in rows for name in re.findall(r"`(\w+)`", row)) == pickcli.__all__


def test_type_checkers_know_them_by_the_same_homes() -> None:
    stub = ast.parse((ROOT / "pickcli" / "__init__.pyi").read_text())
    told = {
        alias.name: node.module
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if alias.asname == alias.name
    }
    assert {name: getattr(pickcli, name) for name in pickcli.__all__}
    assert told == pickcli._HOME  # type: ignore[attr-defined]


def test_importing_the_package_loads_nothing_else() -> None:
    program = "import sys, pickcli; print([m for m in sys.modules if m.startswith(('pickcli.', 'numpy'))])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="'pickcli' has no attribute 'Plannner'"):
        pickcli.Plannner  # type: ignore[attr-defined]  # noqa: B018
    assert "Planner" in dir(pickcli)
