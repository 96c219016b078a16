"""What installed packages add by entry points: listed by name, loaded when it is used."""

from __future__ import annotations

from collections.abc import Callable, Collection
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from pickcli.errors import InputError


def added(group: str, taken: Collection[str]) -> dict[str, EntryPoint]:
    """What installed packages add to a group.

    Args:
        group: Name of the group.
        taken: Names that nobody can add: those of this package.

    Returns:
        Entry points by name, sorted; of several of one name the first by its value.
    """
    found = sorted(entry_points(group=group), key=lambda point: (point.name, point.value), reverse=True)
    by_name = {point.name: point for point in found if point.name not in taken}
    return dict(sorted(by_name.items()))


def loaded(what: str, point: EntryPoint, is_right: Callable[[Any], bool], expected: str) -> Any:
    """Load what a package adds.

    Args:
        what: What it is, for the message, e.g. "driver".
        point: Its entry point.
        is_right: Whether what was loaded is of the right kind.
        expected: What it should be, for the message.

    Returns:
        What was loaded.

    Raises:
        InputError: It cannot be loaded, or is something else.
    """
    try:
        found = point.load()
    except Exception as error:  # whatever the package's own code raises
        raise InputError(
            f"{what} {point.name!r}: {point.value} cannot be loaded ({error}); correct or remove its package"
        ) from error
    if not is_right(found):
        raise InputError(f"{what} {point.name!r}: {point.value} is no {expected}; correct its package")
    return found
