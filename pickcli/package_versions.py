"""Versions of what results depend on."""

from __future__ import annotations

import platform
from collections.abc import Iterable
from importlib import metadata

import pickcli


def package_versions(packages: Iterable[str]) -> dict[str, str]:
    """Return the versions of what results depend on.

    Args:
        packages: Names of the distributions of other packages.

    Returns:
        Version of this package, Python and those, by name; "not installed" of one that is not.
    """
    versions = {"apc-pick": pickcli.__version__, "python": platform.python_version()}
    for package in packages:
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            versions[package] = "not installed"
    return versions
