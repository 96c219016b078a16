"""``apc import-tsr``: conversion of KTH's task space regions to an item in a file of items."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.common_options import (
    items_option,
    json_option,
    of_file,
    output_option,
    refuse_output,
)
from pickcli.commands.options.named_item import find_item, year_option
from pickcli.commands.options.option_types import PATH, FiniteRange, refuse_suffix

if TYPE_CHECKING:
    from pickcli.geometry import Array
    from pickcli.grasping.region_import import ImportedRegions

AXES = ("x", "y", "z", "-x", "-y", "-z")


def parse_axes(ctx: click.Context | None, param: click.Parameter | None, value: str | None) -> Array | None:
    """Parse the value of --axes.

    Args:
        ctx: Context of click.
        param: The option.
        value: Three axes with commas, e.g. x,-z,y; None if not given.

    Returns:
        (3, 3) signed permutation from the regions' frame to the item's; None if not given.

    Raises:
        BadParameter: The value is not three axes, or they form a mirror.
    """
    import numpy as np

    if value is None:
        return None
    names = value.replace(" ", "").split(",")
    S = np.zeros((3, 3))
    if len(names) == 3 and set(names) <= set(AXES):
        for i, name in enumerate(names):
            S[i, "xyz".index(name[-1])] = -1.0 if name[0] == "-" else 1.0
    if not np.isclose(np.linalg.det(S), 1.0):
        what = (
            f"{value!r}: expected which axes of the regions are the item's x, y and z, as a rotation, e.g. "
        )
        raise click.BadParameter(what + "x,-z,y", ctx, param)
    return S


@click.command("import-tsr", cls=Command)
@click.argument("path", metavar="FILE.tsrs", type=PATH)
@click.option("--item", "item_name", required=True, metavar="ITEM", help="The item that the regions are of.")
@year_option
@click.option("--as", "new_name", metavar="NAME",
              help="Name of the new item.  [default: ITEM_tsr]")  # fmt: skip
@click.option(
    "--axes", metavar="X,Y,Z", callback=parse_axes,
    help="Which axes of the regions are the item's x, y, z, e.g. x,-z,y.  [default: the longest is the "
    "longest, and so on]",
)  # fmt: skip
@click.option("--rim", type=FiniteRange(1.0, 100.0), default=17.5, show_default=True, metavar="MM",
              help="Radius of the cup that the regions are for.")  # fmt: skip
@click.option("--seal", type=FiniteRange(0.05, 1.0), metavar="SHARE",
              help="Seal of faces that do not seal according to ITEM.  [default: its best]")  # fmt: skip
@items_option
@output_option("file of items, .yaml")
@json_option
def command(
    path: Path, item_name: str, year: int | None, new_name: str | None, axes: Array | None, rim: float,
    seal: float | None, items_path: Path | None, output: Path, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Convert KTH's task space regions to a file of items.

    FILE.tsrs is a list of !BoxTSR. Each region becomes the part of a face where the cup may be placed (seals
    and areas, docs/formats/items.md); all else of the item is kept. The new item has a name of its own, and
    is used with --items FILE. Regions for which no face was found are listed.

    \b
    Example:
      apc import-tsr dove_beauty_bar.tsrs --item dove_beauty_bar -o dove.yaml
    """
    from dataclasses import replace

    from pickcli.cell.schemas.items_text import items_text
    from pickcli.files.atomic_write import write_text
    from pickcli.grasping.box_tsr import read_box_tsrs
    from pickcli.grasping.region_import import import_regions

    refuse_suffix(output, (".yaml", ".yml"), "a file of items")
    refuse_output(output, overwrite, path, items_path)
    item, regions = find_item(item_name, year, items_path, "--item"), read_box_tsrs(path)
    name = _refuse_bad_name(new_name or f"{item.name}_tsr", items_path)
    with of_file(path):
        found = import_regions(regions, item, axes, rim / 1e3, seal)
    imported = replace(found.item, name=name, seal_source=f"{len(regions)} task space regions of {path.name}")
    origin = f"{item.name} of {item.year}, held where the regions of {path.name} say."
    comment = f"{origin}\nKeys: docs/formats/items.md."
    write_text(output, items_text([imported], comment), overwrite)
    if as_json:
        emit_json({
            "path": str(output), "item": name, "regions": len(regions), "axes": _axes_text(found.axes),
            "faces": found.counts, "left_out": list(found.left_out),
        })  # fmt: skip
    else:
        click.echo("\n".join(_lines(found, name, len(regions), output)))


def _refuse_bad_name(name: str, items_path: Path | None) -> str:
    """Return the name; raise InputError if it is invalid or already in use."""
    import re

    from pickcli.cell.schemas.items_file import load_items
    from pickcli.errors import InputError

    if not re.fullmatch(r"[a-z0-9_]{1,100}", name):
        raise InputError(
            f"--as: {name[:100]!r} is not a name of an item; use lower-case letters, digits and _"
        )
    if name in {known for known, _ in load_items(items_path)}:
        raise InputError(f"--as: there is an item {name} already; choose another name")
    return name


def _axes_text(axes: Array) -> str:
    """Format axes like the value of --axes."""
    signs = (axes.sum(axis=1) < 0.0).tolist()
    return ",".join(
        f"{'-' * sign}{'xyz'[k]}" for sign, k in zip(signs, abs(axes).argmax(axis=1), strict=True)
    )


def _lines(found: ImportedRegions, name: str, n: int, output: Path) -> list[str]:
    """Describe the result for the regions."""
    used = sum(found.counts.values())
    lines = [f"{name}: {used} of {n} regions on {', '.join(found.counts)}; axes {_axes_text(found.axes)}"]
    for face in found.counts:
        area = found.item.areas.get(face, {})
        limits = ", ".join(f"{axis} {1e3 * a:.1f} to {1e3 * b:.1f} mm" for axis, (a, b) in area.items())
        lines.append(f"  {face}: seal {found.item.seals[face]:g}, {limits or 'all of the face'}")
    lines += [f"  left out: {reason}" for reason in found.left_out]
    return [*lines, f"wrote {output}; use it with --items {shlex.quote(str(output))}"]
