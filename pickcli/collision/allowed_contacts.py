"""Who may touch whom on one segment of motion, and how deep (MoveIt: an allowed collision matrix).

``stage_contacts`` makes those of each stage of a motion. A neighbour that may be touched counts as it is
perceived, without what its pose may be off, and as moved out of the way by what explains the contact: as deep
as uncertain poses already have the two in each other, or as far as the bellows give along the cup's axis.
What keeps clear of it there goes no deeper than that. What has no way to give may be touched at any depth;
everything that is not named keeps the cell's clearance.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pickcli.collision.collision_world import CollisionWorld
from pickcli.geometry import Array
from pickcli.kernel import Checker

Way: TypeAlias = tuple[float, float, float]  # m in the world

Touchers: TypeAlias = tuple[tuple[str, Way | None], ...]  # by name, sorted: hashable, and equal where equal


@dataclass(frozen=True)
class AllowedContacts:
    """What the held item and the cup or the fingers may touch, and which items are not there at all.

    Attributes:
        item: What the held item may touch: body or item by name, and how far it counts as moved out of the
            way; None where it may be touched at any depth.
        tool: What the cup or the fingers may touch: body or item by name, and how far it counts as moved out
            of the way; None where it may be touched at any depth.
        absent: Ids of items that are not there: the one that is held, and those a planner may ignore.
        opening: Pairs (link of the robot or "held <item>", body or item) that are not tested: those that a
            way out of a stop only has to take apart.
    """

    item: Touchers = ()
    tool: Touchers = ()
    absent: frozenset[str] = frozenset()
    opening: frozenset[tuple[str, str]] = frozenset()

    @classmethod
    def of(
        cls,
        item: Mapping[str, Array] | None = None,
        tool: Mapping[str, Array] | None = None,
        absent: frozenset[str] = frozenset(),
    ) -> AllowedContacts:
        """Contacts that are allowed only so deep.

        Args:
            item: By name, how far (3,) in m of the world what the held item may touch counts as moved.
            tool: By name, how far (3,) in m of the world what cup or fingers may touch counts as moved.
            absent: Ids of items that are not there.

        Returns:
            The contacts.
        """
        return cls(_sorted(item or {}), _sorted(tool or {}), absent)

    @classmethod
    def at_any_depth(cls, names: Iterable[str], absent: frozenset[str] = frozenset()) -> AllowedContacts:
        """Contacts of tool and held item that may be as deep as they like.

        Args:
            names: Bodies and items that may be touched.
            absent: Ids of items that are not there.

        Returns:
            The contacts.
        """
        touchers = tuple((name, None) for name in sorted(names))
        return cls(touchers, touchers, absent)

    @property
    def names(self) -> frozenset[str]:
        """Everything that may be touched."""
        return frozenset(name for name, _ in (*self.item, *self.tool))

    @property
    def of_present(self) -> AllowedContacts:
        """The contacts left when those with items that are not there are dropped."""
        item, tool = (tuple(t for t in ts if t[0] not in self.absent) for ts in (self.item, self.tool))
        return replace(self, item=item, tool=tool)

    @property
    def of_empty_tool(self) -> AllowedContacts:
        """The contacts left when nothing is held."""
        return replace(self, item=())

    def ignored(self, world: CollisionWorld, tool: tuple[int, ...], item: int) -> NDArray[np.uint64]:
        """Which frames keep no clearance from which solids.

        Args:
            world: Solids of the scene.
            tool: Frames of the tool that may touch: that of the cup, or those of the fingers.
            item: Frame of the held item.

        Returns:
            (B,) per solid of the world the frames, as bits.

        Raises:
            UnknownNameError: If the scene has nothing of a name.
        """
        bits = np.zeros(len(world.names), np.uint64)
        for frames, touchers in ((tool, self.tool), ((item,), self.item)):
            bits[world.indices(name for name, _ in touchers)] |= np.uint64(sum(1 << f for f in set(frames)))
        return bits

    def enter(self, kernel: Checker, world: CollisionWorld, cup: int, item: int) -> NDArray[np.intp]:
        """Give a checker, as its world, what may be touched only so deep, moved out of the way.

        Args:
            kernel: The checker.
            world: Solids of the scene.
            cup: Frame of the cup.
            item: Frame of the held item.

        Returns:
            (K,) indices in ``world`` of the solids entered, in their order.

        Raises:
            UnknownNameError: If the scene has nothing of a name.
        """
        chosen: list[int] = []
        ways: list[Way] = []
        bits: list[np.uint64] = []
        for frame, touchers in ((cup, self.tool), (item, self.item)):
            for name, way in touchers:
                for solid in world.indices([name]) if way is not None else ():
                    assert way is not None
                    chosen.append(solid)
                    ways.append(way)
                    bits.append(~np.uint64(1 << frame))
        kept = np.array(chosen, dtype=np.intp)
        T = world.T_world_box[kept].copy()
        T[:, :3, 3] += np.array(ways).reshape(len(kept), 3)
        none = np.zeros(len(kept))
        ignored = np.array(bits, dtype=np.uint64)
        kernel.set_world(T, world.half_extents[kept], ignored, world.shapes[kept], none)
        return kept

    @property
    def is_limited(self) -> bool:
        """Whether anything may be touched only so deep."""
        return any(way is not None for _, way in (*self.item, *self.tool))


def _sorted(ways: Mapping[str, Array]) -> Touchers:
    rounded = {name: tuple(round(float(v), 9) for v in way) for name, way in ways.items()}
    return tuple((name, (x, y, z)) for name, (x, y, z) in sorted(rounded.items()))


NO_CONTACTS = AllowedContacts()
