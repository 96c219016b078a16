"""Computes the final state for the rules from the scenes before and after a trial."""

from __future__ import annotations

from pickcli.geometry import inverse
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.simulation.places import OUTSIDE, bounds
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.output_file import claim
from pickcli.trial.score import HELD, Damage, Drop, FinalItem, FinalState


def final_state(
    order: Order,
    before: Scene,
    after: Scene,
    belief: Scene,
    held: str | None,
    drops: tuple[Drop, ...],
    damages: tuple[tuple[str, Damage], ...] = (),
) -> FinalState:
    """Collect the quantities that the rules judge after a trial.

    Args:
        order: The order that was played.
        before: The true scene before the trial.
        after: The true scene after it, without the held item.
        belief: The last perceived scene, which is claimed in the output file.
        held: Id of the held item, or None.
        drops: Free falls of items.
        damages: Damaged items, or the shelf, with grades.

    Returns:
        The final state.
    """
    now = {placed.id: placed for placed in after.items}
    items = []
    for placed in before.items:
        there = now.get(placed.id)
        end = HELD if placed.id == held else OUTSIDE if there is None else there.location
        out = 0.0 if there is None or not after.cell.pod.bins else protrusion(after, there)
        items.append(FinalItem(placed.id, placed.item.name, placed.location, end, out))
    claimed = None if order.kind is OrderKind.MOVE else claim(order, belief.items)
    return FinalState(tuple(items), claimed, drops, damages)


def protrusion(scene: Scene, placed: PlacedItem) -> float:
    """Compute how far an item protrudes from the plane of the pod's front face.

    Args:
        scene: The scene, for the pose of the pod.
        placed: The item.

    Returns:
        m; 0 if it does not protrude.
    """
    lower, _ = bounds(placed.item.shape, inverse(scene.T_world_pod) @ placed.T_world_item)
    return max(0.0, -float(lower[0]))
