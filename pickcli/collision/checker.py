"""Is this configuration, edge or path free? One checker per scene, pivot state, held item and contacts."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.robot import PivotState
from pickcli.cell.scene import Scene
from pickcli.collision import explain
from pickcli.collision.allowed_contacts import NO_CONTACTS, AllowedContacts
from pickcli.collision.cover import Cover, cover_shape
from pickcli.collision.explain import Contact
from pickcli.collision.model import CollisionModel
from pickcli.collision.world import KERNEL_KINDS, build_world
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.kernel import Checker


@dataclass(frozen=True, eq=False)
class Held:
    """An item in the cup.

    T_tip_item: (4, 4) item frame in the tool frame
    inflate: m, how far any of its points may be from where that pose says
    """

    item: Item
    T_tip_item: Array
    inflate: float = 0.0


@dataclass(frozen=True, eq=False)
class Touch:
    """A checker of planned contacts alone. kept: (K,) indices of its solids in the world of the scene."""

    kernel: Checker
    kept: NDArray[np.intp]


class SceneChecker:
    """Answers for one scene and one way the robot is in it. Cheap to make: covers and boxes are shared.

    without: ids of items that are not there (the held one, or those a planner may ignore)
    touching: what cup and held item may touch, and how deep; all other links of the robot keep clear of it
    margin: m that everything else is kept apart, the cell's clearance by default
    opening: pairs (link of the robot or "held <item>", body or item) that are not tested: those that a way
        out of a stop only has to take apart

    Raises UnknownNameError for a name in ``without`` or ``touching`` that is not in the scene.
    """

    def __init__(
        self,
        model: CollisionModel,
        scene: Scene,
        pivot: PivotState,
        held: Held | None = None,
        without: frozenset[str] = frozenset(),
        touching: AllowedContacts = NO_CONTACTS,
        margin: float | None = None,
        opening: frozenset[tuple[str, str]] = frozenset(),
    ) -> None:
        self.model, self.scene, self.pivot, self.held = model, scene, pivot, held
        self.margin = model.cell.clearance if margin is None else margin
        self.world = build_world(model, scene)
        self.kept: NDArray[np.intp] = np.flatnonzero(self.world.is_kept(without))
        state = model.state(pivot)
        self.kernel = Checker(state.chain, state.centers, state.radii, state.frames, state.self_pairs)
        touching = touching.but(without)
        self._set_world(touching, opening)
        if held is not None:
            self._set_held(held)
        self.touch = self._touch(touching) if touching.is_limited else None

    @property
    def n(self) -> int:
        """Number of joints of a configuration."""
        return len(self.model.robot.joint_names)

    def is_free(self, q: Array) -> bool:
        """Whether q (n,) keeps more than the margin everywhere."""
        is_free = bool(self.kernel.is_free(q, self.margin))
        return is_free and (self.touch is None or bool(self.touch.kernel.is_free(q, 0.0)))

    def are_free(self, Q: Array) -> NDArray[np.bool_]:
        """(N,) whether each of Q (N, n) is free."""
        Q = np.ascontiguousarray(Q)
        are_free = np.asarray(self.kernel.are_free(Q, self.margin), dtype=bool)
        if self.touch is not None:
            are_free &= np.asarray(self.touch.kernel.are_free(Q, 0.0), dtype=bool)
        return are_free

    def edge_is_free(self, q0: Array, q1: Array, slack: Array | None = None) -> bool:
        """Whether every point of the straight edge is proven free.

        slack: (n,) half-width per joint of a tube around the edge that must be free as well
        """
        is_free = bool(self.kernel.edge_is_free(q0, q1, self.margin, slack))
        return is_free and (self.touch is None or bool(self.touch.kernel.edge_is_free(q0, q1, 0.0, slack)))

    def path_is_free(self, Q: Array, slack: Array | None = None) -> int:
        """Index of the first edge of the polyline Q (N, n) that is not proven free, -1 if all are.

        slack: (N - 1, n) per edge as in `edge_is_free`
        """
        Q = np.ascontiguousarray(Q)
        blocked = int(self.kernel.path_is_free(Q, self.margin, slack))
        if blocked >= 0 or self.touch is None:
            return blocked
        return int(self.touch.kernel.path_is_free(Q, 0.0, slack))

    def clearance(self, q: Array, max_distance: float = 1.0) -> Contact:
        """The closest pair at q; distances of spheres, negative inside. ``a`` is a part of the robot."""
        return explain.closest(self, q, max_distance)

    def explain(self, q: Array) -> Reason:
        """Why q is not free: which link, which obstacle, how deep."""
        return explain.configuration(self, q)

    def explain_edge(self, q0: Array, q1: Array) -> Reason:
        """Why the edge is not free: the deepest pair on it, and at which fraction of the edge."""
        return explain.edge(self, q0, q1)

    def _set_world(self, touching: AllowedContacts, opening: frozenset[tuple[str, str]]) -> None:
        cup, item = self.model.n_frames - 1, self.model.n_frames
        ignored = self.world.ignored | touching.ignored(self.world, cup, item)
        for part, name in opening:
            frame = item if part.startswith("held ") else self.model.frame_names.index(part)
            ignored[self.world.indices([name])] |= np.uint64(1 << frame)
        self.world.enter(self.kernel, self.kept, ignored)

    def _touch(self, touching: AllowedContacts) -> Touch:
        """A checker of what may be touched only so deep: cup and held item as they are, nothing else."""
        state, cup, item = self.model.state(self.pivot), self.model.n_frames - 1, self.model.n_frames
        mine = state.frames == cup
        none = np.zeros((0, 2), np.int32)
        kernel = Checker(state.chain, state.centers[mine], state.radii[mine], state.frames[mine], none)
        kept = touching.enter(kernel, self.world, cup, item)
        if self.held is not None:
            shape, T_cup_item = self.held.item.shape, self.model.robot.tool.T_cup_tip @ self.held.T_tip_item
            kind, no_frames = KERNEL_KINDS[shape.kind], np.zeros(0, np.int32)
            kernel.set_held_solid(T_cup_item, shape.extents / 2, no_frames, kind, 0.0)
        return Touch(kernel, kept)

    def _set_held(self, held: Held) -> None:
        tested = self.model.held_tested_frames
        if self.pivot is PivotState.MOVING:
            cover = swept_cover(self.model, held)
            self.kernel.set_held(cover.centers, cover.radii, tested)
        else:
            shape, T_cup_item = held.item.shape, self.model.robot.tool.T_cup_tip @ held.T_tip_item
            kind = KERNEL_KINDS[shape.kind]
            self.kernel.set_held_solid(T_cup_item, shape.extents / 2, tested, kind, held.inflate)


@lru_cache(maxsize=32)
def swept_cover(model: CollisionModel, held: Held) -> Cover:
    """Spheres in the cup's frame of all that a held item passes through while the cup moves. Cached by
    identity."""
    T_cup_item = model.robot.tool.T_cup_tip @ held.T_tip_item
    return model.swept(cover_shape(held.item.shape).inflated(held.inflate).moved(T_cup_item))
