"""Finds the folders of ROS packages named in a URDF."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from pickcli.errors import InputError

_NAME = re.compile(r"<name>\s*([^<\s]+)\s*</name>")
MANIFEST = "package.xml"
MANIFEST_BYTES = 100_000  # limit of reading a manifest


class PackageSearch:
    """Finds packages by name: in stated folders, above the URDF, and in ROS's own paths.

    Args:
        urdf: The file that names packages.
        stated: Folders, each a package or a folder of packages.
        named: Folders of packages by name.

    Raises:
        InputError: One of these is no folder.
    """

    def __init__(
        self, urdf: Path, stated: Sequence[Path] = (), named: Mapping[str, Path] | None = None
    ) -> None:
        self._stated, self._named = tuple(stated), dict(named or {})
        for folder in (*self._stated, *self._named.values()):
            if not folder.is_dir():
                raise InputError(f"--package-path: {folder} is no folder; correct it")
        self._roots = (*stated, *urdf.resolve().parents, *_ros_folders())

    def find(self, name: str) -> Path | None:
        """Find a package.

        Args:
            name: Name of the package.

        Returns:
            Its folder; None if it is not found.
        """
        if name in self._named:
            return self._named[name]
        for root in self._roots:
            for folder in (root / name, root):
                if name in _names_of(folder):
                    return folder
        return None

    def why_none(self, name: str) -> str:
        """Explain that a package was not found, with advice.

        Args:
            name: Name of the package.

        Returns:
            The text.
        """
        where = ", ".join(map(str, self._stated)) or "the folders above the URDF"
        return (
            f"package {name!r} was not found in {where}; name the folder that it lies in with --package-path"
        )


def _ros_folders() -> Iterator[Path]:
    for text in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        if text:
            yield Path(text)
    for text in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if text:
            yield Path(text) / "share"


def _names_of(folder: Path) -> tuple[str, ...]:
    """Possible names of a package: its folder's, and that in its manifest. Empty if it is not a folder."""
    with suppress(OSError):
        manifest = folder / MANIFEST
        if manifest.is_file():
            with manifest.open(encoding="utf-8", errors="replace") as file:
                stated = _NAME.search(file.read(MANIFEST_BYTES))
            return (folder.name, *([stated[1]] if stated else []))
        return (folder.name,) if folder.is_dir() else ()
    return ()
