"""Reads a link of a URDF: mass, centre of mass, and collision shapes, with meshes as convex pieces."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from pickcli.cell.robot import Link
from pickcli.cell.robots.mesh_names import MeshNames
from pickcli.cell.robots.urdf_origin import MAX_SIZE, read_origin
from pickcli.cell.shapes import Body, MeshPiece, Shape, ShapeKind, hull
from pickcli.errors import InputError
from pickcli.files.xml_mistakes import XmlMistakes
from pickcli.files.xml_reader import Element
from pickcli.geometry import Array, inverse, transform_points
from pickcli.meshes.mesh_pieces import mesh_pieces

MAX_MASS = 1e4  # kg; larger masses were written in another unit


def read_link(element: Element, meshes: MeshNames, mistakes: XmlMistakes) -> Link:
    """Read a link.

    Args:
        element: The link element.
        meshes: Resolves the names of mesh files.
        mistakes: Collects what is wrong with it.

    Returns:
        The link, without wrong values.
    """
    name = element.text("name")
    bodies: list[Body] = []
    for i, collision in enumerate(element.all("collision")):
        bodies += mistakes.tried(partial(_bodies, collision, f"{name}_{i}", meshes), [])
    mass = mistakes.tried(lambda: _mass(element), 0.0)
    return Link(name, tuple(bodies), mass, mistakes.tried(lambda: _T_link_inertia(element), np.eye(4)))


def _mass(link: Element) -> float:
    """Mass in kg, 0 if none is stated."""
    inertial = link.optional("inertial")
    if inertial is None:
        return 0.0
    element = inertial.one("mass")
    mass = element.number("value")
    if mass < 0.0:
        raise element.error(f"expected a mass of 0 kg or more, got {mass:g}")
    if mass > MAX_MASS:
        raise element.error(f"expected a mass of at most {MAX_MASS:g} kg, got {mass:g}")
    return mass


def _T_link_inertia(link: Element) -> Array:
    """Pose (4, 4) of the centre of mass in the link."""
    inertial = link.optional("inertial")
    return np.eye(4) if inertial is None else read_origin(inertial)


def _bodies(collision: Element, default_name: str, meshes: MeshNames) -> list[Body]:
    """Body of a collision element; of a mesh its convex pieces, which share a name."""
    name = collision.attributes.get("name", default_name)
    geometry, T_link_shape = collision.one("geometry"), read_origin(collision)
    if len(geometry.children) != 1:
        raise geometry.error("expected exactly one shape")
    element = geometry.children[0]
    if element.tag != "mesh":
        return [Body(name, _shape(element), T_link_shape)]
    path = meshes.find(element)
    scale = element.numbers("scale", 3) if "scale" in element.attributes else (1.0, 1.0, 1.0)
    if not all(scale):
        raise element.error(f"expected factors other than 0 as scale, got {' '.join(map(str, scale))}")
    try:
        pieces = mesh_pieces(path, scale)
    except InputError as error:
        raise element.error(str(error)) from None
    hulls = (hull(name, transform_points(T_link_shape, piece)) for piece in pieces)
    return [
        replace(each, piece_of=MeshPiece(path, tuple(scale), inverse(each.T_parent_shape) @ T_link_shape))
        for each in hulls
    ]


def _shape(element: Element) -> Shape:
    if element.tag == "box":
        size = element.numbers("size", 3)
    elif element.tag == "cylinder":
        size = (element.number("radius"), element.number("length"))
    elif element.tag == "sphere":
        size = (element.number("radius"),)
    else:
        raise element.error("expected box, cylinder, sphere or mesh; enclose the part in those")
    if min(size) <= 0.0:
        raise element.error(f"expected sizes over 0 m, got {' '.join(map(str, size))}")
    if max(size) > MAX_SIZE:
        listed = " ".join(map(str, size))
        raise element.error(
            f"expected sizes of at most {MAX_SIZE:g} m, got {listed}; lengths are in m, not mm"
        )
    return Shape(ShapeKind(element.tag), size)
