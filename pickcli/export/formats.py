"""Export formats by name: built-in ones, and those of installed packages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib import import_module

from pickcli.errors import InputError, UnknownNameError
from pickcli.export.exporter import Exporter, ExportRequest
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
        return replace(found, encode=partial(_encoded, name, found.encode))
    assert isinstance(found, Exporter)
    return found


def _encoded(name: str, encode: Callable[[ExportRequest], bytes], request: ExportRequest) -> bytes:
    """Encode a plan by a package's own code, whose errors are no bug of ours. Raises InputError for them."""
    try:
        content = encode(request)
    except InputError:
        raise
    except Exception as error:  # any error of the package's own code
        what = f"{type(error).__name__}: {error}"
        raise InputError(f"format {name!r}: {what}; correct or remove its package") from error
    if not isinstance(content, bytes):
        kind = type(content).__name__
        raise InputError(f"format {name!r}: its content is {kind}, bytes expected; correct its package")
    return content


def _is_exporter(found: object) -> bool:
    return isinstance(found, Exporter)
