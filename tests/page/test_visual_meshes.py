"""Robots look as their URDF says, where what it names is there; else as their collision shapes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.files.packed_array import unpacked
from pickcli.page.cell_parts import robot_part
from pickcli.page.page_scene import PageLink
from pickcli.page.visual_meshes import fewer_triangles
from support.other_robots import write_robot

VISUALS = """<visual><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.02" length="0.3"/></geometry>
<material name="red"><color rgba="1 0 0 1"/></material></visual><visual><geometry>
<mesh filename="package://maker/meshes/{}.obj" scale="0.001 0.001 0.001"/></geometry></visual>"""


def looking(folder: Path, mesh: str) -> Cell:
    cell = write_robot(folder)
    urdf = cell / "robot.urdf"
    told = '<link name="upper">'
    urdf.write_text(urdf.read_text().replace(told, told + VISUALS.format(mesh)))
    return load_cell(cell)


def link_of(cell: Cell, name: str) -> PageLink:
    return next(link for link in robot_part(cell).links if link.name == name)


def test_visuals_are_drawn_with_their_colours(tmp_path: Path) -> None:
    cell = looking(tmp_path, "arm")
    rod, arm = link_of(cell, "upper").bodies
    assert (rod.shape.kind, rod.shape.size, rod.shape.colour) == ("cylinder", (0.02, 0.3), "#ff0000")
    assert rod.pose[:3] == (0.0, 0.0, 0.1)
    assert arm.shape.corners is not None and arm.shape.triangles is not None
    assert np.ptp(unpacked(arm.shape.corners), axis=0)[2] == pytest.approx(0.3, abs=1e-3)
    assert arm.shape.is_smooth
    lower = link_of(cell, "lower")
    assert [body.shape.kind for body in lower.bodies] == ["mesh"]  # its collision shape


def test_a_mesh_that_is_not_there_costs_nothing_but_its_looks(tmp_path: Path) -> None:
    upper = link_of(looking(tmp_path, "nowhere"), "upper")
    assert [body.shape.is_smooth for body in upper.bodies] == [False]


def test_meshes_are_made_of_few_triangles_near_the_surface() -> None:
    turn, rise = np.meshgrid(np.linspace(0, 2 * np.pi, 81), np.linspace(-1.4, 1.4, 81))
    ball = 0.1 * np.stack([np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)], axis=-1)
    corners = [ball[:-1, :-1], ball[1:, :-1], ball[:-1, 1:]], [ball[1:, 1:], ball[:-1, 1:], ball[1:, :-1]]
    triangles = np.concatenate([np.stack(each, axis=-2).reshape(-1, 3, 3) for each in corners])
    assert len(triangles) == 12800
    points, faces = fewer_triangles(triangles, 1000)
    assert 200 < len(faces) <= 1000 and faces.max() < len(points)
    assert np.abs(np.linalg.norm(points, axis=1) - 0.1).max() < 0.01
