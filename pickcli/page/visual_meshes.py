"""Reads visuals of a robot's links from its URDF: shapes and simplified meshes, with colours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.robots.mesh_names import MeshNames
from pickcli.cell.robots.urdf_origin import read_origin
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import InputError
from pickcli.files.xml_reader import Element, read_xml
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array
from pickcli.meshes.mesh_file import parse_triangles, read_mesh_bytes
from pickcli.page.page_scene import PageBody, PageShape, posed
from pickcli.page.shape_parts import drawn_shape, mesh

MOST_TRIANGLES = 5000  # per mesh
FINEST = 5e-4  # m, initial distance within which corners are merged
_SIZES = {"cylinder": ("radius", "length"), "sphere": ("radius",)}


def visual_bodies(cell: Cell) -> dict[str, tuple[PageBody, ...]]:
    """Read the visual bodies of a robot's links.

    Args:
        cell: The cell.

    Returns:
        Bodies by link. Links without visuals, or with missing meshes, are left out; pages draw their
        collision shapes instead.
    """
    urdf = cell.robot.urdf
    if urdf.suffix != ".urdf":  # several robots have no common file
        return {}
    robot, meshes = read_xml(urdf), MeshNames(urdf, cell.path, _packages(cell))
    colours = dict(_colours(robot))
    found = {}
    for link in robot.all("link"):
        try:
            bodies = tuple(_body(visual, link, meshes, colours) for visual in link.all("visual"))
        except InputError:
            continue
        if bodies:
            found[link.text("name")] = bodies
    return found


def fewer_triangles(triangles: Array, most: int = MOST_TRIANGLES) -> tuple[Array, Array]:
    """Simplify a mesh by merging corners that are close together.

    Args:
        triangles: (T, 3, 3) m.
        most: Largest number of triangles.

    Returns:
        Corners (V, 3) in m and triangles (F, 3), with F at most ``most``.
    """
    points, grid = triangles.reshape(-1, 3), FINEST
    while True:
        _, which = np.unique(np.round(points / grid), axis=0, return_inverse=True)
        corners = np.zeros((which.max() + 1, 3))
        np.add.at(corners, which, points)
        corners /= np.bincount(which)[:, None]
        faces = which.reshape(-1, 3)
        a, b, c = faces.T
        faces = faces[(a != b) & (b != c) & (c != a)]
        if len(faces) <= most:
            return corners, faces
        grid *= 1.5


def _packages(cell: Cell) -> dict[str, Path]:
    """Folders of the packages stated in the cell file."""
    data = read_yaml(cell.path / "cell.yaml").data
    stated = data.get("robot", {}).get("packages", {})
    return {name: cell.path / folder for name, folder in stated.items()}


def _colours(robot: Element) -> Iterator[tuple[str, str]]:
    """Named materials of a robot with their colours."""
    for material in robot.all("material"):
        if "name" in material.attributes and (colour := _colour(material, {})):
            yield material.text("name"), colour


def _body(visual: Element, link: Element, meshes: MeshNames, colours: Mapping[str, str]) -> PageBody:
    """Convert a visual. Raises InputError if a mesh is missing, or the URDF is malformed."""
    material = visual.optional("material")
    colour = "" if material is None else _colour(material, colours)
    (element,) = visual.one("geometry").children
    return PageBody(link.text("name"), _shape(element, meshes, colour), posed(read_origin(visual)))


def _shape(element: Element, meshes: MeshNames, colour: str) -> PageShape:
    if element.tag == "mesh":
        path = meshes.find(element)
        scale = element.numbers("scale", 3) if "scale" in element.attributes else (1.0, 1.0, 1.0)
        corners, triangles = fewer_triangles(parse_triangles(path, read_mesh_bytes(path), scale))
        return mesh(corners, triangles, colour, is_smooth=True)
    if element.tag == "box":
        return drawn_shape(Shape(ShapeKind.BOX, element.numbers("size", 3)), colour)
    if element.tag not in _SIZES:
        raise element.error("expected box, cylinder, sphere or mesh")
    size = tuple(element.number(name) for name in _SIZES[element.tag])
    return drawn_shape(Shape(ShapeKind(element.tag), size), colour)


def _colour(material: Element, known: Mapping[str, str]) -> str:
    """Colour as #rrggbb: stated or by the material's name; "" if unknown."""
    stated = material.optional("color")
    if stated is None:
        return known.get(material.attributes.get("name", ""), "")
    red, green, blue, _ = np.clip(stated.numbers("rgba", 4), 0.0, 1.0)
    return "#" + "".join(f"{round(255 * part):02x}" for part in (red, green, blue))
