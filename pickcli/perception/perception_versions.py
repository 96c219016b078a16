"""Versions of the packages that shape the bytes of what is perceived."""

from __future__ import annotations

from collections.abc import Iterable

from pickcli.package_versions import package_versions
from pickcli.perception.items.routing import ItemRoute

_PACKAGES = ("numpy", "scipy")


def perception_versions(routes: Iterable[ItemRoute | None]) -> dict[str, str]:
    """Return the versions that shape the answers of looks.

    Args:
        routes: By what items were looked for; None of one of which that is not known any more.

    Returns:
        Version of this package, Python and others, by name.
    """
    return {**package_versions(_PACKAGES), **print_versions(routes)}


def print_versions(routes: Iterable[ItemRoute | None]) -> dict[str, str]:
    """Return the versions that shape answers only where prints were looked for.

    Args:
        routes: By what items were looked for; None of one of which that is not known any more.

    Returns:
        Version of OpenCV; none if no print was looked for, for which it need not be installed.
    """
    if all(route is None or route.views is None for route in routes):
        return {}
    from pickcli.perception.textures.opencv import VERSION  # heavy, and an extra

    return {"opencv": VERSION}
