"""Where an item is let go, judged by physics: what lands there does not turn up towards the tool."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cartesian.line import shifted
from pickcli.cell.cell import Cell
from pickcli.cell.shapes import ShapeKind
from pickcli.collision.attached_item import AttachedItem
from pickcli.errors import Failures
from pickcli.geometry import Array, pose
from pickcli.planning.stages.drop_placements import ABOVE_PILE, DropPlacement, drop_placements
from pickcli.scene.colours import STATIC_COLOURS, item_colour
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from pickcli.simulation.engine import Engine
from pickcli.simulation.world import TIME_STEP
from pickcli.trial.pose_noise import DEFAULT_NOISE
from support.tool_states import DOWN

LONG = "creativity_chenille_stems"
ALONG = np.array([1.0, 0.0, 0.0])  # the tote's long side
WIDE = (0.34, 0.54, 0.2)  # m: a box that fills most of the tote, up to its rim
CLEAR = 0.02  # m over the tip at release, from where the lance is met
WATCHED = 0.6  # s
LOOK = 10  # time steps


def hanging(cell: Cell, name: str) -> AttachedItem:
    """An item that hangs level from the middle of its top."""
    item = cell.item(name)
    return AttachedItem(
        item, pose([0.0, 0.0, float(item.shape.extents[2]) / 2], R=np.diag([1.0, -1.0, -1.0])), 0.003
    )


def lying(cell: Cell, T_world_dropped: Array, aside: float) -> PlacedItem:
    """A roll in the tote, across what is dropped, its axis so far aside of the middle."""
    item, T_world_tote = cell.item("kleenex_paper_towels"), cell.places[TOTE].T_carrier_place
    along = T_world_dropped[:3, 0]
    across = np.array([-along[1], along[0], 0.0])
    R = np.stack([along, np.array([0.0, 0.0, -1.0]), across], axis=1)
    R[:, 1] *= np.sign(np.linalg.det(R))
    at = T_world_dropped[:3, 3] + aside * along
    at[2] = T_world_tote[2, 3] + item.shape.reach(R)[2] + 0.001
    return PlacedItem("roll", item, TOTE, pose(at, R=R))


def risen(cell: Cell, spot: DropPlacement, held: AttachedItem, below: PlacedItem) -> float:
    """Height in the world of the highest point that an item gets to, let go over another one."""
    engine, highest = Engine(TIME_STEP), -np.inf
    try:
        for body in cell.tote_bodies:
            engine.add_static(body, np.eye(4), STATIC_COLOURS[TOTE])
        engine.add_item(below.id, below.item, below.T_world_item, item_colour(below.item))
        engine.add_item("dropped", held.item, spot.release @ held.T_tip_item, item_colour(held.item))
        for n in range(round(WATCHED / TIME_STEP)):
            engine.step()
            if n % LOOK == 0:
                T = engine.pose("dropped")
                highest = max(highest, float(T[2, 3] + held.item.shape.reach(T[:3, :3])[2]))
    finally:
        engine.close()
    return highest


def best_spot(scene: Scene, held: AttachedItem) -> DropPlacement:
    """The best placement over what lies in the tote."""
    spots = drop_placements(scene, scene.cell.places[TOTE], held, DOWN)
    assert not isinstance(spots, Failures)
    return spots[0]


def top(placed: PlacedItem) -> float:
    """Height in the world of the highest point of an item, m."""
    return float(placed.T_world_item[2, 3] + placed.item.shape.reach(placed.T_world_item[:3, :3])[2])


@pytest.mark.parametrize("aside", [-0.03, 0.0, 0.03])
def test_what_lands_on_a_roll_does_not_turn_up(cell: Cell, aside: float) -> None:
    """The roll fills the tote's width: whatever is longer than the room beside it is let go over it.

    Let go beside the middle at that height it turns over, but below the tool.
    """
    held = hanging(cell, LONG)
    middle = cell.places[TOTE].T_carrier_place[:3, 3]
    roll = lying(cell, pose(middle), aside)
    spot = best_spot(Scene(cell, cell.T_world_pod, (roll,), DEFAULT_NOISE), held)
    assert risen(cell, spot, held, roll) < spot.release[2, 3] + CLEAR
    beside = shifted(spot.release, 0.06 * ALONG)
    assert risen(cell, replace(spot, release=beside), held, roll) < beside[2, 3] + CLEAR
    low = beside.copy()  # as low as over what it cannot turn over on
    low[2, 3] = top(roll) + ABOVE_PILE + held.item.shape.extents[2]
    assert risen(cell, replace(spot, release=low), held, roll) > low[2, 3] + CLEAR  # else nothing is judged


def test_what_lands_on_a_wide_box_is_released_low(cell: Cell) -> None:
    held, T_world_tote = hanging(cell, "dove_beauty_bar"), cell.places[TOTE].T_carrier_place
    item = cell.item("folgers_classic_roast_coffee")
    wide = replace(item, shape=replace(item.shape, kind=ShapeKind.BOX, size=WIDE))
    at = T_world_tote[:3, 3] + [0.0, 0.0, WIDE[2] / 2]
    block = PlacedItem("block", wide, TOTE, pose(at, R=T_world_tote[:3, :3]))
    spot = best_spot(Scene(cell, cell.T_world_pod, (block,), DEFAULT_NOISE), held)
    lowest = (spot.release @ held.T_tip_item)[2, 3] - held.item.shape.reach(spot.release[:3, :3])[2]
    assert lowest - top(block) < ABOVE_PILE + 0.01
