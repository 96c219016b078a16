"""What the README shows is what happens."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from support.command_line import apc

README = Path(__file__).parents[2] / "README.md"


def shown(*words: str) -> list[str]:
    """The arguments of the one command in the README that has all of these words."""
    lines = [line.split("#")[0].strip() for line in README.read_text().splitlines()]
    (line,) = (line for line in lines if line.startswith("apc ") and {*words} <= {*line.split()})
    return shlex.split(line)[1:]


@pytest.mark.slow
def test_what_is_in_the_way_goes_into_the_bin_that_the_readme_names(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for words in (("make-scene",), ("plan-pick", "--into")):
        answer = apc(*shown(*words))
        assert answer.code == 0, answer.err
    assert (tmp_path / "aside.json").is_file()
