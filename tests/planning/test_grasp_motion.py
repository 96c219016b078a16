"""Which grasps lead in and out of a bin: what is in the way of the tool, and what is not."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import cached_property

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, pose
from pickcli.grasping.cup_press import outward_of
from pickcli.grasping.suction_grasping import SuctionGrasping
from pickcli.motion.plan import Grasp
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_motion import GraspMotion, ToolLines
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages import grasp_selection
from pickcli.planning.stages.grasp_selection import feasible_grasps
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.verification.verify import verify

BIN = "bin_E"


def contact_speed(problem: PickProblem, grasp: Grasp) -> float | None:
    """How fast the cup may meet the target."""
    return problem.context.method.contact_speed(problem.contacts, grasp)


def scene_of(cell: Cell, *placed: tuple[str, Array]) -> Scene:
    """Items (name, pose in the bin's frame) in one bin."""
    T_bin = cell.T_world_place(cell.pod.bins[BIN])
    items = tuple(PlacedItem(name, cell.item(name), BIN, T_bin @ T) for name, T in placed)
    return Scene(cell, cell.T_world_pod, items, PoseNoise(0.002, float(np.radians(1.0))))


def held_by_flats_only(cell: Cell, name: str) -> Cell:
    """The cell with an item whose narrow faces do not seal."""
    item = cell.item(name)
    seals = {face: share if face in ("+z", "-z") else 0.0 for face, share in item.seals.items()}
    return replace(cell, items={**cell.items, (name, item.year): replace(item, seals=seals)})


def on_floor(cell: Cell, name: str, x: float, y: float, up: float = 0.0, **turn: float) -> tuple[str, Array]:
    """An item level on the floor, ``up`` m above it, on its flat side or turned by ``roll``."""
    R = pose(rpy=[turn.get("roll", 0.0), turn.get("pitch", 0.0), turn.get("yaw", 0.0)])[:3, :3]
    reach = cell.item(name).shape.reach(R)
    floor, _ = cell.pod.bins[BIN].room.rest(np.array(x - reach[0]), np.array(0.0))
    z = float(floor) + float(reach[2]) + 0.0005 + up
    return name, pose([x, y, z], R=R)


def problem_of(context: PlanningContext, scene: Scene, name: str) -> PickProblem:
    return PickProblem(
        context, scene, context.cell.pod.bins[BIN], scene.find(name, BIN), context.cell.places["tote"]
    )


def grasps_of(context: PlanningContext, scene: Scene, name: str) -> tuple[GraspMotion, ...]:
    return feasible_grasps(problem_of(context, scene, name), ())[0]


def met(problem: PickProblem, face: str) -> frozenset[str]:
    return problem.contacts.met_by_cup(outward_of(face, problem.target.T_world_item[:3, :3]))


def test_a_thin_item_is_pressed_on_through_what_it_lies_on(cell: Cell, context: PlanningContext) -> None:
    liner = on_floor(cell, "peva_shower_curtain_liner", 0.25, 0.0)
    book = on_floor(cell, "laugh_out_loud_joke_book", 0.25, 0.0, up=0.0355)
    scene = scene_of(cell, liner, book)
    problem = problem_of(context, scene, "laugh_out_loud_joke_book")
    assert "peva_shower_curtain_liner" in met(problem, "+z")
    assert "peva_shower_curtain_liner" not in met(problem, "-z")
    assert grasps_of(context, scene, "laugh_out_loud_joke_book")


def test_what_stands_higher_than_the_face_is_never_met_by_the_cup(
    cell: Cell, context: PlanningContext
) -> None:
    cards = on_floor(cell, "staples_index_cards", 0.25, 0.0)
    bar = on_floor(cell, "dove_beauty_bar", 0.25, 0.0715)  # beside it, 2 mm away, and higher
    problem = problem_of(context, scene_of(cell, cards, bar), "staples_index_cards")
    assert "dove_beauty_bar" in problem.contacts.near_off_floor
    assert "dove_beauty_bar" not in met(problem, "+z")


def test_a_lance_that_rises_passes_what_a_level_one_meets(cell: Cell, context: PlanningContext) -> None:
    """An item on its edge beside the wall, a lower one in front where a level lance would lie."""
    standing = on_floor(cell, "crayola_24_ct", 0.25, -0.09, roll=np.pi / 2)
    low = on_floor(cell, "expo_dry_erase_board_eraser", 0.10, -0.045, yaw=np.pi / 2)
    scene = scene_of(held_by_flats_only(cell, "crayola_24_ct"), standing, low)
    found = grasps_of(context, scene, "crayola_24_ct")
    assert found
    assert {f.grasp.kind for f in found} == {"side"}
    for f in found:
        rise = (standing[1][:3, :3] @ f.grasp.T_item_tip[:3, 0])[2]
        assert rise > np.sin(np.radians(5.0))


def test_where_the_usual_approach_is_blocked_a_shorter_one_is_taken(
    cell: Cell, context: PlanningContext
) -> None:
    standing = on_floor(cell, "crayola_24_ct", 0.15, -0.1, roll=np.pi / 2)
    wall = on_floor(cell, "jane_eyre_dvd", 0.12, -0.005, roll=np.pi / 2)  # 75 mm beside the free face
    scene = scene_of(held_by_flats_only(cell, "crayola_24_ct"), standing, wall)
    found = grasps_of(context, scene, "crayola_24_ct")
    assert found
    for f in found:
        a, b = (context.arm.tip(q, f.grasp.tool_state)[:3, 3] for q in f.inward[1].waypoints[[0, -1]])
        assert np.linalg.norm(b - a) < context.settings.approach_offset / 2


@pytest.mark.parametrize("name", ["laugh_out_loud_joke_book", "i_am_a_bunny_book"])
def test_under_a_large_item_nothing_is_held_and_it_is_named(
    cell: Cell, context: PlanningContext, name: str
) -> None:
    flat = on_floor(cell, name, 0.25, 0.0)
    up = float(cell.item(name).shape.extents[2]) + 0.001
    cover = on_floor(cell, "peva_shower_curtain_liner", 0.25, 0.0, up=up, yaw=np.pi / 2)
    problem = problem_of(context, scene_of(cell, flat, cover), name)
    found, reasons = feasible_grasps(problem, ())
    assert not found
    assert "peva_shower_curtain_liner" in {reason.in_the_way for reason in reasons}


def test_what_the_cup_cannot_hold_costs_no_search(cell: Cell, context: PlanningContext) -> None:
    name = next(n for (n, _), item in cell.items.items() if not item.suction and cell.item(n) is item)
    problem = problem_of(context, scene_of(cell, on_floor(cell, name, 0.2, 0.0)), name)
    found, reasons = feasible_grasps(problem, ())
    assert not found
    assert [reason.what for reason in reasons] == ["cannot be held by suction"]
    costly = ("contacts", "_results")
    assert all(isinstance(vars(PickProblem)[name], cached_property) for name in costly)
    assert not set(costly) & set(vars(problem))


def test_a_light_item_is_pressed_where_it_is_carried(
    cell: Cell, context: PlanningContext, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mailer across a bar, from which both of its ends stick out."""
    bar = on_floor(cell, "dove_beauty_bar", 0.2, 0.0, yaw=np.pi / 2)
    mailer = on_floor(cell, "scotch_bubble_mailer", 0.2, 0.0, up=cell.item(bar[0]).shape.extents[2])
    scene = scene_of(cell, bar, mailer)
    problem = problem_of(context, scene, "scotch_bubble_mailer")
    found = grasps_of(context, scene, "scotch_bubble_mailer")
    assert found and all(contact_speed(problem, f.grasp) for f in found)
    out = found[0].grasp.T_item_tip.copy()
    out[0, 3] = 0.1
    assert contact_speed(problem, replace(found[0].grasp, T_item_tip=out)) is None
    assert contact_speed(problem, replace(found[0].grasp, T_item_tip=out, kind="frontal"))
    monkeypatch.setattr(SuctionGrasping, "contact_speed", lambda method, contacts, grasp: None)
    none, reasons = feasible_grasps(problem, ())
    assert not none
    assert "tips the item" in {reason.what for reason in reasons}


def test_turned_about_its_axis_the_cup_presses_as_before(
    cell: Cell, context: PlanningContext, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = scene_of(cell, on_floor(cell, "i_am_a_bunny_book", 0.25, 0.0))
    problem, asked = problem_of(context, scene, "i_am_a_bunny_book"), []
    monkeypatch.setattr(SuctionGrasping, "contact_speed", lambda _, __, grasp: asked.append(grasp))
    none, reasons = feasible_grasps(problem, ())
    assert not none and {reason.what for reason in reasons} >= {"tips the item"}
    places = [(g.kind, g.face, *np.round(g.T_item_tip[:3, 2:].ravel(), 6)) for g in asked]
    counts = Counter(places)
    assert max(counts.values()) <= 2  # the few grasps, and the many


def test_the_arm_is_asked_for_few_grasps_that_it_cannot_follow(
    cell: Cell, context: PlanningContext, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = scene_of(cell, on_floor(cell, "i_am_a_bunny_book", 0.25, 0.0))
    problem, asked = problem_of(context, scene, "i_am_a_bunny_book"), []

    def cannot(problem: PickProblem, tool: ToolLines, *_: object) -> Failures:
        asked.append(tool.grasp)
        return Failures.of(Reason("branch jump", str(tool.grasp), "by this test"))

    monkeypatch.setattr(grasp_selection, "plan_grasp_motion", cannot)
    none, reasons = feasible_grasps(problem, ())
    assert not none and "branch jump" in {reason.what for reason in reasons}
    assert grasp_selection.MOST_UNFOLLOWED < len(asked) <= 2 * grasp_selection.MOST_UNFOLLOWED


def test_the_verifier_refuses_what_tips_by_a_rule_of_its_own(
    cell: Cell, context: PlanningContext, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same mailer, pressed where the planner would not."""
    bar = on_floor(cell, "dove_beauty_bar", 0.2, 0.0, yaw=np.pi / 2)
    mailer = on_floor(cell, "scotch_bubble_mailer", 0.2, 0.0, up=cell.item(bar[0]).shape.extents[2])
    scene = scene_of(cell, bar, mailer)
    home, query = cell.configurations["home"], PickQuery(BIN, "scotch_bubble_mailer")
    start = Start(home.q, home.tool_state)
    assert verify(plan_pick(context, scene, query, start, 1), scene).certificate is not None
    monkeypatch.setattr(
        SuctionGrasping,
        "contact_speed",
        lambda method, contacts, grasp: 0.05 if abs(grasp.T_item_tip[0, 3]) >= 0.08 else None,
    )
    verdict = verify(plan_pick(context, scene, query, start, 1), scene)
    assert [reason.what for reason in verdict.reasons] == ["tips the item"]


def test_what_rolls_does_not_count_as_tipping(cell: Cell, context: PlanningContext) -> None:
    ball = on_floor(cell, "rawlings_baseball", 0.25, 0.0)
    scene = scene_of(cell, ball)
    grasps = [f.grasp for f in grasps_of(context, scene, ball[0]) if f.grasp.kind == "top-down"]
    problem = problem_of(context, scene, ball[0])
    assert grasps and all(contact_speed(problem, grasp) for grasp in grasps)


def test_a_cell_need_not_name_a_configuration_for_a_bin(cell: Cell) -> None:
    """Then inverse kinematics begins at random alone."""
    bare = replace(cell, configurations={"home": cell.configurations["home"]})
    scene = scene_of(bare, on_floor(bare, "crayola_24_ct", 0.2, 0.0))
    assert grasps_of(PlanningContext(bare), scene, "crayola_24_ct")
