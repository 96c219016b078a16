"""Collision model of the robot: spheres around its links, and the pairs of links that are tested."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.cell import Cell
from pickcli.cell.robot import Joint, Link, Robot
from pickcli.cell.shapes import Body, ShapeKind
from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.kernel_robot import FrameSpheres, KernelRobot
from pickcli.collision.sphere_cover import Cover, cover_bodies, cover_meshes
from pickcli.collision.swept_cover import sweep
from pickcli.geometry import Array, pose
from pickcli.kernel import Checker
from pickcli.kinematics.chain import bodies_of_frames, build_chain

# How far a link's spheres may stick out: a share of the shape's thickness, between bounds in m. Lance and cup
# pass close to lips and neighbours; the arm's own links stay farther away.
RELATIVE_EXCESS = 0.08
LEAST_EXCESS, MOST_EXCESS = 0.002, 0.006
LINK_COUNT = 64  # spheres per shape; large boxes get a larger excess instead

# Without a tool nothing reaches into places: one excess for all shapes, however thin, makes planning quicker.
BARE_EXCESS = 0.0075

# How far spheres of the hulls of a link's meshes may stick out: seven links make at most some 220 spheres.
HULL_EXCESS, MOST_HULL_EXCESS = 0.014, 0.02
HULL_COUNT = 32

# How far spheres for self-collision may stick out: links of a wrist pass each other by a few mm.
FINE_EXCESS, MOST_FINE_EXCESS = 0.004, 0.006
FINE_COUNT = 96

# m beyond the cell's clearance that links on either side of a joint must keep at any of its positions to be
# exempt; else they are tested in every configuration.
SELF_DISTANCE_RESERVE = 0.003


class CollisionModel:
    """Data of a cell's robot that its collision checks share; built once per cell.

    Links that are fixed to the base belong to the world; links joined by fixed joints are one rigid body and
    are never tested against each other. Also exempt are two links connected by a joint, directly or through
    links without a shape, and the cell's allowed pairs. Other links of two bodies connected by a joint are
    exempt if they are proven apart at any position of that joint.

    Args:
        cell: The cell.

    Attributes:
        cell: The cell.
        robot: The cell's robot.
        frame_names: Name of the link of every frame, in the order of the chain.
        bodies: Number of the rigid body that each frame belongs to, 0 for those fixed to the base.
    """

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self.robot: Robot = cell.robot
        self.frame_names: tuple[str, ...] = tuple(link.name for link in cell.robot.links[1:])
        self.bodies: tuple[int, ...] = bodies_of_frames(cell.robot)
        self._states: dict[ToolState, KernelRobot] = {}

    @property
    def n_frames(self) -> int:
        """Number L of frames; frame L stands for the held item."""
        return len(self.frame_names)

    @property
    def covers(self) -> dict[str, Cover]:
        """Spheres of every link's shapes, in its frame, by its name; none for links fixed to the base."""
        return dict(zip(self.frame_names, self._covers, strict=True))

    @property
    def tip_excess(self) -> float:
        """How far in m the cup's spheres stick out of it, at most."""
        return self._covers[-1].excess

    @property
    def tool_frames(self) -> tuple[int, ...]:
        """Frames that may touch a grasped item: that of the cup, or those of the fingers."""
        return tuple(self.frame_names.index(link) for link in self.robot.tool.contact_links)

    @property
    def _fingers(self) -> dict[int, Joint]:
        """Joints of the fingers of a gripper, by the frame that each moves."""
        joints, fingers = self.robot.joints, self.robot.tool.grip.finger_joints
        return {k: joints[k] for k in self.tool_frames if joints[k].name in fingers}

    @property
    def held_tested_frames(self) -> NDArray[np.int32]:
        """Frames that the held item must keep clear of.

        All except those that are rigid with the base, the links that hold it, and the links of the chain
        that are rigid with those. A side branch that is rigid with them, such as a second tool on the flange,
        is not excepted.
        """
        holding = {*self._chain, *self.tool_frames}
        last = self.bodies[-1]
        return np.array(
            [k for k, b in enumerate(self.bodies) if b > 0 and (b < last or k not in holding)], dtype=np.int32
        )

    @property
    def _chain(self) -> frozenset[int]:
        """Frames from the base to the tool, without side branches."""
        parents = {joint.child: joint.parent for joint in self.robot.joints}
        link, found = self.frame_names[-1], set[str]()
        while link in parents:
            found.add(link)
            link = parents[link]
        return frozenset(k for k, name in enumerate(self.frame_names) if name in found)

    def state(self, tool_state: ToolState) -> KernelRobot:
        """Return the robot's arrays in one tool state, built at the first call.

        Args:
            tool_state: State of the tool.

        Returns:
            The arrays.
        """
        if tool_state not in self._states:
            self._states[tool_state] = self._build(tool_state)
        return self._states[tool_state]

    def swept(self, cover: Cover) -> Cover:
        """Return spheres around the volume that a cover sweeps between any two states of the tool.

        Args:
            cover: Spheres in the cup's frame, for the default state.

        Returns:
            Spheres in that frame.
        """
        joint = self.robot.joints[-1]
        return self._in_any_state(cover, joint) if joint.name == self.robot.tool.joint else cover

    def _in_any_state(self, cover: Cover, joint: Joint) -> Cover:
        """Return spheres around the volume that a cover sweeps with one of the tool's joints."""
        tool = self.robot.tool
        (least, most), here = tool.joint_range(joint.name), tool.joint_position(joint.name, MOVING)
        return cover if least == most else sweep(cover, joint, least - here, most - here)

    def is_allowed(self, a: str, b: str) -> bool:
        """Whether the cell exempts two names from being tested against each other.

        Args:
            a: Name of a link or body.
            b: Name of another one.

        Returns:
            True if it does.
        """
        return frozenset((a, b)) in self._allowed

    def are_joined(self, a: str, b: str) -> bool:
        """Whether a joint connects two links, directly or through links without a shape.

        Args:
            a: Name of a link.
            b: Name of another one.

        Returns:
            True if it does.
        """
        return frozenset((a, b)) in self._joined

    def are_apart(self, kernel: Checker, body: int) -> bool:
        """Whether nothing touches at any position of the joint that moves a body of the robot.

        Args:
            kernel: Checker of links that only this joint moves relative to each other, or to the world.
            body: Number of the body.

        Returns:
            True if it is proven with more than the clearance of the cell.
        """
        lower, upper = (np.zeros(self.robot.n_joints) for _ in range(2))
        low, high = self.robot.limits.window
        lower[body - 1], upper[body - 1] = low[body - 1], high[body - 1]
        return bool(kernel.edge_is_free(lower, upper, self.cell.clearance + SELF_DISTANCE_RESERVE))

    def static_bodies(self) -> tuple[tuple[str, Array, Body], ...]:
        """Return the shapes, except for hulls, of every link that is fixed to the base.

        Returns:
            (link name, T_world_link (4, 4), shape) of each.
        """
        return tuple(
            (link.name, T_world_link, body)
            for link, T_world_link in self._static_links()
            for body in link.bodies
            if body.shape.kind is not ShapeKind.HULL
        )

    def static_spheres(self) -> tuple[tuple[str, Array, float], ...]:
        """Return spheres around the hulls of every link that is fixed to the base.

        Returns:
            (link name, T_world_center (4, 4), radius in m) of each.
        """
        found = []
        for link, T_world_link in self._static_links():
            cover = _cover_hulls(link.bodies)
            centers = zip(cover.centers, cover.radii, strict=True)
            found += [(link.name, T_world_link @ pose(center), float(radius)) for center, radius in centers]
        return tuple(found)

    def _static_links(self) -> list[tuple[Link, Array]]:
        root = self.robot.links[0]
        T_world_link = {root.name: self.robot.T_world_base}
        found = [(root, self.robot.T_world_base)]
        for joint, link, body in zip(self.robot.joints, self.robot.links[1:], self.bodies, strict=True):
            if body > 0:
                break
            T_world_link[link.name] = T_world_link[joint.parent] @ joint.T_parent_joint
            found.append((link, T_world_link[link.name]))
        return found

    @cached_property
    def _allowed(self) -> frozenset[frozenset[str]]:
        return frozenset(frozenset((pair.a, pair.b)) for pair in self.cell.allowed_pairs)

    @cached_property
    def _joined(self) -> frozenset[frozenset[str]]:
        has_shape = {link.name for link in self.robot.links if link.bodies}
        parents = {joint.child: joint.parent for joint in self.robot.joints}
        found = set()
        for link in parents:
            above = parents[link]
            while above in parents and above not in has_shape:
                above = parents[above]
            found.add(frozenset((link, above)))
        return frozenset(found)

    @cached_property
    def _covers(self) -> tuple[Cover, ...]:
        """Sphere covers of the frames; empty for frames that are fixed to the base."""
        links = zip(self.robot.links[1:], self.bodies, strict=True)
        excess = _bare_excess if self.robot.tool.is_bare else _excess
        return tuple(_cover(link.bodies if body > 0 else (), excess) for link, body in links)

    @cached_property
    def _fine_covers(self) -> tuple[Cover, ...]:
        """Tighter covers of the frames with meshes, and of all without a tool; empty for all others."""
        links, is_bare = zip(self.robot.links[1:], self.bodies, strict=True), self.robot.tool.is_bare
        return tuple(_fine_cover(link.bodies if body > 0 else (), is_bare) for link, body in links)

    def _build(self, tool_state: ToolState) -> KernelRobot:
        coarse, fine = (
            FrameSpheres.of_covers(self._in_state(covers, tool_state))
            for covers in (self._covers, self._fine_covers)
        )
        none = np.zeros((0, 2), dtype=np.int32)
        whole = KernelRobot(build_chain(self.robot, tool_state), coarse, fine, none)
        pairs = [pair for pair in self._pairs() if self._is_tested(whole, *pair)]
        return replace(whole, self_pairs=np.array(pairs, dtype=np.int32).reshape(-1, 2))

    def _in_state(self, covers: Sequence[Cover], tool_state: ToolState) -> Sequence[Cover]:
        """Return the covers of the frames; for a moving tool, its covers are swept."""
        if tool_state != MOVING:
            return covers
        fingers = {k: self._in_any_state(covers[k], finger) for k, finger in self._fingers.items()}
        moving = [fingers.get(k, cover) for k, cover in enumerate(covers)]
        return [*moving[:-1], self.swept(moving[-1])]

    def _pairs(self) -> Iterator[tuple[int, int]]:
        """Yield pairs of frames with shapes that move relative to each other, except for allowed pairs."""
        solid = [k for k in range(self.n_frames) if len(self._covers[k].radii)]
        for i, j in combinations(solid, 2):
            if self.bodies[j] > self.bodies[i] and not self.is_allowed(
                self.frame_names[i], self.frame_names[j]
            ):
                yield i, j

    def _is_tested(self, whole: KernelRobot, i: int, j: int) -> bool:
        """Whether frame i is tested against frame j, of a later body, in every configuration."""
        if self.bodies[j] - self.bodies[i] > 1:
            return True
        if self.are_joined(self.frame_names[i], self.frame_names[j]):
            return False
        return not self.are_apart(whole.of_frames((i, j)), self.bodies[j])


