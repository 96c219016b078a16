"""The robot's spheres and pairs: they contain the links, and test what can touch."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import pose, rotation_axis_angle, transform_points
from support.solid_helpers import link_points
from support.tool_states import ALL_STATES, DOWN, STRAIGHT


@pytest.mark.parametrize("tool_state", ALL_STATES)
def test_every_link_lies_in_its_spheres(cell: Cell, model: CollisionModel, tool_state: ToolState) -> None:
    rng = np.random.default_rng(0)
    state = model.state(tool_state)
    for k, name in enumerate(model.frame_names):
        points = link_points(cell, name, rng)
        centers, radii = state.centers[state.frames == k], state.radii[state.frames == k]
        gaps = np.linalg.norm(points[:, None] - centers, axis=2) - radii
        assert gaps.min(axis=1).max() <= 1e-12, name


def test_the_moving_cup_contains_every_position_of_the_cup(cell: Cell, model: CollisionModel) -> None:
    rng = np.random.default_rng(1)
    tool, state = cell.robot.tool, model.state(MOVING)
    axis = next(j.axis for j in cell.robot.joints if j.name == tool.joint)
    cup = state.frames == model.n_frames - 1
    straight, down = (tool.positions[p] for p in (STRAIGHT, DOWN))
    for angle in np.linspace(0, down - straight, 37):
        points = transform_points(
            pose(R=rotation_axis_angle(axis, angle)), link_points(cell, "cup", rng, 100)
        )
        gaps = np.linalg.norm(points[:, None] - state.centers[cup], axis=2) - state.radii[cup]
        assert gaps.min(axis=1).max() <= 1e-12


def test_pairs_leave_out_rigid_and_adjacent_bodies_only(model: CollisionModel) -> None:
    names = model.frame_names
    pairs = {frozenset((names[i], names[j])) for i, j in model.state(STRAIGHT).self_pairs}
    assert frozenset(("carriage", "arm_base")) not in pairs  # one rigid body
    assert frozenset(("carriage", "link_s")) not in pairs  # joined by joint_s
    assert frozenset(("link_t", "lance")) not in pairs and frozenset(("link_b", "cup")) not in pairs
    arm = ["carriage", "link_s", "link_l", "link_e", "link_u", "link_r", "link_b"]
    for i, a in enumerate(arm):
        for b in arm[i + 2 :]:
            assert frozenset((a, b)) in pairs
    assert all(frozenset((a, "cup")) in pairs for a in arm[:-1])


def test_states_are_made_once_and_share_covers(model: CollisionModel) -> None:
    straight = model.state(STRAIGHT)
    assert model.state(STRAIGHT) is straight
    np.testing.assert_array_equal(straight.centers, model.state(DOWN).centers)


def test_the_kernel_stays_small(model: CollisionModel) -> None:
    """Spheres per tool state: what the cost of every check hangs on."""
    assert len(model.state(STRAIGHT).radii) <= 320
    assert len(model.state(MOVING).radii) <= 550
