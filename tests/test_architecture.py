"""The page about the architecture names the layers that are enforced, and every package."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "architecture.md").read_text()


def layers() -> list[set[str]]:
    """Packages and modules on each layer of the import rules, the highest first."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    lines = next(c["layers"] for c in contracts if c["type"] == "layers")
    return [{name.strip().removeprefix("pickcli.") for name in line.split("|")} for line in lines]


def test_the_table_of_layers_is_the_one_that_is_enforced() -> None:
    table = [row for row in PAGE.splitlines() if row.startswith("| ") and "`" in row]
    told = [set(re.findall(r"`(\w+)`", row)) for row in table]
    assert told == layers()


def test_every_package_is_on_a_layer_and_says_what_it_is() -> None:
    packages = {path.parent.name for path in (ROOT / "pickcli").glob("*/__init__.py")}
    assert len(packages) > 20
    assert packages <= set().union(*layers())
    for name in packages:
        assert len((ROOT / "pickcli" / name / "__init__.py").read_text().split('"""')[1].strip()) > 40, name
