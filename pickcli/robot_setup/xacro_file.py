"""URDFs that are written as xacro. The only file that knows xacro, which is an extra."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from pickcli.errors import InputError
from pickcli.robot_setup.package_search import PackageSearch

_INDEX = "ament_index_python"  # where xacro looks for packages: part of ROS, on no registry


def expanded(path: Path, packages: PackageSearch, arguments: Mapping[str, str]) -> str:
    """Expand a xacro.

    Args:
        path: The file.
        packages: Finds what ``$(find PACKAGE)`` asks for.
        arguments: Values of its arguments.

    Returns:
        The URDF as text.

    Raises:
        InputError: The extra is not installed, or xacro refuses the file.
    """
    try:
        import xacro
    except ImportError:
        raise InputError(
            f"{path}: is a xacro, and the package xacro is not installed; pip install 'apc-pick[xacro]', or "
            "expand it where ROS is and name the URDF"
        ) from None
    if not path.is_file():
        raise InputError(f"{path}: no such file; correct the name")
    try:
        with _package_index(packages):
            return str(xacro.process_file(str(path), mappings=dict(arguments)).toprettyxml(indent="  "))
    except Exception as error:  # whatever the file makes xacro evaluate
        raise InputError(f"{path}: xacro refuses it: {error or type(error).__name__}") from error


@contextmanager
def _package_index(packages: PackageSearch) -> Iterator[None]:
    """Answer for ROS's index of packages, which xacro imports when a file asks for one."""

    def share_directory(name: str) -> str:
        found = packages.find(name)
        if found is None:
            raise LookupError(packages.why_none(name))
        return str(found)

    index, listing = ModuleType(_INDEX), ModuleType(f"{_INDEX}.packages")
    listing.get_package_share_directory = share_directory  # type: ignore[attr-defined]
    ours = {_INDEX: index, listing.__name__: listing}
    before = {name: sys.modules.get(name) for name in ours}
    sys.modules.update(ours)
    try:
        yield
    finally:
        for name, module in before.items():
            if module is None:
                del sys.modules[name]
            else:
                sys.modules[name] = module
