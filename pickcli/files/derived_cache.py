"""What is costly to derive from the content of files, kept in the user's cache under a hash of that content.

Nothing depends on the cache: what is not there, damaged or cannot be written is derived again.
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
    """A hash of everything that something is derived from.

    Args:
        parts: Contents of files, settings, and a version of what derives.

    Returns:
        Hexadecimal digits.
    """
    total = hashlib.sha256()
    for part in parts:
        content = part.encode() if isinstance(part, str) else part
        total.update(f"{len(content)}:".encode() + content)
    return total.hexdigest()


def derived(kind: str, key: str, derive: Callable[[], Any]) -> Any:
    """Plain values from the cache, or derived and kept.

    Args:
        kind: Of the values; the name of their folder.
        key: From ``content_key``.
        derive: Makes them: numbers, texts, lists and mappings, as JSON has them.

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
    except RuntimeError:  # a user without a home
        return None


def _kept(path: Path | None) -> Any:
    """The values, if they are there and as they were written."""
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
    """Tell that work is done again each time: not for each of the many files that this is true of."""
    _log.warning(
        "nothing can be kept in the cache %s, so what takes long is computed again each time; set "
        "XDG_CACHE_HOME to a folder that can be written",
        folder,
    )
