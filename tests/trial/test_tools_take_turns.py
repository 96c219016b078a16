"""A trial with two tools on one flange: what no cup holds is pinched, and the tools take turns at home."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_workcell
from pickcli.geometry import pose
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.trial.attempt_runner import TrialSettings
from pickcli.trial.loop import run_trial
from pickcli.trial.pose_noise import DEFAULT_NOISE
from pickcli.trial.simulated_cell import SimulatedArena, TrialArm, interfaces_of
from pickcli.trial.trial_result import ArmSummary, TrialResult
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


@pytest.fixture(scope="module")
def result() -> Iterator[TrialResult]:
    workcell = load_workcell("apc2016_delft_pinch")
    cell = workcell.preferred
    items = tuple(placed(cell, place, name) for place, name in CONTENTS.items())
    scene = Scene(cell, cell.T_world_pod, items, DEFAULT_NOISE)
    order = pick_order({place: (name,) for place, name in CONTENTS.items()}, *CONTENTS.items())
    arms = [
        TrialArm(PlanningContext(each), None, workcell.parked[name], workcell.preferences[name])
        for name, each in workcell.arms.items()
    ]
    arena = SimulatedArena(scene, parked=workcell.parked[cell.arm])
    yield run_trial(order, interfaces_of(arms, arena), TrialSettings())
    arena.close()


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
