"""Where the item is let go: in the tote, below the drop limit, or in a bin, just over its floor."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from pickcli.scene.supports import supports_of
from pickcli.verification.contact_exemptions import releases
from pickcli.verification.static_solids import bin_at, release_pose

DROP_LIMIT = 0.3  # m from the item's bottom to the tote's floor (rules of 2016)
SET_DOWN = 0.02  # m from its bottom to the floor of a bin, on top of its uncertainty: it must not tumble


def check_release(plan: Plan, scene: Scene, T_tip_item: Array | None) -> tuple[Reason, ...]:
    """Check where the item is let go.

    Args:
        plan: The plan.
        scene: The plan's scene.
        T_tip_item: (4, 4) the item in the tool frame where one is held.

    Returns:
        The faults; () where nothing is let go.
    """
    if plan.grasp is None or T_tip_item is None:
        return ()
    ends = releases(plan)
    if plan.segments[-1].held is None and not ends:
        return (Reason("never released", plan.grasp.item, "the item is not brought anywhere"),)
    return tuple(reason for k in ends for reason in _at(plan, scene, k, T_tip_item))


def _at(plan: Plan, scene: Scene, k: int, T_tip_item: Array) -> Iterable[Reason]:
    assert plan.grasp is not None
    T = release_pose(plan, scene, k, T_tip_item)
    where = bin_at(scene, T)
    placed = PlacedItem(plan.grasp.item, scene.item(plan.grasp.item), where or TOTE, T)
    return _in_tote(scene, placed) if where is None else (*_in_bin(scene, placed), *_tumbles(scene, placed))


def _tumbles(scene: Scene, placed: PlacedItem) -> Iterator[Reason]:
    """What is let go stays as it is set down: by the support relation, with the item where it is let go."""
    others = scene.without(placed.id).items
    there = replace(scene, items=(*others, placed), held=None)
    supports = supports_of(there)
    if not supports.stays(placed.id) and not supports.lies_level(placed.id):
        on = ", ".join(supports.carriers(placed.id)) or "nothing"
        detail = f"it does not keep its balance in {placed.location} on what it is let go on ({on})"
        yield Reason("would fall over", placed.id, detail)


def _in_tote(scene: Scene, placed: PlacedItem) -> Iterator[Reason]:
    tote = scene.cell.tote
    if tote is None:
        yield Reason("released outside of every place", placed.id, "the cell has no tote")
        return
    T = inverse(tote.place.T_carrier_place) @ placed.T_world_item
    reach = placed.item.shape.reach(T[:3, :3])
    low, high = T[:3, 3] - reach, T[:3, 3] + reach
    half = np.array(tote.place.room.size[:2]) / 2
    beyond = float(np.maximum(high[:2] - half, -half - low[:2]).max())
    if beyond > 0.0:
        yield Reason("released beyond the tote's walls", placed.id, f"by {beyond * 1e3:.0f} mm")
    if low[2] > DROP_LIMIT:
        yield Reason(
            "released too high", placed.id, f"{low[2]:.3f} m over the floor, the limit is {DROP_LIMIT}"
        )


def _in_bin(scene: Scene, placed: PlacedItem) -> Iterator[Reason]:
    bin_name = placed.location
    cell_bin = scene.cell.pod.bins[bin_name]
    T = inverse(scene.T_world_place(cell_bin)) @ placed.T_world_item
    reach = placed.item.shape.reach(T[:3, :3])
    low = T[:3, 3] - reach
    if low[0] < 0.0:
        out = f"{-low[0] * 1e3:.0f} mm out of {bin_name}"
        yield Reason("released beyond the bin's mouth", placed.id, out)
    floor = float(cell_bin.room.floor_at(low[0] + 2 * reach[0]))
    most = SET_DOWN + scene.noise.bound(placed.item)
    if low[2] - floor > most:
        over = f"{1e3 * (low[2] - floor):.0f} mm over the floor of {bin_name}, at most {most * 1e3:.0f}"
        yield Reason("released too high", placed.id, over)
