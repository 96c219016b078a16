"""The robot's spheres and pairs: they contain the links, and test what can touch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.robot_model import BARE_EXCESS, LINK_COUNT, MOST_FINE_EXCESS, CollisionModel
from pickcli.geometry import Array, pose, rotation_axis_angle, transform_points
from pickcli.kinematics.arm import Arm
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.forward_kinematics import link_poses
from support.other_robots import write_robot
from support.solid_helpers import link_points
from support.tool_states import ALL_STATES, DOWN, STRAIGHT
from support.two_arms import write_two_arms


@pytest.mark.parametrize("tool_state", ALL_STATES)
def test_every_link_lies_in_its_spheres(cell: Cell, model: CollisionModel, tool_state: ToolState) -> None:
    rng = np.random.default_rng(0)
    state = model.state(tool_state)
    for k, name in enumerate(model.frame_names):
        points = link_points(cell, name, rng)
        centers = state.spheres.centers[state.spheres.frames == k]
        radii = state.spheres.radii[state.spheres.frames == k]
        gaps = np.linalg.norm(points[:, None] - centers, axis=2) - radii
        assert gaps.min(axis=1).max() <= 1e-12, name


def test_the_moving_cup_contains_every_position_of_the_cup(cell: Cell, model: CollisionModel) -> None:
    rng = np.random.default_rng(1)
    tool, state = cell.robot.tool, model.state(MOVING)
    axis = next(j.axis for j in cell.robot.joints if j.name == tool.joint)
    cup = state.spheres.frames == model.n_frames - 1
    straight, down = (tool.positions[p] for p in (STRAIGHT, DOWN))
    for angle in np.linspace(0, down - straight, 37):
        points = transform_points(
            pose(R=rotation_axis_angle(axis, angle)), link_points(cell, "cup", rng, 100)
        )
        gaps = np.linalg.norm(points[:, None] - state.spheres.centers[cup], axis=2) - state.spheres.radii[cup]
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
    np.testing.assert_array_equal(straight.spheres.centers, model.state(DOWN).spheres.centers)


def test_the_kernel_stays_small(model: CollisionModel) -> None:
    """Spheres per tool state: what the cost of every check hangs on."""
    assert len(model.state(STRAIGHT).spheres.radii) <= 320
    assert len(model.state(MOVING).spheres.radii) <= 550


def test_links_with_meshes_are_told_apart_where_their_shapes_are(tmp_path: Path) -> None:
    """What is free is so by the shapes, and what is far enough apart for the finer spheres is free."""
    cell = load_cell(write_robot(tmp_path))
    model = CollisionModel(cell)
    kernel = model.state(cell.robot.tool.default_state)
    names, coarse, fine = model.frame_names, kernel.spheres, kernel.fine
    meshed = [k for k in range(len(names)) if (fine.frames == k).any()]
    assert {names[k] for k in meshed} == {"upper", "lower"}
    rng = np.random.default_rng(2)
    for k in meshed:
        corners = np.array(cell.robot.link(names[k]).bodies[0].shape.vertices)
        shares = rng.dirichlet(np.full(len(corners), 0.1), 400)
        points = transform_points(cell.robot.link(names[k]).bodies[0].T_parent_shape, shares @ corners)
        for spheres in (coarse.of([k]), fine.of([k])):
            gaps = np.linalg.norm(points[:, None] - spheres.centers, axis=2) - spheres.radii
            assert gaps.min(axis=1).max() <= 1e-12
        assert len(fine.of([k]).radii) > len(coarse.of([k]).radii)
    alone = kernel.of_frames((meshed[0], meshed[1]))
    Q = Arm(cell.robot).random_seeds(rng, 200)
    exact = np.array([_distance(cell, [names[k] for k in meshed], q) for q in Q])
    by_spheres = alone.clearances(Q, 1.0)
    apart = exact > 0.0
    assert np.count_nonzero(apart) > 50
    assert (by_spheres <= exact + 1e-9)[apart].all()
    assert (exact - by_spheres)[apart].max() <= 2 * (MOST_FINE_EXCESS + 0.001)


def _distance(cell: Cell, links: Sequence[str], q: Array) -> float:
    """m between the meshes of two links, by fcl."""
    poses, names = link_poses(cell.robot, q[None]), [link.name for link in cell.robot.links]
    solids = []
    for link in links:
        body = cell.robot.link(link).bodies[0]
        solids.append(Solid(body.shape))
        solids[-1].place(poses[names.index(link), 0] @ body.T_parent_shape)
    return float(solids[0].distance(solids[1]))


def test_a_robot_without_a_tool_has_fewer_spheres_around_all_of_it(tmp_path: Path) -> None:
    bare = load_cell(write_two_arms(tmp_path), "left")
    model = CollisionModel(bare)
    state, rng = model.state(bare.robot.tool.default_state), np.random.default_rng(0)
    assert len(state.spheres.radii) < len(state.fine.radii)
    for name, cover in model.covers.items():
        of_link = state.spheres.of([model.frame_names.index(name)])
        assert cover.excess <= BARE_EXCESS + 1e-3 or len(cover.radii) >= LINK_COUNT // 2
        if len(of_link.radii):
            points = link_points(bare, name, rng)
            gaps = np.linalg.norm(points[:, None] - of_link.centers, axis=2) - of_link.radii
            assert gaps.min(axis=1).max() <= 1e-12, name


def test_its_links_are_told_apart_wherever_tight_spheres_do(tmp_path: Path) -> None:
    bare = load_cell(write_two_arms(tmp_path), "left")
    state = CollisionModel(bare).state(bare.robot.tool.default_state)
    assert len(state.self_pairs)
    tight = replace(state, spheres=state.fine)
    Q = Arm(bare.robot).random_seeds(np.random.default_rng(2), 2000)
    margins = [0.3, 0.35, 0.4]  # the hand keeps 0.3 m from the shoulder wherever the elbow stands
    told = [state.checker().are_free(Q, margin) for margin in margins]
    assert any(free.any() and not free.all() for free in told)
    for margin, free in zip(margins, told, strict=True):
        assert free[tight.checker().are_free(Q, margin)].all()
