"""``apc cache``: show or delete the cache of built files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.common_options import json_option

if TYPE_CHECKING:
    from pickcli.precompute.artifact_cache import CachedFolder


@click.command("cache", cls=Command)
@click.option("--clear", is_flag=True, help="Delete everything in it; files are built again when needed.")
@json_option
def command(clear: bool, as_json: bool) -> None:
    """Show what is in the cache of built files, or delete it.

    It contains the roadmaps and trajectory databases that trials build, for each cell in a folder named by
    its fingerprint: $XDG_CACHE_HOME/apc, ~/.cache/apc by default.

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
    """Describe the cache, with a line for each folder in it."""
    size = sum(folder.n_bytes for folder in found) / 1e6
    lines = [f"{base}: {'deleted ' if is_cleared else ''}{size:.1f} MB in {len(found)} folders"]
    for folder in found:
        cell = f", cell {folder.cell}" if folder.cell else ""
        lines.append(f"  {folder.name}: {folder.n_files} files, {folder.n_bytes / 1e6:.1f} MB{cell}")
    return lines
