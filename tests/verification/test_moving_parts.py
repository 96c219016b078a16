"""A tool that moves: its parts stand so near to each other that what is in between is within their slack."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.tool import MOVING
from pickcli.geometry import Array, transform_points
from pickcli.verification.forward_kinematics import T_parent_child, last_joint_index, parent_index
from pickcli.verification.moving_parts import SWEEP_STEP, parts
from support.handmade_plans import CRAYOLA, cell, make_scene, pick
from support.rail_motions import rail


def farthest(points: Array) -> float:
    return float(np.linalg.norm(points, axis=1).max())


@pytest.mark.parametrize("holds", [False, True])
def test_half_a_step_of_what_moves_farthest_is_the_slack_of_a_turning_tool(holds: bool) -> None:
    """No point is farther than that from where it is in the nearest of the poses."""
    robot, scene = cell().robot, pick()[1]
    T_tip_item = np.eye(4)
    segment = replace(rail(0.0).segments[0], tool_state=MOVING, held=CRAYOLA if holds else None)
    there = scene if holds else make_scene()
    moving = [p for p in parts(there, segment, T_tip_item) if (p.is_held if holds else p.is_cup)]
    assert len({p.link for p in moving}) == 1 and moving[0].link == parent_index(
        robot, last_joint_index(robot)
    )
    stated = list(robot.tool.positions.values())
    least, most = min(stated), max(stated)
    for shape in {p.shape for p in moving}:
        of_shape = [p for p in moving if p.shape == shape]
        n = len(of_shape)
        T_joint = [T_parent_child(robot, last_joint_index(robot), q) for q in np.linspace(least, most, n)]
        bound = there.noise.bound(there.item(CRAYOLA)) if holds else 0.0
        T_child_shape = np.linalg.inv(T_joint[0]) @ of_shape[0].T_link_shape
        for T, part in zip(T_joint, of_shape, strict=True):
            np.testing.assert_allclose(part.T_link_shape, T @ T_child_shape, atol=1e-9)
        spheres = of_shape[0].spheres
        lever = farthest(transform_points(T_child_shape, spheres.centers)) + spheres.radius
        step = (most - least) / (n - 1)
        assert step * lever <= SWEEP_STEP < (most - least) / (n - 2) * lever
        expected = bound + step * (lever + bound) / 2
        np.testing.assert_allclose([p.slack for p in of_shape], expected, rtol=1e-9)
