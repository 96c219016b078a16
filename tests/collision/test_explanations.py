"""Explanations name link, obstacle, depth and place."""

from __future__ import annotations

import re

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.collision.kernel_validator import Contact
from pickcli.geometry import Array, pose
from pickcli.kinematics.arm import Arm
from support.solid_helpers import MakeChecker, MakeScene, box_item
from support.tool_states import STRAIGHT


def test_configuration_in_collision(
    cell: Cell, make_scene: MakeScene, make_checker: MakeChecker, home: Array
) -> None:
    """A block that the lance enters by 20 mm: the depth is right to within the spheres' excess."""
    tip = Arm(cell.robot).tip(home, STRAIGHT)
    scene = make_scene((box_item((0.1, 0.1, 0.1)), tip @ pose((0.0125 + 0.05 - 0.02, 0, -0.2))))
    reason = make_checker(scene).explain(home)
    assert reason.what == "collision"
    depth = re.fullmatch(r"lance against item item0, (\d+) mm deep", reason.detail)
    assert depth and 20 <= int(depth[1]) <= 23


def test_too_close_is_told_apart(
    cell: Cell, make_scene: MakeScene, make_checker: MakeChecker, home: Array
) -> None:
    tip = Arm(cell.robot).tip(home, STRAIGHT)
    scene = make_scene((box_item((0.1, 0.1, 0.1)), tip @ pose((0, 0, 0.05 + 0.003))))
    reason = make_checker(scene).explain(home)
    assert reason.what == "too close"
    assert re.fullmatch(r"cup against item item0, [0-2]\.\d mm apart \(3 mm are needed\)", reason.detail)


def test_edge_tells_the_deepest_place(cell: Cell, make_checker: MakeChecker) -> None:
    """Straight through the shelf's side: the pod, and a place in the middle."""
    checker = make_checker()
    q = cell.configurations["bin_A"].q
    q0, q1 = q.copy(), q.copy()
    q0[0], q0[1], q1[0], q1[1] = 0.6, -1.2, 0.6, 1.2
    assert not checker.is_valid_edge(q0, q1)
    reason = checker.explain_path(np.stack([q0, q1]))
    found = re.fullmatch(r"\w+ against pod \w+, (\d+) mm deep at (\d+) % of the edge", reason.detail)
    assert reason.what == "collision" and found
    t = int(found[2]) / 100
    there = checker.clearance((1 - t) * q0 + t * q1).distance
    elsewhere = [checker.clearance(q).distance for q in np.linspace(q0, q1, 50)]
    assert there <= min(elsewhere) + 0.01


def test_free_edges_say_so(cell: Cell, make_checker: MakeChecker, home: Array) -> None:
    reason = make_checker().explain_path(np.stack([home, cell.configurations["bin_E"].q]))
    assert reason.what == "no collision" and "apart" in reason.detail


def test_self_collision_names_both_links(make_checker: MakeChecker) -> None:
    folded = np.array([0.5, 0, 0, 0, 2.2689, 0, 1.9198, 0])
    reason = make_checker().explain(folded)
    assert reason.what == "collision"
    contact = make_checker().clearance(folded)
    assert contact.kind == "robot" and contact.a in reason.detail and contact.b in reason.detail
    assert f"{contact.a} against {contact.b}" == str(contact)


def test_nothing_near(make_checker: MakeChecker, home: Array) -> None:
    assert make_checker().clearance(home, max_distance=1e-3) == Contact(1e-3, "", "")
    assert str(Contact(1.0, "", "")) == "nothing near"


def test_what_only_the_deviations_of_a_motion_can_meet_is_named(
    make_scene: MakeScene, make_checker: MakeChecker, home: Array, cell: Cell
) -> None:
    """10 mm before the cup: free on the path, but not for a rail that may be 20 mm off."""
    tip = Arm(cell.robot).tip(home, STRAIGHT)
    scene = make_scene((box_item((0.1, 0.1, 0.1)), tip @ pose((0, 0, 0.05 + 0.010))))
    checker, path = make_checker(scene), np.stack([home, home])
    slack = np.full((1, len(home)), 0.02)
    assert checker.is_valid_path(path) and not checker.is_valid_path(path, slack)
    reason = checker.explain_path(path, slack)
    assert (reason.what, reason.in_the_way) == ("too close", "item0")
    assert "not proven for all deviations" in reason.detail and "are needed" not in reason.detail
