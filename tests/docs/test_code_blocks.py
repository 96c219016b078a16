"""What the documentation shows is what happens: every fenced block of every page runs, or says why not.

The `sh` and `python` blocks of a page run in their order in one new folder, with a cache of their own. A
comment on the line before a block says what is special about it: `<!-- not run: REASON -->`, or
`<!-- exit code N -->` where a command is meant to fail. A command that several pages give the same files to
runs once: it would write the same again.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from itertools import pairwise
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


PLAIN = re.compile(r"apc [\w .,=/+#-]+")  # a call of apc, without redirection or what follows on it


def steps(block: Block) -> list[str]:
    """What of a block runs by itself: each line if every one is a plain call of `apc`, else all of it."""
    lines = [line for line in block.text.splitlines() if line and not line.startswith("#")]
    is_plain = block.language == "sh" and all(PLAIN.fullmatch(line) for line in lines)
    return lines if is_plain else [block.text]


def run(block: Block, step: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a step of a block in a folder."""
    shell = ["bash", "-euo", "pipefail", "-c"] if block.language == "sh" else [sys.executable, "-c"]
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "XDG_CACHE_HOME": str(folder / "cache"), "COLUMNS": "110"}
    return subprocess.run(
        [*shell, step], cwd=folder, env=environment, capture_output=True, text=True, timeout=TIMEOUT
    )


OVERWRITE = "--overwrite"  # changes nothing of what is written
WRITES = ("-o", "--picture", "--video")  # options of what a command writes, and of nothing else


@dataclass(frozen=True)
class Written:
    """What commands wrote on the pages before, by the command and the content of the files that it read."""

    folder: Path

    def of(self, step: str, page_folder: Path) -> Path | None:
        """Where copies are kept of what a command writes.

        None where it may do more, reads a folder, or is to be refused as it would overwrite a file.
        """
        words = [word for word in step.split() if word != OVERWRITE]
        paths = [page_folder / word for word in words]
        is_known = PLAIN.fullmatch(step) and set(words) & set(WRITES) and "--write" not in words
        if not is_known or any(path.is_dir() for path in paths):
            return None
        writes = {page_folder / name for name in outputs(step)}
        if any(path.exists() for path in writes) and OVERWRITE not in step.split():
            return None
        read = [path.read_bytes() for path in paths if path.is_file() and path not in writes]
        return self.folder / hashlib.sha256("\0".join(words).encode() + b"\0".join(read)).hexdigest()


def outputs(step: str) -> list[str]:
    """Names of the files that a command writes."""
    words = step.split()
    return [name for option, name in pairwise(words) if option in WRITES]


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


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Written:
    """Nothing yet."""
    return Written(tmp_path_factory.mktemp("written"))


@pytest.mark.slow
@pytest.mark.parametrize("page", RUN, ids=name_of)
def test_the_blocks_of_a_page_run(page: Path, written: Written, tmp_path: Path) -> None:
    for block in blocks(page):
        for step in steps(block) if block.is_run else ():
            kept = written.of(step, tmp_path)
            if kept is not None and kept.is_dir():
                for name in outputs(step):
                    shutil.copy(kept / name, tmp_path)
                continue
            done = run(block, step, tmp_path)
            code = block.code if step == steps(block)[-1] else 0
            assert done.returncode == code, f"{name_of(page)}:{block.line}\n{done.stdout}{done.stderr}"
            if kept is not None and not code:
                kept.mkdir()
                for name in outputs(step):
                    shutil.copy(tmp_path / name, kept)


def test_a_command_on_the_same_files_is_known_again_and_no_other(written: Written, tmp_path: Path) -> None:
    plan = "apc plan-pick --scene scene.json --bin bin_A -o plan.json"
    first = written.of(plan, tmp_path)
    (tmp_path / "scene.json").write_text("one")
    second = written.of(plan, tmp_path)
    (tmp_path / "scene.json").write_text("other")
    third = written.of(plan, tmp_path)
    assert len({first, second, third, written.of(f"{plan} --seed 1", tmp_path)}) == 4
    assert written.of(f"{plan} --overwrite", tmp_path) == third
    (tmp_path / "plan.json").touch()
    assert written.of(plan, tmp_path) is None and written.of(f"{plan} --overwrite", tmp_path) is not None
    assert written.of("apc verify plan.json --write", tmp_path) is None
    assert written.of("apc check roadmap.h5 --repair", tmp_path) is None
    assert written.of("apc plan-pick --scene scene.json -o plan.json || true", tmp_path) is None
    (tmp_path / "shelf").mkdir()
    assert written.of("apc build-roadmap --cell shelf -o roadmap.h5", tmp_path) is None
    assert outputs("apc make-scene order --picture a.png -o b.json") == ["a.png", "b.json"]
