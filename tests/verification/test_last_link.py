"""A planned joint that moves the last link itself: the verifier follows that link like any other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli import JointPath, Planner, RejectedError, box
from pickcli.cell.cell_file import load_cell
from pickcli.geometry import pose
from pickcli.kinematics.arm import Arm
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import empty_scene
from pickcli.scene.scene_file import scene_hash
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.moving_parts import parts
from support.command_line import apc, refused
from support.elbow import LIMITS, WALL, write_elbow

ENDS = ((0.0, 0.6), (0.01, 2.4))


@pytest.fixture(scope="module")
def planner(tmp_path_factory: pytest.TempPathFactory) -> Planner:
    folder = tmp_path_factory.mktemp("elbow")
    made = apc("init", folder / "cell", "--urdf", write_elbow(folder), *LIMITS)
    assert made.code == 0, made.err
    return Planner.load(folder / "cell")


def test_its_shape_and_the_tip_are_where_all_joints_put_them(planner: Planner) -> None:
    robot, state = planner.cell.robot, planner.cell.robot.tool.default_state
    Q = np.random.default_rng(1).uniform((-0.02, -2.9), (0.02, 2.9), (20, 2))
    links = link_poses(robot, Q)
    segment = Segment(SegmentKind.TRANSIT, 0.0, 1.0, state, None, ())
    last = next(part for part in parts(empty_scene(planner.cell), segment, None) if part.name == "fore")
    for k, (turn, bend) in enumerate(Q):
        T = pose(rpy=(0, 0, turn)) @ pose((0.3, 0, 0), rpy=(0, 0, bend))
        np.testing.assert_allclose(links[last.link, k] @ last.T_link_shape, T @ pose((0.2, 0, 0)), atol=1e-12)
        np.testing.assert_allclose(tip_poses(robot, links, state)[k], T, atol=1e-12)
        np.testing.assert_allclose(Arm(robot).tip(Q[k], state), T, atol=1e-9)
    assert (last.reach > 0.0).all()


def test_a_motion_that_leads_it_through_a_wall_is_rejected(planner: Planner) -> None:
    plan = planner.time_path(JointPath(planner.cell.robot.joint_names, np.array(ENDS)))
    assert planner.verify(plan).certificate is not None
    wall = box("wall", (0.25, 0.25, -0.1), (0.35, 0.35, 0.1))  # in the middle of the way of the forearm
    among = planner.among([wall])
    moved = replace(plan, cell_fingerprint=among.cell.fingerprint, scene_hash=scene_hash(among.scene))
    with pytest.raises(RejectedError, match=r"collision: (wall and fore|fore and wall)"):
        among.verify(moved)


def test_a_pair_that_only_planning_leaves_out_is_verified(tmp_path: Path) -> None:
    """The planner leads the forearm through the wall; with ``verified`` that is no plan to carry out."""
    made = apc("init", tmp_path / "cell", "--urdf", write_elbow(tmp_path, 0.2, 2.9, WALL), *LIMITS)
    assert made.code == 0, made.err
    pair = 'allowed_pairs: [{a: base, b: fore, reason: "spheres that are too large"VERIFIED}]'
    path = tmp_path / "cell" / "cell.yaml"
    text = path.read_text()
    through = ("plan-move", "--cell", tmp_path / "cell", "--from", "0,2", "--to", "0,0.9", "-o")
    path.write_text(text.replace("allowed_pairs: []", pair.replace("VERIFIED", "")))
    never = load_cell(tmp_path / "cell").fingerprint
    assert apc(*through, tmp_path / "never.json").code == 0
    path.write_text(text.replace("allowed_pairs: []", pair.replace("VERIFIED", ", verified: true")))
    assert load_cell(tmp_path / "cell").fingerprint != never
    refused(apc(*through, tmp_path / "verified.json"), 4, "collision: base and fore")
