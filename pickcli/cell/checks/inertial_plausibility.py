"""Warnings for masses and inertias of moving links that are not stated, or that hardly any link has."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.robot import Link
from pickcli.files.file_warnings import FileWarnings
from pickcli.files.source import Key

FAR = 1.5  # radius of gyration over the reach of a link's shapes, which may leave parts out
DENSE = 20_000.0  # kg/m3 of the boxes around a link's shapes, more than gold's


def warn_of_masses(warnings: FileWarnings, cell: Cell) -> None:
    """Warn of moving links whose mass or inertia is not stated, or is one that no body has.

    Args:
        warnings: Collects them.
        cell: The cell.
    """
    links, urdf = _moved_links(cell), ("robot", "urdf")

    def add(kind: str, why: Callable[[Link], str], cause: str) -> None:
        told = {link.name: why(link) for link in links}
        found: dict[str, tuple[Key, str]] = {
            name: (urdf, f"link {name!r} {text}") for name, text in told.items() if text
        }
        warnings.add_alike(kind, found, urdf, cause)

    add("no_mass", _without_mass, "state the masses of the links in the URDF")
    add("odd_inertia", _odd_inertia, "are they about the centres of mass, in kg m^2?")
    add("heavy_link", _too_dense, "are the masses in the URDF in kg, not g?")


def _moved_links(cell: Cell) -> list[Link]:
    """The links with shapes that the planned joints move."""
    moved: set[str] = set()
    for joint in cell.robot.joints:
        if joint.parent in moved or joint.name in cell.robot.joint_names:
            moved.add(joint.child)
    return [link for link in cell.robot.links if link.name in moved and link.bodies]


def _without_mass(link: Link) -> str:
    if link.states_mass:
        return ""
    return "has no <inertial>, or one of 0 kg: it is as heavy as water; state its mass"


def _odd_inertia(link: Link) -> str:
    if link.corrects_inertia:
        return "states an inertia that no body has: that of the box around its shapes is used; correct it"
    gyration, reach = _gyration(link), _reach_of(link)
    if not link.states_mass or gyration <= FAR * reach:
        return ""
    away = f"has its {link.inertial.mass:g} kg {gyration:.2g} m away from their centre by its inertia"
    return f"{away}, but its shapes reach {reach:.2g} m only; correct one of them"


def _too_dense(link: Link) -> str:
    volume = sum(float(np.prod(body.shape.extents)) for body in link.bodies)
    if link.inertial.mass <= DENSE * volume:
        return ""
    return f"of {link.inertial.mass:g} kg has shapes too small for it; is it in kg, not g?"


def _gyration(link: Link) -> float:
    """The largest radius of gyration of a link, m."""
    most = float(np.linalg.eigvalsh(link.inertial.inertia)[-1])
    return math.sqrt(max(most, 0.0) / link.inertial.mass)


def _reach_of(link: Link) -> float:
    """How far the boxes around a link's shapes reach from its centre of mass, m."""
    return max(
        float(np.linalg.norm(body.T_parent_shape[:3, 3] - link.inertial.centre))
        + float(np.linalg.norm(body.shape.extents)) / 2
        for body in link.bodies
    )
