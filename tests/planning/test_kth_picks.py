"""KTH's arms: what a cup at a right angle takes, what a gripper pinches, and where each lets go."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_workcell
from pickcli.cell.pod_tolerance import PodPoses
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import Failures
from pickcli.geometry import Array, pose, rotation_rpy
from pickcli.planning.arm_choice import rank_arms
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.drop_placements import drop_placements
from pickcli.planning.start_state import Start
from pickcli.precompute.empty_cell_checkers import STORED_RESERVE, checker
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.verification.verify import verify

BIN = "bin_E"
PICKS = [  # cell, arm, item, how it lies (roll, pitch, yaw in degrees), its face
    ("apc2016_kth_picking", "right", "safety_first_outlet_plugs", (0, 0, 90), "+z"),
    ("apc2016_kth_picking", "left", "safety_first_outlet_plugs", (0, 0, 90), "+z"),
    ("apc2016_kth", "right", "safety_first_outlet_plugs", (0, 0, 90), "+z"),
    ("apc2016_kth", "left", "expo_dry_erase_board_eraser", (90, 0, 0), "z"),
]


def lying(cell: Cell, name: str, lies: tuple[float, float, float], x: float = 0.08) -> Scene:
    """An item alone in the middle of a bin, x (m) behind its mouth, on the slope of the floor."""
    item, place, R = cell.item(name), cell.places[BIN], rotation_rpy(*np.radians(lies))
    half = item.shape.reach(R)
    height, slope = (float(value[0]) for value in place.room.rest(np.array([x]), half[0]))
    above = float(half[2]) + 1e-4
    R_slope = rotation_rpy(0.0, slope, 0.0)
    at = (x + above * np.sin(slope), 0.0, height + above * np.cos(slope))
    placed = PlacedItem(name, item, BIN, cell.T_world_place(place) @ pose(at, R=R_slope @ R))
    return Scene(cell, cell.T_world_pod, (placed,), PoseNoise())


@pytest.mark.parametrize(("name", "arm", "item", "lies", "face"), PICKS)
def test_a_pick_is_planned_and_certified(
    name: str, arm: str, item: str, lies: tuple[float, float, float], face: str
) -> None:
    cell = load_workcell(name).arms[arm]
    scene, home = lying(cell, item, lies), cell.configurations["home"]
    plan = plan_pick(PlanningContext(cell), scene, PickQuery(BIN, item), Start(home.q, home.tool_state))
    assert plan.arm == arm and plan.grasp is not None and plan.grasp.face == face
    assert verify(plan, scene).certificate is not None


def test_what_only_fingers_hold_goes_to_the_gripper_and_what_only_a_cup_holds_to_the_cup() -> None:
    workcell = load_workcell("apc2016_kth")

    def able(item: str, lies: tuple[float, float, float]) -> list[str]:
        scenes = [lying(cell, item, lies) for cell in workcell.arms.values()]
        ranked = rank_arms(scenes, workcell.preferences, PickQuery(BIN, item))
        return [arm.arm for arm in ranked if arm.is_able]

    assert able("oral_b_toothbrush_red", (0, 0, 0)) == ["left"]
    assert able("folgers_classic_roast_coffee", (0, 0, 0)) == ["right"]


def released(cell: Cell) -> tuple[Array, Array]:
    """Where a thin box in the cup is let go in the tote, and the way from there to the hand: (N, 3) each."""
    item, state = cell.item("ticonderoga_12_pencils"), cell.robot.tool.default_state
    thin = float(item.shape.extents.min()) / 2
    held = AttachedItem(item, pose((0.0, 0.0, thin)), 0.003)
    scene = Scene(cell, cell.T_world_pod, (), PoseNoise())
    found = drop_placements(scene, cell.places["tote"], held, state)
    assert not isinstance(found, Failures)
    poses = np.array([placement.release for placement in found])
    return poses[:, :3, 3], poses[:, :3, 0]


@pytest.mark.parametrize(("arm", "side"), [("left", 1.0), ("right", -1.0)])
def test_each_arm_lets_go_from_its_own_side_and_near_it_first(arm: str, side: float) -> None:
    cell = load_workcell("apc2016_kth_picking").arms[arm]
    tips, to_hand = released(cell)
    assert (side * to_hand[:, 1] > -0.3).all() and side * to_hand[0, 1] > 0.9
    middle = cell.T_world_place(cell.places["tote"])[1, 3]
    assert side * (tips[0, 1] - middle) > 0.0
    assert len(np.unique(np.round(tips[:, :2], 3), axis=0)) >= 15


@pytest.mark.parametrize("name", ["apc2016_kth", "apc2016_kth_picking"])
@pytest.mark.parametrize("arm", ["left", "right"])
def test_over_the_tote_there_is_room_for_a_large_item(name: str, arm: str) -> None:
    """The cube of the stored motions clears the tote's rim, wherever the pod stands."""
    cell = load_workcell(name).arms[arm]
    over, model = cell.configurations["tote"], CollisionModel(cell)
    for pod_poses in PodPoses:
        free = checker(model, over.tool_state, PayloadClass.CUBE, STORED_RESERVE, pod_poses)
        assert free.is_valid(over.q), str(free.explain(over.q))
