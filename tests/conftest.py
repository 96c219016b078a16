"""What all tests share."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.errors import InputError
from pickcli.scene.scene_file import write_scene
from support.cell_copies import CellCopy
from support.gripper_cell import with_gripper
from support.scene_files import make_scene

# How long an example takes says how busy the machine is, and nothing about the code.
# CI judges a change, not the luck of a draw: its examples are the same each time, elsewhere they are new.
settings.register_profile("suite", deadline=None, derandomize="CI" in os.environ)
settings.load_profile("suite")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the files with slow tests first: a long file that begins last would keep one worker alone."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture(scope="session")
def cell() -> Cell:
    """The default cell, which nothing changes."""
    return load_cell("apc2016_delft")


@pytest.fixture
def cell_copy(tmp_path: Path) -> CellCopy:
    """A copy of the default cell's folder, to break."""
    shutil.copytree(data_path() / "cells" / "apc2016_delft", tmp_path / "cell")
    return CellCopy(tmp_path / "cell")


@pytest.fixture(scope="session")
def gripper_cell(tmp_path_factory: pytest.TempPathFactory) -> Cell:
    """The default cell with a gripper in place of lance and cup, which nothing changes."""
    folder = tmp_path_factory.mktemp("gripper") / "cell"
    shutil.copytree(data_path() / "cells" / "apc2016_delft", folder)
    return with_gripper(CellCopy(folder)).load()


@pytest.fixture
def refused() -> Callable[[Callable[[], object]], str]:
    """The message of the InputError that a call must raise."""

    def message(call: Callable[[], object]) -> str:
        with pytest.raises(InputError) as caught:
            call()
        return str(caught.value)

    return message


@pytest.fixture
def written(tmp_path: Path, cell: Cell) -> Path:
    """A scene file that is sound."""
    path = tmp_path / "scene.json"
    write_scene(make_scene(cell), path)
    return path
