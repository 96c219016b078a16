"""Free flyers: an item without an arm, or the tool without its arm.

In the kernel a free flyer is a robot of three prismatic and three revolute joints (Pinocchio: a free flyer),
so straight displacements are proven like edges of an arm. Motions that are infeasible even for the body
without the arm are rejected without inverse kinematics, which costs a hundred times as much.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.tool import ToolState
from pickcli.collision.allowed_contacts import NO_CONTACTS, AllowedContacts
from pickcli.collision.collision_world import KERNEL_KINDS, build_world
from pickcli.collision.kernel_validator import KernelValidator, KernelWorld
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse, pose, transform_points
from pickcli.kernel import Chain, Checker, JointKind
from pickcli.scene.scene import Scene

N_FREE = 6  # x, y, z along the axes, then yaw about z, pitch about the turned y, roll about the turned x
LANCE, CUP = 5, 6  # frames that move with all six joints: two, because only the cup may touch solids
ROLL_JUMPS = 0.75 * np.pi  # rad, at which the tool's roll wraps around

PUSH_TOLERANCE = 0.0005  # m that an item may come nearer to neighbours that it must not push
# m of lead over an item that rolls after it: on a floor of 5 degrees that takes a ball 0.3 s
ROLLING_LEAD = 0.03
# m on top of the clearance: an arm follows a straight line only approximately
LINE_FOLLOWING_RESERVE = 0.0012


@dataclass(frozen=True, eq=False)
class ToolSpheres:
    """Spheres that cover a tool without its arm.

    Attributes:
        centers: (S, 3) m, in a frame of the tool.
        radii: (S,) m.
        frames: (S,) whether each belongs to the lance or to the cup, which may touch other solids.
    """

    centers: Array
    radii: Array
    frames: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class FreeItem:
    """An item as a free flyer.

    Attributes:
        item: The item.
        T_world_item: (4, 4) its pose at displacement 0.
        R_world_axes: (3, 3) axes of the displacements.
        inflate: m, bound of the error of that pose.
    """

    item: Item
    T_world_item: Array
    R_world_axes: Array
    inflate: float


class FreeItemChecker(KernelValidator):
    """Checker of an item displaced by d (6,) from a pose: m along given axes, rad about their z, y, then x.

    The item turns about its own centre. It may not push neighbours that could roll along: it must never come
    nearer to those than at the start, and must end well apart from them.

    Args:
        model: The collision model of the scene's cell.
        scene: The planning scene.
        free: The item, which must be absent from ``scene`` or by ``contacts``.
        contacts: Solids that it may touch as a held item, and how deep.
        beside: Checkers of the item with only one neighbour each that may roll along.
    """

    def __init__(
        self,
        model: CollisionModel,
        scene: Scene,
        free: FreeItem,
        contacts: AllowedContacts = NO_CONTACTS,
        beside: tuple[FreeItemChecker, ...] = (),
    ) -> None:
        """Create the kernel's checkers for the scene."""
        self._beside = beside
        world, item = build_world(model, scene), free.item
        chain = _floating_chain(free.T_world_item[:3, 3], free.R_world_axes)
        T_last_item = pose(R=free.R_world_axes.T @ free.T_world_item[:3, :3])
        contacts, this = contacts.of_present, chain.n_frames

        def flying(inflated: float) -> Checker:
            none, no_pairs = np.zeros(0, np.int32), np.zeros((0, 2), np.int32)
            kernel = Checker(chain, np.zeros((0, 3)), np.zeros(0), none, no_pairs)
            kind = KERNEL_KINDS[item.shape.kind]
            kernel.set_held_solid(T_last_item, item.shape.extents / 2, none, kind, inflated)
            return kernel

        clear = KernelWorld(flying(free.inflate), np.flatnonzero(world.is_kept(contacts.absent)))
        world.enter(clear.kernel, clear.kept, contacts.ignored_frames(world, (this,), this))
        touch: KernelWorld | None = None
        if contacts.is_limited:
            kernel = flying(0.0)
            touch = KernelWorld(kernel, contacts.enter(kernel, world, this, this))
        parts = (*[""] * this, item.name)
        stated = model.cell.clearance
        super().__init__(world, parts, stated + LINE_FOLLOWING_RESERVE, stated, clear, touch)

    def is_valid_edge(self, q0: Array, q1: Array) -> bool:
        """Whether a straight displacement is proven free and pushes nothing.

        Args:
            q0: (6,) displacement at the start.
            q1: (6,) displacement at the end.

        Returns:
            True if it is.
        """
        return self.is_valid_path(np.stack([q0, q1]))

    def first_blocked_edge(self, Q: Array, slack: Array | None = None) -> int:
        """Find the first displacement that is not proven free; if all are, the first that pushes something.

        Args:
            Q: (N, 6) displacements, joined by straight lines.
            slack: (N - 1, 6) half-widths of a tube around each edge that must be free as well.

        Returns:
            Index of the edge, -1 if all are proven.
        """
        blocked = super().first_blocked_edge(Q, slack)
        if blocked < 0 and (pursued := self._first_pursued(Q)) is not None:
            return pursued[0]
        return blocked

    def explain_path(self, Q: Array, slack: Array | None = None) -> Reason:
        """Explain why a path is not free, or which neighbour could roll after the item.

        Args:
            Q: (N, 6) displacements, joined by straight lines.
            slack: (N - 1, 6) half-widths of a tube around each edge that must be free as well.

        Returns:
            The item, obstacle, depth, and location on the edge.
        """
        if super().first_blocked_edge(Q, slack) < 0 and (pursued := self._first_pursued(Q)) is not None:
            i, other = pursued
            contact = other.clearance(Q[i + 1])
            return Reason("too close", "", f"{contact}, which could roll after it", contact.item)
        return super().explain_path(Q, slack)

    def _first_pursued(self, Q: Array) -> tuple[int, FreeItemChecker] | None:
        """Return the first displacement on which a neighbour could roll after the item, and its checker."""
        for other in self._beside:
            start = other.clearance(Q[0]).distance
            for i, (a, b) in enumerate(pairwise(Q)):
                if min(other.clearance(d).distance for d in ((a + b) / 2, b)) < start - PUSH_TOLERANCE:
                    return i, other
            if other.clearance(Q[-1]).distance < start + ROLLING_LEAD:
                return len(Q) - 2, other
        return None


