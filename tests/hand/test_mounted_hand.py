"""The hand as planner and verifier see it on an arm: shaped as in the physics, and as heavy as its parts."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.errors import InputError
from pickcli.geometry import inverse, pose
from pickcli.hand.grasp_world import GraspWorld, Standing
from pickcli.hand.hand_urdf import FINGER_JOINTS, PALM, pad_bodies
from pickcli.hand.mounted_hand import flange_to_hand, hand_bodies, open_fingers, with_hand
from support.belt_hands import HAND, post
from support.commissions import belts_booth, booth


def test_solids_of_fingers_that_stand_are_where_the_physics_has_them() -> None:
    world = GraspWorld(HAND, post(1.0), [Standing(1.0, 0.0)], np.array([0.0, 0.0, 0.3, 0.2, 0.0, 0.0]))
    world.hand.motor.wanted, world.hand.motor.set_point = HAND.drive.speed, 1.0
    for _ in range(300):
        world.step()
    world.hand.exert()  # reads the joints
    solids = {body.name: body for body in hand_bodies(HAND, world.hand.fingers)}
    engine = world.engine
    T_hand_world = inverse(engine.pose(world.hand.body, PALM))
    for link in FINGER_JOINTS:
        pads = pad_bodies(HAND, 1.0 if link.startswith("left") else -1.0)
        pad = pads[link.endswith("distal")]
        there = T_hand_world @ engine.pose(world.hand.body, link) @ pad.T_parent_shape
        assert solids[link].T_parent_shape == pytest.approx(there, abs=1e-5)


def test_the_flange_carries_hand_and_object_as_one_body_with_a_fingerprint_of_its_own() -> None:
    cell, can = belts_booth(), Body("can", Shape(ShapeKind.CYLINDER, (0.0265, 0.135)), pose((0.05, 0.0, 0.0)))
    empty = with_hand(cell, HAND, open_fingers(HAND))
    full = with_hand(cell, HAND, open_fingers(HAND), (can,), 0.361)
    closed = with_hand(cell, HAND, np.zeros((2, 2)))
    assert len({each.fingerprint for each in (cell, empty, full, closed)}) == 4
    link = full.robot.link(cell.robot.tool.flange_link)
    own = HAND.palm.mass + 4 * HAND.fingers.mass
    assert link.inertial.mass == pytest.approx(own + 0.361)
    ahead = flange_to_hand(HAND) @ can.T_parent_shape
    centre = (own * empty.robot.link(link.name).inertial.centre + 0.361 * ahead[:3, 3]) / link.inertial.mass
    assert link.inertial.centre == pytest.approx(centre)
    assert link.bodies[-1].T_parent_shape == pytest.approx(ahead)


def test_a_cell_with_a_tool_takes_no_hand() -> None:
    with pytest.raises(InputError, match="the arm has a tool of its own; a hand needs a cell"):
        with_hand(booth(), HAND, open_fingers(HAND))
