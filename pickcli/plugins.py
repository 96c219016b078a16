"""Plugins that installed packages add by entry points: listed by name, loaded at their use."""

from __future__ import annotations

from collections.abc import Callable, Collection
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from pickcli.errors import InputError


def added(group: str, taken: Collection[str]) -> dict[str, EntryPoint]:
    """List the plugins that installed packages add to a group.

    Args:
        group: Name of the group.
        taken: Names that cannot be added, because this package uses them.

    Returns:
        Entry points by name, sorted; of several with one name the first by its value.
    """
    found = sorted(entry_points(group=group), key=lambda point: (point.name, point.value), reverse=True)
    by_name = {point.name: point for point in found if point.name not in taken}
    return dict(sorted(by_name.items()))


def loaded(what: str, point: EntryPoint, is_right: Callable[[Any], bool], expected: str) -> Any:
    """Load a plugin.

    Args:
        what: Kind of the plugin, for the message, e.g. "driver".
        point: Its entry point.
        is_right: Whether the loaded object is of the right kind.
        expected: Description of the right kind, for the message.

    Returns:
        The loaded object.

    Raises:
        InputError: It cannot be loaded, or is of another kind.
    """
    try:
        found = point.load()
    except Exception as error:  # any error of the package's own code
        raise InputError(
            f"{what} {point.name!r}: {point.value} cannot be loaded ({error}); correct or remove its package"
        ) from error
    if not is_right(found):
        raise InputError(f"{what} {point.name!r}: {point.value} is no {expected}; correct its package")
    return found