class FreeToolChecker(KernelValidator):
    """Checker of lance and cup in one tool state, by the robot's own spheres, at any pose of the tool frame.

    Args:
        model: The collision model of the scene's cell.
        scene: The planning scene.
        tool_state: State of the tool.
        R_world_axes: (3, 3) axes about which the tool is level.
        contacts: Solids that the cup may touch, at any depth; the lance keeps clear of them.
    """

    def __init__(
        self,
        model: CollisionModel,
        scene: Scene,
        tool_state: ToolState,
        R_world_axes: Array,
        contacts: AllowedContacts = NO_CONTACTS,
    ) -> None:
        """Create the kernel's checker for the scene."""
        # The axes of the lance become x, y, z of the revolute joints: x into the bin, and z away from where a
        # cup across the lance points, so that yaw and pitch stay far from their singularities.
        self._R_axes, self._R_tool = R_world_axes, model.robot.tool.R_tip_lance(tool_state)
        self._model, self._tool_state = model, tool_state
        world = build_world(model, scene)
        kernel = _floating_tool(model, tool_state, R_world_axes.tobytes()).bare()
        contacts = contacts.of_present
        clear = KernelWorld(kernel, np.flatnonzero(world.is_kept(contacts.absent, contacts.entered)))
        world.enter(kernel, clear.kept, contacts.ignored_frames(world, (CUP,), CUP + 1))
        tool = model.robot.tool
        parts = (*[""] * LANCE, tool.lance_link, " or ".join(tool.contact_links))
        super().__init__(world, parts, model.cell.clearance, model.cell.clearance, clear, None)

    def spheres(self, T_tip_palm: Array) -> ToolSpheres:
        """Return the spheres of the tool.

        Args:
            T_tip_palm: (4, 4) a frame of the tool.

        Returns:
            The spheres in that frame.
        """
        centers, radii, frames = _tool_spheres(self._model, self._tool_state)
        T_palm_level = inverse(pose(R=self._R_tool.T) @ T_tip_palm)
        return ToolSpheres(transform_points(T_palm_level, centers), radii, frames)

    @property
    def depth(self) -> float:
        """Distance in m from the front of the lance or hand to the tip, along the tool's axis."""
        centers, radii, frames = _tool_spheres(self._model, self._tool_state)
        ahead = (centers @ self._R_tool.T)[:, 2] + radii
        return max(0.0, -float(ahead[frames == LANCE].max()))

    def are_valid_at(self, T_world_tip: Array) -> NDArray[np.bool_]:
        """Whether the tool has clearance at poses of the tool frame.

        Args:
            T_world_tip: (N, 4, 4) poses.

        Returns:
            (N,) True for those at which it has.
        """
        return self.are_valid(self.displacements(T_world_tip))

    def displacements(self, T_world_tip: Array) -> Array:
        """Return displacements of the free tool for poses of the tool frame.

        Args:
            T_world_tip: (N, 4, 4) poses.

        Returns:
            (N, 6) x, y, z along the axes in m, then yaw, pitch and roll in rad.
        """
        R = self._R_axes.T @ T_world_tip[:, :3, :3] @ self._R_tool
        d = np.empty((len(T_world_tip), N_FREE))
        d[:, :3] = T_world_tip[:, :3, 3] @ self._R_axes
        d[:, 3] = np.arctan2(R[:, 1, 0], R[:, 0, 0])
        d[:, 4] = np.arcsin(np.maximum(np.minimum(-R[:, 2, 0], 1.0), -1.0))  # np.clip is slower
        roll = np.arctan2(R[:, 2, 1], R[:, 2, 2])
        d[:, 5] = (roll + ROLL_JUMPS) % (2 * np.pi) - ROLL_JUMPS  # no quarter turn is at the wrap-around
        return d


