"""Where a query states a place, the item is set down there: among others, on them, or not at all."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.schemas.items_text import items_text
from pickcli.errors import NoPlanError
from pickcli.geometry import inverse
from pickcli.motion.plan import Plan
from pickcli.motion.plan_file import read_plan
from pickcli.palletizing.carton_item import carton_item
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery, StatedPlace
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_file import write_scene
from pickcli.verification.release_check import check_release
from pickcli.verification.verify import certifier
from support.command_line import apc, misused, refused
from support.pallet_stacks import CARTONS, station

MILK = CARTONS[0]
ON_THE_DECK = StatedPlace(-0.1, 0.05, 0.1)
EXACT = PoseNoise()


@cache
def context() -> PlanningContext:
    return PlanningContext(station().cell)


def standing(name: str, place: StatedPlace, where: str = "pallet") -> PlacedItem:
    cell = station().cell
    T = cell.T_world_place(cell.places[where]) @ place.T_place_item
    return PlacedItem(name, station().items[name], where, T)


def scene_with(*others: PlacedItem, noise: PoseNoise = EXACT) -> Scene:
    coming = station().presented(MILK)
    return replace(station().empty(0), items=(coming, *others), noise=noise)


def planned(scene: Scene, at: StatedPlace) -> Plan:
    home = context().cell.home
    query = PickQuery("infeed", MILK.id, "pallet", at=at)
    return plan_pick(context(), scene, query, Start(home.q, home.tool_state), certify=certifier(scene))


def released(plan: Plan, scene: Scene) -> np.ndarray:
    """(4, 4) pose of the item in the frame of the pallet where it is let go."""
    assert plan.grasp is not None
    held = [segment for segment in plan.segments if segment.held is not None]
    q = plan.trajectory.sample(held[-1].t_end)[0]
    T_world_item = context().arm.tip(q, context().cell.home.tool_state) @ inverse(plan.grasp.T_item_tip)
    return np.asarray(inverse(scene.T_world_place(context().cell.places["pallet"])) @ T_world_item)


@pytest.mark.parametrize("yaw", [0.0, np.pi / 2])
def test_an_item_is_let_go_a_little_over_the_place_that_is_stated(yaw: float) -> None:
    scene = scene_with()
    plan = planned(scene, replace(ON_THE_DECK, yaw=yaw))
    T = released(plan, scene)
    assert np.abs(T[:2, 3] - (-0.1, 0.05)).max() < 1e-3 and 0.0 < T[2, 3] - 0.1 < 0.003
    assert abs(np.arctan2(T[1, 0], T[0, 0]) - yaw) < 0.01
    stated = f"-100.0,50.0,100.0 mm and {np.degrees(yaw):.1f} deg"
    assert plan.query == f"pick milk_1 from infeed into pallet at {stated}"


def test_it_is_set_down_between_others_from_over_their_tops() -> None:
    """With 12 mm on two sides, and errors of 1 mm and 0.2 degrees."""
    beside = (
        standing("milk_2", StatedPlace(-0.1, -0.162, 0.1)),
        standing("crisps", StatedPlace(0.262, 0.05, 0.1)),
    )
    scene = scene_with(*beside, noise=PoseNoise(0.001, 0.0035))
    T = released(planned(scene, ON_THE_DECK), scene)
    assert np.abs(T[:2, 3] - (-0.1, 0.05)).max() < 1e-3


def test_it_is_set_down_on_two_others_though_either_alone_would_bear_it() -> None:
    below = standing("crisps", StatedPlace(-0.1, 0.05, 0.1)), standing("milk_2", StatedPlace(0.2, 0.05, 0.1))
    scene = scene_with(*below)
    T = released(planned(scene, StatedPlace(0.0, 0.05, 0.3)), scene)
    assert 0.0 < T[2, 3] - 0.3 < 0.003


@pytest.mark.parametrize(
    ("beside", "at", "told"),
    [
        (StatedPlace(-0.1, 0.252, 0.1), ON_THE_DECK, "the stated place is not free"),
        (StatedPlace(-0.1, 0.05, 0.1), StatedPlace(0.06, 0.05, 0.3), "would fall over"),
        (StatedPlace(0.2, -0.19, 0.1), StatedPlace(-0.1, 0.05, 0.2), "nothing is below the stated place"),
        (StatedPlace(0.2, -0.19, 0.1), StatedPlace(-0.1, 0.21, 0.1), "over the edge.*by 10.0 mm"),
    ],
)
def test_a_place_where_it_cannot_stand_is_refused(beside: StatedPlace, at: StatedPlace, told: str) -> None:
    with pytest.raises(NoPlanError, match=told):
        planned(scene_with(standing("milk_2", beside)), at)


@pytest.mark.parametrize(
    ("at", "told"),
    [
        ("-100.0,50.0,100.0 mm and 0.0 deg", []),
        ("-104.0,50.0,100.0 mm and 0.0 deg", ["not set down as stated"]),
        ("-100.0,50.0,60.0 mm and 0.0 deg", ["not set down as stated"]),
        ("-100.0,50.0,100.0 mm and 90.0 deg", ["not set down as stated"]),
    ],
)
def test_the_verifier_compares_the_release_with_the_stated_place(at: str, told: list[str]) -> None:
    scene = scene_with()
    plan = planned(scene, ON_THE_DECK)
    assert plan.grasp is not None
    query = f"pick milk_1 from infeed into pallet at {at}"
    changed = replace(plan, query=query)
    assert [r.what for r in check_release(changed, scene, inverse(plan.grasp.T_item_tip))] == told


def test_the_verifier_refuses_another_place_than_the_stated_one() -> None:
    scene = scene_with()
    plan = planned(scene, ON_THE_DECK)
    assert plan.grasp is not None
    changed = replace(plan, query=plan.query.replace("into pallet", "into infeed"))
    found = check_release(changed, scene, inverse(plan.grasp.T_item_tip))
    assert [r.what for r in found] == ["not set down as stated"]


def test_a_place_is_stated_on_the_command_line(tmp_path: Path) -> None:
    scene, items, out = tmp_path / "scene.json", tmp_path / "items.yaml", tmp_path / "plan.json"
    write_scene(scene_with(), scene)
    items.write_text(items_text([carton_item(MILK)]))
    asked = ["plan-pick", "--scene", scene, "--items", items, "--bin", "infeed", "--item", MILK.id]
    assert apc(*asked, "--into", "pallet", "--at=-100,50,100,90", "-o", out).code == 0
    plan = read_plan(out)
    assert plan.certificate is not None
    assert plan.query == "pick milk_1 from infeed into pallet at -100.0,50.0,100.0 mm and 90.0 deg"
    asked += ["--into", "pallet", "-o", tmp_path / "other.json", "--at"]
    misused(apc(*asked, "100,50"), "expected X,Y,Z or X,Y,Z,DEG")
    refused(apc(*asked, "390,50,100"), 5, "over the edge")
