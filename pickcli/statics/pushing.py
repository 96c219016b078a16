"""Pushing neighbours aside in an open box: which a lifted item may push, and which ride on it.

Nothing falls far between the walls of an open box, so an item that slides or tips there does no harm. What
lies on the lifted item with its centre over it does not slide off, but is carried along.
"""

from __future__ import annotations

import numpy as np

from pickcli.statics.supports import Supports

# kg at most that a pushed item has. Dragged along the floor and the lifted item, with a friction of 0.5 on
# both, it resists by at most its weight, 6 N: a third of the pull that a cup keeps in reserve as it pushes.
HEAVIEST = 0.6
RIDER_MARGIN = 0.01  # m beyond the edge of the lifted item, besides both pose errors, that count as over it
N_DIRECTIONS = 32  # horizontal ones, in which an item may be beside the lifted one


def pushable(supports: Supports, item_id: str) -> frozenset[str]:
    """Find the items that may be pushed aside when an item is lifted out of an open box.

    They are light, and lie so low that they stay in the box wherever they slide; and so is all that lies on
    them and moves with them.

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
    firm = {
        name
        for name, placed in here.items()
        if placed.item.heaviest > HEAVIEST or supports.highest_centre(name) >= rim
    }
    below = {name for each in firm for name in graph.chain(graph.carriers, each)}
    return frozenset(here.keys() - firm - below)


def riders(supports: Supports, item_id: str) -> tuple[str, ...]:
    """Find the items that a lifted item would carry along: they lie on it, with their centre over it.

    Args:
        supports: The support relation of the scene.
        item_id: Id of the lifted item.

    Returns:
        Ids, in the order in which they must be moved away.
    """
    lying = supports.graph.chain(supports.graph.lying_on, item_id)
    return tuple(
        name for name in supports.falling(item_id) if name in lying and _is_over(supports, name, item_id)
    )


def mass_lying_on(supports: Supports, item_id: str) -> float:
    """Return the mass of all that lies on an item, directly or through others, wholly or partly.

    Args:
        supports: The support relation of the scene.
        item_id: Id of the item.

    Returns:
        kg at most.
    """
    graph = supports.graph
    lying = sorted(graph.chain(graph.lying_on, item_id))
    return sum(graph.items[name].item.heaviest for name in lying)


def _is_over(supports: Supports, name: str, lower: str) -> bool:
    """Whether the centre of an item may be over another one, given both pose errors, or nearly is."""
    solids, index = supports.graph.solids, supports.graph.index
    k, i = index[lower], index[name]
    turn = 2.0 * np.pi * np.arange(N_DIRECTIONS) / N_DIRECTIONS
    directions = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(N_DIRECTIONS)])
    edges = solids.half_widths(np.array([k]), directions[None])[0]
    off = directions @ (solids.T[i, :3, 3] - solids.T[k, :3, 3])
    return bool((off <= edges + solids.bound[k] + solids.bound[i] + RIDER_MARGIN).all())
