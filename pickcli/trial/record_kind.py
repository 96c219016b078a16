"""Kinds of records of trials: what they say they were made from, and how they are recognised and read."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pickcli.cell.cell import Cell
from pickcli.errors import InputError, StaleError
from pickcli.files.bounded_reading import read_text
from pickcli.files.file_kind import TRIAL
from pickcli.files.json_reader import parse_json
from pickcli.package_versions import package_versions

MAX_BYTES = 24 * 2**20
PACKAGES = ("numpy", "ompl", "pybullet", "python-fcl", "ruckig", "scipy")


@dataclass(frozen=True)
class RecordKind:
    """Records of trials of one kind.

    Attributes:
        played: What was played, as ``a pallet``, for messages.
        format: The format that they state.
        version: And its version.
        keys: Fields that they must have.
        check: Refuses, with an ``InputError``, content that readers cannot take: of the record and its file.
    """

    played: str
    format: str
    version: int
    keys: frozenset[str] = frozenset()
    check: Callable[[Mapping[str, Any], str], None] | None = None

    def made_from(self, cell: Cell, seed: int, **played: Any) -> dict[str, Any]:
        """Say what a record was made from.

        Args:
            cell: The cell of the trial.
            seed: Its seed.
            **played: JSON values that tell what was played.

        Returns:
            JSON values by name.
        """
        return {
            "format": self.format,
            "version": self.version,
            **played,
            "seed": seed,
            "cell": cell.name,
            "cell_fingerprint": cell.scene_fingerprint,
            "versions": package_versions(PACKAGES),
        }

    def is_of(self, path: Path) -> bool:
        """Tell whether a record is one of this kind, by the format that it states.

        Args:
            path: The file.

        Returns:
            True if it is.

        Raises:
            InputError: The file cannot be read.
        """
        return bool(_parsed(_text(path), str(path))[1].get("format") == self.format)

    def read(self, path: Path) -> dict[str, Any]:
        """Read a record.

        Args:
            path: The file.

        Returns:
            JSON values by name.

        Raises:
            InputError: The file cannot be read, or is no such record.
            StaleError: It has another version of the format.
        """
        return self.parsed(_text(path), str(path))

    def parsed(self, text: str, where: str) -> dict[str, Any]:
        """Read a record from its text.

        Args:
            text: The text.
            where: Name of the file, for messages.

        Returns:
            JSON values by name.

        Raises:
            InputError: It is no such record.
            StaleError: It has another version of the format.
        """
        record, made = _parsed(text, where)
        if made.get("format") != self.format:
            raise InputError(
                f"{where}: made_from.format is not {self.format!r}: no record of {self.played}; play one"
            )
        if made.get("version") != self.version:
            raise StaleError(
                f"{where}: is of version {made.get('version')}, not {self.version}; play the trial again"
            )
        if lacking := self.keys - record.keys():
            raise InputError(f"{where}: {', '.join(sorted(lacking))} missing; play the trial again")
        if self.check is not None:
            self.check(record, where)
        return record


def refuse_other_file(played: str, path: Path, record: Mapping[str, Any]) -> None:
    """Refuse a file that is not the one which was played.

    Args:
        played: What it is, as ``stream``.
        path: The file.
        record: Record of the trial, which states its SHA-256.

    Raises:
        StaleError: It is another one.
    """
    if hashlib.sha256(path.read_bytes()).hexdigest() != record["made_from"].get(f"{played}_sha256"):
        raise StaleError(f"{path}: is not the {played} that the record was made from; play the trial again")


def _text(path: Path) -> str:
    return read_text(path, MAX_BYTES, "apc run-trial writes one", TRIAL)


def _parsed(text: str, where: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """A record, and what it says that it was made from; {} of what is none."""
    record = parse_json(text, where)
    made = record.get("made_from") if isinstance(record, dict) else None
    return (record, made) if isinstance(made, dict) else ({}, {})
