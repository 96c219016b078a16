"""Where an item is let go: in a place, low enough over its floor, and so that it stays."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pickcli.geometry import Array, inverse, pose
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.verification.release_check import check_release
from support.cell_copies import CellCopy
from support.handmade_plans import CRAYOLA, cell, crayola_scene, pick, tip
from support.place_cells import BENCH, with_places
from support.plan_mutations import segment

SIZE = cell().item(CRAYOLA).shape.size


def told(scene: Scene, place: str, T_place_item: Array) -> list[str]:
    """What is wrong where the pick lets its item go at a pose (4, 4) in the frame of a place."""
    plan, _ = pick()
    put = plan.segments[segment(plan, SegmentKind.PLACE)]
    T_world_tip = tip(plan.trajectory.sample(put.t_end)[0])
    T = scene.T_world_place(scene.cell.places[place]) @ T_place_item
    return [reason.what for reason in check_release(plan, scene, inverse(T_world_tip) @ T)]


@pytest.mark.parametrize("noise", [0.0, 0.004])
def test_an_item_is_set_down_wholly_in_a_bin_and_just_over_its_floor(noise: float) -> None:
    scene = crayola_scene(PoseNoise(noise, 0.0))
    room = scene.cell.places["bin_H"].room
    flat, high = room.floor_flat_from, room.floor_back + SIZE[2] / 2
    for over, problem in (
        (1e-4, []), (0.0199 + noise, []), (0.0201 + noise, ["released too high"]),
    ):  # fmt: skip
        there = pose((flat + SIZE[0], 0.0, high + over))
        assert told(scene, "bin_H", there) == problem
    half = SIZE[0] / 2
    front = room.floor_front + SIZE[2] / 2 + 1e-4
    for x, problem in ((half + 1e-4, []), (half - 1e-4, ["released beyond the bin's mouth"])):
        found = told(scene, "bin_H", pose((x, 0.0, front)))
        assert [what for what in found if "mouth" in what] == problem


def test_an_item_stays_as_it_is_set_down() -> None:
    """On its broad side or on end, but not on an edge."""
    scene = crayola_scene()
    room = scene.cell.places["bin_H"].room
    x = room.floor_flat_from + SIZE[0]
    for rpy, half, problem in (
        ((0.0, 0.0, 0.3), SIZE[2] / 2, []),
        ((0.0, 1.5707963, 0.0), SIZE[0] / 2, []),
        ((0.0, 0.6, 0.0), SIZE[0] / 2 * 0.5646 + SIZE[2] / 2 * 0.8253, ["would fall over"]),
    ):
        T = pose((x, 0.0, room.floor_back + half + 2e-4), rpy=rpy)
        assert told(scene, "bin_H", T) == problem


def test_an_item_is_set_down_wholly_on_a_table(cell_copy: CellCopy) -> None:
    own = with_places(cell_copy, "places:\n", BENCH).load()
    scene = replace(crayola_scene(), cell=own)
    room = own.places["bench"].room
    edge = room.high[:2]
    for over, problem in ((1e-4, []), (0.0199, []), (0.0201, ["released too high"])):
        assert told(scene, "bench", pose((0.0, 0.0, SIZE[2] / 2 + over))) == problem
    for beyond, problem in ((-1e-4, []), (1e-4, ["released beyond the bench's edge"])):
        for x, y in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
            at = (x * (edge[0] - SIZE[0] / 2 + beyond), y * (edge[1] - SIZE[1] / 2 + beyond))
            assert told(scene, "bench", pose((*at, SIZE[2] / 2 + 1e-4))) == problem


def test_what_is_carried_is_let_go_once_and_what_is_not_is_not() -> None:
    plan, scene = pick()
    T = pose()
    never = replace(plan, segments=tuple(replace(s, held=None) for s in plan.segments))
    assert [reason.what for reason in check_release(never, scene, T)] == ["never released"]
    carried = replace(plan, segments=(replace(plan.segments[0], held=CRAYOLA),))
    assert check_release(carried, scene, T) == ()
    assert check_release(replace(never, grasp=None), scene, T) == ()
    assert check_release(never, scene, None) == ()
