"""The scene as boxes of the kernel: pod where it stands, tote, obstacles, items with their uncertainty."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.scene import Scene
from pickcli.cell.shapes import Body
from pickcli.collision.model import CollisionModel
from pickcli.errors import StaleError, UnknownNameError
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class World:
    """B oriented boxes. Bit f of ``ignored[b]``: frame f of the robot is never tested against box b."""

    names: tuple[str, ...]  # body name, item id, or link name for what stands still with the base
    kinds: tuple[str, ...]  # "pod", "tote", "obstacle", "item", "base"
    T_world_box: Array  # (B, 4, 4)
    half_extents: Array  # (B, 3) m
    groups: NDArray[np.int32]  # (B,) boxes that stand together
    ignored: NDArray[np.uint64]  # (B,)

    def indices(self, names: Iterable[str]) -> list[int]:
        """Boxes with one of these names. Raises UnknownNameError for a name that no box has."""
        wanted = set(names)
        for name in sorted(wanted - set(self.names)):
            raise UnknownNameError("body or item", name, sorted(set(self.names)), "collision scene")
        return [b for b, name in enumerate(self.names) if name in wanted]

    def is_kept(self, without: frozenset[str]) -> NDArray[np.bool_]:
        """(B,) False for the boxes of the items named. Raises UnknownNameError for any other name."""
        kept = np.ones(len(self.names), dtype=bool)
        kept[self.indices(without)] = False
        return kept


@dataclass(frozen=True, eq=False)
class _Box:
    name: str
    kind: str
    group: str
    T_world_box: Array
    half_extents: Array


@lru_cache(maxsize=32)
def build_world(model: CollisionModel, scene: Scene) -> World:
    """All boxes of a scene; cylinders and spheres as the boxes around them. Cached by identity.

    Raises StaleError if the scene is one of another cell than the model.
    """
    ours, theirs = model.cell, scene.cell
    if ours.fingerprint != theirs.fingerprint:
        raise StaleError(
            f"the scene is of cell {theirs.name!r} ({theirs.fingerprint[:12]}), the collision model of "
            f"{ours.name!r} ({ours.fingerprint[:12]}); make the scene again for this cell"
        )
    boxes = [*_pod(scene), *_standing(scene), *_base(model), *_items(scene)]
    groups = {name: i for i, name in enumerate(dict.fromkeys(box.group for box in boxes))}
    return World(
        tuple(box.name for box in boxes),
        tuple(box.kind for box in boxes),
        np.array([box.T_world_box for box in boxes]),
        np.array([box.half_extents for box in boxes]),
        np.array([groups[box.group] for box in boxes], dtype=np.int32),
        np.array([_ignored(model, box) for box in boxes], dtype=np.uint64),
    )


def _pod(scene: Scene) -> Iterator[_Box]:
    group_of = {body: group for group, bodies in scene.cell.pod.groups.items() for body in bodies}
    for body in scene.cell.pod.bodies:
        yield _body("pod", group_of.get(body.name, body.name), scene.T_world_pod, body)


def _standing(scene: Scene) -> Iterator[_Box]:
    for body in scene.cell.tote.bodies:
        yield _body("tote", "tote", np.eye(4), body)
    for body in scene.cell.obstacles.bodies:
        yield _body("obstacle", f"obstacle {body.name}", np.eye(4), body)


def _base(model: CollisionModel) -> Iterator[_Box]:
    for link, T_world_link, body in model.static_bodies():
        box = _body("base", "base", T_world_link, body)
        yield _Box(link, box.kind, box.group, box.T_world_box, box.half_extents)


def _items(scene: Scene) -> Iterator[_Box]:
    for placed in scene.items:
        half = placed.item.shape.extents / 2 + scene.noise.bound(placed.item)
        yield _Box(placed.id, "item", f"items in {placed.location}", placed.T_world_item, half)


def _body(kind: str, group: str, T_world_parent: Array, body: Body) -> _Box:
    return _Box(body.name, kind, group, T_world_parent @ body.T_parent_shape, body.shape.extents / 2)


def _ignored(model: CollisionModel, box: _Box) -> int:
    """Frames exempted by the cell, and for the base the body that moves on it."""
    frames = zip(model.frame_names, model.bodies, strict=True)
    return sum(
        1 << k
        for k, (name, body) in enumerate(frames)
        if model.is_allowed(name, box.name) or (box.kind == "base" and body <= 1)
    )
