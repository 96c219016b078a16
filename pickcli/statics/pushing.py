"""Pushing neighbours aside in an open box: which a lifted item may push, and which ride on it.

Nothing falls far between the walls of an open box, so an item that slides or tips there does no harm. What
lies on the lifted item with its centre over it does not slide off, but is carried along.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from functools import partial

import numpy as np

from pickcli.scene.touching import gaps
from pickcli.statics.supports import Supports

# kg at most that a pushed item has. Dragged along the floor and the lifted item, with a friction of 0.5 on
# both, it resists by at most its weight, 6 N: a third of the pull that a cup keeps in reserve as it pushes.
HEAVIEST = 0.6
MARGIN = 0.002  # m, besides both pose errors, by which an item beside or below another counts as over it
REARING_RISE = 0.015  # m by which friction may lift an item that rears up beside the lifted one
UPRIGHT = 1e-3  # vertical part of a unit normal that rounding leaves it
N_DIRECTIONS = 36  # horizontal ones, in which an item may be beside the lifted one


def pushable(supports: Supports, item_id: str) -> frozenset[str]:
    """Find the items that may be pushed aside when an item is lifted out of an open box.

    They are light, and lie so low that they stay in the box wherever they slide; and so is all that lies on
    them and moves with them. None touches, directly or through others, what could fall over the rim: several
    that are pushed at once may be what keeps it from falling.

    Args:
        supports: The support relation of the scene.
        item_id: Id of the lifted item.

    Returns:
        Ids; empty if the item is not in an open box.
    """
    rim, graph = supports.rim(item_id), supports.graph
    if rim is None:
        return frozenset()
    here = {
        placed.id: placed
        for placed in graph.scene.in_location(graph.items[item_id].location)
        if placed.id != item_id
    }
    high = {name for name in here if supports.highest_centre(name) >= rim}
    firm = high | {name for name, placed in here.items() if placed.item.heaviest > HEAVIEST}
    below = {name for each in firm for name in graph.chain(partial(_may_bear, supports), each)}
    leaving = [name for name in sorted(high) if supports.may_leave_over(rim, name)]
    return frozenset(here.keys() - firm - below - _tied_to(supports, leaving, here.keys() - {item_id}))


def _tied_to(supports: Supports, some: Collection[str], within: Collection[str]) -> frozenset[str]:
    """Return what touches some items, directly or through others of a set of ids."""
    return frozenset(
        name
        for each in some
        for name in supports.graph.chain(
            lambda item_id: (c.b for c in supports.graph.touching[item_id] if c.b in within), each
        )
    )


def riders(supports: Supports, item_id: str) -> tuple[str, ...]:
    """Find the items that a lifted item would carry along: those on it or higher with their centre over it.

    Args:
        supports: The support relation of the scene.
        item_id: Id of the lifted item.

    Returns:
        Ids, the highest first: the order in which they must be moved away.
    """
    return tuple(name for name in _above(supports, item_id) if _is_over(supports, name, item_id))


def mass_above(supports: Supports, item_id: str) -> float:
    """Return the mass of all that a lifted item may have to bear as it slides off.

    That is what lies on it, directly or through others, wholly or partly, and what it would meet above it.

    Args:
        supports: The support relation of the scene.
        item_id: Id of the item.

    Returns:
        kg at most.
    """
    graph, met = supports.graph, _met_above(supports, item_id)
    borne = set(met).union(*(_lying_on(supports, name) for name in met)) - {item_id}
    return sum(graph.items[name].item.heaviest for name in sorted(borne))


def pushed_height(supports: Supports, item_id: str) -> float:
    """Return how high the items are that a lifted one may push, or may become.

    One that slides off it, or leans on it as it rises, is lifted by one side; at worst it stands on a corner.

    Args:
        supports: The support relation of the scene.
        item_id: Id of the lifted item.

    Returns:
        m in the world; minus infinity if there are none.
    """
    graph, solids = supports.graph, supports.graph.solids
    indices = [graph.index[name] for name in sorted(pushable(supports, item_id))]
    heights = [-np.inf, *(float(solids.T[k, 2, 3] + solids.upright[k, 2] + solids.bound[k]) for k in indices)]
    for name in _met_above(supports, item_id):
        placed, k = graph.items[name], graph.index[name]
        bottom = float(placed.T_world_item[2, 3] - solids.upright[k, 2] + solids.bound[k])
        heights.append(bottom + float(np.linalg.norm(placed.item.shape.extents)) + REARING_RISE)
    return max(heights)


def _met_above(supports: Supports, item_id: str) -> list[str]:
    """Return what a lifted item takes along by one side at least: what lies on it, or partly over it."""
    lying = _lying_on(supports, item_id)
    return [
        name
        for name in _above(supports, item_id)
        if name in lying
        or (_is_over(supports, name, item_id, partly=True) and not _is_beside(supports, name, item_id))
    ]


def _is_beside(supports: Supports, name: str, lower: str) -> bool:
    """Whether an item passes another one as it rises: an upright plane, or one under that, divides them.

    Solids are convex. Within the errors of their poses the plane counts as upright, and as dividing them.
    """
    scene, items, solids = supports.graph.scene, supports.graph.items, supports.graph.solids
    k, i = supports.graph.index[lower], supports.graph.index[name]
    found = gaps(solids, np.array([k]), np.array([i]))
    angle = scene.noise_of(items[lower]).angle + scene.noise_of(items[name]).angle
    divides = found.width[0] >= -(solids.bound[k] + solids.bound[i] + MARGIN)
    return bool(divides and found.normal[0, 2] <= np.sin(angle) + UPRIGHT)


def _may_bear(supports: Supports, item_id: str) -> Iterator[str]:
    """Yield what an item rests on, and what it may touch that is lower than all of it.

    Across an edge, which way a contact within the errors of poses bears is not known.
    """
    graph, solids = supports.graph, supports.graph.solids
    heights, half, k = solids.T[:, 2, 3], solids.upright[:, 2], graph.index[item_id]
    for contact in graph.touching[item_id]:
        i = graph.index[contact.b]
        if contact.carries or heights[i] + half[i] <= heights[k] - half[k]:
            yield contact.b


def _lying_on(supports: Supports, item_id: str) -> frozenset[str]:
    return supports.graph.chain(supports.graph.lying_on, item_id)


def _above(supports: Supports, item_id: str) -> list[str]:
    """Return what lies on an item, and what may be pushed and be higher, the highest first.

    What carries it is below the plane of that contact, also where its centre is the higher one.
    """
    solids, index, lying = supports.graph.solids, supports.graph.index, _lying_on(supports, item_id)
    heights = {name: float(solids.T[k, 2, 3] + solids.bound[k]) for name, k in index.items()}
    k = index[item_id]
    least = float(solids.T[k, 2, 3] - solids.bound[k]) - MARGIN
    higher = {name for name in pushable(supports, item_id) if heights[name] > least}
    higher -= {*supports.graph.carriers(item_id)}
    return sorted(higher | lying, key=lambda name: (-heights[name], name))


def _is_over(supports: Supports, name: str, lower: str, partly: bool = False) -> bool:
    """Whether the centre, or any part, of an item may be over or under another one, or nearly is."""
    solids, index = supports.graph.solids, supports.graph.index
    k, i = index[lower], index[name]
    turn = 2.0 * np.pi * np.arange(N_DIRECTIONS) / N_DIRECTIONS
    directions = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(N_DIRECTIONS)])
    lower_edges, edges = solids.half_widths(np.array([k, i]), np.stack([directions, directions]))
    off = directions @ (solids.T[i, :3, 3] - solids.T[k, :3, 3])
    reach = lower_edges + solids.bound[k] + solids.bound[i] + MARGIN
    return bool((off <= (reach + edges if partly else reach)).all())