def _cover(shapes: tuple[Body, ...], excess: Callable[[Body], float]) -> Cover:
    """Cover a link's shapes with spheres: its hulls as one solid, every other shape by itself."""
    plain = [body for body in shapes if body.shape.kind is not ShapeKind.HULL]
    return cover_bodies(plain, excess, LINK_COUNT).joined(_cover_hulls(shapes))


def _fine_cover(shapes: tuple[Body, ...], is_bare: bool) -> Cover:
    """Cover a link's shapes with tighter spheres; on an arm with a tool none for a link without hulls."""
    hulls = _hulls(shapes)
    plain = [body for body in shapes if (hulls or is_bare) and body.shape.kind is not ShapeKind.HULL]
    fine = cover_meshes(hulls, FINE_EXCESS, MOST_FINE_EXCESS, FINE_COUNT)
    return cover_bodies(plain, _excess, LINK_COUNT).joined(fine)


def _cover_hulls(shapes: tuple[Body, ...]) -> Cover:
    return cover_meshes(_hulls(shapes), HULL_EXCESS, MOST_HULL_EXCESS, HULL_COUNT)


def _hulls(shapes: tuple[Body, ...]) -> list[Body]:
    return [body for body in shapes if body.shape.kind is ShapeKind.HULL]


def _excess(body: Body) -> float:
    return float(np.clip(RELATIVE_EXCESS * body.shape.extents.min(), LEAST_EXCESS, MOST_EXCESS))


def _bare_excess(body: Body) -> float:
    """Excess of a shape of a robot without a tool."""
    return BARE_EXCESS
