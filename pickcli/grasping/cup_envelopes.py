"""Envelopes in which a cup seals on an item: a face inset from its edges, the cup's tilt, any roll."""

from __future__ import annotations

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.tool import Tool
from pickcli.geometry import perpendiculars, pose
from pickcli.grasping.envelope import Envelope
from pickcli.grasping.surfaces import Face, faces
from pickcli.kernel import SurfaceKind

ON_SURFACE = 1e-4  # m that a cup's tip may be off the face that it is put on


def cup_envelopes(item: Item, tool: Tool) -> tuple[Envelope, ...]:
    """Return the envelopes in which a cup seals on an item.

    On each face the tip stays within the inset face, tilted by what the bellows bear, and its roll is free.

    Args:
        item: The item.
        tool: The tool, with a cup.

    Returns:
        One envelope for each face on which the cup seals; () if there is none.
    """
    return tuple(_cup(face, tool.cup.tilt) for face in faces(item, tool))


def _cup(face: Face, tilt: float) -> Envelope:
    region, slab, name = face.region, np.array([-ON_SURFACE, ON_SURFACE]), face.name
    if name == "mantle":
        radius, heights = float(region.T_region_tool[0, 3]), region.bounds[2]
        bounds = np.array([[-np.pi, np.pi], heights, radius + slab])
        return Envelope(name, SurfaceKind.CYLINDER, np.eye(4), bounds[:, 0], bounds[:, 1], tilt, face=name)
    if name == "sphere":
        radius = float(region.T_region_tool[0, 3])
        bounds = np.array([[-np.pi, np.pi], [-np.pi / 2, np.pi / 2], radius + slab])
        return Envelope(name, SurfaceKind.SPHERE, np.eye(4), bounds[:, 0], bounds[:, 1], tilt, face=name)
    T, outward = region.T_object_region, -region.T_object_region[:3, 2]
    x, _ = perpendiculars(outward)
    T_surface = pose(T[:3, 3], R=np.column_stack([x, np.cross(outward, x), outward]))
    half = np.abs(T_surface[:3, :2].T @ T[:3, :2]) @ region.bounds[:2, 1]
    low, high = np.append(-half, -ON_SURFACE), np.append(half, ON_SURFACE)
    return Envelope(name, SurfaceKind.PLANE, T_surface, low, high, tilt, face=name)
