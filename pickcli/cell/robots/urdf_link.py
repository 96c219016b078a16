"""Reads a link of a URDF: mass properties, and collision shapes, with meshes as convex pieces."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from pickcli.cell.inertial import Inertial, assumed_inertial, box_inertia, is_possible
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
    inertial = element.optional("inertial")
    stated = None if inertial is None else mistakes.tried(partial(_stated_inertial, inertial), None)
    if stated is None:
        return Link(name, tuple(bodies), assumed_inertial(bodies), states_mass=False)
    if is_possible(stated.inertia):
        return Link(name, tuple(bodies), stated)
    in_box = replace(stated, inertia=box_inertia(stated.mass, bodies))
    return Link(name, tuple(bodies), in_box, corrects_inertia=bool(stated.inertia.any()))


def _stated_inertial(element: Element) -> Inertial | None:
    """Mass properties in the link, even if no body has them; None for a mass of 0."""
    mass, T_link_inertia = _mass(element), read_origin(element)
    if mass == 0.0:
        return None
    R = T_link_inertia[:3, :3]
    return Inertial(mass, T_link_inertia[:3, 3], R @ _inertia(element) @ R.T)


def _mass(inertial: Element) -> float:
    """Mass in kg."""
    element = inertial.one("mass")
    mass = element.number("value")
    if mass < 0.0:
        raise element.error(f"expected a mass of 0 kg or more, got {mass:g}")
    if mass > MAX_MASS:
        raise element.error(f"expected a mass of at most {MAX_MASS:g} kg, got {mass:g}")
    return mass


def _inertia(inertial: Element) -> Array:
    """Inertia (3, 3) in kg m^2 about the centre of mass, zeros where none is stated."""
    element = inertial.optional("inertia")
    if element is None:
        return np.zeros((3, 3))
    xx, xy, xz, yy, yz, zz = (
        element.number(name) if name in element.attributes else 0.0
        for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


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
