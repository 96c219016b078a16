"""Places in the tote: over the lowest pile, between the walls, never dropped from too high."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.collision.attached_item import AttachedItem
from pickcli.errors import Failures
from pickcli.geometry import Array, pose
from pickcli.planning.stages.drop_placements import (
    ABOVE_PILE,
    LEAST_WALL_DISTANCE,
    MAX_DROP,
    DropPlacement,
    drop_placements,
)
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from support.tool_states import DOWN, STRAIGHT

SceneWith = Callable[..., Scene]


@pytest.fixture
def held(cell: Cell) -> AttachedItem:
    """A box that hangs from the middle of its top."""
    item = cell.item("crayola_24_ct")
    return AttachedItem(
        item, pose([0.0, 0.0, float(item.shape.extents[2]) / 2], R=np.diag([1.0, -1.0, -1.0])), 0.003
    )


def piled(scene: Scene, *places: tuple[float, float, float]) -> Scene:
    """The scene with boxes that lie in the tote at (x, y) from its middle, their centres at z."""
    item, T_world_tote = scene.cell.item("crayola_24_ct"), scene.cell.places["tote"].T_carrier_place
    lying = tuple(PlacedItem(f"lying {i}", item, TOTE, T_world_tote @ pose(p)) for i, p in enumerate(places))
    return replace(scene, items=(*scene.items, *lying))


def box(T: Array, held: AttachedItem) -> tuple[Array, Array]:
    """Corners of the box along the world's axes around the released item."""
    reach = held.item.shape.reach(T[:3, :3]) + held.inflate
    return T[:3, 3] - reach, T[:3, 3] + reach


def found(scene: Scene, held: AttachedItem, tool_state: ToolState) -> tuple[DropPlacement, ...]:
    places = drop_placements(scene, scene.cell.places["tote"], held, tool_state)
    assert not isinstance(places, Failures) and places
    return places


def released_pose(spot: DropPlacement, held: AttachedItem) -> Array:
    """Pose (4, 4) in the world of the item at the moment of release."""
    return np.asarray(spot.release @ held.T_tip_item)


def test_what_is_moved_aside_does_not_come_to_lie_on_what_should_stay_uncovered(
    scene_with: SceneWith, held: AttachedItem
) -> None:
    """The floor is full: what would come to lie under the item by default does not have to."""
    heights = np.linspace(0.0, 0.01, 12)  # so that one place is the lowest
    at = [(x, y) for x in (-0.15, -0.05, 0.05, 0.15) for y in (-0.11, 0.0, 0.11)]
    scene = piled(scene_with(), *((x, y, float(z)) for (x, y), z in zip(at, heights, strict=True)))

    def covered(uncovered: frozenset[str]) -> frozenset[str]:
        spots = drop_placements(scene, scene.cell.places[TOTE], held, STRAIGHT, 1, uncovered)
        assert not isinstance(spots, Failures)
        low, high = box(released_pose(spots[0], held), held)
        lying = {p.id: p.T_world_item[:3, 3] for p in scene.in_location(TOTE)}
        return frozenset(
            n for n, p in lying.items() if (low[:2] <= p[:2]).all() and (p[:2] <= high[:2]).all()
        )

    usual = covered(frozenset())
    assert usual and not usual & covered(usual)


@pytest.mark.parametrize("tool_state", [STRAIGHT, DOWN])
def test_the_item_is_released_in_the_tote_and_above_all_that_lies_there(
    scene_with: SceneWith, held: AttachedItem, tool_state: ToolState
) -> None:
    scene = piled(scene_with(), (0.0, 0.0, 0.02), (0.1, 0.05, 0.05), (-0.15, 0.0, 0.08))
    tote = scene.cell.places[TOTE]
    walls = np.array(tote.room.size[:2]) / 2 - LEAST_WALL_DISTANCE
    assert len(scene.in_location(TOTE)) == 3
    for spot in found(scene, held, tool_state):
        low, high = box(released_pose(spot, held), held)
        middle = tote.T_carrier_place[:2, 3]
        assert np.all(low[:2] >= middle - walls - 1e-9) and np.all(high[:2] <= middle + walls + 1e-9)
        assert low[2] - tote.T_carrier_place[2, 3] <= MAX_DROP + 1e-9
        for lying in scene.in_location(TOTE):
            reach = lying.item.shape.reach(lying.T_world_item[:3, :3]) + scene.noise.bound(lying.item)
            is_under = np.all((lying.T_world_item[:3, 3] + reach)[:2] > low[:2]) and np.all(
                (lying.T_world_item[:3, 3] - reach)[:2] < high[:2]
            )
            if is_under:
                assert low[2] >= lying.T_world_item[2, 3] + reach[2] + ABOVE_PILE - 1e-9


def test_the_best_spot_is_beside_the_pile(scene_with: SceneWith, held: AttachedItem) -> None:
    empty = found(scene_with(), held, STRAIGHT)
    first = released_pose(empty[0], held)[:3, 3]
    floor = scene_with().cell.places["tote"].T_carrier_place
    x, y = (first - floor[:3, 3])[:2]
    other = found(piled(scene_with(), (x, y, 0.05)), held, STRAIGHT)
    assert other[0].cost == pytest.approx(empty[0].cost)
    moved = np.abs(released_pose(other[0], held)[:2, 3] - first[:2])
    assert moved.max() > 0.05


def test_what_is_too_large_does_not_fit(cell: Cell, scene_with: SceneWith) -> None:
    item = cell.item("crayola_24_ct")
    huge = replace(item, shape=replace(item.shape, size=(0.7, 0.7, 0.1)))
    scene, huge_held = scene_with(), AttachedItem(huge, pose(), 0.0)
    failures = drop_placements(scene, cell.places["tote"], huge_held, STRAIGHT)
    assert isinstance(failures, Failures)
    assert [reason.what for reason in failures] == ["does not fit between the walls"]  # said once


@pytest.mark.parametrize("tool_state", [STRAIGHT, DOWN])
def test_over_the_rim_nothing_is_between_the_walls_and_the_fall_is_allowed(
    scene_with: SceneWith, held: AttachedItem, tool_state: ToolState
) -> None:
    scene = scene_with()
    tote = scene.cell.places["tote"]
    rim = float((tote.T_carrier_place @ tote.access.T_place_mouth)[2, 3])
    floor = float(tote.T_carrier_place[2, 3]) + tote.room.floor_back
    spots = drop_placements(scene, tote, held, tool_state, over_rim=True)
    assert not isinstance(spots, Failures) and spots
    for spot in spots:
        low, _ = box(released_pose(spot, held), held)
        assert rim < low[2] <= floor + MAX_DROP + 1e-9
        assert np.array_equal(spot.above, spot.release)


def test_what_would_fall_too_far_from_over_the_rim_is_not_dropped_from_there(
    scene_with: SceneWith, held: AttachedItem, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pickcli.planning.stages.drop_placements.MAX_DROP", 0.2)
    scene = scene_with()
    tote = scene.cell.places["tote"]
    assert isinstance(drop_placements(scene, tote, held, STRAIGHT, over_rim=True), Failures)
    assert not isinstance(drop_placements(scene, tote, held, STRAIGHT), Failures)
