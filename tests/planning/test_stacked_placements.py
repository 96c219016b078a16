"""What comes out of a box is set down on another item where no floor is free, and stays there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import ShapeKind
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, inverse, pose
from pickcli.motion.plan import Plan
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.stacked_placements import stacked_placements
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.simulation.settle import settle
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.release_check import check_release
from pickcli.verification.static_solids import release_pose
from pickcli.verification.verify import verify
from support.bin_piles import BIN, at, shaped

NOISE = PoseNoise(0.002, float(np.radians(1.0)))
ITEM = "dove_beauty_bar"
SLAB = (0.2, 0.28, 0.03)  # m, of what leaves no level floor free


def in_tote(cell: Cell) -> PlacedItem:
    """The bar, lying in the middle of the tote."""
    item, place = cell.item(ITEM), cell.places[TOTE]
    T = pose((0.0, 0.0, place.room.floor_back + item.shape.extents[2] / 2 + 0.0005))
    return PlacedItem(ITEM, item, TOTE, cell.T_world_place(place) @ T)


def over(cell: Cell, *below: PlacedItem) -> Scene:
    return Scene(cell, cell.T_world_pod, (in_tote(cell), *below), NOISE)


def slab(cell: Cell) -> PlacedItem:
    return at(cell, "slab", shaped(cell, SLAB), 0.331, 0.0, SLAB[2] / 2 + 0.0005)


def on_the_slope(cell: Cell) -> PlacedItem:
    """What leaves no floor free in front of the slab, and has no side on which a cup seals."""
    item = shaped(cell, (0.19, 0.28, 0.02))
    bare = replace(item, seals=dict.fromkeys(item.seals, 0.0))
    return at(cell, "front", bare, 0.12, 0.0, 0.0205, (0.0, float(np.radians(5.0)), 0.0))


def found(context: PlanningContext, scene: Scene, n_most: int = 8) -> tuple[PlacedItem, ...] | Failures:
    return stacked_placements(context, scene, scene.find(ITEM), np.eye(3), scene.cell.places[BIN], n_most)


def test_an_item_lies_just_over_the_other_and_stays_there(context: PlanningContext, cell: Cell) -> None:
    """Physics is the judge, too."""
    scene = over(cell, slab(cell))
    spots = found(context, scene, n_most=100)
    assert not isinstance(spots, Failures) and len(spots) > 10
    below, item = scene.find("slab"), cell.item(ITEM)
    apart = scene.noise.bound(item) + scene.noise.bound(below.item)
    for spot in spots:
        T = inverse(below.T_world_item) @ spot.T_world_item
        gap = T[2, 3] - SLAB[2] / 2 - item.shape.extents[2] / 2
        assert apart < gap < apart + 0.002 and spot.location == BIN
    for spot in (spots[0], spots[-1]):
        rested = settle(scene, (below, spot))
        assert not isinstance(rested, Reason)
        for before, after in zip((below, spot), rested, strict=True):
            moved = after.T_world_item[:3, 3] - before.T_world_item[:3, 3]
            assert np.linalg.norm(moved[:2]) < 0.004 and abs(moved[2]) < apart + 0.003


@pytest.mark.parametrize(
    ("size", "kind", "rpy"),
    [
        ((0.05,), ShapeKind.SPHERE, (0.0, 0.0, 0.0)),
        ((0.05, 0.2), ShapeKind.CYLINDER, (np.pi / 2, 0.0, 0.0)),
        ((0.2, 0.2, 0.06), ShapeKind.BOX, (0.3, 0.0, 0.0)),
    ],
)
def test_what_is_round_or_askew_bears_nothing(
    context: PlanningContext, cell: Cell, size: tuple[float, ...], kind: ShapeKind, rpy: tuple[float, ...]
) -> None:
    below = at(cell, "below", shaped(cell, size, kind), 0.27, 0.0, 0.07, rpy)
    spots = found(context, over(cell, below))
    assert isinstance(spots, Failures) and [reason.what for reason in spots] == ["no level top"]


def test_a_side_on_which_no_cup_seals_is_not_taken_to_exist(context: PlanningContext, cell: Cell) -> None:
    closed = slab(cell)
    item = replace(closed.item, seals=dict(closed.item.seals) | {"+z": 0.0})
    assert not isinstance(found(context, over(cell, closed)), Failures)
    assert isinstance(found(context, over(cell, replace(closed, item=item))), Failures)


def test_nothing_is_put_where_it_would_tip_what_bears_it(context: PlanningContext, cell: Cell) -> None:
    """A light board on a narrow block: only over the block."""
    block = at(cell, "block", shaped(cell, (0.06, 0.2, 0.05)), 0.32, 0.0, 0.0255)
    board = at(cell, "slab", shaped(cell, (0.22, 0.2, 0.01), mass=0.02), 0.32, 0.0, 0.056)
    scene = over(cell, block, board)
    spots = found(context, scene, n_most=100)
    assert not isinstance(spots, Failures) and spots
    off = [(inverse(block.T_world_item) @ spot.T_world_item)[0, 3] for spot in spots]
    assert max(map(abs, off)) < 0.03


@pytest.fixture(scope="module")
def stowed(context: PlanningContext, cell: Cell) -> tuple[Plan, Scene]:
    """The bar, on its way onto the slab."""
    scene, home = over(cell, slab(cell), on_the_slope(cell)), cell.configurations["home"]
    plan = plan_pick(context, scene, PickQuery(TOTE, ITEM, BIN), Start(home.q, home.tool_state), seed=1)
    return plan, scene


def released(plan: Plan, scene: Scene) -> tuple[int, Array, Array]:
    T_tip_item = pose_in_tool(plan, scene)
    assert T_tip_item is not None
    k = max(k for k, segment in enumerate(plan.segments) if segment.held is not None)
    return k, T_tip_item, release_pose(plan, scene, k, T_tip_item)


def test_a_stow_ends_on_the_item_below_and_the_verifier_accepts_it(stowed: tuple[Plan, Scene]) -> None:
    plan, scene = stowed
    _, _, T = released(plan, scene)
    top = scene.find("slab").T_world_item[2, 3] + SLAB[2] / 2
    assert top < T[2, 3] - scene.find(ITEM).item.shape.extents[2] / 2 < top + 0.015
    assert verify(plan, scene).certificate is not None


def test_a_release_over_the_other_item_or_without_it_is_refused(stowed: tuple[Plan, Scene]) -> None:
    plan, scene = stowed
    _, T_tip_item, T = released(plan, scene)
    assert check_release(plan, scene, T_tip_item) == ()
    higher = T_tip_item @ inverse(T) @ pose((0.0, 0.0, 0.02)) @ T
    for where, held in ((scene, higher), (scene.without("slab"), T_tip_item)):
        reasons = check_release(plan, where, held)
        assert "released too high" in [reason.what for reason in reasons]


def test_a_release_that_tips_what_is_below_is_refused(stowed: tuple[Plan, Scene]) -> None:
    """The board under it is borne by a block, under the bar or far beside it."""
    plan, scene = stowed
    _, T_tip_item, T = released(plan, scene)
    top = T[2, 3] - scene.find(ITEM).item.shape.extents[2] / 2 - 0.001
    T_world_place = scene.T_world_place(scene.cell.places[BIN])
    for aside, problem in ((0.0, []), (-0.07, ["would fall over"])):
        x, y = (T[:3, 3] + aside * T_world_place[:3, 0])[:2]
        under = []
        for name, size, middle in (("board", (0.2, 0.1, 0.01), 0.005), ("block", (0.05, 0.05, 0.3), 0.16)):
            there = pose((x, y, top - middle), R=T_world_place[:3, :3])
            under.append(PlacedItem(name, shaped(scene.cell, size, mass=0.02), BIN, there))
        reasons = check_release(plan, replace(scene, items=(in_tote(scene.cell), *under)), T_tip_item)
        assert [reason.what for reason in reasons] == problem


def test_what_may_have_turned_in_the_cup_is_let_go_higher(context: PlanningContext, cell: Cell) -> None:
    scene = over(cell, slab(cell))
    place = cell.places[BIN]
    low, high = (
        stacked_placements(context, scene, scene.find(ITEM), np.eye(3), place, 1, hover)
        for hover in (0.0, 0.004)
    )
    assert not isinstance(low, Failures) and not isinstance(high, Failures)
    assert high[0].T_world_item[2, 3] - low[0].T_world_item[2, 3] == pytest.approx(0.004, abs=1e-6)
