"""The simulated robot is the one that was planned for and verified: a tree with meshes, posture and tool."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell, load_workcell
from pickcli.cell.robot import Robot
from pickcli.cell.shapes import Body, Shape, ShapeKind, hull
from pickcli.errors import InputError
from pickcli.geometry import pose
from pickcli.motion.plan import Plan
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.robot_urdf import solid_cup, write_urdf
from pickcli.simulation.scene_bodies import jointed_pairs
from pickcli.simulation.world import ROBOT, World
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.forward_kinematics import link_poses
from support.other_robots import write_robot

MARGIN = 1e-3  # m that the engine puts around hulls


@pytest.fixture(scope="module")
def branching(tmp_path_factory: pytest.TempPathFactory) -> Cell:
    """The branching robot, with the devices that a simulated cell has."""
    return load_cell(write_robot(tmp_path_factory.mktemp("branching")))


def scene_of(cell: Cell) -> Scene:
    return Scene(cell, cell.T_world_pod, (), PoseNoise(0.0, 0.0))


@pytest.fixture
def world(branching: Cell) -> Iterator[World]:
    world = World(scene_of(branching), branching.configurations["home"].q)
    yield world
    world.close()


@pytest.mark.parametrize("q", [(0.0, 0.3, 0.0), (2.5, -0.6, 1.0), (-3.1, 1.9, -2.9), (4.0, 0.0, 0.0)])
def test_every_link_stands_where_the_verifier_has_it(branching: Cell, q: tuple[float, ...]) -> None:
    world = World(scene_of(branching), np.array(q))
    expected = link_poses(branching.robot, np.array([q]))[:, 0]
    for link, T in zip(branching.robot.links, expected, strict=True):
        np.testing.assert_allclose(world.engine.pose(ROBOT, link.name), T, atol=1e-6, err_msg=link.name)


def test_only_planned_joints_move(world: World, branching: Cell) -> None:
    assert set(world.engine.joints(ROBOT)) == set(branching.robot.joint_names)


def test_meshes_are_as_large_as_what_was_verified(world: World, branching: Cell) -> None:
    robot = branching.robot
    T = dict(zip((link.name for link in robot.links), link_poses(robot, world.q[None])[:, 0], strict=True))
    for name in ("upper", "lower"):
        (piece,) = robot.link(name).bodies
        mine, bodies = Solid(piece.shape), [*branching.tote_bodies, *branching.obstacles.bodies]
        mine.place(T[name] @ piece.T_parent_shape)
        for body in bodies:
            other = Solid(body.shape)
            other.place(body.T_parent_shape)
            simulated = world.engine.distance(ROBOT, name, body.name, 5.0)
            assert -2 * MARGIN < simulated - mine.distance(other) <= 1e-6


def test_links_that_the_srdf_exempts_or_no_joint_parts_do_not_collide(tmp_path: Path) -> None:
    folder = write_robot(tmp_path)
    urdf = folder / "robot.urdf"
    # The camera reaches through the lower arm, the fingers through each other.
    urdf.write_text(urdf.read_text().replace("0.05 0.05 0.05", "0.9 0.9 0.9"))
    cell = load_cell(folder)
    home = cell.configurations["home"].q

    def touched(cell: Cell) -> set[tuple[str, str]]:
        world = World(scene_of(cell), home)
        world.step()
        pairs = {(c.a, c.b) for c in world.contacts.collisions}
        world.close()
        return {(a, b) for a, b in pairs if "camera" in (a, b)}

    assert touched(cell)
    assert not any({"lower", "camera"} == set(pair) for pair in touched(cell))
    without = replace(cell, allowed_pairs=())
    assert any({"lower", "camera"} == set(pair) for pair in touched(without))
    assert not any({"upper", "camera"} == set(pair) for pair in touched(without))


def plan_of(cell: Cell) -> Plan:
    home, away = cell.configurations["home"], cell.configurations["away"]
    start = Start(home.q, home.tool_state)
    return plan_move(PlanningContext(cell), scene_of(cell), start, MoveGoal(away.q), seed=1)


def test_a_plan_is_followed_as_well_as_by_the_default_robot(branching: Cell) -> None:
    world = World(scene_of(branching), branching.configurations["home"].q)
    execution = execute(plan_of(branching), world)
    assert execution.stop is None
    assert (execution.collisions, execution.limit_violations) == ((), ())
    assert execution.max_lag < 3e-3
    np.testing.assert_allclose(world.q, branching.configurations["away"].q, atol=1e-4)


def test_what_is_written_is_read_back_as_the_same_tree(branching: Cell, tmp_path: Path) -> None:
    path = write_urdf(branching.robot, tmp_path)
    root = ElementTree.parse(path).getroot()
    assert [e.get("name") for e in root.findall("link")] == [link.name for link in branching.robot.links]
    assert {e.get("filename") for e in root.iter("mesh")} == {p.name for p in tmp_path.glob("*.obj")}
    assert all(float(e.get("value", "nan")) > 0.0 for e in root.iter("mass"))
    assert max(map(len, path.read_text().splitlines())) < 1000  # the engine breaks lines of 8 kB


def cup(robot: Robot, *shapes: Shape) -> tuple[Body, ...]:
    return tuple(Body(f"cup_{i}", shape, pose((0.0, 0.0, 0.02))) for i, shape in enumerate(shapes))


def test_the_cup_ends_where_its_bellows_give_no_more(branching: Cell) -> None:
    robot, tool = branching.robot, branching.robot.tool
    upright = Shape(ShapeKind.CYLINDER, (0.015, 0.04))
    corners = np.array([(x, y, z) for x in (-0.01, 0.01) for y in (-0.01, 0.01) for z in (0.0, 0.04)])
    shapes = (*cup(robot, upright, Shape(ShapeKind.SPHERE, (0.02,))), hull("cup_mesh", corners))
    end = float(tool.T_last_tip[2, 3]) - tool.cup.stroke
    for body in solid_cup(tool, shapes):
        top = body.T_parent_shape[2, 3] + body.shape.reach(body.T_parent_shape[:3, :3])[2]
        assert top <= end
    kinds = [body.shape.kind for body in solid_cup(tool, shapes)]
    assert kinds == [ShapeKind.CYLINDER, ShapeKind.BOX, ShapeKind.BOX]


def test_a_cell_without_a_valve_is_told_what_is_missing(branching: Cell) -> None:
    cell = replace(branching, devices={"pump": branching.devices["pump"]})
    with pytest.raises(InputError, match="has no device of kind valve"):
        World(scene_of(cell), cell.configurations["home"].q)


def test_a_robot_alone_plays_its_plans(tmp_path: Path) -> None:
    """No tool, no pod, no tote, no devices, and nothing that stands."""
    folder = write_robot(tmp_path)
    content = yaml.safe_load((folder / "cell.yaml").read_text())
    for key in ("tool", "pod", "tote"):
        del content[key]
    content["robot"] |= {"tip": "flange", "unshaped": ["flange"]}
    content |= {"devices": {}, "obstacles": []}
    (folder / "cell.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    cell = load_cell(folder)
    world = World(scene_of(cell), cell.configurations["home"].q)
    execution = execute(plan_of(cell), world)
    assert (execution.stop, execution.collisions, execution.limit_violations) == (None, (), ())
    np.testing.assert_allclose(world.q, cell.configurations["away"].q, atol=1e-4)


def test_links_that_a_joint_connects_through_one_without_a_shape_are_left_out() -> None:
    """As planner and verifier have it: between the PR2's wrist and palm is a link without a shape."""
    robot = load_workcell("pr2_belt").cell("left").robot
    pairs = set(jointed_pairs(robot))
    assert ("l_gripper_palm_link", "l_wrist_flex_link") in pairs
    assert ("l_wrist_flex_link", "l_forearm_link") in pairs
    assert not any({"l_gripper_palm_link", "l_forearm_link"} == set(pair) for pair in pairs)
