"""Allowed contacts of one segment of motion, and their depth (MoveIt: an allowed collision matrix).

``stage_contacts`` builds those of each stage of a motion. A neighbour that may be touched is tested at its
perceived pose, without the pose error, and shifted away by the depth that explains the contact: as deep as
uncertain poses already overlap, or as far as the bellows give way along the cup's axis. A solid that the
shifted one clears is entered no deeper than that. A solid without a shift may be touched at any depth;
everything that is not named keeps the cell's clearance. Items that a held item may push aside are not tested
against it at all; cup and arm keep clear of them where they are perceived. An empty tool pushes with its cup,
and only the arm keeps clear of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pickcli.collision.collision_world import CollisionWorld, Entered
from pickcli.geometry import Array
from pickcli.kernel import Checker

Way: TypeAlias = tuple[float, float, float]  # m in the world

Touchers: TypeAlias = tuple[tuple[str, Way | None], ...]  # by name, sorted: hashable and comparable


@dataclass(frozen=True)
class AllowedContacts:
    """Solids that the held item and the cup or fingers may touch, and items that are absent.

    Attributes:
        item: Solids that the held item may touch: body or item by name, and how far it is shifted away; None
            if it may be touched at any depth.
        tool: Solids that the cup or the fingers may touch: body or item by name, and how far it is shifted
            away; None if it may be touched at any depth.
        absent: Ids of items that are not in the world: the held one, and those that a planner ignores.
        pushed: Ids of items that the held item may push aside; if there is none, the cup.
        opening_pairs: Pairs (link of the robot or "held <item>", body or item) that are not tested, because a
            recovery motion only has to separate them.
        entered: Item and hollow that the tool may enter, if any; it keeps clear of the walls.
    """

    item: Touchers = ()
    tool: Touchers = ()
    absent: frozenset[str] = frozenset()
    pushed: frozenset[str] = frozenset()
    opening_pairs: frozenset[tuple[str, str]] = frozenset()
    entered: Entered | None = None

    @classmethod
    def of(
        cls,
        item: Mapping[str, Array] | None = None,
        tool: Mapping[str, Array] | None = None,
        absent: frozenset[str] = frozenset(),
    ) -> AllowedContacts:
        """Build contacts of limited depth.

        Args:
            item: By name, shift (3,) in m in the world of each solid that the held item may touch.
            tool: By name, shift (3,) in m in the world of each solid that cup or fingers may touch.
            absent: Ids of items that are absent.

        Returns:
            The contacts.
        """
        return cls(_sorted(item or {}), _sorted(tool or {}), absent)

    @classmethod
    def at_any_depth(cls, names: Iterable[str], absent: frozenset[str] = frozenset()) -> AllowedContacts:
        """Build contacts of tool and held item without a limit of their depth.

        Args:
            names: Bodies and items that may be touched.
            absent: Ids of items that are absent.

        Returns:
            The contacts.
        """
        touchers = tuple((name, None) for name in sorted(names))
        return cls(touchers, touchers, absent)

    @property
    def names(self) -> frozenset[str]:
        """Names of all solids that may be touched."""
        return frozenset(name for name, _ in (*self.item, *self.tool))

    @property
    def of_present(self) -> AllowedContacts:
        """The contacts without those with absent items."""
        item, tool = (tuple(t for t in ts if t[0] not in self.absent) for ts in (self.item, self.tool))
        return replace(self, item=item, tool=tool, pushed=self.pushed - self.absent)

    @property
    def of_empty_tool(self) -> AllowedContacts:
        """The contacts of the tool, without those of the held item."""
        return replace(self, item=())

    def ignored_frames(
        self, world: CollisionWorld, tool: tuple[int, ...], item: int, is_empty: bool = False
    ) -> NDArray[np.uint64]:
        """Return the frames that keep no clearance from each solid.

        Args:
            world: Solids of the scene.
            tool: Frames of the tool that may touch: that of the cup, or those of the fingers.
            item: Frame of the held item.
            is_empty: Whether the tool pushes by itself, because it holds nothing.

        Returns:
            (B,) frames as bits, per solid of the world.

        Raises:
            UnknownNameError: If the scene has no solid with one of the names.
        """
        bits = np.zeros(len(world.names), np.uint64)
        touched = tuple(name for name, _ in self.item)
        met, pushing = tuple(name for name, _ in self.tool), tool if is_empty else (item,)
        for frames, names in ((tool, met), ((item,), touched), (pushing, tuple(sorted(self.pushed)))):
            bits[world.indices(names)] |= np.uint64(sum(1 << f for f in set(frames)))
        return bits

    def enter(self, kernel: Checker, world: CollisionWorld, cup: int, item: int) -> NDArray[np.intp]:
        """Set a checker's world to the solids that may be touched to a limited depth, shifted away.

        Args:
            kernel: The checker.
            world: Solids of the scene.
            cup: Frame of the cup.
            item: Frame of the held item.

        Returns:
            (K,) indices in ``world`` of the solids entered, in their order.

        Raises:
            UnknownNameError: If the scene has no solid with one of the names.
        """
        chosen: list[int] = []
        ways: list[Way] = []
        bits: list[np.uint64] = []
        present = world.is_present(self.entered)
        for frame, touchers in ((cup, self.tool), (item, self.item)):
            for name, way in touchers:
                for solid in world.indices([name]) if way is not None else ():
                    if not present[solid]:
                        continue
                    assert way is not None
                    chosen.append(solid)
                    ways.append(way)
                    bits.append(~np.uint64(1 << frame))
        kept = np.array(chosen, dtype=np.intp)
        T = world.T_world_box[kept].copy()
        T[:, :3, 3] += np.array(ways).reshape(len(kept), 3)
        none = np.zeros(len(kept))
        ignored_frames = np.array(bits, dtype=np.uint64)
        kernel.set_world(T, world.half_extents[kept], ignored_frames, world.shapes[kept], none)
        return kept

    @property
    def is_limited(self) -> bool:
        """Whether any contact has a limited depth."""
        return any(way is not None for _, way in (*self.item, *self.tool))


def _sorted(ways: Mapping[str, Array]) -> Touchers:
    rounded = {name: tuple(round(float(v), 9) for v in way) for name, way in ways.items()}
    return tuple((name, (x, y, z)) for name, (x, y, z) in sorted(rounded.items()))


NO_CONTACTS = AllowedContacts()
