"""Caches results that are costly to derive from files in the user's cache, by a hash of the files' content.

The cache is optional: missing or damaged entries, and those that cannot be written, are derived again.
"""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from platformdirs import user_cache_path

from pickcli.errors import InputError
from pickcli.files.atomic_write import write_bytes

_log = logging.getLogger(__name__)


def content_key(*parts: bytes | str) -> str:
    """Compute a hash over all inputs of a derivation.

    Args:
        parts: Contents of files, settings, and a version of the algorithm.

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
