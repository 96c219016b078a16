"""Files and benches that the pages name are there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])

# What a reader is to make, and what lies in another project.
ELSEWHERE = {
    "pickcli/commands/verb_noun.py", "data/example.json", "data/cells/mine/cell.yaml",
    "node_scripts/score_calculator.py",
}  # fmt: skip

FILE = re.compile(r"\b((?:pickcli|tests|bench|docs|data)/[\w./-]+|[a-z_]+/[a-z_]+\.py)\b")
BENCH = re.compile(r"python -m (bench(?:\.\w+)?)\b")


def named(page: Path) -> set[str]:
    """Paths of files and folders that a page speaks of."""
    return {name.rstrip(".") for name in FILE.findall(page.read_text())} - ELSEWHERE


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_what_a_page_names_is_there(page: Path) -> None:
    bases = (ROOT, ROOT / "pickcli", page.parent)
    assert not [name for name in named(page) if not any((base / name).exists() for base in bases)]
    benches = [ROOT / name.replace(".", "/") for name in BENCH.findall(page.read_text())]
    assert not [path for path in benches if not (path.is_dir() or path.with_suffix(".py").exists())]


def test_pages_name_files() -> None:
    assert sum(len(named(page)) for page in PAGES) > 50
