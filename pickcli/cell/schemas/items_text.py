"""Writes items as an item file, such that ``read_items`` reads back equal items."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pickcli.cell.hollow import Hollow
from pickcli.cell.item import Item
from pickcli.cell.sensors.material import Material
from pickcli.files.yaml_reader import quoted

_OPTIONAL = ("why_not", "folded")


def items_text(items: Sequence[Item], comment: str = "") -> str:
    """Write items of one year.

    Args:
        items: The items, at least one, all of the same year.
        comment: Lines of comment for the head of the file.

    Returns:
        The text.
    """
    head = [f"# {line}".rstrip() for line in comment.splitlines()]
    lines = [*head, "format: apc items", "version: 1", f"year: {items[0].year}", "items:"]
    for item in items:
        lines += [f"  {item.name}:", *(f"    {line}" for line in _lines(item))]
    return "\n".join(lines) + "\n"


def _lines(item: Item) -> Iterator[str]:
    """Yield the keys of an item, as in docs/formats/items.md."""
    yield f"{item.shape.kind.value}: [{', '.join(map(repr, item.shape.size))}]"
    yield f"mass: {item.mass!r}"
    if item.mass_error != 0.1:
        yield f"mass_error: {item.mass_error!r}"
    yield f"bonus: {item.bonus}"
    yield "seal: 0.0"
    if seals := {face: share for face, share in item.seals.items() if share > 0.0}:
        yield f"seals: {{{', '.join(f'{quoted(face)}: {share!r}' for face, share in seals.items())}}}"
    if item.areas:
        yield "areas:"
        for face, area in item.areas.items():
            limits = ", ".join(f"{axis}: [{low!r}, {high!r}]" for axis, (low, high) in area.items())
            yield f"  {quoted(face)}: {{{limits}}}"
    yield f"seal_source: {_text(item.seal_source)}"
    yield f"seal_inset: {item.seal_inset!r}"
    if item.speed_scale != 1.0:
        yield f"speed_scale: {item.speed_scale!r}"
    if item.max_tilt is not None:
        yield f"max_tilt: {item.max_tilt!r}"
    if item.is_fragile:
        yield "fragile: true"
    if item.material is not Material.MATTE:
        yield f"material: {item.material}"
    if item.colour is not None:
        yield f"colour: {list(item.colour)}"
    if item.is_printed:
        yield "printed: true"
    if item.deformation:
        yield f"deforms: {item.deformation!r}"
    if item.hollows:
        yield "hollows:"
        for hollow in item.hollows:
            yield f"  {hollow.name}: {{{_hollow(hollow)}}}"
    for key in _OPTIONAL:
        if text := getattr(item, key):
            yield f"{key}: {_text(text)}"
    yield f"source: {_text(item.source)}"


def _hollow(hollow: Hollow) -> str:
    """Write the keys of a hollow."""
    keys = [f"face: {quoted(hollow.face)}", f"depth: {hollow.depth!r}"]
    if hollow.radius is not None:
        keys.append(f"radius: {hollow.radius!r}")
    for axis, (least, greatest) in zip(hollow.across, hollow.sides, strict=False):
        keys.append(f"{'xyz'[axis]}: [{least!r}, {greatest!r}]")
    return ", ".join(keys)


def _text(text: str) -> str:
    """Quote a text."""
    return quoted(text) if not text.replace(" ", "a").replace("_", "a").isalnum() else f'"{text}"'
