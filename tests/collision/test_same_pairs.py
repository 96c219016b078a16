"""Planner and verifier leave out the same pairs, each by its own derivation from the cell."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.collision.motion_segment import Mode
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.forward_kinematics import link_poses
from pickcli.verification.verify import verify
from support.other_robots import write_robot

# Beside the turning column, where the camera on it comes by; part of the base.
POST = """<link name="post"><collision><geometry><box size="0.03 0.03 0.2"/></geometry></collision></link>
<joint name="post_joint" type="fixed"><parent link="world_link"/><child link="post"/>
<origin xyz="0.16 0 0.55"/></joint></robot>"""
RIGID = ({"upper", "camera"}, {"lower", "hand", "left", "right"}, {"mount", "cup"})
JOINED = ({"column", "upper"}, {"upper", "lower"}, {"lower", "mount"})  # the flange has no shape

Change = Callable[[dict[str, Any]], object]


def branching(folder: Path, change: Change = lambda c: None, urdf: tuple[str, str] = ("", "")) -> Cell:
    """The branching robot with something changed in its cell file and something replaced in its URDF."""
    cell = write_robot(folder)
    content = yaml.safe_load((cell / "cell.yaml").read_text())
    change(content)
    (cell / "cell.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    text = (cell / "robot.urdf").read_text()
    assert urdf[0] in text
    (cell / "robot.urdf").write_text(text.replace(*urdf))
    return load_cell(cell)


def scene_of(cell: Cell) -> Scene:
    return Scene(cell, cell.T_world_pod, (), PoseNoise(0.0, 0.0))


def move(cell: Cell, start: tuple[float, ...], goal: tuple[float, ...]) -> Plan:
    begin = Start(np.array(start), cell.robot.tool.default_state)
    return plan_move(PlanningContext(cell), scene_of(cell), begin, MoveGoal(np.array(goal)))


def nearest(cell: Cell, q: Array) -> tuple[float, set[str]]:
    """The nearest two links by the verifier's solids, without those that are rigid or joined by a joint."""
    names, poses = [link.name for link in cell.robot.links], link_poses(cell.robot, q[None])[:, 0]
    found = []
    for i, j in combinations(range(len(names)), 2):
        pair = {names[i], names[j]}
        if any(pair <= group for group in RIGID) or pair in JOINED:
            continue
        for a in cell.robot.links[i].bodies:
            for b in cell.robot.links[j].bodies:
                one, other = Solid(a.shape), Solid(b.shape)
                one.place(poses[i] @ a.T_parent_shape)
                other.place(poses[j] @ b.T_parent_shape)
                found.append((one.distance(other), pair))
    return min(found, key=lambda each: each[0])


def without_srdf(content: dict[str, Any]) -> None:
    del content["robot"]["srdf"]


@pytest.mark.parametrize(
    "urdf",
    [
        ("0.05 0.05 0.05", "0.25 0.25 0.25"),  # a camera that the lower arm and the hand come by
        ('<sphere radius="0.03"/>', '<sphere radius="0.3"/>'),  # a hand that meets the upper arm
        ("</robot>", POST),
    ],
)
def test_the_planner_refuses_all_that_the_verifier_measures_too_near(
    tmp_path: Path, urdf: tuple[str, str]
) -> None:
    cell = branching(tmp_path, without_srdf, urdf)
    checker = PlanningContext(cell).checker_for(scene_of(cell), Mode(cell.robot.tool.default_state))
    rng, near = np.random.default_rng(0), set()
    for q in rng.uniform(*cell.robot.limits.window, (120, 3)):
        distance, pair = nearest(cell, q)
        if distance < cell.clearance - 1e-4:
            near.add(frozenset(pair))
            assert not checker.is_valid(q), (pair, distance)
    assert near


def test_links_that_never_meet_cost_nothing(tmp_path: Path) -> None:
    model = CollisionModel(branching(tmp_path))
    names, state = model.frame_names, model.state(model.robot.tool.default_state)
    tested = {frozenset((names[i], names[j])) for i, j in state.self_pairs}
    # On either side of the joint of the flange, never nearer than 20 mm.
    assert not tested & {frozenset(("hand", "mount")), frozenset(("hand", "cup"))}
    assert frozenset(("upper", "mount")) in tested


def test_a_base_may_stand_in_its_stand(tmp_path: Path) -> None:
    def sink(content: dict[str, Any]) -> None:
        content["obstacles"][0]["upper"][2] = 1.05  # 50 mm over the lower end of the column

    cell = branching(tmp_path, sink)
    plan = move(cell, (0.0, 0.3, 0.0), (2.5, -0.6, 1.0))
    verdict = verify(plan, scene_of(cell))
    assert verdict.certificate is not None, verdict.reasons


def test_what_stands_beside_the_first_joint_is_gone_round(tmp_path: Path) -> None:
    cell = branching(tmp_path, urdf=("</robot>", POST))
    checker = PlanningContext(cell).checker_for(scene_of(cell), Mode(cell.robot.tool.default_state))
    assert "camera against base post" in str(checker.explain(np.zeros(3)))
    plan = move(cell, (-1.0, 0.3, 0.0), (1.0, 0.3, 0.0))
    assert plan.trajectory.positions[-1][0] == pytest.approx(1.0 - 2 * np.pi)
    verdict = verify(plan, scene_of(cell))
    assert verdict.certificate is not None, verdict.reasons


@pytest.mark.parametrize(
    ("name", "other"),
    [("upper", "a link of the robot too"), ("post_left", "a part of the pod or the tote too")],
)
def test_no_obstacle_has_the_name_of_something_else(
    tmp_path: Path, refused: Callable[[Callable[[], object]], str], name: str, other: str
) -> None:
    def rename(content: dict[str, Any]) -> None:
        content["obstacles"][0]["name"] = name

    message = refused(lambda: branching(tmp_path, rename))
    assert f"obstacles[0].name: {name!r} is {other}; rename the obstacle" in message
