"""What the documentation shows is what happens: every fenced block of every page runs, or says why not.

The `sh` and `python` blocks of a page run in their order in one new folder, with a cache of their own. A
comment on the line before a block says what is special about it: `<!-- not run: REASON -->`, or
`<!-- exit code N -->` where a command is meant to fail.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted(path for path in (ROOT / "docs").rglob("*.md") if "api" not in path.relative_to(ROOT).parts),
]
LANGUAGES = {"sh", "python", "text", "json", "yaml", "{toctree}", "{eval-rst}"}
COMMENT = re.compile(r"<!-- (?:not run: (?P<reason>.{10,})|exit code (?P<code>\d+)) -->")
TIMEOUT = 1200.0  # s, for one page


@dataclass(frozen=True)
class Block:
    """A fenced block of a page.

    Attributes:
        line: Of its first fence.
        language: What stands behind the fence.
        text: What is between the fences.
        code: The exit code that it ends with.
        reason: Why it is not run, "" if it is.
    """

    line: int
    language: str
    text: str
    code: int
    reason: str

    @property
    def is_run(self) -> bool:
        """Whether the block is a program that is run."""
        return self.language in ("sh", "python") and not self.reason


def blocks(page: Path) -> list[Block]:
    """The fenced blocks of a page."""
    found: list[Block] = []
    opened: int | None = None
    inside: list[str] = []
    lines = page.read_text().splitlines()
    for number, line in enumerate(lines, 1):
        if opened is None and line.startswith("```"):
            opened, inside = number, []
        elif opened is not None and line == "```":
            told = COMMENT.fullmatch(lines[opened - 2]) if opened > 1 else None
            code = int(told["code"] or 0) if told else 0
            reason = (told["reason"] or "") if told else ""
            language = lines[opened - 1].removeprefix("```").split(" ")[0]
            found.append(Block(opened, language, "\n".join(inside), code, reason))
            opened = None
        elif opened is not None:
            inside.append(line)
    assert opened is None, f"{page}:{opened}: a block without end"
    return found


def run(block: Block, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a block in a folder."""
    shell = ["bash", "-euo", "pipefail", "-c"] if block.language == "sh" else [sys.executable, "-c"]
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "XDG_CACHE_HOME": str(folder / "cache"), "COLUMNS": "110"}
    return subprocess.run(
        [*shell, block.text], cwd=folder, env=environment, capture_output=True, text=True, timeout=TIMEOUT
    )


def name_of(page: Path) -> str:
    """A page's path in the repository."""
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_block_says_what_it_is(page: Path) -> None:
    found = blocks(page)
    assert [(block.line, block.language) for block in found if block.language not in LANGUAGES] == []
    fenced = "\n".join(re.split(r"^```.*?^```$", page.read_text(), flags=re.MULTILINE | re.DOTALL))
    indented = [
        line for line in re.findall(r"^\n {4,}(\S.*)", fenced, re.MULTILINE) if not line.startswith("sum ")
    ]
    assert [line for line in indented if re.match(r"(apc|make|python|dask|\.venv|\{)\b", line)] == []


def test_every_comment_belongs_to_a_block() -> None:
    told = [(page, block) for page in PAGES for block in blocks(page) if block.reason or block.code]
    comments = [line for page in PAGES for line in page.read_text().splitlines() if line.startswith("<!--")]
    assert [line for line in comments if not COMMENT.fullmatch(line)] == []
    assert len(comments) == len(told)


RUN = [page for page in PAGES if any(block.is_run for block in blocks(page))]


def test_most_pages_that_show_commands_run_some() -> None:
    assert {"README.md", "docs/tutorial.md", "docs/commands.md"} <= {name_of(page) for page in RUN}


@pytest.mark.slow
@pytest.mark.parametrize("page", RUN, ids=name_of)
def test_the_blocks_of_a_page_run(page: Path, tmp_path: Path) -> None:
    for block in blocks(page):
        if block.is_run:
            done = run(block, tmp_path)
            assert done.returncode == block.code, f"{name_of(page)}:{block.line}\n{done.stdout}{done.stderr}"
