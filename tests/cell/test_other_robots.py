"""A robot as it comes: a tree with meshes and mimic joints, of which a cell plans one chain."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.robots.srdf import read_srdf
from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import inverse
from pickcli.kinematics.chain import bodies_of_frames, build_chain
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.verification.forward_kinematics import link_poses, reaches
from pickcli.verification.verify import verify
from support.other_robots import write_robot

Refused = Callable[[Callable[[], object]], str]


@pytest.fixture(scope="module")
def branching(tmp_path_factory: pytest.TempPathFactory) -> Cell:
    return load_cell(write_robot(tmp_path_factory.mktemp("branching")))


def changed(folder: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    """A cell of the robot with something changed in its file."""
    path = write_robot(folder) / "cell.yaml"
    content = yaml.safe_load(path.read_text())
    change(content)
    path.write_text(yaml.safe_dump(content, sort_keys=False))
    return path


def test_the_chain_comes_after_its_branches_and_the_cup_last(branching: Cell) -> None:
    names = [link.name for link in branching.robot.links]
    assert names == [
        "world_link", "column", "upper", "camera", "lower", "hand", "left", "right", "flange", "mount", "cup",
    ]  # fmt: skip
    assert bodies_of_frames(branching.robot) == (0, 1, 1, 2, 2, 2, 2, 3, 3, 3)


def test_joints_off_the_chain_stand_in_their_posture(branching: Cell) -> None:
    T = dict(
        zip(
            (link.name for link in branching.robot.links),
            link_poses(branching.robot, np.zeros((1, 3))),
            strict=True,
        )
    )
    T_hand = inverse(T["hand"][0])
    np.testing.assert_allclose((T_hand @ T["left"][0])[:3, 3], [0.0, 0.02, 0.05], atol=1e-12)
    np.testing.assert_allclose((T_hand @ T["right"][0])[:3, 3], [0.0, -0.021, 0.05], atol=1e-12)
    np.testing.assert_allclose((inverse(T["upper"][0]) @ T["camera"][0])[0, 0], np.cos(0.3))


def test_planner_and_verifier_see_every_link_at_the_same_place(branching: Cell) -> None:
    robot = branching.robot
    chain = build_chain(robot, robot.tool.default_state)
    Q = np.random.default_rng(0).uniform(-1.5, 1.5, (20, 3))
    ours = np.stack([chain.fk(q) for q in Q], axis=1)
    np.testing.assert_allclose(ours, link_poses(robot, Q)[1:], atol=1e-12)


def test_no_point_of_a_branch_moves_farther_than_its_reach(branching: Cell) -> None:
    robot, step = branching.robot, 1e-5
    rng = np.random.default_rng(1)
    for link in range(1, len(robot.links)):
        bound = reaches(robot, link, 0.0)
        for q in rng.uniform(-1.5, 1.5, (20, 3)):
            moved = link_poses(robot, q + step * np.eye(3))[link] - link_poses(robot, q[None])[link]
            assert (np.linalg.norm(moved[:, :3, 3], axis=1) / step <= bound + 1e-4).all()


def test_meshes_are_hulls_in_metres(branching: Cell) -> None:
    (arm,) = branching.robot.link("upper").bodies
    assert arm.shape.kind is ShapeKind.HULL
    np.testing.assert_allclose(arm.shape.size, [0.12, 0.12, 0.3])
    np.testing.assert_allclose(arm.T_parent_shape[:3, 3], [0.0, 0.0, 0.2], atol=1e-12)


def test_limits_come_from_the_file_where_the_cell_states_none(branching: Cell) -> None:
    assert branching.robot.limits.velocity.tolist() == [1.0, 1.5, 1.5]
    assert branching.robot.limits.jerk.tolist() == [50.0, 50.0, 50.0]


def test_disabled_pairs_of_the_srdf_are_allowed(branching: Cell) -> None:
    assert [(p.a, p.b, p.reason) for p in branching.allowed_pairs] == [
        ("lower", "camera", "disabled in the SRDF: Never")
    ]


def test_an_srdf_is_read(tmp_path: Path) -> None:
    srdf = read_srdf(write_robot(tmp_path) / "robot.srdf")
    assert srdf.groups["arm"].chains == (("column", "flange"),)
    assert srdf.states[0].positions == {"turn": 0.0, "bend": 0.1}
    assert [state.group for state in srdf.states] == ["arm", ""]
    assert (srdf.end_effectors[0].name, srdf.end_effectors[0].parent_link) == ("fingers", "hand")


def test_a_move_is_planned_and_verified(branching: Cell) -> None:
    scene = Scene(branching, np.eye(4), (), PoseNoise(0.0, 0.0))
    home, away = branching.configurations["home"], branching.configurations["away"]
    plan = plan_move(
        PlanningContext(branching), scene, Start(home.q, home.tool_state), MoveGoal(away.q), seed=1
    )
    verdict = verify(plan, scene)
    assert verdict.certificate is not None, verdict.reasons
    assert verdict.certificate.min_clearance >= branching.clearance - 1e-6


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda c: c["robot"]["posture"].pop("pan"), "robot.posture.pan: is not planned; expected where"),
        (lambda c: c["robot"]["posture"].update(pan=3.0), "expected -1 to 1, got 3; positions are in rad"),
        (lambda c: c["robot"]["posture"].update(pin=0.0), "no moving joint is named 'pin'"),
        (lambda c: c["robot"].pop("packages"), "package 'maker' is unknown; state its folder"),
        (lambda c: c["robot"].update(without=["hend"]), "robot.without[0]: no link is named 'hend'"),
        (lambda c: c["robot"].update(without=["world_link"]), "'world_link' is the root link"),
        (lambda c: c["tool"].update(flange_link="flunge"), "no link of the robot is named 'flunge'"),
        (lambda c: c["robot"].update(srdf="../robot.srdf"), "robot.srdf: expected a path inside the cell"),
        (lambda c: c["robot"].update(joint_limits="none.yaml"), "no such file"),
    ],
)  # fmt: skip
def test_a_mistake_is_told(
    tmp_path: Path, refused: Refused, change: Callable[[dict[str, Any]], object], problem: str
) -> None:
    assert problem in refused(lambda: load_cell(changed(tmp_path, change)))


def test_a_limit_that_no_file_states_is_asked_for(tmp_path: Path, refused: Refused) -> None:
    path = write_robot(tmp_path) / "cell.yaml"
    limits = path.parent / "joint_limits.yaml"
    limits.write_text(limits.read_text().replace("has_jerk_limits: true", "has_jerk_limits: false"))
    message = refused(lambda: load_cell(path))
    told = "max_jerk: expected a jerk limit in m/s3 or rad/s3, got nothing; state what the controller allows"
    assert message.count(told) == 3


def test_what_is_not_there_takes_all_that_hangs_on_it_along(tmp_path: Path) -> None:
    def change(content: dict[str, Any]) -> None:
        content["robot"]["without"] = ["hand"]
        content["robot"]["posture"] = {"pan": 0.0}

    names = [link.name for link in load_cell(changed(tmp_path, change)).robot.links]
    assert not {"hand", "left", "right", "dummy"} & set(names)


def test_a_link_that_is_drawn_but_not_shaped_is_not_free_of_charge(tmp_path: Path, refused: Refused) -> None:
    path = write_robot(tmp_path) / "cell.yaml"
    urdf = path.parent / "robot.urdf"
    drawn = '<link name="flange"><visual><geometry><sphere radius="0.05"/></geometry></visual></link>'
    urdf.write_text(urdf.read_text().replace('<link name="flange"/>', drawn))
    assert "link 'flange' is drawn but has no collision shape" in refused(lambda: load_cell(path))
    content = yaml.safe_load(path.read_text())
    content["robot"]["unshaped"] = ["flange"]
    path.write_text(yaml.safe_dump(content))
    assert load_cell(path)
