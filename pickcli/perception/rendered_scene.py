"""The solids of a scene as cameras see them: items, carriers, obstacles and all links of the robot."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull

from pickcli.cell.item import Item
from pickcli.cell.robot import Robot
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.station import UNKNOWN
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.kernel import RaycastingScene, SolidKind
from pickcli.kinematics.arm import Arm
from pickcli.perception.camera_pose import link_poses
from pickcli.perception.deformed_look import deformed_pieces
from pickcli.perception.surface_view import SurfaceView
from pickcli.scene.scene import Scene

_KINDS = {
    ShapeKind.BOX: SolidKind.BOX,
    ShapeKind.CYLINDER: SolidKind.CYLINDER,
    ShapeKind.SPHERE: SolidKind.SPHERE,
    ShapeKind.HULL: SolidKind.BOX,  # its bounding box, cut by the planes of its faces
}
_SAME_PLANE = 9  # decimals of m: the triangles of one face of a hull have one plane


class OwnerKind(StrEnum):
    """Kinds of what a solid is part of."""

    ITEM = "item"
    CARRIER = "carrier"  # also the obstacles
    LINK = "link"


@dataclass(frozen=True, eq=False)
class RenderedSolid:
    """A solid as cameras see it.

    Attributes:
        kind: Kind of its owner.
        owner: Id of the item, name of the carrier ("obstacle" for obstacles), or name of the link.
        shape: The shape.
        T_world_shape: (4, 4) pose.
        item: The product, None for other solids.
        planes: (P, 4) that cut the shape, normal and offset; those of its own faces are not among them.
    """

    kind: OwnerKind
    owner: str
    shape: Shape
    T_world_shape: Array
    item: Item | None = None
    planes: Array | None = None


@dataclass(frozen=True, eq=False)
class RenderedScene:
    """The solids of a scene, with the robot in one configuration.

    Attributes:
        solids: In the order of the indices of a picture.
    """

    solids: tuple[RenderedSolid, ...]

    @classmethod
    def of(
        cls, scene: Scene, q: Array, tool_state: ToolState, deformed_seed: int | None = None
    ) -> RenderedScene:
        """Take the solids of a scene.

        A cloud is left out: its points are what another sensor saw, and no surfaces. So is unknown space.

        Args:
            scene: The scene.
            q: (n,) configuration of the arm, rad or m; other arms stand as the cell says.
            tool_state: State of its tool.
            deformed_seed: Seed of what items look like that deform; None to show the boxes of all.

        Returns:
            The solids; of an item that is shown deformed several pieces.
        """
        items = _items(scene, q, tool_state)
        if deformed_seed is not None:
            items = (piece for solid in items for piece in _deformed(solid, deformed_seed))
        return cls((*items, *_carriers(scene), *_links(scene.cell.robot, q, tool_state)))

    @cached_property
    def kernel(self) -> RaycastingScene:
        """The solids in the kernel."""
        planes = [_planes(solid.shape) if solid.planes is None else solid.planes for solid in self.solids]
        return RaycastingScene(
            np.array([solid.T_world_shape for solid in self.solids]).reshape(-1, 4, 4),
            np.array([solid.shape.extents / 2 for solid in self.solids]).reshape(-1, 3),
            np.array([_KINDS[solid.shape.kind] for solid in self.solids], dtype=np.int32),
            np.concatenate([np.zeros((0, 4)), *planes]),
            np.array([len(each) for each in planes], dtype=np.int32),
        )

    def seen_by(self, camera: PinholeCamera, T_world_camera: Array) -> SurfaceView:
        """Render what a camera sees, without noise.

        Args:
            camera: Its intrinsics.
            T_world_camera: (4, 4) pose.

        Returns:
            The view; the indices in it are those of ``solids``.
        """
        depth, index, normals = self.kernel.cast_rays(camera.intrinsics, camera.size, T_world_camera)
        return SurfaceView(camera, T_world_camera, depth, index, normals)

    def indices_of(self, owner: str) -> tuple[int, ...]:
        """Return the indices of the solids of an owner.

        Args:
            owner: Id of an item, name of a carrier or name of a link.

        Returns:
            Indices in ``solids``; none if nothing has that name.
        """
        return tuple(i for i, solid in enumerate(self.solids) if solid.owner == owner)


def _items(scene: Scene, q: Array, tool_state: ToolState) -> Iterator[RenderedSolid]:
    held = scene.held
    for placed in scene.items:
        if held is None or placed.id != held.id:
            yield RenderedSolid(
                OwnerKind.ITEM, placed.id, placed.item.shape, placed.T_world_item, placed.item
            )
    if held is not None:
        T_world_item = Arm(scene.cell.robot).tip(q, tool_state) @ held.T_tip_item
        yield RenderedSolid(OwnerKind.ITEM, held.id, held.item.shape, T_world_item, held.item)


def _deformed(solid: RenderedSolid, seed: int) -> Iterator[RenderedSolid]:
    """The pieces of an item that deforms, or the solid as it is."""
    if solid.item is None or not solid.item.deformation:
        yield solid
        return
    for planes in deformed_pieces(solid.item, seed, solid.owner):
        yield replace(solid, planes=planes)


def _carriers(scene: Scene) -> Iterator[RenderedSolid]:
    for carrier in scene.posed_carriers:
        for body in carrier.bodies if carrier.name != UNKNOWN else ():
            T = carrier.T_world_carrier @ body.T_parent_shape
            yield RenderedSolid(OwnerKind.CARRIER, carrier.name, body.shape, T)


def _links(robot: Robot, q: Array, tool_state: ToolState) -> Iterator[RenderedSolid]:
    poses = link_poses(robot, q, tool_state)
    for link in robot.links:
        for body in link.bodies:
            yield RenderedSolid(OwnerKind.LINK, link.name, body.shape, poses[link.name] @ body.T_parent_shape)


def _planes(shape: Shape) -> Array:
    """Planes (P, 4) of a hull's faces, normal and offset; none for other shapes."""
    if shape.kind is not ShapeKind.HULL:
        return np.zeros((0, 4))
    equations = np.unique(ConvexHull(np.array(shape.vertices)).equations.round(_SAME_PLANE), axis=0)
    scale = np.linalg.norm(equations[:, :3], axis=1)[:, None]
    return np.asarray(equations / scale * [1.0, 1.0, 1.0, -1.0])
