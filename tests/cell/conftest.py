"""The default cell, loaded once, and a copy of its folder to break."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from pickcli.cell.data_path import data_path
from pickcli.cell.load import load_cell
from pickcli.cell.model import Cell
from pickcli.errors import InputError


@pytest.fixture(scope="session")
def cell() -> Cell:
    return load_cell("apc2016_delft")


@dataclass
class Editable:
    """A file to edit; ``replace`` returns the line (from 1) of what it changed."""

    path: Path

    def replace(self, old: str, new: str) -> int:
        text = self.path.read_text()
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times"
        self.path.write_text(text.replace(old, new))
        return text[: text.index(old)].count("\n") + 1


@dataclass
class CellCopy:
    folder: Path

    @property
    def yaml(self) -> Editable:
        return Editable(self.folder / "cell.yaml")

    @property
    def urdf(self) -> Editable:
        return Editable(self.folder / "robot.urdf")

    def load(self) -> Cell:
        return load_cell(self.folder)


@pytest.fixture
def cell_copy(tmp_path: Path) -> CellCopy:
    shutil.copytree(data_path() / "cells" / "apc2016_delft", tmp_path / "cell")
    return CellCopy(tmp_path / "cell")


@pytest.fixture
def refused() -> Callable[[Callable[[], object]], str]:
    """The message of the InputError that a call must raise."""

    def message(call: Callable[[], object]) -> str:
        with pytest.raises(InputError) as caught:
            call()
        return str(caught.value)

    return message
