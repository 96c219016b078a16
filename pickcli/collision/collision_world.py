"""The scene as solids of the kernel: carriers at their poses, obstacles, items with their uncertainty."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.cell.tool import MOVING
from pickcli.collision.hollow_cover import cover_around
from pickcli.collision.kernel_robot import KernelRobot
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import StaleError, UnknownNameError
from pickcli.geometry import Array
from pickcli.kernel import Checker, SolidKind
from pickcli.scene.cloud import Cloud
from pickcli.scene.scene import Scene

Entered: TypeAlias = tuple[str, str]  # id of an item, and the bottom of its hollow that the tool may enter

# m: points in one cell of a grid this wide become one ball, which exceeds them by half its diagonal at most.
VOXEL = 0.01

KERNEL_KINDS = {
    ShapeKind.BOX: SolidKind.BOX,
    ShapeKind.CYLINDER: SolidKind.CYLINDER,
    ShapeKind.SPHERE: SolidKind.SPHERE,
}


@dataclass(frozen=True, eq=False)
class KernelCloud:
    """A cloud in the kernel; balls replace several close points.

    Attributes:
        points: (N, 3) m, in the world.
        holder: A checker that holds the cloud; others share it.
    """

    points: Array
    holder: Checker

    def name(self, i: int) -> str:
        """Return the name of a point for messages.

        Args:
            i: Index of the point.

        Returns:
            Its coordinates as a text.
        """
        x, y, z = self.points[i].tolist()
        return f"point at ({x:.3f}, {y:.3f}, {z:.3f})"


@dataclass(frozen=True, eq=False)
class CollisionWorld:
    """B solids, each enlarged by its rounding.

    An item with hollows is in it several times: as its outer shape, and as what covers it but for each of its
    hollows. Only one of these is entered into a checker.

    Attributes:
        names: (B,) body name, item id, or link name for links that are fixed to the base.
        kinds: (B,) name of the carrier, "obstacle", "item" or "base".
        T_world_box: (B, 4, 4) pose of each solid, at the centre of its bounding box.
        half_extents: (B, 3) m, of the solid without its rounding.
        shapes: (B,) kinds of solids, as numbered by the kernel.
        rounding: (B,) m, bound of the pose error.
        ignored_frames: (B,) bits: if bit f is set, frame f of the robot is never tested against the solid.
        cloud: The scene's cloud, None if it has none.
        around: (B,) bottom of the hollow around which the solid is part of a cover, "" for others.
        is_wall: (B,) whether it is a wall of that cover.
    """

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    T_world_box: Array
    half_extents: Array
    shapes: NDArray[np.int32]
    rounding: Array
    ignored_frames: NDArray[np.uint64]
    cloud: KernelCloud | None
    around: tuple[str, ...]
    is_wall: NDArray[np.bool_]

    def enter(self, kernel: Checker, kept: NDArray[np.intp], ignored_frames: NDArray[np.uint64]) -> None:
        """Set a checker's world to some of the solids, and the cloud.

        Args:
            kernel: The checker.
            kept: (K,) indices of the solids.
            ignored_frames: (B,) frames never tested against each solid, as bits, instead of the world's own.
        """
        kernel.set_world(
            self.T_world_box[kept], self.half_extents[kept], ignored_frames[kept], self.shapes[kept],
            self.rounding[kept],
        )  # fmt: skip
        if self.cloud is not None:
            kernel.share_cloud(self.cloud.holder)

    def indices(self, names: Iterable[str]) -> list[int]:
        """Find the indices of solids by name, without the walls of hollows, which nothing may touch.

        Args:
            names: Names of solids.

        Returns:
            Indices of all solids but walls with one of these names, sorted.

        Raises:
            UnknownNameError: If no solid has one of the names.
        """
        wanted = sorted(set(names))
        for name in wanted:
            if name not in self._by_name:
                raise UnknownNameError("body or item", name, sorted(self._by_name), "collision scene")
        return sorted(b for name in wanted for b in self._by_name[name] if not self.is_wall[b])

    @cached_property
    def _by_name(self) -> dict[str, list[int]]:
        """Indices of the solids with each name."""
        found: dict[str, list[int]] = {}
        for b, name in enumerate(self.names):
            found.setdefault(name, []).append(b)
        return found

    def is_kept(self, without: frozenset[str], entered: Entered | None = None) -> NDArray[np.bool_]:
        """Return a mask that excludes solids by name, and all but one form of each item with hollows.

        Args:
            without: Names of the solids to exclude.
            entered: Item and hollow that the tool may enter: the item is what covers it but for that hollow.

        Returns:
            (B,) False for the named solids, and for other forms of items.

        Raises:
            UnknownNameError: If no solid has one of the names.
        """
        kept = self.is_present(entered)
        self.indices(without)  # raises
        kept[[b for name in without for b in self._by_name[name]]] = False
        return kept

    def is_present(self, entered: Entered | None) -> NDArray[np.bool_]:
        """Return a mask that excludes all but one form of each item with hollows.

        Args:
            entered: Item and hollow that the tool may enter, None for none.

        Returns:
            (B,) True for plain solids, outer shapes of items that are not entered, and the cover around the
            hollow.
        """
        item, hollow = entered or ("", "")
        forms = zip(self.names, self.around, strict=True)
        return np.array([around == (hollow if name == item else "") for name, around in forms], dtype=bool)


@dataclass(frozen=True, eq=False)
class _Solid:
    name: str
    kind: str
    T_world_shape: Array
    shape: Shape
    rounding: float = 0.0
    around: str = ""
    is_wall: bool = False


@lru_cache(maxsize=32)
def build_world(model: CollisionModel, scene: Scene) -> CollisionWorld:
    """Build the solids of a scene. Cached by identity.

    Args:
        model: The collision model of the scene's cell.
        scene: The scene.

    Returns:
        The solids: carriers and obstacles, links that are fixed to the base, items.

    Raises:
        StaleError: If the scene belongs to another cell than the model.
    """
    ours, theirs = model.cell, scene.cell
    if ours.fingerprint != theirs.fingerprint:
        raise StaleError(
            f"the scene is of cell {theirs.name!r} ({theirs.fingerprint[:12]}), the collision model of "
            f"{ours.name!r} ({ours.fingerprint[:12]}); plan with a planner of that cell"
        )
    solids = [*_standing(scene), *_base(model), *_items(scene)]
    return CollisionWorld(
        tuple(solid.name for solid in solids),
        tuple(solid.kind for solid in solids),
        np.array([solid.T_world_shape for solid in solids]).reshape(-1, 4, 4),
        np.array([solid.shape.extents / 2 for solid in solids]).reshape(-1, 3),
        np.array([KERNEL_KINDS[solid.shape.kind] for solid in solids], dtype=np.int32),
        np.array([solid.rounding for solid in solids]),
        np.array([_ignored_frames(model, solid) for solid in solids], dtype=np.uint64),
        None if scene.cloud is None else _kernel_cloud(model, scene.cloud),
        tuple(solid.around for solid in solids),
        np.array([solid.is_wall for solid in solids], dtype=bool),
    )


@lru_cache(maxsize=4)
def _kernel_cloud(model: CollisionModel, cloud: Cloud) -> KernelCloud:
    holder = model.state(model.robot.tool.default_state).checker()
    holder.set_cloud(cloud.points, cloud.radius + cloud.error, voxel=VOXEL)
    return KernelCloud(cloud.points, holder)


def _standing(scene: Scene) -> Iterator[_Solid]:
    for carrier in scene.posed_carriers:
        for body in carrier.grown:
            yield _body(carrier.name, carrier.T_world_carrier, body)


def _base(model: CollisionModel) -> Iterator[_Solid]:
    for link, T_world_link, body in model.static_bodies():
        yield _Solid(link, "base", T_world_link @ body.T_parent_shape, body.shape)
    for link, T_world_center, radius in model.static_spheres():
        yield _Solid(link, "base", T_world_center, Shape(ShapeKind.SPHERE, (radius,)))


def _items(scene: Scene) -> Iterator[_Solid]:
    for placed in scene.items:
        bound, T = scene.bound(placed), placed.T_world_item
        yield _Solid(placed.id, "item", T, placed.item.shape, bound)
        for hollow in placed.item.hollows:
            for piece in cover_around(placed.item.shape, hollow):
                at, near = T @ piece.T_item_shape, float(scene.noise_of(placed).at(np.array(piece.farthest)))
                yield _Solid(placed.id, "item", at, piece.shape, near, hollow.bottom, piece.is_wall)


def _body(kind: str, T_world_parent: Array, body: Body) -> _Solid:
    return _Solid(body.name, kind, T_world_parent @ body.T_parent_shape, body.shape)


def _ignored_frames(model: CollisionModel, solid: _Solid) -> int:
    """Return the frames exempted by the cell and, for the base, those that cannot reach it, as bits."""
    return _frames_ignoring(model, solid.name, solid.kind == "base")


@lru_cache(maxsize=1024)
def _frames_ignoring(model: CollisionModel, name: str, is_base: bool) -> int:
    """Return the frames that are never tested against what has a name, as bits. Cached."""
    frames = zip(model.frame_names, model.bodies, strict=True)
    return sum(
        1 << k
        for k, (frame, body) in enumerate(frames)
        if model.is_allowed(frame, name)
        or (is_base and (body == 0 or (body == 1 and (k, name) in _clear_of_base(model))))
    )


@lru_cache(maxsize=8)
def _clear_of_base(model: CollisionModel) -> frozenset[tuple[int, str]]:
    """Return frames of the first moving body, each with a base link that it is not tested against."""
    robot = model.state(MOVING)
    base: dict[str, list[_Solid]] = {}
    for solid in _base(model):
        base.setdefault(solid.name, []).append(solid)
    found = set()
    for k in (k for k, body in enumerate(model.bodies) if body == 1):
        for link, solids in base.items():
            if model.are_joined(model.frame_names[k], link) or model.are_apart(_among(robot, k, solids), 1):
                found.add((k, link))
    return frozenset(found)


def _among(robot: KernelRobot, frame: int, solids: Sequence[_Solid]) -> Checker:
    """Return a checker of one frame of a robot among some solids."""
    kernel = robot.of_frames([frame])
    kernel.set_world(
        np.array([solid.T_world_shape for solid in solids]),
        np.array([solid.shape.extents / 2 for solid in solids]),
        np.zeros(len(solids), np.uint64),
        np.array([KERNEL_KINDS[solid.shape.kind] for solid in solids], dtype=np.int32),
    )
    return kernel
