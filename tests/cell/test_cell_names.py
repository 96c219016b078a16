"""Which cell a text or path stands for, where a folder has the name of a shipped cell."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from pickcli.cell.cell_file import cell_file
from pickcli.cell.data_path import data_path

NAME = "panda_table"


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A changed copy of a shipped cell, in the working folder."""
    shutil.copytree(data_path() / "cells" / NAME, tmp_path / NAME)
    monkeypatch.chdir(tmp_path)
    return tmp_path / NAME / "cell.yaml"


@pytest.mark.parametrize(
    "given", [f"./{NAME}", f"{NAME}/", f"{NAME}/cell.yaml", Path(NAME), Path(NAME) / "cell.yaml"]
)
def test_a_path_is_a_path_whatever_its_name(given: str | Path, own: Path) -> None:
    assert cell_file(given).resolve() == own.resolve()


def test_a_name_is_that_of_a_shipped_cell(own: Path) -> None:
    assert cell_file(NAME) == data_path() / "cells" / NAME / "cell.yaml"
    shutil.rmtree(own.parent)
    assert cell_file(Path(NAME)) == cell_file(NAME)
