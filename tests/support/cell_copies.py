"""A copy of the default cell's folder, to break."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell


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
    """The folder of the copy, and its two files."""

    folder: Path

    @property
    def yaml(self) -> Editable:
        return Editable(self.folder / "cell.yaml")

    @property
    def urdf(self) -> Editable:
        return Editable(self.folder / "robot.urdf")

    def load(self) -> Cell:
        return load_cell(self.folder)
