"""The pile of items in one place, as the verifier sees it: bodies, contacts, and what they lack for balance.

All items are balanced at once, which asks whether any forces could hold them; the planner checks, item by
item and with a margin, whether certain contacts do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import Array
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_overlap import TOUCH
from pickcli.verification.body_boxes import BodyBoxes
from pickcli.verification.equilibrium import PileContact, RigidBody, missing_to_balance

# vertical part of a normal from which on an item above is lifted along
LYING_NORMAL_Z = np.sin(np.radians(30.0))
CARRYING_NORMAL_Z = np.sin(np.radians(20.0))  # vertical part of a normal from which on a contact carries
LEVEL_NORMAL_XY = np.sin(np.radians(1.5))  # horizontal part of a normal up to which nothing begins to roll
CHOCK_TILT = np.radians(8.0)  # angle that the world may tilt by without round items rolling off
WEIGHT_TOLERANCE = 1e-3  # missing weights for balance that count as rounding
N_TILTS = 3
_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class ContactPile:
    """Items in one place and their contacts.

    Attributes:
        bodies: The items by id.
        touching: By id all contacts of each, with it as the first of the two bodies.
        hanging: Ids of items that nothing carries at their stated poses.
        rollers: Ids of items that can roll.
    """

    bodies: Mapping[str, RigidBody]
    touching: Mapping[str, Sequence[PileContact]]
    hanging: frozenset[str]
    rollers: frozenset[str]

    @classmethod
    def at(cls, scene: Scene, location: str) -> ContactPile:
        """Build the pile of all items in one place.

        Args:
            scene: The scene.
            location: Name of the place.

        Returns:
            The pile.
        """
        placed = {each.id: each for each in scene.in_location(location)}
        bodies = {name: body_of(scene, each) for name, each in placed.items()}
        boxes = BodyBoxes.around((*bodies.values(), *_firm_bodies(scene)))
        contacts = list(_contacts(len(bodies), boxes))
        carried = {c.a.name for c in contacts if c.normal[2] >= CARRYING_NORMAL_Z}
        carried |= {c.b.name for c in contacts if c.normal[2] <= -CARRYING_NORMAL_Z}
        contacts += _falls(len(bodies), boxes, carried)
        rollers = frozenset(name for name, each in placed.items() if each.can_roll)
        touching = {name: _seen_from(name, contacts) for name in bodies}
        touching |= {name: _kept(touching[name]) for name in rollers}
        return cls(bodies, touching, frozenset(bodies.keys() - carried), rollers)

    def around(self, item_id: str) -> ContactPile:
        """Return the part of the pile that is connected to an item by contacts.

        Args:
            item_id: Id of the item.

        Returns:
            That part.
        """
        found, todo = {item_id}, [item_id]
        while todo:
            others = {c.b.name for c in self.touching[todo.pop()] if not c.b.is_firm} - found
            found |= others
            todo += others
        return replace(self, bodies={name: body for name, body in self.bodies.items() if name in found})

    def lying_on(self, item_id: str) -> frozenset[str]:
        """Return the items that lie on an item, directly or through others, wholly or partly.

        Args:
            item_id: Id of the item.

        Returns:
            Their ids.
        """
        return self._reached(item_id, lambda contact: -contact.normal[2] >= LYING_NORMAL_Z)

    def carrying(self, item_id: str) -> frozenset[str]:
        """Return the items that carry an item, directly or through others.

        Args:
            item_id: Id of the item.

        Returns:
            Their ids.
        """
        return self._reached(item_id, lambda contact: contact.normal[2] >= CARRYING_NORMAL_Z)

    def _reached(self, item_id: str, leads_on: Callable[[PileContact], bool]) -> frozenset[str]:
        """Return the items that one is linked to by contacts of a kind, each seen from where it leads on."""
        found: set[str] = set()
        todo = [item_id]
        while todo:
            beyond = {c.b.name for c in self.touching[todo.pop()] if not c.b.is_firm and leads_on(c)}
            todo += beyond - found - {item_id}
            found |= beyond - {item_id}
        return frozenset(found)

    def lies_level(self, item_id: str, loose: Set[str] = frozenset()) -> bool:
        """Whether an item can roll, carries nothing, and lies level on bodies that are not loose.

        For a cylinder, level means level across its axis.

        Args:
            item_id: Id of the item.
            loose: Ids of items that are loose.

        Returns:
            Whether it does.
        """
        if item_id not in self.rollers:
            return False
        body, contacts = self.bodies[item_id], self.touching[item_id]
        carrying = [contact for contact in contacts if contact.normal[2] >= CARRYING_NORMAL_Z]
        is_free = not any(
            contact.normal[2] <= -CARRYING_NORMAL_Z and not contact.b.is_firm for contact in contacts
        )
        return (
            bool(carrying)
            and is_free
            and all(_fall_line(body, contact.normal) <= LEVEL_NORMAL_XY for contact in carrying)
            and all(contact.b.name not in loose for contact in carrying)
        )

    def losing_balance(self, taken: frozenset[str]) -> frozenset[str]:
        """Return the items that are less balanced without some items than with them.

        All items are judged at once, except those that can roll or that are not balanced at their stated
        poses even with everything else fixed: these are judged separately, by whether they leaned on a
        removed item. Items that seem to hang in the air count as fixed.

        Args:
            taken: Ids of the removed items.

        Returns:
            Ids of others.
        """
        alone, gone = self.rollers, taken
        while True:
            lost = self._lacking_more(gone, self.bodies.keys() - self.hanging - alone)
            unexplained = {name for name in lost if self.missing_alone(name).max() > WEIGHT_TOLERANCE}
            if unexplained:
                alone |= unexplained
                continue
            lost |= self._leaning(gone | lost, alone)
            if not lost:
                return gone - taken
            gone |= lost

    def _lacking_more(self, gone: Set[str], standing: Set[str]) -> frozenset[str]:
        """Return those of some bodies that are less balanced without others, all else being fixed."""
        after = self.without(*gone).missing(standing - gone)
        if all(less.max() <= WEIGHT_TOLERANCE for less in after.values()):
            return frozenset()
        before = self.missing(standing)
        return frozenset(
            name for name, less in after.items() if (less > before[name] + WEIGHT_TOLERANCE).any()
        )

    def _leaning(self, gone: Set[str], alone: Set[str]) -> frozenset[str]:
        """Return those of the separately judged items that leaned on a removed one."""
        left = self.without(*gone)
        met = {contact.b.name for name in gone for contact in self.touching[name]}
        return frozenset(
            name
            for name in met & alone & left.bodies.keys()
            if (left.missing_alone(name) > self.missing_alone(name) + WEIGHT_TOLERANCE).any()
        )

    def without(self, *gone: str) -> ContactPile:
        """Return the pile without some items.

        Args:
            gone: Their ids.

        Returns:
            The rest.
        """
        left = {name: body for name, body in self.bodies.items() if name not in gone}
        touching = {name: [c for c in self.touching[name] if c.b.name not in gone] for name in left}
        return replace(self, bodies=left, touching=touching)

    def missing(self, of: Set[str]) -> dict[str, Array]:
        """Return (N_TILTS,) weights by id that some items lack for balance, for each tilt of the world.

        All other items are fixed. The world is tilted by the bound of the angular pose errors.

        Args:
            of: Ids of the items.

        Returns:
            The weights.
        """
        return self._missing_if_tilted(of, max((self.bodies[name].angle for name in of), default=0.0))

    def missing_alone(self, item_id: str) -> Array:
        """Return (N_TILTS,) weights that an item lacks for balance if everything that it touches is fixed.

        For items that can roll, the world is tilted by ``CHOCK_TILT``.

        Args:
            item_id: Id of the item.

        Returns:
            The weights, one for each tilt of the world.
        """
        angle = self.bodies[item_id].angle
        if item_id in self.rollers:
            angle = max(angle, CHOCK_TILT)
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


@lru_cache(maxsize=16)
def pile_at(scene: Scene, location: str) -> ContactPile:
    """Return the pile of all items in one place. Cached by identity of the scene.

    Args:
        scene: The scene.
        location: Name of the place.

    Returns:
        The pile.
    """
    return ContactPile.at(scene, location)


def _contacts(n_items: int, boxes: BodyBoxes) -> Iterator[PileContact]:
    """Yield all contacts of items, which come first among the bodies; each once."""
    for k, item in enumerate(boxes.bodies[:n_items]):
        for other in boxes.near(k, TOUCH + item.bound):
            reach = TOUCH + item.bound + other.bound
            contact = PileContact.between(item, other, reach, _askew(item, other))
            if contact is not None:
                yield contact


def _falls(n_items: int, boxes: BodyBoxes, carried: Set[str]) -> Iterator[PileContact]:
    """Yield, for each item that nothing carries, a contact with the body below it, as if it lay there."""
    for k, item in enumerate(boxes.bodies[:n_items]):
        below = boxes.next_below(k) if item.name not in carried else None
        if below is not None:
            yield PileContact.across(item, below, _UP, 0.0, _askew(item, below))


def _askew(a: RigidBody, b: RigidBody) -> float:
    """Return the angle in rad up to which faces of two bodies count as parallel."""
    return 2.0 * max(a.angle, b.angle)


def _seen_from(name: str, contacts: Sequence[PileContact]) -> list[PileContact]:
    """Return the contacts of an item, with it as the first of the two bodies."""
    seen = (c if c.a.name == name else c.flipped for c in contacts if name in (c.a.name, c.b.name))
    return list(seen)


def _kept(contacts: Sequence[PileContact]) -> list[PileContact]:
    """Return the contacts of an item that can roll, without fixed bodies farther away than the nearest one.

    The item could roll over a contact that it only nearly makes: one pose error moves it away from all or
    from none. But it always keeps the contact with the nearest ground.
    """
    firm = [contact for contact in contacts if contact.b.is_firm]
    nearest = min((contact.gap for contact in firm), default=0.0)
    ground = min((contact.gap for contact in firm if contact.normal[2] >= CARRYING_NORMAL_Z), default=0.0)
    return [
        contact
        for contact in contacts
        if not contact.b.is_firm
        or contact.gap <= (ground if contact.normal[2] >= CARRYING_NORMAL_Z else nearest) + TOUCH
    ]


def body_of(scene: Scene, placed: PlacedItem) -> RigidBody:
    """Return an item as a rigid body, with the errors of its pose.

    Args:
        scene: The scene.
        placed: The item.

    Returns:
        The body.
    """
    bound, angle = scene.bound(placed), scene.noise_of(placed).angle
    return RigidBody(placed.id, placed.item.shape, placed.T_world_item, placed.item.mass, bound, angle)


def _firm_bodies(scene: Scene) -> Iterator[RigidBody]:
    """All that stands for sure: unknown space may be empty."""
    unknown = {body.name for space in scene.unknown for body in space.bodies}
    return (
        RigidBody(b.name, b.shape, T @ b.T_parent_shape, np.inf)
        for b, T in scene.standing
        if b.name not in unknown
    )


def _tilted(angle: float, turn: float) -> Array:
    """Return a (3,) unit vector tilted off the vertical by an angle, towards a direction of turn."""
    return np.array([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)])


def _fall_line(body: RigidBody, normal: Array) -> float:
    """Return the sine of the slope for a round body on ground with a normal; a cylinder's across its axis."""
    down = np.array([0.0, 0.0, -1.0]) + normal[2] * normal  # downhill, along the ground
    if body.shape.kind is ShapeKind.CYLINDER:
        axis = body.T[:3, 2]
        down -= (down @ axis) * axis
    return float(np.linalg.norm(down))
