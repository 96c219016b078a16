"""What nobody recognised, beside an item: it may lie or lean on it, and would fall with it."""

from __future__ import annotations

import numpy as np

from pickcli.scene.scene import Scene
from pickcli.scene.solid_overlap import TOUCH
from pickcli.scene.touching import PosedSolids, gaps

# m, besides the error of the item's pose: what hangs over an edge is seen down to a pixel beside the item,
# and the verifier measures distances by other means
REACH = 2.0 * TOUCH
NOT_RECOGNISED = "not recognised"  # why nothing is taken that touches it, in the words of a reason


def unrecognised_at(scene: Scene, item_id: str) -> tuple[str, ...]:
    """Find what nobody recognised and an item may touch, within the error of its pose.

    How it lies is not known, nor how far it reaches where it is hidden. So it may rest on the item, lean on
    it, or be balanced by its weight, wherever it touches it.

    Args:
        scene: Items, and unknown space with boxes in which something is that nobody recognised, or may be.
        item_id: Id of the item.

    Returns:
        Names of these boxes, the nearest first.
    """
    placed = scene.find(item_id)
    bodies = scene.unrecognised_in(placed.location)
    if not bodies:
        return ()
    solids = PosedSolids.of(scene, (placed,), tuple((body, np.eye(4)) for body in bodies))
    boxes = np.arange(1, len(solids.names))
    found = gaps(solids, np.zeros(len(boxes), dtype=np.intp), boxes).width
    order = np.argsort(found, kind="stable")
    return tuple(solids.names[1 + k] for k in order if found[k] <= REACH + solids.bound[0])
