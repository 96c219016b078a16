"""Formats by their names: those of this package, and those that installed packages add."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import EntryPoint, entry_points

from pickcli.errors import InputError, UnknownNameError
from pickcli.export.exporter import Exporter

GROUP = "apc.exporters"

# Name -> module of this package, in which EXPORTER is the format: imported only when it is used.
BUILT_IN = {
    "joint-trajectory": "joint_trajectory",
    "csv": "csv_table",
    "mcap": "mcap_log",
    "urscript": "urscript",
}


def added_formats() -> dict[str, EntryPoint]:
    """What installed packages add.

    Returns:
        Entry points by name, sorted. None has the name of a format of this package.
    """
    found = sorted(entry_points(group=GROUP), key=lambda point: (point.name, point.value))
    return {point.name: point for point in reversed(found) if point.name not in BUILT_IN}


def format_names() -> list[str]:
    """The names of all formats.

    Returns:
        Those of this package first.
    """
    return [*BUILT_IN, *sorted(added_formats())]


def exporter(name: str) -> Exporter:
    """Find a format.

    Args:
        name: Its name.

    Returns:
        The format.

    Raises:
        InputError: There is none of that name, or what a package adds cannot be loaded.
    """
    if name in BUILT_IN:
        found = import_module(f"pickcli.export.{BUILT_IN[name]}").EXPORTER
        assert isinstance(found, Exporter)
        return found
    added = added_formats()
    if name not in added:
        raise UnknownNameError("format", name, format_names())
    return _loaded(added[name])


def _loaded(point: EntryPoint) -> Exporter:
    """The format that an entry point names. Raises InputError where it is none."""
    try:
        found = point.load()
    except Exception as error:  # whatever the package's own code raises
        raise InputError(
            f"format {point.name!r}: {point.value} cannot be loaded ({error}); correct or remove its package"
        ) from error
    if not isinstance(found, Exporter):
        raise InputError(
            f"format {point.name!r}: {point.value} is no pickcli.export.exporter.Exporter; correct its "
            "package"
        )
    return found
