"""``apc cache``: where built files lie, how large they are, and away with them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options import json_option

if TYPE_CHECKING:
    from pickcli.precompute.artifact_cache import CachedFolder


@click.command("cache", cls=Command)
@click.option("--clear", is_flag=True, help="Delete everything in it; what is needed again is built again.")
@json_option
def command(clear: bool, as_json: bool) -> None:
    """Show what is in the cache of built files, or delete it.

    Roadmaps and trajectory databases that a trial builds lie there, each cell's in a folder named by its
    fingerprint: $XDG_CACHE_HOME/apc, ~/.cache/apc by default.

    \b
    Example:
      apc cache --json
      apc cache --clear
    """
    from pickcli.precompute.artifact_cache import cache_folder, cached, clear_cache

    base = cache_folder()
    found = cached(base)
    if clear:
        clear_cache(base)
    if as_json:
        folders = [{"name": f.name, "cell": f.cell, "files": f.n_files, "bytes": f.n_bytes} for f in found]
        emit_json({"path": str(base), "cleared": clear, "folders": folders})
    else:
        click.echo("\n".join(_lines(base, found, clear)))


def _lines(base: Path, found: list[CachedFolder], is_cleared: bool) -> list[str]:
    """Where the cache is, and a line for each folder in it."""
    size = sum(folder.n_bytes for folder in found) / 1e6
    told = [f"{base}: {'deleted ' if is_cleared else ''}{size:.1f} MB in {len(found)} folders"]
    for folder in found:
        cell = f", cell {folder.cell}" if folder.cell else ""
        told.append(f"  {folder.name}: {folder.n_files} files, {folder.n_bytes / 1e6:.1f} MB{cell}")
    return told
