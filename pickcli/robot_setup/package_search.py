"""Where the ROS packages lie that a URDF names."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

_NAME = re.compile(r"<name>\s*([^<\s]+)\s*</name>")
MANIFEST = "package.xml"
MANIFEST_BYTES = 100_000  # of a manifest that are read


class PackageSearch:
    """Finds packages by name: in folders that were stated, above the URDF, and where ROS has them.

    Args:
        urdf: The file that names packages.
        stated: Folders, each a package or one that holds packages.
        named: Folders of packages by name.
    """

    def __init__(
        self, urdf: Path, stated: Sequence[Path] = (), named: Mapping[str, Path] | None = None
    ) -> None:
        self._stated, self._named = tuple(stated), dict(named or {})
        self._roots = (*stated, *urdf.resolve().parents, *_ros_folders())

    def find(self, name: str) -> Path | None:
        """Find a package.

        Args:
            name: Its name.

        Returns:
            Its folder; None if it is nowhere.
        """
        if name in self._named:
            return self._named[name]
        for root in self._roots:
            for folder in (root / name, root):
                if name in _names_of(folder):
                    return folder
        return None

    def why_none(self, name: str) -> str:
        """Tell that a package was not found, and what to do.

        Args:
            name: Its name.

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
    """What a package may be called: as its folder, or as its manifest says. Nothing for what is no folder."""
    with suppress(OSError):
        manifest = folder / MANIFEST
        if manifest.is_file():
            with manifest.open(encoding="utf-8", errors="replace") as file:
                stated = _NAME.search(file.read(MANIFEST_BYTES))
            return (folder.name, *([stated[1]] if stated else []))
        return (folder.name,) if folder.is_dir() else ()
    return ()
