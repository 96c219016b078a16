"""What falls, rolls or is lifted when an item is taken out of its pile: by equilibrium of all that is left.

The verifier's own answer. The planner asks of each item by itself whether contacts that are surely there hold
it, and keeps a margin; here it is asked of all at once whether any forces could.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import Array
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_overlap import TOUCH
from pickcli.verification.equilibrium import PileContact, RigidBody, missing_to_balance

LYING = np.sin(np.radians(30.0))  # vertical part of a normal from which on what is above is lifted with it
CARRIES = np.sin(np.radians(20.0))  # the same from which on a contact carries
LEVEL = np.sin(np.radians(1.5))  # level part of a normal up to which nothing begins to roll
CHOCKED = np.radians(8.0)  # by which the world may tilt and what is round is still kept
MISSING = 1e-3  # weights that may be missing to a balance by rounding
N_TILTS = 3
_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Removal:
    """What becomes of a pile when an item is lifted out of it.

    Attributes:
        lifted: Ids of what lies on the item, or on what does, wholly or partly.
        falling: Ids of what has no equilibrium without it.
        rolling: Ids of what touches it, stays where it is on level ground, and rolls if it is pushed.
    """

    lifted: frozenset[str]
    falling: frozenset[str]
    rolling: frozenset[str]


@lru_cache(maxsize=64)
def removal(scene: Scene, item_id: str) -> Removal:
    """What becomes of a pile when an item is lifted out of it. Cached by identity of the scene.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        The effects.
    """
    pile = _pile(scene, scene.find(item_id).location).around(item_id)
    lifted = pile.lying_on(item_id)
    loose = pile.losing_balance(item_id)
    level = {name for name in loose if pile.without(item_id, *lifted - {name}).lies_level(name, loose)}
    beside = {contact.b.name for contact in pile.touching[item_id]}
    return Removal(lifted, frozenset(loose - level), frozenset(level & beside))


def keeps_standing(scene: Scene, item_id: str) -> bool:
    """Whether an item keeps its balance where it is, on what it touches as if that stood firm.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        True if it may.
    """
    pile = _pile(scene, scene.find(item_id).location)
    return bool(pile.missing_alone(item_id).max() <= MISSING) or pile.lies_level(item_id)


@dataclass(frozen=True, eq=False)
class _Pile:
    """Items in one place, and what touches what.

    bodies: the items by id. touching: by id all contacts of each. hanging: ids of what nothing carries, as
    poses say. rollers: ids of what can roll. angle: rad by which poses may be off
    """

    bodies: Mapping[str, RigidBody]
    touching: Mapping[str, Sequence[PileContact]]
    hanging: frozenset[str]
    rollers: frozenset[str]
    angle: float

    @classmethod
    def at(cls, scene: Scene, location: str) -> _Pile:
        """All that is in one place."""
        placed = {each.id: each for each in scene.in_location(location)}
        bodies = {name: _body(scene, each) for name, each in placed.items()}
        boxes = _Boxes.around((*bodies.values(), *_firm_bodies(scene)))
        askew = 2.0 * scene.noise.angle
        contacts = list(_contacts(len(bodies), boxes, askew))
        carried = {c.a.name for c in contacts if c.normal[2] >= CARRIES}
        carried |= {c.b.name for c in contacts if c.normal[2] <= -CARRIES}
        contacts += _falls(len(bodies), boxes, carried, askew)
        rollers = frozenset(name for name, each in placed.items() if each.can_roll)
        touching = {name: _seen_from(name, contacts) for name in bodies}
        touching |= {name: _kept(touching[name]) for name in rollers}
        return cls(bodies, touching, frozenset(bodies.keys() - carried), rollers, scene.noise.angle)

    def around(self, item_id: str) -> _Pile:
        """The part of it that hangs together with an item."""
        found, todo = {item_id}, [item_id]
        while todo:
            others = {c.b.name for c in self.touching[todo.pop()] if not c.b.is_firm} - found
            found |= others
            todo += others
        return replace(self, bodies={name: body for name, body in self.bodies.items() if name in found})

    def lying_on(self, item_id: str) -> frozenset[str]:
        """Ids of what lies on an item, and on what does, wholly or partly."""
        found: set[str] = set()
        todo = [item_id]
        while todo:
            above = {c.b.name for c in self.touching[todo.pop()] if not c.b.is_firm and -c.normal[2] >= LYING}
            todo += above - found - {item_id}
            found |= above - {item_id}
        return frozenset(found)

    def lies_level(self, item_id: str, loose: Set[str] = frozenset()) -> bool:
        """Whether an item can roll, nothing is on it, and what carries it is level and not loose itself.

        Level across its axis, for a cylinder.
        """
        if item_id not in self.rollers:
            return False
        body, contacts = self.bodies[item_id], self.touching[item_id]
        carrying = [contact for contact in contacts if contact.normal[2] >= CARRIES]
        is_free = not any(contact.normal[2] <= -CARRIES and not contact.b.is_firm for contact in contacts)
        return (
            bool(carrying)
            and is_free
            and all(_fall_line(body, contact.normal) <= LEVEL for contact in carrying)
            and all(contact.b.name not in loose for contact in carrying)
        )

    def losing_balance(self, item_id: str) -> frozenset[str]:
        """Ids of what lacks more to its balance without an item than with it.

        Judged of all at once. What can roll, and what is not in balance where it is seen even if all else
        stands firm, is judged by itself: whether it leaned on what is gone. What seems to hang in the air
        stands firm.
        """
        alone, gone = self.rollers, frozenset({item_id})
        while True:
            lost = self._lacking_more(gone, self.bodies.keys() - self.hanging - alone)
            unexplained = {name for name in lost if self.missing_alone(name).max() > MISSING}
            if unexplained:
                alone |= unexplained
                continue
            lost |= self._leaning(gone | lost, alone)
            if not lost:
                return gone - {item_id}
            gone |= lost

    def _lacking_more(self, gone: Set[str], standing: Set[str]) -> frozenset[str]:
        """Of some bodies those that lack more to their balance without others, all else standing firm."""
        after = self.without(*gone).missing(standing - gone)
        if all(less.max() <= MISSING for less in after.values()):
            return frozenset()
        before = self.missing(standing)
        return frozenset(name for name, less in after.items() if (less > before[name] + MISSING).any())

    def _leaning(self, gone: Set[str], alone: Set[str]) -> frozenset[str]:
        """Of what is judged by itself that which leaned on what is gone."""
        left = self.without(*gone)
        met = {contact.b.name for name in gone for contact in self.touching[name]}
        return frozenset(
            name
            for name in met & alone & left.bodies.keys()
            if (left.missing_alone(name) > self.missing_alone(name) + MISSING).any()
        )

    def without(self, *gone: str) -> _Pile:
        """The pile without some items."""
        left = {name: body for name, body in self.bodies.items() if name not in gone}
        touching = {name: [c for c in self.touching[name] if c.b.name not in gone] for name in left}
        return replace(self, bodies=left, touching=touching)

    def missing(self, of: Set[str]) -> dict[str, Array]:
        """(N_TILTS,) weights by id that are missing to the balance of some, for each tilt of the world.

        All others stand firm. The world is tilted by as much as poses may be off.
        """
        return self._missing_if_tilted(of, self.angle)

    def missing_alone(self, item_id: str) -> Array:
        """(N_TILTS,) weights that are missing to the balance of an item if all that it touches stands firm.

        For what can roll the world is tilted by ``CHOCKED``.
        """
        angle = max(self.angle, CHOCKED) if item_id in self.rollers else self.angle
        return self._missing_if_tilted({item_id}, angle)[item_id]

    def _missing_if_tilted(self, of: Set[str], angle: float) -> dict[str, Array]:
        if not of:
            return {}
        bodies = [body for name, body in self.bodies.items() if name in of]
        contacts = [
            contact
            for k, body in enumerate(bodies)
            for contact in self.touching[body.name]
            if all(contact.b.name != later.name for later in bodies[k + 1 :])
        ]
        n = N_TILTS if angle > 0.0 else 1
        turns = 2.0 * np.pi * np.arange(n) / n
        found = [missing_to_balance(bodies, contacts, _tilted(angle, turn)) for turn in turns]
        return {name: np.array([each[name] for each in found]) for name in of}


_pile = lru_cache(maxsize=16)(_Pile.at)


@dataclass(frozen=True, eq=False)
class _Boxes:
    """Bodies and the boxes around them along the axes of the world.

    bodies: N. low, high: (N, 3) m
    """

    bodies: tuple[RigidBody, ...]
    low: Array
    high: Array

    @classmethod
    def around(cls, bodies: Sequence[RigidBody]) -> _Boxes:
        """The boxes of bodies."""
        middles = np.array([body.T[:3, 3] for body in bodies])
        reach = np.array([body.shape.reach(body.T[:3, :3]) for body in bodies])
        return cls(tuple(bodies), middles - reach, middles + reach)

    def near(self, k: int, reach: float) -> Iterator[RigidBody]:
        """Later bodies whose boxes are within a reach, and their own bounds, of that of the body k."""
        room = reach + np.array([[other.bound] for other in self.bodies])
        is_near = np.all((self.low <= self.high[k] + room) & (self.high >= self.low[k] - room), axis=1)
        return (self.bodies[i] for i in np.flatnonzero(is_near) if i > k)

    def next_below(self, k: int) -> RigidBody | None:
        """What the body k would fall on: of what its box is over the one with the highest top."""
        is_under = np.all((self.low < self.high[k])[:, :2] & (self.high > self.low[k])[:, :2], axis=1)
        is_under &= (self.low + self.high)[:, 2] < (self.low + self.high)[k, 2]
        tops = np.where(is_under, self.high[:, 2], -np.inf)
        return self.bodies[int(np.argmax(tops))] if is_under.any() else None


def _contacts(n_items: int, boxes: _Boxes, askew: float) -> Iterator[PileContact]:
    """All contacts of items, the first of the bodies, each once."""
    for k, item in enumerate(boxes.bodies[:n_items]):
        for other in boxes.near(k, TOUCH + item.bound):
            contact = PileContact.between(item, other, TOUCH + item.bound + other.bound, askew)
            if contact is not None:
                yield contact


def _falls(n_items: int, boxes: _Boxes, carried: Set[str], askew: float) -> Iterator[PileContact]:
    """Of each item that nothing carries the contact with what it would fall on: there it is taken to lie."""
    for k, item in enumerate(boxes.bodies[:n_items]):
        below = boxes.next_below(k) if item.name not in carried else None
        if below is not None:
            yield PileContact.across(item, below, _UP, 0.0, askew)


def _seen_from(name: str, contacts: Sequence[PileContact]) -> list[PileContact]:
    """The contacts of an item, it being the first of the two."""
    seen = (c if c.a.name == name else c.flipped for c in contacts if name in (c.a.name, c.b.name))
    return list(seen)


def _kept(contacts: Sequence[PileContact]) -> list[PileContact]:
    """Contacts of what can roll, without bodies that stand firm farther from it than another.

    It may pass over what it only nearly meets: one error of its pose moves it away from all or from none. But
    whatever it is next to, it lies on what of the ground is nearest.
    """
    firm = [contact for contact in contacts if contact.b.is_firm]
    nearest = min((contact.gap for contact in firm), default=0.0)
    ground = min((contact.gap for contact in firm if contact.normal[2] >= CARRIES), default=0.0)
    return [
        contact
        for contact in contacts
        if not contact.b.is_firm
        or contact.gap <= (ground if contact.normal[2] >= CARRIES else nearest) + TOUCH
    ]


def _body(scene: Scene, placed: PlacedItem) -> RigidBody:
    bound = scene.noise.bound(placed.item)
    return RigidBody(placed.id, placed.item.shape, placed.T_world_item, placed.item.mass, bound)


def _firm_bodies(scene: Scene) -> Iterator[RigidBody]:
    return (RigidBody(b.name, b.shape, T @ b.T_parent_shape, np.inf) for b, T in scene.standing)


def _tilted(angle: float, turn: float) -> Array:
    """(3,) unit vector that is off the vertical by an angle, to the side of a turn."""
    return np.array([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)])


def _fall_line(body: RigidBody, normal: Array) -> float:
    """Sine of the slope down which a round body rolls on ground with a normal: a cylinder across its axis."""
    down = np.array([0.0, 0.0, -1.0]) + normal[2] * normal  # along the ground
    if body.shape.kind is ShapeKind.CYLINDER:
        axis = body.T[:3, 2]
        down -= (down @ axis) * axis
    return float(np.linalg.norm(down))
