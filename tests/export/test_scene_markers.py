"""Markers and description of what is no box, cylinder or ball."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import hull
from pickcli.export.robot_description import robot_description
from pickcli.export.scene_markers import POINTS, TRIANGLE_LIST, cell_markers
from pickcli.geometry import Array, pose, transform_points
from pickcli.scene.cloud import Cloud
from pickcli.scene.scene import PoseNoise, Scene

TETRAHEDRON = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.1]])


def points_of(marker: dict[str, Any]) -> Array:
    """The points (N, 3) of a marker."""
    return np.array([[p["x"], p["y"], p["z"]] for p in marker["points"]])


def test_a_hull_is_shown_by_its_triangles(cell: Cell) -> None:
    obstacles = replace(cell.obstacles, bodies=(hull("rock", TETRAHEDRON),))
    scene = Scene(replace(cell, obstacles=obstacles), cell.T_world_pod, (), PoseNoise())
    rock = cell_markers(scene, "world")[-1]
    assert rock["type"] == TRIANGLE_LIST and len(rock["points"]) == 12
    position = rock["pose"]["position"]
    corners = points_of(rock) + np.array([position[axis] for axis in "xyz"])
    assert {tuple(np.round(c, 12)) for c in corners} == {tuple(c) for c in TETRAHEDRON}


def test_a_cloud_is_shown_where_its_points_are(cell: Cell) -> None:
    measured = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
    cloud = Cloud(Path("cloud.npy"), pose((1.0, 0.0, 0.0)), measured, 0.005, 0.001)
    scene = Scene(cell, cell.T_world_pod, (), PoseNoise(), cloud=cloud)
    marker = cell_markers(scene, "world")[-1]
    assert (marker["type"], marker["ns"], marker["scale"]["x"]) == (POINTS, "cloud", 0.01)
    np.testing.assert_allclose(points_of(marker), transform_points(cloud.T_world_sensor, measured))


def test_a_link_of_meshes_is_described_by_boxes_around_their_pieces(cell: Cell) -> None:
    body = hull("piece", TETRAHEDRON)
    link = replace(cell.robot.links[1], bodies=(body,))
    robot = replace(cell.robot, links=(cell.robot.links[0], link, *cell.robot.links[2:]))
    root = ElementTree.fromstring(robot_description(robot))
    described = next(each for each in root.findall("link") if each.attrib["name"] == link.name)
    box = described.find("visual/geometry/box")
    assert box is not None and box.attrib["size"] == "0.3 0.2 0.1"
    assert root.find(".//mesh") is None
