"""Page of a stack on a pallet, which is put up carton by carton."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pickcli.errors import Reason
from pickcli.files.packed_array import packed
from pickcli.geometry import Array, pose
from pickcli.page.motion_parts import TIME_RESOLUTION
from pickcli.page.page_document import PageDocument, PageTable
from pickcli.page.page_motion import Chapter, PageMotion, Track
from pickcli.page.page_scene import (
    INVISIBLE_ROBOT,
    Fact,
    PageGroup,
    PageItem,
    PageShape,
    Tone,
    posed,
    rounded,
)
from pickcli.page.shape_parts import drawn_body
from pickcli.palletizing.pallet_bodies import deck_body, wall_bodies
from pickcli.palletizing.pallet_stack import Placement
from pickcli.palletizing.pallet_stack_file import StackedPallet
from pickcli.palletizing.stack_verification import verify_stack

_ORIGIN = pose((0.0, 0.0, 0.0))
_WOOD, _STEEL, _CLEAR = "#b58b5a", "#9aa4ad", 0.2
_INKS = ("#0072b2", "#009e73", "#e69f00", "#56b4e9", "#cc79a7", "#d55e00")
_ACROSS, _DOWN = 0.6, 0.6  # s from the row where a carton waits to over its place, and down to it
_APART = 0.1  # m between cartons that wait
_POSE_RESOLUTION = 1e-4


def pallet_page(stack: StackedPallet) -> PageDocument:
    """Create the page of a stack: its cartons come from a row beside the pallet, one after the other.

    Args:
        stack: The stack.

    Returns:
        The page; the world is the frame of the pallet, on its deck.
    """
    pallet, n, per_carton = stack.pallet, len(stack.placements), _ACROSS + _DOWN
    faults = verify_stack(stack).reasons
    waiting = _waiting(stack)
    duration = max(n, 1) * per_carton
    return PageDocument(
        kind="pallet",
        title="Stacked pallet",
        subtitle=f"{n} cartons, {stack.top:.2f} m high",
        facts=(*_facts(stack), _verdict(faults)),
        robot=INVISIBLE_ROBOT,
        groups=(
            PageGroup("pallet", posed(_ORIGIN), _WOOD, (drawn_body(deck_body(pallet, pallet.deck)),)),
            PageGroup("walls", posed(_ORIGIN), _STEEL, tuple(map(drawn_body, wall_bodies(pallet))), _CLEAR),
        )[: 1 + bool(pallet.walls)],
        items=tuple(
            _item(each, start, _INKS[k % len(_INKS)], stack.loads[each.carton.id])
            for k, (each, start) in enumerate(zip(stack.placements, waiting, strict=True))
        ),
        motion=PageMotion(
            duration, packed(np.array([0.0, duration]), TIME_RESOLUTION),
            packed(np.zeros((2, 0)), _POSE_RESOLUTION),
            tracks=tuple(
                _track(each, start, k * per_carton)
                for k, (each, start) in enumerate(zip(stack.placements, waiting, strict=True))
            ),
        ),
        chapters=tuple(
            Chapter(each.carton.id, "stands", Tone.GOOD, k * per_carton, (k + 1) * per_carton, each.carton.id)
            for k, each in enumerate(stack.placements)
        ),
        tables=tuple(_tables(stack, faults)),
    )  # fmt: skip


def _waiting(stack: StackedPallet) -> list[Array]:
    """Positions (3,) at which cartons wait: in a row on the floor beside the pallet, in sequence."""
    x, found = 0.0, []
    for placement in stack.placements:
        size = placement.size
        y = -stack.pallet.size[1] / 2 - 1.0 - size[1] / 2
        found.append(np.array([x + size[0] / 2, y, size[2] / 2 - stack.pallet.deck]))
        x += float(size[0]) + _APART
    middle = np.array([(x - _APART) / 2, 0.0, 0.0])
    return [each - middle for each in found]


def _item(placement: Placement, start: Array, ink: str, load: float) -> PageItem:
    carton = placement.carton
    facts = (
        Fact("size", " x ".join(f"{side:g}" for side in carton.size) + " m"),
        Fact("mass", f"{carton.mass:g} kg"),
        Fact("bears", f"{load:g} kg"),
        Fact("rests on", ", ".join(placement.rests_on) or "the deck"),
    )
    shape = PageShape("box", rounded(placement.size))
    return PageItem(carton.id, carton.id, ink, shape, posed(pose(start)), facts)


def _track(placement: Placement, start: Array, t: float) -> Track:
    """The way of a carton: over its place, and straight down."""
    end = placement.centre
    above = np.array([end[0], end[1], placement.from_above + float(placement.size[2]) / 2])
    times = np.array([t, t + _ACROSS, t + _ACROSS + _DOWN])
    poses = np.array([posed(pose(p)) for p in (start, above, end)])
    return Track(placement.carton.id, packed(times, TIME_RESOLUTION), packed(poses, _POSE_RESOLUTION))


def _facts(stack: StackedPallet) -> list[Fact]:
    facts = [
        Fact("pallet", " x ".join(f"{side:g}" for side in stack.pallet.size) + " m"),
        Fact("mass", f"{sum(each.carton.mass for each in stack.placements):.0f} kg"),
        Fact("moved in the engine", f"up to {1e3 * max(stack.sinking, stack.shift):.1f} mm"),
    ]
    return facts + [Fact("left", f"{len(stack.left)} cartons", Tone.FAIR)] * bool(stack.left)


def _verdict(faults: Sequence[Reason]) -> Fact:
    if faults:
        return Fact("verifier", f"rejects it: {len(faults)} reasons", Tone.BAD)
    return Fact("verifier", "accepts it", Tone.GOOD)


def _tables(stack: StackedPallet, faults: Sequence[Reason]) -> list[PageTable]:
    rows = tuple(
        (str(k + 1), each.carton.id, f"{each.carton.mass:g}", f"{stack.loads[each.carton.id]:g}",
         ", ".join(each.rests_on) or "the deck")
        for k, each in enumerate(stack.placements)
    )  # fmt: skip
    tables = [PageTable("Rejected", ("why",), tuple((str(each),) for each in faults))] if faults else []
    tables += [PageTable("In sequence", ("no.", "carton", "kg", "bears, kg", "rests on"), rows)]
    if stack.left:
        left = tuple((name, "; ".join(reasons)) for name, reasons in stack.left.items())
        tables.append(PageTable("Left", ("carton", "why"), left))
    return tables
