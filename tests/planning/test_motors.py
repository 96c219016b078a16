"""Picks by weak motors are slower, and accepted by the verifier; motors must hold the arm at least."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import NoPlanError
from pickcli.motion.plan import Plan
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import Scene
from pickcli.verification.verify import verify
from planning.conftest import SceneWith

ITEM = "crayola_24_ct"


def with_motors(cell: Cell, share: float) -> Cell:
    forces = {name: share * force for name, force in cell.robot.motor_forces.items()}
    return replace(cell, robot=replace(cell.robot, motor_forces=forces))


def plan_with(scene: Scene, start: Start) -> Plan:
    return plan_pick(PlanningContext(scene.cell), scene, PickQuery("bin_E", ITEM), start, 1)


def test_weak_motors_take_longer_and_are_not_overtaxed(scene_with: SceneWith, home: Start) -> None:
    scene = scene_with((ITEM, "bin_E", 0.1, 0.0))
    strong = plan_with(scene, home)
    weak_scene = replace(scene, cell=with_motors(scene.cell, 0.55))
    assert "motor too weak" in {reason.what for reason in verify(strong, weak_scene).reasons}
    slower = plan_with(weak_scene, home)
    assert verify(slower, weak_scene).certificate is not None
    assert slower.trajectory.duration > strong.trajectory.duration


def test_motors_that_cannot_hold_the_arm_are_the_reason(scene_with: SceneWith, home: Start) -> None:
    scene = scene_with((ITEM, "bin_E", 0.1, 0.0))
    with pytest.raises(NoPlanError, match="what the motors may exert"):
        plan_with(replace(scene, cell=with_motors(scene.cell, 0.2)), home)
