"""The final state of a trial: all that the rules judge, from the scenes before and after it."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.geometry import inverse
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.simulation.places import OUTSIDE, bounds
from pickcli.trial.damage import Damage
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.output_file import claim

HELD = "held"  # place of an item held by the tool at the end of the trial


@dataclass(frozen=True)
class FinalItem:
    """Final place of one instance. Places are bin names, TOTE, HELD or OUTSIDE.

    Attributes:
        id: Id of the instance.
        name: Name of the item.
        start: Place before the trial.
        end: Place after it.
        protrusion: m by which it protrudes from its bin, beyond the front face.
    """

    id: str
    name: str
    start: str
    end: str
    protrusion: float = 0.0


@dataclass(frozen=True)
class Drop:
    """One free fall of an item.

    Attributes:
        item: Its id.
        height: m.
        is_release: Whether it was released intentionally, over the tote.
    """

    item: str
    height: float
    is_release: bool = False


@dataclass(frozen=True)
class FinalState:
    """All quantities that the rules judge.

    Attributes:
        items: Final places of all items.
        claim: The task output file, or None.
        drops: Free falls of items.
        damages: Damaged items or the shelf, with grades.
    """

    items: tuple[FinalItem, ...]
    claim: Order | None = None
    drops: tuple[Drop, ...] = ()
    damages: tuple[tuple[str, Damage], ...] = ()


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
