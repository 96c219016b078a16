"""Caches results that are costly to derive in the user's cache, by what they were made from.

The cache is optional: missing or damaged entries, and those that cannot be written, are derived again.
"""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from numpy.typing import NDArray
from platformdirs import user_cache_path

from pickcli.errors import InputError
from pickcli.files.atomic_write import write_bytes
from pickcli.files.packed_array import deflated, inflated

_log = logging.getLogger(__name__)


def content_key(*parts: bytes | str) -> str:
    """Compute a hash over all inputs of a derivation.

    Args:
        parts: Contents of files, settings, and a version of the algorithm; or names.

    Returns:
        Hexadecimal digits.
    """
    total = hashlib.sha256()
    for part in parts:
        content = part.encode() if isinstance(part, str) else part
        total.update(f"{len(content)}:".encode() + content)
    return total.hexdigest()


def derived(kind: str, key: str, derive: Callable[[], Any]) -> Any:
    """Return values from the cache, or derive and store them.

    Args:
        kind: Kind of the values; the name of their folder.
        key: From ``content_key``.
        derive: Function that computes them: numbers, texts, lists and mappings, as in JSON.

    Returns:
        The values.
    """
    path = _path(kind, key)
    values = _kept(path)
    if values is None:
        _log.info("deriving %s %s", kind, key[:12])
        values = derive()
        _keep(path, values)
    return values


def derived_arrays(
    kind: str, name: str, made_from: Mapping[str, Any], derive: Callable[[], Mapping[str, NDArray[Any]]]
) -> dict[str, NDArray[Any]]:
    """Return arrays from the cache, or derive and store them beside all that they were made from.

    What was made from anything else is replaced, so that large results do not pile up.

    Args:
        kind: Kind of the arrays; the name of their folder.
        name: Name of their file.
        made_from: All inputs of the derivation, the version of the algorithm included: numbers, texts, lists
            and mappings, as in JSON.
        derive: Function that computes the arrays.

    Returns:
        The arrays by name, bit by bit as they were derived.
    """
    path = _path(kind, name)
    values = _kept(path)
    if values is None or values["made_from"] != made_from:
        _log.info("deriving %s %s", kind, name)
        arrays = {of: deflated(array) for of, array in derive().items()}
        values = {"made_from": dict(made_from), "arrays": arrays}
        _keep(path, values)
    return {of: inflated(array) for of, array in values["arrays"].items()}


def _path(kind: str, key: str) -> Path | None:
    try:
        return user_cache_path("apc", appauthor=False) / kind / f"{key}.json"
    except RuntimeError:  # a user without a home directory
        return None


def _kept(path: Path | None) -> Any:
    """The stored values, if they exist and are undamaged."""
    try:
        stated, _, content = path.read_bytes().partition(b"\n") if path is not None else (b"", b"", b"")
    except OSError:
        return None
    if not content or hashlib.sha256(content).hexdigest().encode() != stated:
        return None
    return json.loads(content)


def _keep(path: Path | None, values: Any) -> None:
    content = json.dumps(values, separators=(",", ":")).encode()
    if path is None:
        _warn_once("of a user without a home")
        return
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, hashlib.sha256(content).hexdigest().encode() + b"\n" + content)
    except (OSError, InputError) as error:
        _log.info("not kept in the cache: %s", error)
        _warn_once(str(path.parent.parent))


@cache
def _warn_once(folder: str) -> None:
    """Warn that results are not cached; once per folder, as this affects many files."""
    _log.warning(
        "nothing can be kept in the cache %s, so what takes long is computed again each time; set "
        "XDG_CACHE_HOME to a folder that can be written",
        folder,
    )
