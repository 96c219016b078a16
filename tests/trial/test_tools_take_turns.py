"""A trial with two tools on one flange: what no cup holds is pinched, and the tools take turns at home."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_workcell
from pickcli.cell.workcell import Workcell
from pickcli.errors import StaleError
from pickcli.geometry import pose
from pickcli.page.html_page import page_bytes
from pickcli.page.trial_page import trial_page
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.simulation.motion_recorder import MotionRecorder
from pickcli.simulation.reality import DEFAULT
from pickcli.trial.loop import run_trial
from pickcli.trial.motion_record import RecordedMotion, motion_values, parse_motion, refuse_other_motion
from pickcli.trial.played_trial import positions_at_start
from pickcli.trial.pose_noise import DEFAULT_NOISE
from pickcli.trial.simulated_cell import SimulatedArena, TrialArm, interfaces_of
from pickcli.trial.trial_record import trial_record
from pickcli.trial.trial_result import ArmSummary, TrialResult
from pickcli.trial.trial_settings import TrialSettings
from support.order_builders import pick_order

CONTENTS = {"bin_B": "dove_beauty_bar", "bin_E": "fitness_gear_3lb_dumbbell", "bin_G": "crayola_24_ct"}
BY_FINGERS = "fitness_gear_3lb_dumbbell"


def placed(cell: Cell, place_name: str, name: str) -> PlacedItem:
    """An item level in the middle of a bin, 15 cm from its front."""
    item, place = cell.item(name), cell.places[place_name]
    front = 0.15 - max(item.shape.extents) / 2
    floor, _ = place.room.rest(np.array(front), np.array(0.0))
    T = pose((0.15, 0.0, float(floor) + float(item.shape.extents[2]) / 2 + 5e-4))
    return PlacedItem(name, item, place_name, cell.T_world_place(place) @ T)


@dataclass(frozen=True, eq=False)
class Played:
    workcell: Workcell
    scene: Scene
    result: TrialResult
    motion: RecordedMotion


@pytest.fixture(scope="module")
def played() -> Played:
    workcell = load_workcell("apc2016_delft_pinch")
    cell = workcell.preferred
    items = tuple(placed(cell, place, name) for place, name in CONTENTS.items())
    scene = Scene(cell, cell.T_world_pod, items, DEFAULT_NOISE)
    order = pick_order({place: (name,) for place, name in CONTENTS.items()}, *CONTENTS.items())
    arms = [
        TrialArm(PlanningContext(each), None, workcell.parked[name], workcell.preferences[name])
        for name, each in workcell.arms.items()
    ]
    recorder = MotionRecorder(positions_at_start(arms))
    with closing(SimulatedArena(scene, DEFAULT, 0, workcell.parked[cell.arm], recorder)) as arena:
        result = run_trial(order, interfaces_of(arms, arena), TrialSettings())
    motion = parse_motion(motion_values(recorder, tuple(workcell.arms.values())))
    return Played(workcell, scene, result, motion)


@pytest.fixture(scope="module")
def result(played: Played) -> TrialResult:
    return played.result


def test_what_no_cup_holds_is_pinched(result: TrialResult) -> None:
    assert result.items_in_tote == 3
    assert result.arms == {"suction": ArmSummary(2, 2), "fingers": ArmSummary(1, 1)}
    pinched = next(a for a in result.attempts if a.item == BY_FINGERS and a.plan is not None)
    assert pinched.plan is not None and pinched.plan.arm == "fingers"
    assert not result.collisions and not any(run.limit_violations for run in result.executions)


def test_each_tool_is_brought_to_its_parked_state_before_the_other_one_moves(result: TrialResult) -> None:
    arms = [a.plan.arm for a in result.attempts if a.plan is not None]
    parkings = [a.parking for a in result.attempts if a.parking is not None]
    n_turns = sum(a != b for a, b in zip(["suction", *arms], arms, strict=False))
    assert 1 <= len(parkings) <= n_turns
    assert all(not parking.stopped for parking in parkings)
    fingers_acted = arms.index("fingers") < len(arms) - 1
    closed = [e for p in parkings for e in p.events if e["device"] == "gripper" and e["action"] == "closed"]
    assert len(closed) == fingers_acted


def test_a_tool_that_stands_is_recorded_where_it_is(played: Played) -> None:
    motion, workcell = played.motion, played.workcell
    assert (motion.arms, motion.joint_names) == (("suction", "fingers"), workcell.moving_joints)
    assert {each.arm for each in motion.executions} == {"suction", "fingers"}
    for execution in motion.executions:
        mine = workcell.arms[execution.arm].robot.moving_joints
        standing = [k for k, name in enumerate(motion.joint_names) if name not in mine]
        is_now = (motion.times >= execution.t_start) & (motion.times <= execution.t_end)
        rows = motion.joints[is_now]
        assert len(rows) > 10 and np.ptp(rows[:, standing], axis=0).max() == 0.0
        assert np.ptp(np.delete(rows, standing, axis=1), axis=0).max() > 0.1


def test_a_motion_of_other_arms_is_refused(played: Played) -> None:
    motion, cells = played.motion, tuple(played.workcell.arms.values())
    refuse_other_motion(motion, played.scene, cells, "motion")
    by_another = replace(motion.executions[0], arm="thumb")
    for other in (
        replace(motion, executions=(by_another,)),
        replace(motion, joint_names=motion.joint_names[1:]),
    ):
        with pytest.raises(StaleError, match="motion of another scene or cell"):
            refuse_other_motion(other, played.scene, cells, "motion")
    with pytest.raises(StaleError, match="motion of another scene or cell"):
        refuse_other_motion(motion, played.scene, cells[:1], "motion")


def test_its_page_moves_both_tools(played: Played) -> None:
    record = trial_record(played.result, "order.json", 0.5)
    page = trial_page(record, played.scene, played.motion, played.workcell)
    assert page.robot is not None and page.robot.moved == played.motion.joint_names
    moving = {joint.name for joint in page.robot.joints if joint.type != "fixed"}
    assert moving == set(played.motion.joint_names)
    names = [signal.name for signal in page.signals]
    assert {"suction velocity", "fingers jerk", "vacuum"} <= set(names)
    lanes = {lane.name for lane in page.lanes}
    assert {"pump", "gripper", "cup pivot"} <= lanes
    assert page.clearance is not None and len(page_bytes(page)) < 2_000_000
