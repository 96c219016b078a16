"""Pictures of stored files: what they show is what the files hold, and they are drawn the same each time."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import ANY_POD
from pickcli.cell.shapes import ShapeKind
from pickcli.cell.tool import MOVING
from pickcli.drawing.draw import cell_of, picture_of, write_png
from pickcli.drawing.picture import Colour, Picture
from pickcli.drawing.png import png_bytes
from pickcli.drawing.scenery import arm_solids, skeleton, solids, tool_path
from pickcli.drawing.stored import database_picture, roadmap_picture
from pickcli.errors import InputError, Reason, StaleError
from pickcli.geometry import inverse, transform_points
from pickcli.kinematics.arm import Arm
from pickcli.motion.path import JointPath
from pickcli.motion.trajectory import Trajectory
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.roadmap_tables import RoadmapGaps
from pickcli.roadmap.store import write_database, write_roadmap
from pickcli.roadmap.trajectory_database import CoarseMotion, MotionKey, PayloadClass, TrajectoryDatabase
from pickcli.verification.forward_kinematics import link_poses
from support.other_robots import write_robot
from support.tool_states import STRAIGHT

NAMES = ("home", "bin_A", "bin_B", "cam_A", "tote")
MISSING = ((MotionKey("bin_A", "tote", PayloadClass.EMPTY), Reason("no path")),)


@pytest.fixture(scope="module")
def cell() -> Cell:
    whole = load_cell("apc2016_delft")
    return replace(whole, configurations={name: whole.configurations[name] for name in NAMES})


def _roadmap(cell: Cell) -> Roadmap:
    """A ring of home, bin_A, bin_B, and the tote beside it; nobody asks whether it is free."""
    roadmap = Roadmap.empty(cell.robot.joint_names)
    for name in ("home", "bin_A", "bin_B", "tote"):
        roadmap, _ = roadmap.with_node(cell.configurations[name].q, name)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        roadmap = roadmap.with_edge(a, b, roadmap.configurations[[a, b]], ANY_POD)
    return roadmap.with_edge(0, 3, roadmap.configurations[[0, 3]])


def _database(cell: Cell) -> TrajectoryDatabase:
    return TrajectoryDatabase.of(
        cell.robot.joint_names, [_motion(cell, "home", "bin_A"), _motion(cell, "bin_B", "tote")]
    )


def _motion(cell: Cell, start: str, goal: str) -> CoarseMotion:
    names, Q = cell.robot.joint_names, np.stack([cell.configurations[name].q for name in (start, goal)])
    timed = Trajectory(names, np.array([0.0, 2.0]), Q, np.zeros_like(Q), np.zeros_like(Q))
    key = MotionKey(start, goal, PayloadClass.EMPTY)
    return CoarseMotion(key, MOVING, JointPath(names, Q), 2.0, timed, 1.6)


def _drawn(cell: Cell) -> tuple[Picture, Picture]:
    return roadmap_picture(cell, _roadmap(cell), RoadmapGaps()), database_picture(
        cell, _database(cell), MISSING
    )


def test_an_edge_is_drawn_where_the_tip_goes(cell: Cell) -> None:
    arm, Q = Arm(cell.robot), np.stack([cell.configurations[name].q for name in ("home", "bin_A", "tote")])
    points = tool_path(Q, arm)
    ends = arm.tips(Q, STRAIGHT)[:, :3, 3]
    np.testing.assert_allclose(points[[0, -1]], ends[[0, -1]], atol=1e-12)
    assert np.linalg.norm(points - ends[1], axis=1).min() < 1e-12
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() < 0.15


def test_solids_are_the_cells_bodies_but_for_the_floor(cell: Cell) -> None:
    drawn = solids(cell)
    bodies = [*cell.pod.bodies, *cell.tote_bodies, *cell.obstacles.bodies]
    assert len(drawn) == len(bodies) - 1
    low = cell.obstacles.bodies[1].T_parent_shape[:3, 3] - cell.obstacles.bodies[1].shape.extents / 2
    assert any(np.allclose(solid.corners.min(axis=0), low) for solid in drawn)


@pytest.fixture(scope="module")
def branching(tmp_path_factory: pytest.TempPathFactory) -> Cell:
    return load_cell(write_robot(tmp_path_factory.mktemp("branching")))


def test_the_arm_is_drawn_where_its_links_are_meshes_as_their_pieces(branching: Cell) -> None:
    robot, home = branching.robot, branching.configurations["home"]
    drawn = arm_solids(branching, Arm(robot))
    shapes = [(i, body) for i, link in enumerate(robot.links) for body in link.bodies]
    assert len(drawn) == len(shapes)
    poses = link_poses(robot, home.q[None])[:, 0]
    for solid, (i, body) in zip(drawn, shapes, strict=True):
        T = poses[i] @ body.T_parent_shape
        local = transform_points(inverse(T), solid.corners)
        np.testing.assert_allclose(np.ptp(local, axis=0), body.shape.extents, rtol=0.06)
        assert np.all(np.abs(local).max(axis=0) <= body.shape.extents / 2 + 1e-9)
        if body.shape.kind is ShapeKind.HULL:
            corners = {tuple(corner) for corner in np.round(local, 9).tolist()}
            assert corners == {tuple(corner) for corner in np.round(body.shape.vertices, 9).tolist()}
        # Closed: every edge belongs to two triangles.
        edges = np.sort(np.concatenate([solid.faces[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))]), axis=1)
        assert set(np.unique(edges, axis=0, return_counts=True)[1].tolist()) == {2}


def test_the_skeleton_runs_from_the_base_to_the_tip_past_all_branches(branching: Cell) -> None:
    arm, home = Arm(branching.robot), branching.configurations["home"]
    points = skeleton(branching, arm).points
    np.testing.assert_allclose(points[0], branching.robot.T_world_base[:3, 3])
    np.testing.assert_allclose(points[-1], arm.tip(home.q, home.tool_state)[:3, 3])
    assert len(points) == 8  # the base, column, upper, lower, flange, mount, cup, tip


def test_an_arm_of_meshes_is_drawn_in_both_kinds(branching: Cell) -> None:
    picture = roadmap_picture(branching, Roadmap.empty(branching.robot.joint_names), RoadmapGaps())
    assert sum(solid.ink is Colour.ARM for solid in picture.solids) >= 8
    assert png_bytes(picture)


def test_a_roadmaps_picture_has_every_node_and_edge_and_counts_routes(cell: Cell) -> None:
    picture, _ = _drawn(cell)
    assert [node.name for node in picture.nodes] == ["home", "bin_A", "bin_B", "tote"]
    edges = picture.lines[1:]
    assert [line.ink for line in edges] == [Colour.GOOD, Colour.GOOD, Colour.GOOD, Colour.FAIR]
    assert edges[0].name == "home to bin_A"
    assert picture.coverage is not None
    counts = {bar.name: bar.counts for bar in picture.coverage.bars}
    # bin_A: two routes to bin_B and home, one to the tote, none to its camera pose; nor has that to the tote
    assert counts["bin_A"] == (2, 1, 2)
    assert counts["bin_B"] == (2, 1, 0)
    assert counts["bin_L"] == (0, 0, 0)


def test_a_databases_picture_counts_what_is_stored_and_missing(cell: Cell) -> None:
    _, picture = _drawn(cell)
    assert picture.coverage is not None
    counts = {bar.name: bar.counts for bar in picture.coverage.bars}
    assert counts["bin_A"] == (0, 1, 1) and counts["bin_B"] == (0, 1, 0)
    assert picture.words == ("2 of 3 wanted motions are stored", "4 s in all, 1.250 times their lower bounds")


def test_the_image_is_one_and_shows_every_colour_of_its_lines(cell: Cell) -> None:
    picture, _ = _drawn(cell)
    content = png_bytes(picture)
    assert content == png_bytes(picture)
    image = Image.open(io.BytesIO(content)).convert("RGB")
    assert min(image.size) >= 1000
    seen = {tuple(pixel) for pixel in np.unique(np.asarray(image).reshape(-1, 3), axis=0).tolist()}
    assert {_rgb(Colour.BAD), _rgb(Colour.FAIR), _rgb(Colour.BIN)} <= seen


def test_an_empty_roadmap_can_be_drawn(cell: Cell) -> None:
    picture = roadmap_picture(cell, Roadmap.empty(cell.robot.joint_names), RoadmapGaps())
    assert png_bytes(picture)


def test_files_are_drawn_by_their_kind(cell: Cell, tmp_path: Path) -> None:
    stored = tmp_path / "roadmap.h5", tmp_path / "trajectories.h5"
    write_roadmap(stored[0], _roadmap(cell), cell.fingerprint, {})
    write_database(stored[1], _database(cell), cell.fingerprint, {}, MISSING)
    for path, drawn in zip(stored, _drawn(cell), strict=True):
        picture, output = picture_of(path, cell), path.with_suffix(".png")
        assert picture.title == drawn.title and picture.words == drawn.words
        write_png(picture, output)
        assert output.read_bytes() == png_bytes(drawn)
        with pytest.raises(InputError, match="exists by now"):
            write_png(picture, output, replace=False)
        with pytest.raises(StaleError):
            picture_of(path, replace(cell, fingerprint="0" * 64))


def test_a_cell_is_found_by_its_fingerprint(cell: Cell) -> None:
    assert cell_of(cell.fingerprint).name == cell.name
    with pytest.raises(InputError, match="name the one of this file with --cell"):
        cell_of("0" * 64)


def _rgb(ink: Colour) -> tuple[int, int, int]:
    return int(ink[1:3], 16), int(ink[3:5], 16), int(ink[5:7], 16)
