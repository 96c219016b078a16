"""Contacts of items with hollows by the convex solids that they consist of, as they are simulated.

By its outer shape, an item that lies in the hollow of another, or under it, overlaps that one; and one whose
hollow is open to the side touches the ground with edges that are not there.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pickcli.cell.hollow_body import solids_of
from pickcli.cell.shapes import Shape
from pickcli.geometry import Array
from pickcli.scene.solid_overlap import TOUCH
from pickcli.scene.touching import PosedSolids, gaps
from pickcli.statics.contact_graph import ContactGraph
from pickcli.statics.patches import feature, patch
from pickcli.statics.solid_contact import SolidContact


def is_of_hollow(graph: ContactGraph, contact: SolidContact) -> bool:
    """Tell whether one of two solids that touch is an item with hollows.

    Args:
        graph: The contacts of the scene.
        contact: The contact.

    Returns:
        True if one is; False also of solids that do not touch by their outer shapes, but are taken to.
    """
    return contact.gap <= _reach(graph, contact) and any(
        name in graph.items and graph.items[name].item.hollows for name in (contact.a, contact.b)
    )


def hollow_patches(graph: ContactGraph, contact: SolidContact, askew: float) -> Iterator[tuple[Array, Array]]:
    """Find where the parts of two solids meet, of which at least one has hollows.

    Args:
        graph: The contacts of the scene.
        contact: Their contact by the outer shapes.
        askew: rad by which faces that are in contact may be misaligned.

    Yields:
        Corners (N, 3) m of a patch in the world, and the normal (3,) from a to b there.
    """
    ours, theirs = _solids(graph, contact.a), _solids(graph, contact.b)
    every = PosedSolids.standing([*ours, *theirs])
    a, b = (axis.ravel() for axis in np.meshgrid(np.arange(len(ours)), len(ours) + np.arange(len(theirs))))
    found = gaps(every, a, b)
    for k in np.flatnonzero(found.width <= _reach(graph, contact)):
        normal, (i, j) = found.normal[k], (found.a[k], found.b[k])
        mine = feature(every.shapes[i], every.T[i], normal, askew)
        yield patch(mine, feature(every.shapes[j], every.T[j], -normal, askew), normal, 0.0), normal


def _reach(graph: ContactGraph, contact: SolidContact) -> float:
    """Gap, m, up to which two solids touch within the errors of their poses."""
    return TOUCH + sum(float(graph.solids.bound[graph.index[name]]) for name in (contact.a, contact.b))


def _solids(graph: ContactGraph, name: str) -> list[tuple[Shape, Array]]:
    """The convex solids of an item or body, with their poses (4, 4) in the world."""
    if name in graph.items:
        placed = graph.items[name]
        return [(part.shape, placed.T_world_item @ part.T_parent_shape) for part in solids_of(placed.item)]
    k = graph.index[name]
    return [(graph.solids.shapes[k], graph.solids.T[k])]
