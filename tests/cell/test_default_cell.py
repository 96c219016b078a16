"""The default cell is Team Delft's station: its figures against those of the sources."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.robot import Link
from pickcli.cell.shapes import ShapeKind
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from support import arm_table

CELL = load_cell("apc2016_delft")
STRAIGHT, DOWN = 0.0, np.pi / 2
BINS = "ABCDEFGHIJKL"

# Bounds of the collision meshes of motoman_sia20d_support, in the link frames, m.
MESH_BOUNDS = {
    "arm_base": ((-0.200, -0.143, 0.000), (0.143, 0.140, 0.175)),
    "link_s": ((-0.109, -0.109, -0.298), (0.109, 0.111, 0.109)),
    "link_l": ((-0.120, -0.120, -0.120), (0.120, 0.086, 0.266)),
    "link_e": ((-0.091, -0.104, -0.244), (0.091, 0.091, 0.085)),
    "link_u": ((-0.092, -0.065, -0.092), (0.092, 0.097, 0.265)),
    "link_r": ((-0.067, -0.067, -0.181), (0.067, 0.084, 0.064)),
    "link_b": ((-0.070, -0.080, -0.070), (0.070, 0.066, 0.168)),
    "link_t": ((-0.050, -0.050, -0.016), (0.050, 0.050, 0.000)),
}


def configurations() -> st.SearchStrategy[Array]:
    limits = CELL.robot.limits
    each = [st.floats(lo, up) for lo, up in zip(limits.lower, limits.upper, strict=True)]
    return st.tuples(*each).map(np.array)


@given(configurations(), st.sampled_from([STRAIGHT, DOWN]))
def test_the_urdf_moves_like_the_table(q: Array, tool_state: float) -> None:
    assert_allclose(arm_table.chain_tip(CELL.robot, q, tool_state), arm_table.tip(q, tool_state), atol=1e-12)


def test_home_holds_the_lance_level_at_the_stated_place(cell: Cell) -> None:
    T = arm_table.chain_tip(cell.robot, cell.configurations["home"].q, STRAIGHT)
    assert_allclose(T[:3, 3], (-0.605, 0.0, 1.716), atol=1e-3)
    assert_allclose(T[:3, 2], (1, 0, 0), atol=2e-3)


@pytest.mark.parametrize("letter", BINS)
def test_bin_poses_point_into_their_bin_and_the_turned_cup_down(cell: Cell, letter: str) -> None:
    named = cell.configurations[f"bin_{letter}"]
    assert (named.kind, named.tool_state) == ("bin", ToolState("straight"))
    T = arm_table.chain_tip(cell.robot, named.q, STRAIGHT)
    mouth = cell.pod.bins[f"bin_{letter}"].T_carrier_place[:3, 3]
    assert_allclose(T[0, 3], -0.30, atol=0.01)
    assert abs(T[1, 3] - mouth[1]) < 0.06
    assert 0.08 < T[2, 3] - mouth[2] < 0.14
    assert T[0, 2] > 0.998
    assert arm_table.chain_tip(cell.robot, named.q, DOWN)[2, 2] < -0.998


def test_each_bin_has_a_waiting_and_a_camera_pose_of_its_letter(cell: Cell) -> None:
    named = cell.configurations.values()
    for kind in ("bin", "camera"):
        assert sorted(each.place for each in named if each.kind == kind) == list(BINS)


def test_yardstick_poses_stand_over_the_tote_pointing_down(cell: Cell) -> None:
    poses = [c for c in cell.configurations.values() if c.kind == "yardstick"]
    assert len(poses) == 12
    for named in poses:
        T = arm_table.chain_tip(cell.robot, named.q, STRAIGHT)
        assert_allclose(T[2, 3], 0.752, atol=0.005)
        assert T[2, 2] < -0.998


def test_drop_poses_span_the_tote_under_the_drop_limit(cell: Cell) -> None:
    centres = []
    for named in (c for c in cell.configurations.values() if c.kind == "drop"):
        T = arm_table.chain_tip(cell.robot, named.q, cell.robot.tool.positions[named.tool_state])
        p = T[:3, 3] - cell.places["tote"].T_carrier_place[:3, 3]
        assert p[2] == pytest.approx(0.24, abs=1e-3)
        assert T[2, 2] < -0.86
        assert all(abs(p[:2]) < np.array(cell.places["tote"].room.size[:2]) / 2 - 0.08)
        centres.append((named.tool_state, *np.round(p[:2], 2)))
    assert len(centres) == len(set(centres)) == 12


def test_every_named_pose_of_delft_is_there(cell: Cell) -> None:
    bins = {f"{kind}_{letter}" for kind in ("bin", "cam") for letter in BINS}
    cells = {f"tote_{row}{column}{tool}" for row in "01" for column in "012" for tool in "vh"}
    assert bins | cells | {"home", "tote", "midway"} <= set(cell.configurations)
    assert cell.configurations["tote_02h"].q[-1] == pytest.approx(-0.1551)


def test_limits_are_delfts_and_jerk_builds_acceleration_up_in_50_ms(cell: Cell) -> None:
    limits = cell.robot.limits
    assert_allclose(limits.velocity, [1.0, 2.2, 2.2, 2.9, 2.9, 3.4, 3.4, 6.8])
    assert_allclose(limits.acceleration, [2, 5, 5, 6, 6, 7, 7, 10])
    assert_allclose(limits.acceleration / limits.jerk, 0.05)
    assert_allclose([limits.lower[0], limits.upper[0]], [0.05, 1.15])


@pytest.mark.parametrize("name", MESH_BOUNDS)
def test_link_shapes_reach_at_least_as_far_as_the_meshes(cell: Cell, name: str) -> None:
    lower, upper = extent(cell.robot.link(name))
    mesh_lower, mesh_upper = MESH_BOUNDS[name]
    assert np.all(lower <= np.array(mesh_lower) + 1e-9)
    assert np.all(upper >= np.array(mesh_upper) - 1e-9)


def test_the_chain_is_one_moving_joint_per_planned_name_and_the_tools(cell: Cell) -> None:
    robot = cell.robot
    assert [j.child for j in robot.joints] == [link.name for link in robot.links[1:]]
    moving = [j.name for j in robot.joints if j.type != "fixed"]
    assert moving == [*robot.joint_names, robot.tool.joint]
    assert set(robot.motor_forces) == set(moving)


def test_the_tool_is_54_cm_long(cell: Cell) -> None:
    q = np.zeros(8)
    straight, down = (arm_table.chain_tip(cell.robot, q, p)[:3, 3] for p in (STRAIGHT, DOWN))
    flange = np.array([-1.758, 0.0, 0.85 + 0.41 + 0.49 + 0.42 + 0.18])
    assert_allclose(straight - flange, (0, 0, 0.54), atol=1e-12)
    assert_allclose(down - flange, (0.03, 0, 0.51), atol=1e-12)


def test_every_allowed_pair_has_its_reason(cell: Cell) -> None:
    links = {link.name for link in cell.robot.links}
    assert cell.allowed_pairs
    for pair in cell.allowed_pairs:
        assert pair.a in links
        assert len(pair.reason.split()) >= 5


def extent(link: Link) -> tuple[Array, Array]:
    """Corners of the box around all shapes of a link, link frame."""
    lower, upper = np.full(3, np.inf), np.full(3, -np.inf)
    for body in link.bodies:
        T, size = body.T_parent_shape, body.shape.size
        if body.shape.kind is ShapeKind.CYLINDER:
            half = abs(T[:3, 2]) * size[1] / 2 + size[0] * np.sqrt(np.maximum(0.0, 1 - T[:3, 2] ** 2))
        elif body.shape.kind is ShapeKind.SPHERE:
            half = np.full(3, size[0])
        else:
            half = abs(T[:3, :3]) @ (np.array(size) / 2)
        lower = np.minimum(lower, T[:3, 3] - half)
        upper = np.maximum(upper, T[:3, 3] + half)
    return lower, upper


def test_a_cell_without_meshes_is_read_without_what_is_slow_to_import() -> None:
    program = (
        "import sys; from pickcli.cell.cell_file import load_cell; "
        "from pickcli.collision.robot_model import CollisionModel; "
        "CollisionModel(load_cell('apc2016_delft')); "
        "print([name for name in ('scipy', 'trimesh') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