def _floating_chain(origin: Array, R_world_axes: Array) -> Chain:
    """Return a chain whose frames LANCE and CUP are at ``origin`` (3,), along the axes, at displacement 0."""
    kinds = np.array([*[JointKind.PRISMATIC] * 3, *[JointKind.REVOLUTE] * 3, JointKind.FIXED], np.int32)
    frames = np.stack([pose(origin, R=R_world_axes), *[np.eye(4)] * N_FREE])
    z, y, x = np.eye(3)[::-1]
    axes = np.vstack([np.eye(3), z, y, x, z])
    return Chain(kinds, frames, axes, np.array([*range(N_FREE), -1], np.int32))


@lru_cache(maxsize=32)
def _floating_tool(model: CollisionModel, tool_state: ToolState, axes: bytes) -> Checker:
    """Return the tool without a world, for cheap copies; axes: the bytes of R_world_axes. Cached."""
    chain = _floating_chain(np.zeros(3), np.frombuffer(axes).reshape(3, 3))
    return Checker(chain, *_tool_spheres(model, tool_state), np.zeros((0, 2), np.int32))


@lru_cache(maxsize=32)
def _tool_spheres(model: CollisionModel, tool_state: ToolState) -> tuple[Array, Array, NDArray[np.int32]]:
    """Return centres (S, 3), radii (S,) and frames (S,) of the tool's links, level about the tip. Cached."""
    state, tool = model.state(tool_state), model.robot.tool
    links = state.chain.fk(np.zeros(state.chain.n))
    T_frame_tip = pose(R=tool.R_tip_lance(tool_state).T)
    T_frame_world = T_frame_tip @ inverse(links[-1] @ tool.T_last_tip)
    centers, frames = np.empty((0, 3)), np.empty(0, np.int32)
    radii = np.empty(0)
    for frame, name in ((LANCE, tool.lance_link), *((CUP, name) for name in tool.contact_links)):
        k = model.frame_names.index(name)
        is_of_link = state.spheres.frames == k
        T = T_frame_world @ links[k]
        centers = np.vstack([centers, state.spheres.centers[is_of_link] @ T[:3, :3].T + T[:3, 3]])
        radii = np.append(radii, state.spheres.radii[is_of_link])
        frames = np.append(frames, np.full(int(is_of_link.sum()), frame, np.int32))
    return centers, radii, frames
