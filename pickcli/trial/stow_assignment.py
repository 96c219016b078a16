"""Assigns bins to the items of a stow, by points and free volume.

A bin gives more points the more it held at the start, independent of its present contents, and all items
count alike except for a bonus that does not depend on the bin. So the score is largest with as many items as
possible in the bins that started fullest: the smallest first. This is a heuristic by sizes; planning decides
whether an item can be placed in a bin, and otherwise the next bin is tried. What no tool can hold comes last,
so that it takes no room from others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.tool import Tool
from pickcli.grasping.method_choice import may_hold
from pickcli.scene.scene import Scene
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.order_file import NEWEST
from pickcli.trial.score import target_points

FULL_SHARE = 0.5  # share of a bin's volume filled by the items' boxes, above which its floor rarely has room


class StowRule(StrEnum):
    """Rule for the choice of bins."""

    POINTS = "points"  # the smallest items first, into the bins with the most points
    SIZE = "size"  # KTH: large items into large bins


@dataclass(frozen=True)
class StowChoice:
    """One item of a stow with its bins.

    Attributes:
        item: Name of the item.
        bins: Names of all bins that are large enough, in the order in which they are tried.
        points: Points of the item in the first bin; 0 without bins, or if no tool can hold it.
        reason: Why that bin comes first, or why the item gives no points.
        can_be_held: Whether a tool may be able to hold it in some pose.
    """

    item: str
    bins: tuple[str, ...]
    points: int
    reason: str
    can_be_held: bool = True


def assign_bins(
    order: Order,
    cell: Cell,
    bonus: Mapping[str, int],
    tools: Sequence[Tool],
    rule: StowRule = StowRule.POINTS,
) -> tuple[StowChoice, ...]:
    """Choose a bin for every item in the tote.

    Args:
        order: A stow order.
        cell: The cell, for its bins and items.
        bonus: Points by name of the item, as from ``item_bonuses``.
        tools: The tools of all arms that may stow.
        rule: Rule for the choice of bins.

    Returns:
        One choice per item, in the order of decision: the smallest first, for KTH's rule the largest; what no
        tool can hold last.
    """
    filled = {
        name: sum(_box(cell.item(each, order.year)) for each in names) / cell.places[name].room.volume
        for name, names in order.bin_contents.items()
    }
    items = sorted((cell.item(name, order.year) for name in order.tote_contents), key=_box)
    by_size = items if rule is StowRule.POINTS else [*reversed(items)]
    choices = []
    for item in sorted(by_size, key=lambda item: not may_hold(tools, item)):
        taking = {name: filled[name] + _box(item) / cell.places[name].room.volume for name in filled}
        bins = tuple(_ranked(order, cell, item, taking, rule))
        if not may_hold(tools, item):
            why = f"no tool can hold it{item.why_not and f': {item.why_not}'}"
            choices.append(StowChoice(item.name, bins, 0, why, can_be_held=False))
            continue
        points = target_points(order, bins[0], item.name, bonus) if bins else 0
        choices.append(StowChoice(item.name, bins, points, _why(order, item, bins, taking, rule)))
        if bins:
            filled[bins[0]] = taking[bins[0]]
    return tuple(choices)


def order_as_it_lies(scene: Scene, item: Item) -> Order:
    """Return the stow order of one item that starts from a scene.

    Args:
        scene: The scene.
        item: The item.

    Returns:
        The order, with nothing else in the tote.
    """
    contents = {name: tuple(p.item.name for p in scene.in_location(name)) for name in scene.cell.pod.bins}
    return Order(OrderKind.STOW, NEWEST, contents, (item.name,), ())


def _box(item: Item) -> float:
    """Volume of the box around an item, m^3."""
    return float(item.shape.extents.prod())


def _ranked(
    order: Order, cell: Cell, item: Item, taking: Mapping[str, float], rule: StowRule
) -> Iterator[str]:
    """Bins that are large enough for an item, the best first. taking: share filled with it, by bin."""
    rooms = {name: cell.places[name].room for name in taking}
    fitting = (name for name in taking if not rooms[name].too_small_for(item.shape.extents))

    def cost(name: str) -> tuple[bool, float, float, str]:
        points = float(target_points(order, name, item.name, {}))
        first = points if rule is StowRule.POINTS else round(1e3 * rooms[name].volume)
        return taking[name] > FULL_SHARE, -first, taking[name], name

    yield from sorted(fitting, key=cost)


def _why(order: Order, item: Item, bins: tuple[str, ...], taking: Mapping[str, float], rule: StowRule) -> str:
    """Explain why the first of its bins was chosen for an item."""
    if not bins:
        return "no bin is large enough for it"
    first = bins[0]
    what = f"{first} started with {len(order.bin_contents[first])}"
    if rule is StowRule.SIZE:
        what = f"{1e3 * _box(item):.1f} litres go to a bin of its size; {what}"
    text = f"{what}, {100 * taking[first]:.0f} % full with it"
    fuller = [
        name
        for name in bins
        if target_points(order, name, item.name, {}) > target_points(order, first, item.name, {})
    ]
    if rule is StowRule.POINTS and fuller:
        text += f"; {', '.join(fuller)} would be over {100 * FULL_SHARE:.0f} %"
    return text
