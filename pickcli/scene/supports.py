"""Which item rests on which, and what falls or rolls when one is taken away.

Statics of single bodies. An item stays where it lies if the contacts that are left can balance its weight,
within cones of friction (Mason, Mechanics of Robotic Manipulation, 2001, ch. 7), and still can when the world
is tilted by a little to any side, and when what lies on it presses on any corner of where it touches: poses
are uncertain. What stays by that rule stays; what does not may stay all the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Set
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from pickcli.geometry import GRAVITY, Array
from pickcli.scene.patches import feature, patch
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_contact import SolidContact, bears, can_balance, friction_cones
from pickcli.scene.solid_overlap import TOUCH
from pickcli.scene.touching import Gaps, PosedSolids, gaps

LEAST_TILT = np.radians(1.0)  # of the world, on top of the angle that poses may be off
CHOCKED = np.radians(10.0)  # the same for what can roll: what keeps it must be more than a bend of the floor
LEVEL = np.radians(1.0)  # slope of the ground up to which nothing begins to roll
SETTLED = np.radians(1.5)  # rad by which a face that lies on another may be askew, on top of that
N_TILTS = 8  # directions in which the world is tilted


@dataclass(frozen=True, eq=False)
class Supports:
    """The support relation of one scene. Make it with ``supports_of``.

    Attributes:
        scene: The scene.
        solids: The scene's items in their order, then everything that stands.
        gaps: All pairs of an item and a solid that may touch.
    """

    scene: Scene
    solids: PosedSolids
    gaps: Gaps

    @cached_property
    def touching(self) -> Mapping[str, tuple[SolidContact, ...]]:
        """By item id: all contacts that it has or may have, seen from it."""
        found: dict[str, list[SolidContact]] = {placed.id: [] for placed in self.scene.items}
        names = self.solids.names
        for a, b, gap, normal in zip(
            self.gaps.a, self.gaps.b, self.gaps.width, self.gaps.normal, strict=True
        ):
            one = SolidContact(names[a], names[b], float(gap), normal)
            found[one.a].append(one)
            if one.b in found:
                found[one.b].append(one.flipped)
        for name in [name for name, contacts in found.items() if not any(c.carries for c in contacts)]:
            for below in self._below(name):
                found[name].append(below)
                if below.b in found:
                    found[below.b].append(below.flipped)
        return {name: tuple(contacts) for name, contacts in found.items()}

    def carriers(self, item_id: str) -> tuple[str, ...]:
        """What an item rests on: wholly where there is but one.

        Args:
            item_id: Id of the item.

        Returns:
            Ids of items and names of bodies.
        """
        return tuple(c.b for c in self.touching[item_id] if c.carries)

    def lying_on(self, item_id: str) -> tuple[str, ...]:
        """What rests on an item, wholly or partly.

        Args:
            item_id: Id of the item.

        Returns:
            Ids of items.
        """
        contacts = self.touching[item_id]
        return tuple(c.b for c in contacts if c.b in self._items and c.flipped.carries)

    def near(
        self, item_id: str, reach: float, also: frozenset[str] = frozenset()
    ) -> tuple[SolidContact, ...]:
        """All solids whose gap to an item may be below a reach, as poses may be off.

        Bodies of carriers count as grown to wherever the errors of their poses may put them.

        Args:
            item_id: Id of the item.
            reach: m.
            also: Names of solids that are reported wherever they stand.

        Returns:
            Contacts, seen from the item.
        """
        solids, k = self._grown, self._index[item_id]
        where = self._items[item_id].location
        is_here = [name not in self._items or self._items[name].location == where for name in solids.names]
        apart = np.linalg.norm(solids.T[:, :3, 3] - solids.T[k, :3, 3], axis=1)
        balls = np.linalg.norm(solids.half, axis=1) + solids.bound
        asked = np.array([name in also for name in solids.names])
        b = np.flatnonzero(asked | (np.array(is_here) & (apart <= balls + balls[k] + reach)))
        b = b[b != k]
        found = gaps(solids, np.full(len(b), k), b)
        close = np.flatnonzero(asked[b] | (found.width < reach + solids.bound[k] + solids.bound[b]))
        return tuple(
            SolidContact(item_id, solids.names[b[i]], float(found.width[i]), found.normal[i]) for i in close
        )

    def stays(self, item_id: str, without: Iterable[str] = ()) -> bool:
        """Whether an item keeps its balance on what it touches when others are gone.

        Args:
            item_id: Id of the item.
            without: Ids of the items that are gone.

        Returns:
            True if it does.
        """
        gone = frozenset(without)
        if (item_id, gone) not in self._known:
            self._known[item_id, gone] = self._is_balanced(item_id, gone)
        return self._known[item_id, gone]

    def stays_under(self, item_id: str, force: Array, point: Array) -> bool:
        """Whether an item, as light as it may be, keeps its balance on what it touches while pressed on.

        Args:
            item_id: Id of the item.
            force: (3,) N with which it is pressed, world axes.
            point: (3,) m in the world, where it is pressed.

        Returns:
            True if it does.
        """
        placed = self._items[item_id]
        centre, weight = placed.T_world_item[:3, 3], placed.item.lightest * GRAVITY * _UP
        both = (-weight, centre), (force, point)
        for contact in self.touching[item_id]:  # mostly one bears both by itself
            if contact.carries and all(bears(self._patch(contact), -contact.normal, *at) for at in both):
                return True
        borne = weight - force
        wrench = np.concatenate([borne, np.cross(point - centre, -force)]) / np.linalg.norm(borne)
        size = float(placed.item.shape.extents.max()) / 2
        return can_balance(self._holding(item_id, frozenset()), wrench, size)

    def footing(self, item_id: str) -> Array:
        """Where an item stands on what carries it.

        Args:
            item_id: Id of the item.

        Returns:
            (N, 3) m in the world, corners of all contacts that carry it, wherever poses may be off. Where
            those may put it beside all of them, as the poses say: on something it stands.
        """
        carrying = [contact for contact in self.touching[item_id] if contact.carries]
        sure = np.concatenate([np.empty((0, 3)), *(self._patch(contact) for contact in carrying)])
        if len(sure) or not carrying:
            return sure
        return np.concatenate([self._found_patch(contact, inset=0.0) for contact in carrying])

    def lies_level(self, item_id: str) -> bool:
        """Whether an item that can roll lies on nothing but level ground: it stays unless it is pushed.

        Args:
            item_id: Id of the item.

        Returns:
            True if it does.
        """
        return self._lies_level(item_id, frozenset())

    def falling(self, item_id: str) -> tuple[str, ...]:
        """Items that would fall or roll away if an item were gone.

        Those that lie on it or lean on it, those that lie or lean on these, and those under it that keep
        their balance only by its weight. What can roll on a level floor and is not pushed stays: see
        ``rolling``.

        Args:
            item_id: Id of the item that is taken away.

        Returns:
            Ids, what must be moved first at the head.
        """
        below = self._chain(self.carriers, item_id)
        tipping = {name for name in below if self._is_tipping(name, without=item_id)}
        gone, todo = frozenset({item_id, *tipping}), [item_id, *sorted(tipping)]
        while todo:
            for contact in self.touching[todo.pop()]:
                name = contact.b
                if name in self._items and name not in gone and self._falls(name, contact, gone, below):
                    gone |= {name}
                    todo.append(name)
        return tuple(sorted(gone - {item_id}, key=lambda name: (-self._bottom[name], name)))

    def rolling(self, item_id: str) -> tuple[str, ...]:
        """Items that stay if an item that they touch is taken away, but roll as soon as they are pushed.

        Args:
            item_id: Id of the item that is taken away.

        Returns:
            Ids.
        """
        gone = frozenset({item_id, *self.falling(item_id)})
        left = [c.b for c in self.touching[item_id] if c.b in self.touching and c.b not in gone]
        return tuple(name for name in left if self._lies_level(name, gone) and not self.stays(name, gone))

    def _is_tipping(self, name: str, without: str) -> bool:
        """Whether what lies on an item keeps it in balance, and no longer without one of these."""
        lifted = {without, *self._chain(self.lying_on, without)}
        cones, size = self._holding(name, frozenset()), float(self._items[name].item.shape.extents.max()) / 2
        before, after = self._load(name), self._load(name, lifted)
        return can_balance(cones, before, size) and not can_balance(cones, after, size)

    def _falls(self, name: str, contact: SolidContact, gone: frozenset[str], below: frozenset[str]) -> bool:
        """Whether an item goes with one that it touches.

        contact: of the one that goes, seen from that. below: all that the target rests on
        """
        if contact.flipped.carries:
            return True  # it lies on what goes, be it only in part
        if self.stays(name, gone):
            return False
        if name in below:  # what is lifted off it may be its counterweight, or keep it on a slope
            return self.stays(name) or contact.is_steep
        return not self._lies_level(name, gone)

    def _lies_level(self, name: str, gone: frozenset[str]) -> bool:
        """Whether something that can roll lies on nothing but level ground, with nothing on it."""
        placed = self._items[name]
        if not placed.can_roll:
            return False
        left = [c for c in self.touching[name] if c.b not in gone]
        slopes = [np.hypot(c.normal[0], c.normal[1]) for c in left if c.carries]
        if not slopes or any(c.flipped.carries for c in left if c.b in self._items):
            return False
        return bool(max(slopes) <= np.sin(LEVEL))

    @cached_property
    def _items(self) -> Mapping[str, PlacedItem]:
        return {placed.id: placed for placed in self.scene.items}

    @cached_property
    def _index(self) -> Mapping[str, int]:
        return {name: k for k, name in enumerate(self.solids.names)}

    @cached_property
    def _grown(self) -> PosedSolids:
        """All solids as ``solids`` has them, but bodies of carriers grown by the errors of their poses."""
        return PosedSolids.of(self.scene, self.scene.items, self.scene.grown)

    @cached_property
    def _bottom(self) -> Mapping[str, float]:
        """Lowest point of every item, m."""
        bottoms = self.solids.T[:, 2, 3] - self.solids.upright[:, 2]
        return dict(zip(self.solids.names, bottoms.tolist(), strict=True))

    def _weights(self, placed: PlacedItem) -> Array:
        """(K, 3) unit vectors against which an item's weight may act: straight down, and tilted."""
        tilt = self.scene.noise.angle + (CHOCKED if placed.can_roll else LEAST_TILT)
        turns = 2 * np.pi * np.arange(N_TILTS) / N_TILTS
        aside = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(N_TILTS)])
        return np.vstack([_UP, np.cos(tilt) * _UP + np.sin(tilt) * aside])

    @cached_property
    def _known(self) -> dict[tuple[str, frozenset[str]], bool]:
        """Who stays without whom, as far as it was asked."""
        return {}

    @cached_property
    def _patches(self) -> dict[tuple[str, str, bytes], Array]:
        """Corners of contacts, as far as they were asked for."""
        return {}

    def _patch(self, contact: SolidContact) -> Array:
        """(N, 3) corners of where a presses on b."""
        key = contact.a, contact.b, contact.normal.tobytes()
        if key not in self._patches:
            self._patches[key] = self._found_patch(contact, self._inset(contact))
        return self._patches[key]

    def _inset(self, contact: SolidContact) -> float:
        """How far (m) inside of an item another must lie to be on it wherever poses may be off.

        What is carried by a body of the pod is carried wherever it lies on it.
        """
        a, b = self._index[contact.a], self._index[contact.b]
        return float(self.solids.bound[a] + self.solids.bound[b]) if contact.b in self._items else 0.0

    def _found_patch(self, contact: SolidContact, inset: float) -> Array:
        a, b = self._index[contact.a], self._index[contact.b]
        solids, askew = self.solids, SETTLED + 2 * self.scene.noise.angle
        mine = feature(solids.shapes[a], solids.T[a], contact.normal, askew)
        theirs = feature(solids.shapes[b], solids.T[b], -contact.normal, askew)
        return patch(mine, theirs, contact.normal, inset)

    def _is_balanced(self, name: str, gone: frozenset[str]) -> bool:
        """Whether contacts with what is left can balance an item, however the world is tilted."""
        left = [c for c in self.touching[name] if c.b not in gone]
        centre, cones = self._items[name].T_world_item[:3, 3], self._holding(name, gone)
        size = self._items[name].item.shape.extents.max() / 2
        wrenches = [np.concatenate([w, np.zeros(3)]) for w in self._weights(self._items[name])]
        on_it = [c for c in left if c.b in self._items and c.flipped.carries]
        wrenches += [wrench for contact in on_it for wrench in self._pressed(contact, centre)]
        return all(can_balance(cones, wrench, float(size)) for wrench in wrenches)

    def _holding(self, name: str, gone: frozenset[str]) -> Array:
        """(6, 4 N) unit wrenches about an item's centre of what is left around it and not on it."""
        left = [c for c in self.touching[name] if c.b not in gone and not c.flipped.carries]
        centre = self._items[name].T_world_item[:3, 3]
        return np.concatenate(
            [_NO_PUSH, *(friction_cones(self._patch(c) - centre, -c.normal) for c in left)], axis=1
        )

    def _pressed(self, contact: SolidContact, centre: Array) -> Iterator[Array]:
        """Wrenches (6,) that hold an item up on which another lies, for each place where the other may press.

        contact: between the two, seen from the one below
        """
        mass, places = self._pile(contact)
        share = mass / (mass + self._items[contact.a].item.mass)
        for place in places:
            yield np.concatenate([_UP, np.cross(place - centre, share * _UP)])

    def _load(self, name: str, lifted: Set[str] = frozenset()) -> Array:
        """Wrench (6,) that holds an item up with all on it, each pile in the middle of where it may press.

        lifted: ids of what no longer lies on it
        """
        mine, total, moment = self._items[name], self._items[name].item.mass, np.zeros(3)
        on_it = [c for c in self.touching[name] if c.b in self._items and c.flipped.carries]
        for mass, places in [self._pile(contact, lifted) for contact in on_it if contact.b not in lifted]:
            if len(places) > 0:  # else it may as well be off aside
                total, moment = total + mass, moment + mass * (places.mean(axis=0) - mine.T_world_item[:3, 3])
        return np.concatenate([_UP, np.cross(moment / total, _UP)])

    def _pile(self, contact: SolidContact, lifted: Set[str] = frozenset()) -> tuple[float, Array]:
        """Mass (kg) of what lies on an item at one contact, and (N, 3) where in the world it may press.

        contact: between the two, seen from the one below. lifted: ids of what no longer belongs to it
        """
        names = {contact.b, *self._chain(self.lying_on, contact.b)} - lifted
        pile = [self._items[name] for name in sorted(names)]
        masses = np.array([placed.item.mass for placed in pile])
        if len(self.carriers(contact.b)) > 1:
            return float(masses.sum()), self._patch(contact.flipped)
        middles = np.array([placed.T_world_item[:3, 3] for placed in pile])  # all goes straight down
        return float(masses.sum()), (masses @ middles / masses.sum())[None]

    def _chain(self, following: Callable[[str], Iterable[str]], name: str) -> frozenset[str]:
        """Ids of the items that follow an item, and of what follows those: all on it, or all under it."""
        found: set[str] = set()
        todo = [name]
        while todo:
            more = (set(following(todo.pop())) & self._items.keys()) - found - {name}
            found |= more
            todo += more
        return frozenset(found)

    def _below(self, name: str) -> Iterator[SolidContact]:
        """What an item that seems to hang in the air would fall onto: its support was seen elsewhere."""
        solids, k = self.solids, self._index[name]
        half = solids.upright
        apart = np.abs(solids.T[:, :2, 3] - solids.T[k, :2, 3]) < half[:, :2] + half[k, :2]
        tops = solids.T[:, 2, 3] + half[:, 2]
        fall = solids.T[k, 2, 3] - half[k, 2] - tops
        under = apart.all(axis=1) & (solids.T[:, 2, 3] < solids.T[k, 2, 3]) & (np.arange(len(half)) != k)
        for other in self.scene.items:
            under[self._index[other.id]] &= other.location == self._items[name].location
        if under.any():
            nearest = int(np.argmin(np.where(under, fall, np.inf)))
            yield SolidContact(name, solids.names[nearest], float(fall[nearest]), -_UP)


_UP = np.array([0.0, 0.0, 1.0])
_NO_PUSH = np.zeros((6, 1))  # of what touches nothing


@lru_cache(maxsize=32)
def supports_of(scene: Scene) -> Supports:
    """The support relation of a scene, from the poses and how well they are known. Cached by identity.

    Args:
        scene: Items, the carriers where they really stand, and the bounds of the error of the items' poses.

    Returns:
        All pairs that are no farther apart than those bounds allow for solids that touch.
    """
    solids = PosedSolids.of(scene, scene.items, scene.standing)
    places = np.array([placed.location for placed in scene.items] + [""] * len(scene.standing))
    a, b = solids.near(len(scene.items), TOUCH)
    is_possible = (places[a] == places[b]) | (places[b] == "")  # a board is between items of two bins
    found = gaps(solids, a[is_possible], b[is_possible])
    close = found.width <= TOUCH + solids.bound[found.a] + solids.bound[found.b]
    return Supports(
        scene, solids, Gaps(found.a[close], found.b[close], found.width[close], found.normal[close])
    )
