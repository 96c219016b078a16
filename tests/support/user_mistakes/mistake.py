"""One mistake that a user makes: what is changed in files that are right, what is called, what is said."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from pickcli.cell.data_path import data_path

Replacement: TypeAlias = tuple[str, str]  # a text that stands once, and what stands there instead
Change: TypeAlias = Callable[[Any], object]  # of the values of a JSON file


@dataclass(frozen=True)
class Mistake:
    """A mistake, and what its user reads.

    Attributes:
        name: Of the mistake, in a few words.
        call: Arguments of ``apc``; CELL, SCENE, ITEMS, ORDER, PLAN, MOVE and OUT stand for files.
        told: What a line of stderr says: where, what is wrong, what to do; its parts in turn, … between.
        code: Exit code.
        cell: Changes of cell.yaml.
        urdf: Changes of robot.urdf.
        items: Changes of a file of items.
        scene: Change of the scene.
        order: Change of the order.
    """

    name: str
    call: str
    told: str
    code: int = 3
    cell: tuple[Replacement, ...] = ()
    urdf: tuple[Replacement, ...] = ()
    items: tuple[Replacement, ...] = ()
    scene: Change | None = None
    order: Change | None = None

    @property
    def changes_a_file(self) -> bool:
        """Whether the mistake is in a file, and not in the call."""
        return bool(self.cell or self.urdf or self.items or self.scene or self.order)


@dataclass(frozen=True)
class Files:
    """Files that are right, and their copies.

    Attributes:
        right: The folder with scene, order, plan and move.
        folder: That of the copies.
    """

    right: Path
    folder: Path

    def arguments(self, mistake: Mistake) -> list[str]:
        """The arguments of the call, on copies with the mistake in them."""
        return [self._argument(word, mistake) for word in mistake.call.split()]

    def _argument(self, word: str, mistake: Mistake) -> str:
        if word == "CELL" or word.startswith("CELL/"):
            return str(self._cell(mistake) / word[len("CELL/") :])
        if word == "ITEMS":
            return str(self._items(mistake))
        if word == "OUT":
            return str(self.folder / "out.json")
        if word in ("SCENE", "ORDER", "PLAN", "MOVE"):
            return str(self._json(word.lower(), getattr(mistake, word.lower(), None)))
        return word

    def _cell(self, mistake: Mistake) -> Path:
        folder = self.folder / "cell"
        shutil.copytree(data_path() / "cells" / "apc2016_delft", folder, dirs_exist_ok=True)
        replaced(folder / "cell.yaml", mistake.cell)
        replaced(folder / "robot.urdf", mistake.urdf)
        return folder

    def _items(self, mistake: Mistake) -> Path:
        path = self.folder / "items.yaml"
        shutil.copy(data_path() / "items" / "apc2016.yaml", path)
        replaced(path, mistake.items)
        return path

    def _json(self, name: str, change: Change | None) -> Path:
        data = json.loads((self.right / f"{name}.json").read_text())
        if change is not None:
            change(data)
        path = self.folder / f"{name}.json"
        path.write_text(json.dumps(data, indent=1))
        return path


def replaced(path: Path, changes: tuple[Replacement, ...]) -> None:
    """Make changes in a text."""
    text = path.read_text()
    for old, new in changes:
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in {path.name}"
        text = text.replace(old, new)
    path.write_text(text)
