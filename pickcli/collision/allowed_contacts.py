"""Who may touch whom on one segment, and how deep: the one place where planned contact is allowed.

A neighbour that may be touched counts as it is perceived, without what its pose may be off, and as moved out
of the way by what explains the contact: as deep as uncertain poses already have the two in each other, or as
far as the bellows give along the cup's axis. Whoever keeps clear of it there goes no deeper than that. What
has no way to give may be touched anyhow; everything that is not named keeps the cell's clearance.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pickcli.collision.collision_world import World
from pickcli.geometry import Array
from pickcli.kernel import Checker

Way: TypeAlias = tuple[float, float, float]  # m in the world

Touchers: TypeAlias = tuple[tuple[str, Way | None], ...]  # by name, sorted: hashable, and equal where equal


@dataclass(frozen=True)
class AllowedContacts:
    """What the held item and the cup may touch.

    item, cup: body or item by name, and how far it counts as moved out of the way; None where it may be
        touched anyhow
    """

    item: Touchers = ()
    cup: Touchers = ()

    @classmethod
    def of(
        cls, item: Mapping[str, Array] | None = None, cup: Mapping[str, Array] | None = None
    ) -> AllowedContacts:
        """From ways (3,) by name."""
        return cls(_sorted(item or {}), _sorted(cup or {}))

    @classmethod
    def anyhow(cls, names: Iterable[str]) -> AllowedContacts:
        """Both may touch these as deep as they like: for ways out of where the robot stands already."""
        touchers = tuple((name, None) for name in sorted(names))
        return cls(touchers, touchers)

    @property
    def names(self) -> frozenset[str]:
        """Everything that may be touched."""
        return frozenset(name for name, _ in (*self.item, *self.cup))

    def but(self, names: frozenset[str]) -> AllowedContacts:
        """The same without the contacts with some bodies or items."""
        item, cup = (tuple(t for t in ts if t[0] not in names) for ts in (self.item, self.cup))
        return AllowedContacts(item, cup)

    def ignored(self, world: World, cup: int, item: int) -> NDArray[np.uint64]:
        """(B,) per solid of a world the frames, as bits, that keep no clearance from it.

        cup, item: frames of the cup and the held item
        """
        bits = np.zeros(len(world.names), np.uint64)
        for frame, touchers in ((cup, self.cup), (item, self.item)):
            bits[world.indices(name for name, _ in touchers)] |= np.uint64(1 << frame)
        return bits

    def enter(self, kernel: Checker, world: World, cup: int, item: int) -> NDArray[np.intp]:
        """Give a checker what may be touched only so deep, moved out of the way, as its world.

        Returns the indices (K,) in ``world`` of the solids entered, in their order.
        """
        chosen: list[int] = []
        ways: list[Way] = []
        bits: list[np.uint64] = []
        for frame, touchers in ((cup, self.cup), (item, self.item)):
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
        groups, ignored = np.arange(len(kept), dtype=np.int32), np.array(bits, dtype=np.uint64)
        kernel.set_world(T, world.half_extents[kept], groups, ignored, world.shapes[kept], none)
        return kept

    @property
    def is_limited(self) -> bool:
        """Whether anything may be touched only so deep."""
        return any(way is not None for _, way in (*self.item, *self.cup))


def _sorted(ways: Mapping[str, Array]) -> Touchers:
    rounded = {name: tuple(round(float(v), 9) for v in way) for name, way in ways.items()}
    return tuple((name, (x, y, z)) for name, (x, y, z) in sorted(rounded.items()))


NO_CONTACTS = AllowedContacts()
