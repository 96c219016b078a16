"""Collects the files of a robot: its URDF, expanded from xacro if necessary, and the meshes named in it."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from pickcli.errors import InputError
from pickcli.files.bounded_reading import read_text
from pickcli.files.file_kind import URDF
from pickcli.files.xml_mistakes import XmlMistakes
from pickcli.files.xml_reader import Element, read_xml
from pickcli.robot_setup.package_search import PackageSearch
from pickcli.robot_setup.xacro_file import expanded

PACKAGE, FILE = "package://", "file://"
PACKAGES, MESHES = "packages", "meshes"  # folders of a cell
MAX_BYTES = 10_000_000


@dataclass(frozen=True)
class RobotFiles:
    """The files that make a cell's folder self-contained.

    Attributes:
        urdf: Text of the URDF.
        meshes: Files by their target path in the cell's folder.
        packages: Folders in the cell's folder, by name as in ``package://``.
    """

    urdf: str
    meshes: dict[str, Path]
    packages: dict[str, str]


def find_robot_files(
    urdf: Path, packages: PackageSearch, arguments: Mapping[str, str], scratch: Path
) -> RobotFiles:
    """Find the files that a URDF needs: meshes of collision shapes, and available meshes of visuals.

    The text is unchanged except for meshes named by a path outside its folder.

    Args:
        urdf: A URDF or xacro file.
        packages: Finder of packages.
        arguments: Arguments of a xacro, by name.
        scratch: A folder for the expanded text of a xacro.

    Returns:
        The files.

    Raises:
        InputError: With every missing package and every missing mesh of a collision shape; or a URDF is given
            arguments.
    """
    if urdf.suffix == ".xacro":
        text, path = expanded(urdf, packages, arguments), scratch / f"{urdf.stem}.urdf"
        path.write_text(text)
    elif arguments:
        raise InputError(f"--xacro-arg {min(arguments)}: {urdf} is no xacro (.xacro), and has no arguments")
    else:
        text, path = read_text(urdf, MAX_BYTES, wanted=URDF), urdf
    robot, mistakes = read_xml(path), XmlMistakes(path)
    found = _Found(urdf, packages)
    for mesh in _meshes(robot, "collision"):
        mistakes.tried(lambda mesh=mesh: found.add(mesh), None)  # type: ignore[misc]
    mistakes.check()
    for mesh in _meshes(robot, "visual"):
        with suppress(InputError):  # without the mesh, collision shapes are drawn
            found.add(mesh)
    for name, target in found.renamed.items():
        text = re.sub(rf"(filename\s*=\s*[\"']){re.escape(name)}([\"'])", rf"\g<1>{target}\g<2>", text)
    return RobotFiles(text, found.meshes, found.packages)


def _meshes(robot: Element, tag: str) -> Iterator[Element]:
    """Yield all meshes of collision shapes or visuals."""
    for link in robot.all("link"):
        for shape in link.all(tag):
            for geometry in shape.all("geometry"):
                yield from geometry.all("mesh")


class _Found:
    """Meshes found so far.

    Args:
        urdf: The file that names them.
        packages: Finder of packages.
    """

    def __init__(self, urdf: Path, packages: PackageSearch) -> None:
        self.urdf, self._search = urdf, packages
        self.meshes: dict[str, Path] = {}
        self.packages: dict[str, str] = {}
        self._missing = set[str]()
        self.renamed: dict[str, str] = {}  # old and new mesh name in the text

    def add(self, mesh: Element) -> None:
        """Find the file of a mesh. Raises InputError."""
        name = mesh.text("filename")
        if name.startswith(PACKAGE):
            package, _, rest = name.removeprefix(PACKAGE).partition("/")
            root = self._search.find(package)
            if root is None:
                self._tell_missing(mesh, package)
                return
            inside = os.path.normpath(rest)
            if inside.startswith(".."):
                raise mesh.error(f"{rest!r} leads out of package {package!r}; expected a path inside of it")
            self._keep(mesh, f"{PACKAGES}/{package}/{inside}", root / inside)
            self.packages[package] = f"{PACKAGES}/{package}"
            return
        path = self.urdf.parent / name.removeprefix(FILE)
        inside = os.path.normpath(name)
        if name.startswith((FILE, "/", "..")) or inside.startswith(".."):
            inside = self.renamed.get(name, self._own_name(path))
            self._keep(mesh, inside, path)
            self.renamed[name] = inside
            return
        self._keep(mesh, inside, path)

    def _tell_missing(self, mesh: Element, package: str) -> None:
        """Raise InputError for the first mesh of a missing package; later ones are ignored."""
        if package not in self._missing:
            self._missing.add(package)
            raise mesh.error(self._search.why_none(package))

    def _keep(self, mesh: Element, target: str, path: Path) -> None:
        if not path.is_file():
            raise mesh.error(f"{path}: no such file; copy it there or correct the name")
        self.meshes[target] = path

    def _own_name(self, path: Path) -> str:
        """A file name in the folder of meshes that no other file has."""
        for k in range(len(self.meshes) + 1):
            name = f"{MESHES}/{path.name}" if k == 0 else f"{MESHES}/{path.stem}_{k}{path.suffix}"
            if self.meshes.get(name, path) == path:
                return name
        raise AssertionError("one name more than there are files is free")
