"""Page of the envelopes of an item: poses of the tool drawn from each, whole and truncated to a scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.files.packed_array import packed
from pickcli.geometry import Array, inverse, pose
from pickcli.grasping.envelope import Envelope
from pickcli.grasping.envelope_truncation import Truncation
from pickcli.page.cell_parts import item_ink
from pickcli.page.page_document import PageDocument, PageTable
from pickcli.page.page_scene import (
    INVISIBLE_ROBOT,
    Fact,
    PageItem,
    PageLine,
    posed,
)
from pickcli.page.shape_parts import drawn_item
from pickcli.scene.scene import PlacedItem

_N_DRAWN = 60  # poses of each envelope
_ARROW = 0.05  # m, from the palm back along the approach, for an envelope without depth
_NEAR = 0.35  # m, within which other items are drawn
_POINT_RESOLUTION = 1e-4  # m
_WHOLE, _KEPT = "#999999", "#009e73"


@dataclass(frozen=True, eq=False)
class EnvelopeRow:
    """What is shown of an envelope.

    Attributes:
        envelope: The whole envelope.
        tool_state: State of the tool in which most of it is left.
        truncation: What the scene leaves of it; None without a scene.
        reached: Share of it that the arm reaches; of what is left of it, in a scene. None without one.
    """

    envelope: Envelope
    tool_state: str
    truncation: Truncation | None = None
    reached: float | None = None


def envelope_page(
    target: PlacedItem, others: Sequence[PlacedItem], rows: Sequence[EnvelopeRow]
) -> PageDocument:
    """Create the page of an item's envelopes.

    Args:
        target: The item.
        others: Items around it in its scene.
        rows: Its envelopes.

    Returns:
        The page; its world is the item's frame.
    """
    T_target = inverse(target.T_world_item)
    near = [each for each in others if np.linalg.norm((T_target @ each.T_world_item)[:3, 3]) < _NEAR]
    name = target.item.name.replace("_", " ")
    return PageDocument(
        kind="envelopes",
        title=f"Envelopes of {name}",
        subtitle=f"{len(rows)} envelopes, {len(near)} items near it",
        facts=tuple(_facts(rows)),
        robot=INVISIBLE_ROBOT,
        items=(
            _item(target, pose((0.0, 0.0, 0.0))),
            *(_item(each, T_target @ each.T_world_item) for each in near),
        ),
        lines=tuple(_lines(rows)),
        legend=(("whole envelope", _WHOLE), ("proven free in the scene", _KEPT)),
        tables=(_table(rows),),
    )


def _item(placed: PlacedItem, T: Array) -> PageItem:
    name = placed.item.name.replace("_", " ")
    return PageItem(placed.id, name, item_ink(placed.item), drawn_item(placed.item), posed(T))


def _facts(rows: Sequence[EnvelopeRow]) -> Iterator[Fact]:
    for row in rows:
        if row.truncation is not None and row.truncation.against is not None:
            yield Fact(row.envelope.name, str(row.truncation.against))


def _lines(rows: Sequence[EnvelopeRow]) -> Iterator[PageLine]:
    """Yield arrows from the palm to the tip, for poses drawn by a fixed seed."""
    for row in rows:
        left = None if row.truncation is None else row.truncation.envelope
        for envelope, colour, kind in ((row.envelope, _WHOLE, "whole"), (left, _KEPT, "free")):
            if envelope is None:
                continue
            for k, T in enumerate(envelope.sample(np.random.default_rng(0), _N_DRAWN)):
                back = max(envelope.depth, _ARROW)
                points = np.stack([T[:3, 3] - back * T[:3, 2], T[:3, 3]])
                yield PageLine(f"{envelope.name}, {kind} {k + 1}", packed(points, _POINT_RESOLUTION), colour)


def _table(rows: Sequence[EnvelopeRow]) -> PageTable:
    header = ("from", "tool", "about", "cone, degrees", "kept", "of the cones", "of the roll", "reached")
    return PageTable("Envelopes", header, tuple(_cells(row) for row in rows))


def _cells(row: EnvelopeRow) -> tuple[str, ...]:
    envelope, left = row.envelope, row.truncation
    about, cone = envelope.surface.name.lower(), f"{np.degrees(envelope.cone):.0f}"
    whole = (envelope.name, row.tool_state, about, cone)
    if left is None:
        return (*whole, "", "", "", "")
    if left.envelope is None:
        return (*whole, "nothing", "", "", "")
    shares = (left.kept, left.cone_share, left.roll_share, row.reached or 0.0)
    return (*whole, *(f"{share:.0%}" for share in shares))
