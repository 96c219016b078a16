"""Export formats by name: built-in ones, and those of installed packages."""

from __future__ import annotations

from importlib import import_module

from pickcli.errors import UnknownNameError
from pickcli.export.exporter import Exporter
from pickcli.plugins import added, loaded

GROUP = "apc.exporters"

# Name -> module of this package with the format as EXPORTER, imported on demand.
BUILT_IN = {
    "joint-trajectory": "joint_trajectory",
    "csv": "csv_table",
    "mcap": "mcap_log",
    "urscript": "urscript",
}


def format_names() -> list[str]:
    """Return the names of all formats.

    Returns:
        Names, the built-in ones first.
    """
    return [*BUILT_IN, *added(GROUP, BUILT_IN)]


def exporter(name: str) -> Exporter:
    """Find a format.

    Args:
        name: Name of the format.

    Returns:
        The format.

    Raises:
        InputError: No format has that name, or the package's entry point cannot be used.
    """
    if name in BUILT_IN:
        found = import_module(f"pickcli.export.{BUILT_IN[name]}").EXPORTER
    else:
        others = added(GROUP, BUILT_IN)
        if name not in others:
            raise UnknownNameError("format", name, format_names())
        found = loaded("format", others[name], _is_exporter, "pickcli.export.exporter.Exporter")
    assert isinstance(found, Exporter)
    return found


def _is_exporter(found: object) -> bool:
    return isinstance(found, Exporter)
