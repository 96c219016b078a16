"""Statics of single items: whether the contacts of an item keep it in balance.

An item stays if its remaining contacts can balance its weight within their friction cones (Mason, Mechanics
of Robotic Manipulation, 2001, ch. 7), also if the world is tilted slightly in any direction and if items on
it press on any corner of their contacts, because poses are uncertain. The test is conservative: an item that
fails it may still stay.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Set
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import GRAVITY, Array
from pickcli.scene.scene import PlacedItem
from pickcli.statics.contact_graph import ContactGraph
from pickcli.statics.hollow_contacts import hollow_patches, is_of_hollow
from pickcli.statics.patches import feature, patch
from pickcli.statics.solid_contact import (
    SolidContact,
    balance,
    bears,
    can_balance,
    friction_cones,
    missing_to_balance,
)

LEAST_TILT = np.radians(1.0)  # tilt of the world, in addition to the angular error of poses
CHOCK_TILT = np.radians(10.0)  # tilt for items that can roll, so that a slight step does not count as a chock
LEVEL_SLOPE = np.radians(1.0)  # largest slope of the ground on which nothing begins to roll
SETTLED = np.radians(1.5)  # rad, misalignment of faces in contact as they lie, at most
EXPLAINED = 2e-3  # weights; a lack of balance up to this is explained by small pose errors
WORSE = 1e-3  # weights by which the lack must increase to count
ROUGH = 1.0  # friction that no item exceeds on another
LEVER = 5e-4  # m, of rounded poses of settled items
# weights left unbalanced; settled piles leave 0.005 at most, as seen with errors of poses
WEIGHT_TOLERANCE = 0.03
# narrowest side of the base over the height, below which an item must lean on something
FREE_SLENDERNESS = 0.35
N_TILTS = 8  # number of directions in which the world is tilted
_UP = np.array([0.0, 0.0, 1.0])
_NO_FORCE = np.zeros((6, 1))  # for a body without contacts


@dataclass(frozen=True, eq=False)
class Balance:
    """The statics of one scene's items.

    Attributes:
        graph: The contacts of the scene.
    """

    graph: ContactGraph

    def stays(self, item_id: str, without: Iterable[str] = ()) -> bool:
        """Whether an item keeps its balance after others are removed.

        Args:
            item_id: Id of the item.
            without: Ids of the removed items.

        Returns:
            True if it does.
        """
        gone = frozenset(without)
        if (item_id, gone) not in self._known:
            self._known[item_id, gone] = self._is_balanced(item_id, gone)
        return self._known[item_id, gone]

    def stays_under(self, item_id: str, force: Array, point: Array) -> bool:
        """Whether an item at its least mass keeps its balance while a force presses on it.

        Args:
            item_id: Id of the item.
            force: (3,) N, the pressing force, world axes.
            point: (3,) m in the world, at which it acts.

        Returns:
            True if it does.
        """
        placed = self.graph.items[item_id]
        centre, weight = placed.T_world_item[:3, 3], placed.item.lightest * GRAVITY * _UP
        for contact in self._bearing_weight(item_id):  # usually one of these bears both forces by itself
            if bears(self._patch(contact), -contact.normal, force, point):
                return True
        borne = weight - force
        wrench = np.concatenate([borne, np.cross(point - centre, -force)]) / np.linalg.norm(borne)
        return can_balance(self._holding(item_id, frozenset()), wrench, _half_size(placed))

    def is_at_rest(self, item_id: str) -> bool:
        """Whether an item can be at rest at its pose, with rough surfaces and contact forces of any size.

        Items with hollows touch with the solids that are left of them.

        Args:
            item_id: Id of the item.

        Returns:
            False if it must fall or roll from there, however its contacts push.
        """
        cones, own = self._rested_on(item_id), np.concatenate([_UP, np.zeros(3)])
        placed = self.graph.items[item_id]
        lever = LEVER + 2 * self.graph.scene.bound(placed)  # m that its weight may act beside contacts
        return balance(cones, own, min(_half_size(placed), lever / WEIGHT_TOLERANCE))[1] <= WEIGHT_TOLERANCE

    def footing(self, item_id: str, is_sure: bool = True) -> Array:
        """Return the corners of the contacts that carry an item.

        Args:
            item_id: Id of the item.
            is_sure: Whether to return only the area that is in contact for every allowed pose error.

        Returns:
            (N, 3) m in the world, corners of all contacts that carry it. If no area is sure, the contacts by
            the nominal poses, as it must stand on something.
        """
        carrying = [contact for contact in self.graph.touching[item_id] if contact.carries]
        sure = np.concatenate([np.empty((0, 3)), *(self._patch(contact) for contact in carrying)])
        if not carrying or (is_sure and len(sure)):
            return sure
        return np.concatenate([self._found_patch(contact, inset=0.0) for contact in carrying])

    def lies_level(self, item_id: str, without: Set[str] = frozenset()) -> bool:
        """Whether an item that can roll lies only on ground that is level in the rolling direction.

        Such an item stays unless it is pushed, if nothing lies on it. A lying cylinder rolls only across its
        axis: on ground that slopes along the axis, friction holds it.

        Args:
            item_id: Id of the item.
            without: Ids of the removed items.

        Returns:
            True if it does.
        """
        placed = self.graph.items[item_id]
        if not placed.can_roll:
            return False
        left = [c for c in self.graph.touching[item_id] if c.b not in without]
        slopes = [_slope_to_roll(placed, c.normal) for c in left if c.carries]
        if not slopes or any(c.flipped.carries for c in left if c.b in self.graph.items):
            return False
        return bool(max(slopes) <= np.sin(LEVEL_SLOPE))

    def is_tipping(self, item_id: str, without: str) -> bool:
        """Whether the items on an item keep it in balance, and no longer do if one of them is removed.

        This is so if all weights balance and the remaining ones do not. With uncertain poses it is also
        assumed if some forces anywhere in the contacts balance the item, and the remaining contacts cannot.

        Args:
            item_id: Id of the item.
            without: Id of an item that lies on it, directly or indirectly.

        Returns:
            True if it loses its counterweight.
        """
        lifted = frozenset({without, *self.graph.chain(self.graph.lying_on, without)})
        missing = self._missing(item_id, frozenset())
        if missing <= EXPLAINED and self._missing(item_id, lifted) > missing + WORSE:
            return True
        if self.graph.scene.noise_of(self.graph.items[item_id]).position == 0.0:
            return False
        own = np.concatenate([_UP, np.zeros(3)])
        size = _half_size(self.graph.items[item_id])
        with_it, left = (self._touched(item_id, gone) for gone in (frozenset(), lifted))
        return can_balance(with_it, own, size) and not can_balance(left, own, size)

    def _weights(self, placed: PlacedItem) -> Array:
        """Unit vectors (K, 3) opposite to an item's weight: straight up, and tilted."""
        tilt = self.graph.scene.noise_of(placed).angle + (CHOCK_TILT if placed.can_roll else LEAST_TILT)
        turns = 2 * np.pi * np.arange(N_TILTS) / N_TILTS
        aside = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(N_TILTS)])
        return np.vstack([_UP, np.cos(tilt) * _UP + np.sin(tilt) * aside])

    @cached_property
    def _known(self) -> dict[tuple[str, frozenset[str]], bool]:
        """Cache of ``stays`` by item and removed items."""
        return {}

    @cached_property
    def _bearing(self) -> dict[str, tuple[SolidContact, ...]]:
        return {}

    @cached_property
    def _patches(self) -> dict[tuple[str, str, bytes], Array]:
        """Cache of contact patches."""
        return {}

    def _bearing_weight(self, item_id: str) -> tuple[SolidContact, ...]:
        """Return the contacts each of which could bear an item's weight by itself."""
        if item_id not in self._bearing:
            centre = self.graph.items[item_id].T_world_item[:3, 3]
            self._bearing[item_id] = tuple(
                contact
                for contact in self.graph.touching[item_id]
                if contact.carries and bears(self._patch(contact), -contact.normal, -_UP, centre)
            )
        return self._bearing[item_id]

    def _patch(self, contact: SolidContact) -> Array:
        """Corners (N, 3) of the patch in which a presses on b."""
        key = contact.a, contact.b, contact.normal.tobytes()
        if key not in self._patches:
            self._patches[key] = self._found_patch(contact, self._inset(contact))
        return self._patches[key]

    def _inset(self, contact: SolidContact) -> float:
        """Margin (m) inside an item's face within which another item lies on it for every allowed pose error.

        It is 0 on bodies of carriers.
        """
        a, b = self.graph.index[contact.a], self.graph.index[contact.b]
        return (
            float(self.graph.solids.bound[a] + self.graph.solids.bound[b])
            if contact.b in self.graph.items
            else 0.0
        )

    def _found_patch(self, contact: SolidContact, inset: float) -> Array:
        a, b = self.graph.index[contact.a], self.graph.index[contact.b]
        solids, askew = self.graph.solids, self._askew(contact)
        mine = feature(solids.shapes[a], solids.T[a], contact.normal, askew)
        theirs = feature(solids.shapes[b], solids.T[b], -contact.normal, askew)
        return patch(mine, theirs, contact.normal, inset)

    def _askew(self, contact: SolidContact) -> float:
        """Misalignment (rad) of faces that are in contact, at most."""
        both = [self.graph.items[name] for name in (contact.a, contact.b) if name in self.graph.items]
        angle = max((self.graph.scene.noise_of(placed).angle for placed in both), default=0.0)
        return float(max(SETTLED, 2 * angle))

    def _is_balanced(self, name: str, gone: frozenset[str]) -> bool:
        """Whether the remaining contacts can balance an item for every tilt of the world."""
        left = [c for c in self.graph.touching[name] if c.b not in gone]
        centre, cones = self.graph.items[name].T_world_item[:3, 3], self._holding(name, gone)
        size = _half_size(self.graph.items[name])
        wrenches = [np.concatenate([w, np.zeros(3)]) for w in self._weights(self.graph.items[name])]
        on_it = [c for c in left if c.b in self.graph.items and c.flipped.carries]
        wrenches += [wrench for contact in on_it for wrench in self._pressed(contact, centre)]
        return all(can_balance(cones, wrench, size) for wrench in wrenches)

    def _holding(self, name: str, gone: frozenset[str]) -> Array:
        """Unit wrenches (6, 4 N) about an item's centre by the remaining contacts, except of items on it."""
        left = [c for c in self.graph.touching[name] if c.b not in gone and not c.flipped.carries]
        centre = self.graph.items[name].T_world_item[:3, 3]
        return np.concatenate(
            [_NO_FORCE, *(friction_cones(self._patch(c) - centre, -c.normal) for c in left)], axis=1
        )

    def _touched(self, name: str, gone: frozenset[str]) -> Array:
        """Unit wrenches (6, 4 N) about an item's centre by all remaining contacts, at the nominal poses."""
        left = [c for c in self.graph.touching[name] if c.b not in gone]
        centre = self.graph.items[name].T_world_item[:3, 3]
        return np.concatenate(
            [
                _NO_FORCE,
                *(friction_cones(self._found_patch(c, 0.0) - centre, -c.normal) for c in left),
            ],
            axis=1,
        )

    def _rested_on(self, name: str) -> Array:
        """Unit wrenches (6, 4 N) about an item's centre by what it really touches, if it is rough."""
        centre, contacts = self.graph.items[name].T_world_item[:3, 3], self.graph.touching[name]
        hollow = [contact for contact in contacts if is_of_hollow(self.graph, contact)]
        whole = [(self._found_patch(c, 0.0), c.normal) for c in contacts if c not in hollow]
        parts = [each for c in hollow for each in hollow_patches(self.graph, c, self._askew(c))]
        cones = [friction_cones(met - centre, -normal, ROUGH) for met, normal in [*whole, *parts]]
        return np.concatenate([_NO_FORCE, *cones], axis=1)

    def _pressed(self, contact: SolidContact, centre: Array) -> Iterator[Array]:
        """Wrenches (6,) that hold up an item on which another lies, one per point where the other may press.

        contact: between the two, as seen from the lower one
        """
        mass, places = self._pile(contact)
        share = mass / (mass + self.graph.items[contact.a].item.mass)
        for place in places:
            yield np.concatenate([_UP, np.cross(place - centre, share * _UP)])

    def _missing(self, name: str, lifted: Set[str]) -> float:
        """Weights by which the balance of an item with all items on it fails.

        Items that touch nothing else press with their whole weight at their centre of mass; others with any
        part of it at any point of their contact.

        lifted: ids of removed items
        """
        mine = self.graph.items[name]
        centre, borne = mine.T_world_item[:3, 3], np.concatenate([_UP, np.zeros(3)])
        presses, limits = [_NO_FORCE[:, :0]], list[tuple[int, float]]()
        for contact in self.graph.touching[name]:
            if contact.b not in self.graph.items or contact.b in lifted or not contact.flipped.carries:
                continue
            mass, places = self._pile(contact, lifted)
            if self._is_held_elsewhere(contact.b, {name, *lifted}):
                arms = self._found_patch(contact.flipped, inset=0.0) - centre
                presses.append(friction_cones(arms, -contact.normal))
                limits.append((presses[-1].shape[1], mass / mine.item.mass))
            else:
                weight = mass / mine.item.mass * _UP
                borne = borne + np.concatenate([weight, np.cross(places[0] - centre, weight)])
        cones = np.concatenate([*presses, self._holding(name, frozenset())], axis=1)
        return missing_to_balance(cones, borne, _half_size(mine), limits)

    def _is_held_elsewhere(self, name: str, others: Set[str]) -> bool:
        """Whether an item, or items on it, touch more than these others."""
        pile = {name, *self.graph.chain(self.graph.lying_on, name)} - others
        return any(c.b not in pile and c.b not in others for one in pile for c in self.graph.touching[one])

    def _pile(self, contact: SolidContact, lifted: Set[str] = frozenset()) -> tuple[float, Array]:
        """Mass (kg) of the items on an item at one contact, and points (N, 3) where it may press.

        contact: between the two, as seen from the lower one. lifted: ids of removed items
        """
        names = {contact.b, *self.graph.chain(self.graph.lying_on, contact.b)} - lifted
        pile = [self.graph.items[name] for name in sorted(names)]
        masses = np.array([placed.item.mass for placed in pile])
        if len(self.graph.carriers(contact.b)) > 1:
            return float(masses.sum()), self._patch(contact.flipped)
        middles = np.array([placed.T_world_item[:3, 3] for placed in pile])  # all weight acts downwards
        return float(masses.sum()), (masses @ middles / masses.sum())[None]


def _half_size(placed: PlacedItem) -> float:
    """Half of the item's largest extent, m, which scales moments to forces."""
    return float(placed.item.shape.extents.max()) / 2


def _slope_to_roll(placed: PlacedItem, normal: Array) -> float:
    """Sine of the slope in an item's rolling direction, on ground with a normal, (3,) in the world."""
    if placed.item.shape.kind is ShapeKind.SPHERE:
        return float(np.hypot(normal[0], normal[1]))
    return float(abs(np.cross(placed.T_world_item[:3, 2], normal)[2]))
