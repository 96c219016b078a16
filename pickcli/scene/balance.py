"""Whether contacts keep an item in balance: statics of a single body.

An item stays where it lies if the contacts that are left can balance its weight, within cones of friction
(Mason, Mechanics of Robotic Manipulation, 2001, ch. 7), and still can when the world is tilted by a little to
any side, and when what lies on it presses on any corner of where it touches: poses are uncertain. What stays
by that rule stays; what does not may stay all the same.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Set
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import GRAVITY, Array
from pickcli.scene.contact_graph import ContactGraph
from pickcli.scene.patches import feature, patch
from pickcli.scene.scene import PlacedItem
from pickcli.scene.solid_contact import (
    SolidContact,
    bears,
    can_balance,
    friction_cones,
    missing_to_balance,
)

LEAST_TILT = np.radians(1.0)  # of the world, on top of the angle that poses may be off
CHOCKED = np.radians(10.0)  # for what can roll: what keeps it must be more than a bend of the floor
LEVEL = np.radians(1.0)  # slope of the ground up to which nothing begins to roll
SETTLED = np.radians(1.5)  # rad by which a face that lies on another may be askew, on top of that
EXPLAINED = 2e-3  # weights that may be missing to a balance by poses that are hardly off; more is kept else
WORSE = 1e-3  # weights by which that must grow to count
N_TILTS = 8  # directions in which the world is tilted
_UP = np.array([0.0, 0.0, 1.0])
_NO_PUSH = np.zeros((6, 1))  # of what touches nothing


@dataclass(frozen=True, eq=False)
class Balance:
    """The statics of one scene's items.

    Attributes:
        graph: The contacts of the scene.
    """

    graph: ContactGraph

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
        placed = self.graph.items[item_id]
        centre, weight = placed.T_world_item[:3, 3], placed.item.lightest * GRAVITY * _UP
        both = (-weight, centre), (force, point)
        for contact in self.graph.touching[item_id]:  # mostly one bears both by itself
            if contact.carries and all(bears(self._patch(contact), -contact.normal, *at) for at in both):
                return True
        borne = weight - force
        wrench = np.concatenate([borne, np.cross(point - centre, -force)]) / np.linalg.norm(borne)
        return can_balance(self._holding(item_id, frozenset()), wrench, _half_size(placed))

    def footing(self, item_id: str, is_sure: bool = True) -> Array:
        """Where an item stands on what carries it.

        Args:
            item_id: Id of the item.
            is_sure: Whether only what is there wherever poses may be off.

        Returns:
            (N, 3) m in the world, corners of all contacts that carry it. Where poses may put it beside all of
            them, as the poses say: on something it stands.
        """
        carrying = [contact for contact in self.graph.touching[item_id] if contact.carries]
        sure = np.concatenate([np.empty((0, 3)), *(self._patch(contact) for contact in carrying)])
        if not carrying or (is_sure and len(sure)):
            return sure
        return np.concatenate([self._found_patch(contact, inset=0.0) for contact in carrying])

    def lies_level(self, item_id: str, without: Set[str] = frozenset()) -> bool:
        """Whether an item that can roll lies on nothing but ground that is level where it could roll to.

        With nothing on it, it then stays unless it is pushed. A lying cylinder rolls across its axis only: on
        ground that slopes along it, friction holds it.

        Args:
            item_id: Id of the item.
            without: Ids of the items that are gone.

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
        return bool(max(slopes) <= np.sin(LEVEL))

    def is_tipping(self, item_id: str, without: str) -> bool:
        """Whether what lies on an item keeps it in balance, and no longer does without one of these.

        It does where all weights balance, and those that are left do not. Where poses may be off it
        may do so too, by a press anywhere that it touches it.

        Args:
            item_id: Id of the item.
            without: Id of an item that lies on it, or on what lies on it.

        Returns:
            True if it loses its counterweight.
        """
        lifted = frozenset({without, *self.graph.chain(self.graph.lying_on, without)})
        missing = self._missing(item_id, frozenset())
        if missing <= EXPLAINED and self._missing(item_id, lifted) > missing + WORSE:
            return True
        if self.graph.scene.noise.position == 0.0:
            return False
        own = np.concatenate([_UP, np.zeros(3)])
        size = _half_size(self.graph.items[item_id])
        with_it, left = (self._touched(item_id, gone) for gone in (frozenset(), lifted))
        return can_balance(with_it, own, size) and not can_balance(left, own, size)

    def _weights(self, placed: PlacedItem) -> Array:
        """(K, 3) unit vectors against which an item's weight may act: straight down, and tilted."""
        tilt = self.graph.scene.noise.angle + (CHOCKED if placed.can_roll else LEAST_TILT)
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
        a, b = self.graph.index[contact.a], self.graph.index[contact.b]
        return (
            float(self.graph.solids.bound[a] + self.graph.solids.bound[b])
            if contact.b in self.graph.items
            else 0.0
        )

    def _found_patch(self, contact: SolidContact, inset: float) -> Array:
        a, b = self.graph.index[contact.a], self.graph.index[contact.b]
        solids, askew = self.graph.solids, SETTLED + 2 * self.graph.scene.noise.angle
        mine = feature(solids.shapes[a], solids.T[a], contact.normal, askew)
        theirs = feature(solids.shapes[b], solids.T[b], -contact.normal, askew)
        return patch(mine, theirs, contact.normal, inset)

    def _is_balanced(self, name: str, gone: frozenset[str]) -> bool:
        """Whether contacts with what is left can balance an item, however the world is tilted."""
        left = [c for c in self.graph.touching[name] if c.b not in gone]
        centre, cones = self.graph.items[name].T_world_item[:3, 3], self._holding(name, gone)
        size = _half_size(self.graph.items[name])
        wrenches = [np.concatenate([w, np.zeros(3)]) for w in self._weights(self.graph.items[name])]
        on_it = [c for c in left if c.b in self.graph.items and c.flipped.carries]
        wrenches += [wrench for contact in on_it for wrench in self._pressed(contact, centre)]
        return all(can_balance(cones, wrench, size) for wrench in wrenches)

    def _holding(self, name: str, gone: frozenset[str]) -> Array:
        """(6, 4 N) unit wrenches about an item's centre of what is left around it and not on it."""
        left = [c for c in self.graph.touching[name] if c.b not in gone and not c.flipped.carries]
        centre = self.graph.items[name].T_world_item[:3, 3]
        return np.concatenate(
            [_NO_PUSH, *(friction_cones(self._patch(c) - centre, -c.normal) for c in left)], axis=1
        )

    def _touched(self, name: str, gone: frozenset[str]) -> Array:
        """(6, 4 N) unit wrenches about an item's centre of all that is left and touches it, as poses say."""
        left = [c for c in self.graph.touching[name] if c.b not in gone]
        centre = self.graph.items[name].T_world_item[:3, 3]
        return np.concatenate(
            [
                _NO_PUSH,
                *(friction_cones(self._found_patch(c, inset=0.0) - centre, -c.normal) for c in left),
            ],
            axis=1,
        )

    def _pressed(self, contact: SolidContact, centre: Array) -> Iterator[Array]:
        """Wrenches (6,) that hold an item up on which another lies, for each place where the other may press.

        contact: between the two, seen from the one below
        """
        mass, places = self._pile(contact)
        share = mass / (mass + self.graph.items[contact.a].item.mass)
        for place in places:
            yield np.concatenate([_UP, np.cross(place - centre, share * _UP)])

    def _missing(self, name: str, lifted: Set[str]) -> float:
        """Weights that are missing to the balance of an item with all that lies on it.

        What touches nothing else presses with its whole weight in its middle; what does, with any part of it
        anywhere.

        lifted: ids of what no longer lies on it
        """
        mine = self.graph.items[name]
        centre, borne = mine.T_world_item[:3, 3], np.concatenate([_UP, np.zeros(3)])
        presses, limits = [_NO_PUSH[:, :0]], list[tuple[int, float]]()
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
        """Whether an item, or what lies on it, touches more than these others."""
        pile = {name, *self.graph.chain(self.graph.lying_on, name)} - others
        return any(c.b not in pile and c.b not in others for one in pile for c in self.graph.touching[one])

    def _pile(self, contact: SolidContact, lifted: Set[str] = frozenset()) -> tuple[float, Array]:
        """Mass (kg) of what lies on an item at one contact, and (N, 3) where in the world it may press.

        contact: between the two, seen from the one below. lifted: ids of what no longer belongs to it
        """
        names = {contact.b, *self.graph.chain(self.graph.lying_on, contact.b)} - lifted
        pile = [self.graph.items[name] for name in sorted(names)]
        masses = np.array([placed.item.mass for placed in pile])
        if len(self.graph.carriers(contact.b)) > 1:
            return float(masses.sum()), self._patch(contact.flipped)
        middles = np.array([placed.T_world_item[:3, 3] for placed in pile])  # all goes straight down
        return float(masses.sum()), (masses @ middles / masses.sum())[None]


def _half_size(placed: PlacedItem) -> float:
    """m, at which moments count as forces."""
    return float(placed.item.shape.extents.max()) / 2


def _slope_to_roll(placed: PlacedItem, normal: Array) -> float:
    """Sine of the slope down which an item would roll on ground with a normal, (3,) in the world."""
    if placed.item.shape.kind is ShapeKind.SPHERE:
        return float(np.hypot(normal[0], normal[1]))
    return float(abs(np.cross(placed.T_world_item[:3, 2], normal)[2]))
