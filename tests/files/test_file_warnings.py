"""Warnings about a file: where they stand, how they are silenced, and that many are one."""

from __future__ import annotations

from pathlib import Path

import pytest

from pickcli.files.file_kind import CELL
from pickcli.files.file_warnings import FileWarnings, refuse_unknown_kinds
from pickcli.files.source import Key
from pickcli.files.yaml_reader import read_yaml


def _warnings(folder: Path, accepted: str = "") -> FileWarnings:
    path = folder / "cell.yaml"
    path.write_text(f"format: apc cell\npumps:\n  a: 1\n  b: 2\n{accepted}")
    return FileWarnings.of(read_yaml(path, CELL))


def test_a_warning_has_its_place_and_how_to_silence_it(tmp_path: Path) -> None:
    warnings = _warnings(tmp_path)
    warnings.add("slow", "b", ("pumps", "b"), "2 s is long")
    (line,) = warnings.lines
    assert line == (
        f"{tmp_path}/cell.yaml:4:3: pumps.b: 2 s is long (if it is meant, add slow:b to accepted_warnings)"
    )


def test_a_value_of_another_file_has_its_place_there_and_is_accepted_in_this_one(tmp_path: Path) -> None:
    warnings = _warnings(tmp_path)
    warnings.source.origins["pumps", "c"] = (tmp_path / "pumps.yaml", 7, 5)
    warnings.add("slow", "c", ("pumps", "c"), "2 s is long")
    (line,) = warnings.lines
    assert line.startswith(f"{tmp_path}/pumps.yaml:7:5: pumps.c: 2 s is long")
    assert line.endswith("add slow:c to accepted_warnings of cell.yaml)")


@pytest.mark.parametrize(("accepted", "left"), [("slow", []), ("slow:b", ["a"]), ("fast", ["a", "b"])])
def test_what_the_file_accepts_is_silent(tmp_path: Path, accepted: str, left: list[str]) -> None:
    warnings = _warnings(tmp_path, f"accepted_warnings: ['{accepted}']\n")
    for name in ("a", "b"):
        warnings.add("slow", name, ("pumps", name), f"{name} is long")
    assert [line.split("pumps.")[1][0] for line in warnings.lines] == left


def test_more_than_a_few_of_one_kind_are_one_line(tmp_path: Path) -> None:
    found: dict[str, tuple[Key, str]] = {f"n{i}": (("pumps", "a"), f"n{i} is long") for i in range(3)}
    few = _warnings(tmp_path)
    few.add_alike("slow", found, ("pumps",), "are they in s?")
    assert len(few.lines) == 3
    many = _warnings(tmp_path)
    many.add_alike("slow", {**found, "n3": (("pumps", "b"), "n3 is long")}, ("pumps",), "are they in s?")
    (line,) = many.lines
    assert ":2:1: pumps: n0 is long, and 3 more are like it; are they in s?" in line
    assert line.endswith("(if it is meant, add slow to accepted_warnings)")


def test_an_unknown_kind_silences_nothing_and_is_refused() -> None:
    refuse_unknown_kinds(["slow", "slow:b"], ["slow", "fast"])
    with pytest.raises(ValueError, match=r"no warning is called 'slwo'; did you mean 'slow'\?"):
        refuse_unknown_kinds(["slwo:b"], ["slow", "fast"])
