"""An item by itself, pushed along straight lines: can it be taken out at all, whatever holds it?

The kernel proves it as it proves an arm.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.scene import Scene
from pickcli.collision.allowed_contacts import NO_CONTACTS, AllowedContacts
from pickcli.collision.explain import Contact
from pickcli.collision.floating import floating_chain
from pickcli.collision.model import CollisionModel
from pickcli.collision.world import KERNEL_KINDS, build_world
from pickcli.geometry import Array, pose
from pickcli.kernel import Checker

NUDGE = 0.0005  # m that an item may come nearer to what it must not push
APART = 0.03  # m of lead over what rolls after it: on a floor of 5 degrees that takes a ball 0.3 s
FOLLOWING = 0.0012  # m on top of the clearance: an arm follows a straight line only nearly


class Ghost:
    """The item at a pose, displaced by d (6,): m along the axes of a frame, rad about its z, y, then x axis.

    It turns about its own centre. R_world_axes: (3, 3) the axes of the displacements. inflate: m,
    uncertainty of the item's own pose.
    without: ids of items that are not there (the item itself among them). touching: what it may touch.
    beside: the item with nothing but one neighbour each that may roll along: it must never come nearer to
    those than it starts, and end well apart from them.
    """

    def __init__(
        self, model: CollisionModel, scene: Scene, item: Item, T_world_item: Array, R_world_axes: Array,
        inflate: float, without: frozenset[str], touching: AllowedContacts = NO_CONTACTS,
        beside: tuple[Ghost, ...] = (),
    ) -> None:  # fmt: skip
        self._beside = beside
        self.item, self.margin = item, model.cell.clearance + FOLLOWING
        world = build_world(model, scene)
        self._kept = np.flatnonzero(world.is_kept(without))
        self._names, self._kinds = world.names, world.kinds
        chain = floating_chain(T_world_item[:3, 3], R_world_axes)
        none, no_pairs = np.zeros(0, np.int32), np.zeros((0, 2), np.int32)
        self.kernel = Checker(chain, np.zeros((0, 3)), np.zeros(0), none, no_pairs)
        T_last_item = pose(R=R_world_axes.T @ T_world_item[:3, :3])
        kind = KERNEL_KINDS[item.shape.kind]
        self.kernel.set_held_solid(T_last_item, item.shape.extents / 2, none, kind, inflate)
        touching, this = touching.but(without), chain.n_frames
        world.enter(self.kernel, self._kept, touching.ignored(world, this, this))
        self._touch: Checker | None = None
        if touching.is_limited:
            self._touch = Checker(chain, np.zeros((0, 3)), np.zeros(0), none, no_pairs)
            self._touch.set_held_solid(T_last_item, item.shape.extents / 2, none, kind, 0.0)
            touching.enter(self._touch, world, this, this)

    def is_free(self, d: Array) -> bool:
        """Whether the item keeps the clearance when displaced by d (6,)."""
        is_free = bool(self.kernel.is_free(d, self.margin))
        return is_free and (self._touch is None or bool(self._touch.is_free(d, 0.0)))

    def are_free(self, D: Array) -> NDArray[np.bool_]:
        """(N,) whether it does so at each of D (N, 6)."""
        D = np.ascontiguousarray(D)
        are_free = np.asarray(self.kernel.are_free(D, self.margin), dtype=bool)
        if self._touch is not None:
            are_free &= np.asarray(self._touch.are_free(D, 0.0), dtype=bool)
        return are_free

    def path_is_free(self, D: Array) -> int:
        """Index of the first straight push of the polyline D (N, 6) that is not proven free, or -1."""
        D = np.ascontiguousarray(D)
        blocked = int(self.kernel.path_is_free(D, self.margin))
        if blocked < 0 and self._touch is not None:
            blocked = int(self._touch.path_is_free(D, 0.0))
        return blocked if blocked >= 0 else self._first_pursued(D)

    def _first_pursued(self, D: Array) -> int:
        """Index of the first push on which something beside the item could stay with it, or -1."""
        for ghost in self._beside:
            start = ghost.clearance(D[0]).distance
            for i, (a, b) in enumerate(pairwise(D)):
                if min(ghost.clearance(d).distance for d in ((a + b) / 2, b)) < start - NUDGE:
                    return i
            if ghost.clearance(D[-1]).distance < start + APART:
                return len(D) - 2
        return -1

    def clearances(self, D: Array) -> Array:
        """(N,) m to what is closest to the item at each of D (N, 6), negative where they overlap."""
        return np.asarray(self.kernel.clearances(np.ascontiguousarray(D), 1.0))

    def clearance(self, d: Array) -> Contact:
        """What is closest to the item when displaced by d (6,)."""
        distance, frame, _, index = self.kernel.clearance(d, 1.0)
        if frame < 0:
            return Contact(float(distance), "", "")
        box = int(self._kept[index])
        return Contact(float(distance), self.item.name, self._names[box], self._kinds[box])
