"""What cameras see of scenes: every point that is seen is on the surface that it is said to be on."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell, load_workcell
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.cell.shapes import Shape, ShapeKind, hull
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array, inverse, pose, transform_points
from pickcli.kinematics.arm import Arm
from pickcli.perception.camera_pose import link_poses
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene, RenderedSolid
from pickcli.scene.scene import HeldItem, PlacedItem, Scene, empty_scene
from pickcli.verification.forward_kinematics import link_poses as verified_poses
from support.ray_reference import random_pose

CAMERA = PinholeCamera(150.0, 140.0, 79.5, 59.5, 160, 120)
STRAIGHT = ToolState("straight")
# Of a camera that looks along +x of the world, its columns to the right and its rows down.
R_FORWARD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


@cache
def cell() -> Cell:
    return load_cell("apc2016_delft")


def looking_forward(x: float, y: float, z: float) -> Array:
    T = pose((x, y, z))
    T[:3, :3] = R_FORWARD
    return T


def home() -> Array:
    return cell().configurations["home"].q


def over_surface(shape: Shape, points: Array) -> Array:
    """How far points in a shape's frame are outside of it, m; of a hull and a box by their faces."""
    if shape.kind is ShapeKind.SPHERE:
        return np.asarray(np.linalg.norm(points, axis=1) - shape.size[0])
    if shape.kind is ShapeKind.CYLINDER:
        radius, length = shape.size
        across = np.linalg.norm(points[:, :2], axis=1) - radius
        return np.asarray(np.maximum(across, np.abs(points[:, 2]) - length / 2))
    if shape.kind is ShapeKind.BOX:
        return np.asarray((np.abs(points) - np.array(shape.size) / 2).max(axis=1))
    directions = np.random.default_rng(0).normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    reach = (directions @ np.array(shape.vertices).T).max(axis=1)
    return np.asarray((points @ directions.T - reach).max(axis=1))


def items_in_bins() -> tuple[PlacedItem, ...]:
    names = ("dasani_water_bottle", "crayola_24_ct", "rawlings_baseball", "i_am_a_bunny_book")
    bins = ("bin_D", "bin_E", "bin_F", "bin_H")
    found = []
    for name, place in zip(names, bins, strict=True):
        item, frame = cell().item(name), cell().T_world_place(cell().places[place])
        found.append(PlacedItem(name, item, place, frame @ pose((0.15, 0.0, 0.12), rpy=(0.3, 0.2, 0.9))))
    return tuple(found)


def test_points_lie_on_the_surfaces_of_their_solids() -> None:
    """Of all items, the shelf and the arm, from the front and from behind the arm."""
    scene = empty_scene(cell())
    scene = Scene(scene.cell, scene.T_world_pod, items_in_bins(), scene.noise)
    rendered, owners = RenderedScene.of(scene, home(), STRAIGHT), set()
    for T in (looking_forward(-0.7, 0.0, 1.4), looking_forward(-3.0, 0.0, 1.3)):
        view = rendered.seen_by(CAMERA, T)
        for i in np.unique(view.index[view.index >= 0]):
            solid = rendered.solids[i]
            points = view.points[view.index == i].astype(np.float64)
            local = transform_points(inverse(solid.T_world_shape) @ T, points)
            grazing = 1.0 / np.cos(np.minimum(view.incidence[view.index == i], 1.55))
            assert (np.abs(over_surface(solid.shape, local)) < 2e-5 * grazing).all()
            owners.add((solid.kind, solid.owner))
    assert {(OwnerKind.ITEM, placed.id) for placed in scene.items} <= owners
    assert {(OwnerKind.CARRIER, "pod"), (OwnerKind.LINK, "link_l")} <= owners


def test_a_held_item_is_seen_at_the_tip_and_not_where_it_was() -> None:
    scene, tip = empty_scene(cell()), Arm(cell().robot).tip(home(), STRAIGHT)
    items, T_tip_item = items_in_bins(), pose((0.0, 0.0, 0.05))
    held = HeldItem(items[0].id, items[0].item, T_tip_item)
    rendered = RenderedScene.of(
        Scene(scene.cell, scene.T_world_pod, items, scene.noise, held=held), home(), STRAIGHT
    )
    (index,) = rendered.indices_of(held.id)
    np.testing.assert_allclose(rendered.solids[index].T_world_shape, tip @ T_tip_item)


