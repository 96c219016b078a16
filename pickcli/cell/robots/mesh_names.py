"""Resolves mesh file names of a URDF, in the cell's folder or in those of ROS packages."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from pickcli.files.xml_reader import Element
from pickcli.name_suggestion import suggestion

_PACKAGE, _FILE = "package://", "file://"


@dataclass(frozen=True)
class MeshNames:
    """Resolver of the mesh file names in a URDF.

    Attributes:
        urdf: Path of the URDF.
        folder: The cell's folder. Files named by a path must be in it or in a package.
        packages: Folders of the packages, by name as in ``package://``.
    """

    urdf: Path
    folder: Path
    packages: Mapping[str, Path]

    def find(self, mesh: Element) -> Path:
        """Find the file of a mesh.

        Args:
            mesh: An element with a ``filename``: ``package://NAME/PATH``, or a path from the URDF's folder.

        Returns:
            Its path.

        Raises:
            InputError: The package is unknown, there is no such file, or it is outside the folders that may
                be read.
        """
        name = mesh.text("filename")
        if name.startswith(_PACKAGE):
            return self._in_package(mesh, name.removeprefix(_PACKAGE))
        path = self.urdf.parent / name.removeprefix(_FILE)
        if not any(_is_in(path, root) for root in (self.folder, *self.packages.values())):
            raise mesh.error(
                f"{name!r} lies outside of the cell's folder; copy it there, or state its folder in "
                "robot.packages of the cell"
            )
        return _existing(mesh, path)

    def _in_package(self, mesh: Element, name: str) -> Path:
        package, _, rest = name.partition("/")
        root = self.packages.get(package)
        if root is None:
            hint = f"; {suggestion(package, list(self.packages))}" if self.packages else ""
            raise mesh.error(
                f"package {package!r} is unknown; state its folder as robot.packages.{package}{hint}"
            )
        if not _is_in(root / rest, root):
            raise mesh.error(f"{rest!r} leads out of package {package!r}; expected a path inside of it")
        return _existing(mesh, root / rest)


def _is_in(path: Path, root: Path) -> bool:
    with suppress(OSError):  # e.g. a name that is too long for a file
        return path.resolve().is_relative_to(root.resolve())
    return False


def _existing(mesh: Element, path: Path) -> Path:
    with suppress(OSError):
        if path.is_file():
            return path
    raise mesh.error(f"{path}: no such file; copy it there or correct the name")