def test_links_are_where_kinematics_puts_them() -> None:
    """The cup's link and the tip differ by the fixed pose of the tool frame; the root stands at its base."""
    robot = cell().robot
    poses = link_poses(robot, home(), STRAIGHT)
    tip = Arm(robot).tip(home(), STRAIGHT)
    np.testing.assert_allclose(poses[robot.tool.last_link] @ robot.tool.T_last_tip, tip, atol=1e-12)
    np.testing.assert_array_equal(poses[robot.links[0].name], robot.T_world_base)


@pytest.mark.parametrize("name", ["apc2016_kth", "apc2016_delft_pinch", "panda_table"])
def test_links_are_where_the_second_opinion_puts_them(name: str) -> None:
    """Of all arms, also of those that stand, but for what hangs on a joint of the tool."""
    for seen in load_workcell(name).arms.values():
        robot = seen.robot
        of_tool = {joint.child for joint in robot.joints if joint.name in robot.tool.joints}
        for at in list(seen.configurations.values())[:3]:
            poses, expected = link_poses(robot, at.q, at.tool_state), verified_poses(robot, at.q[None])
            for link, T in zip(robot.links, expected[:, 0], strict=True):
                parents = {joint.child: joint.parent for joint in robot.joints}
                above = link.name
                while above in parents and above not in of_tool:
                    above = parents[above]
                if above not in of_tool:
                    np.testing.assert_allclose(poses[link.name], T, atol=1e-9)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_hulls_are_seen_as_their_convex_pieces(seed: int) -> None:
    """All points are on the surface, and the corners that can be seen are seen at their places."""
    rng = np.random.default_rng(seed)
    body = hull("piece", rng.uniform(-0.2, 0.2, (12, 3)))
    T_world_camera, T = np.eye(4), pose((0.0, 0.0, 1.0)) @ random_pose(rng, 0.0)
    view = RenderedScene((RenderedSolid(OwnerKind.LINK, "link", body.shape, T),)).seen_by(
        CAMERA, T_world_camera
    )
    assert (view.index == 0).sum() > 100
    points = transform_points(inverse(T), view.points[view.index == 0].astype(np.float64))
    over = over_surface(body.shape, points)
    assert over.max() < 1e-5
    assert over.min() > -0.02  # the directions of the oracle miss corners and edges by a few degrees
    corners = CAMERA.project(transform_points(T, np.array(body.shape.vertices)))
    rows, columns = np.nonzero(view.index == 0)
    low, high = corners.min(axis=0), corners.max(axis=0)
    assert (columns >= low[0] - 1e-3).all()
    assert (columns <= high[0] + 1e-3).all()
    assert (rows >= low[1] - 1e-3).all()
    assert (rows <= high[1] + 1e-3).all()
    assert columns.max() - columns.min() > high[0] - low[0] - 12.0


def test_points_project_to_their_pixels() -> None:
    u, v = np.meshgrid(np.arange(160), np.arange(120))
    pixels = CAMERA.project(CAMERA.rays * 1.7)
    np.testing.assert_allclose(pixels, np.stack([u, v], axis=-1), atol=1e-9)
    points = CAMERA.rays[5, 7] * 2.0
    np.testing.assert_allclose(CAMERA.K @ points / points[2], [7.0, 5.0, 1.0])


def test_incidence_is_the_angle_to_the_normal() -> None:
    """A wall turned by 40 degrees about the vertical is met at 40 degrees in the middle of the picture."""
    T = pose((0.0, 0.0, 1.0), rpy=(0.0, np.radians(40.0), 0.0))
    wall = RenderedSolid(OwnerKind.CARRIER, "wall", Shape(ShapeKind.BOX, (4.0, 4.0, 0.1)), T)
    view = RenderedScene((wall,)).seen_by(PinholeCamera(100.0, 100.0, 50.0, 50.0, 101, 101), np.eye(4))
    assert view.incidence[50, 50] == pytest.approx(np.radians(40.0), abs=1e-6)
