"""Decide what falls, rolls or is lifted when an item is taken out of a pile: equilibrium of the rest.

Independent of the planner: that checks, item by item and with a margin, whether certain contacts hold it;
this module checks whether any forces could hold all items at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from pickcli.cell.place import Place
from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import Array
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_overlap import TOUCH
from pickcli.verification.equilibrium import PileContact, RigidBody, missing_to_balance
from pickcli.verification.separation import support

# vertical part of a normal from which on an item above is lifted along
LYING_NORMAL_Z = np.sin(np.radians(30.0))
CARRYING_NORMAL_Z = np.sin(np.radians(20.0))  # vertical part of a normal from which on a contact carries
FOOTING_NORMAL_Z = np.sin(np.radians(45.0))  # vertical part from which on an item lies on it, and leans not
ALIKE = 0.5  # cosine of the angle between normals from which on contacts push the same way
LEVEL_NORMAL_XY = np.sin(np.radians(1.5))  # horizontal part of a normal up to which nothing begins to roll
CHOCK_TILT = np.radians(8.0)  # angle that the world may tilt by without round items rolling off
WEIGHT_TOLERANCE = 1e-3  # missing weights for balance that count as rounding
N_TILTS = 3
N_EDGES = 36  # horizontal directions in which the edge of what carries an item is looked for
_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Removal:
    """Effects on a pile of lifting an item out of it.

    Attributes:
        lifted: Ids of items that lie on the item, directly or through others, wholly or partly.
        falling: Ids of items without an equilibrium once it is removed.
        rolling: Ids of items that touch it, stay in place on level ground, and roll if pushed.
    """

    lifted: frozenset[str]
    falling: frozenset[str]
    rolling: frozenset[str]


def barrier(scene: Scene, place: Place, placed: PlacedItem) -> float:
    """Return the height over which the middle of an item must come to get over the rim of an open box.

    Above the rim it is at least the radius of the largest ball in the item higher than the rim: a convex
    solid that the rim does not enter holds none that does.

    Args:
        scene: The scene.
        place: The box.
        placed: The item, in the box.

    Returns:
        m in the world.
    """
    rim = float((scene.T_world_place(place) @ place.access.T_place_mouth)[2, 3])
    return rim + float(placed.item.shape.extents.min()) / 2


def may_leave(scene: Scene, place: Place, placed: PlacedItem) -> bool:
    """Whether an item that falls in an open box may get over the rim. It falls, so its middle does not rise.

    Args:
        scene: The scene.
        place: The box.
        placed: The item, in the box.

    Returns:
        Whether its middle is not certainly below the barrier.
    """
    return not placed.T_world_item[2, 3] + scene.bound(placed) < barrier(scene, place, placed)


@lru_cache(maxsize=64)
def removal(scene: Scene, item_id: str) -> Removal:
    """Compute the effects of lifting an item out of its pile. Cached by identity of the scene.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        The effects.
    """
    pile = _pile(scene, scene.find(item_id).location).around(item_id)
    lifted = pile.lying_on(item_id)
    loose = pile.losing_balance(frozenset({item_id}))
    level = {name for name in loose if pile.without(item_id, *lifted - {name}).lies_level(name, loose)}
    beside = {contact.b.name for contact in pile.touching[item_id]}
    return Removal(lifted, frozenset(loose - level), frozenset(level & beside))


def falling_without(scene: Scene, location: str, taken: Set[str]) -> frozenset[str]:
    """Find what loses its balance if several items are gone at once.

    Args:
        scene: The scene.
        location: Name of the place that they are in.
        taken: Their ids.

    Returns:
        Ids of other items there.
    """
    return _pile(scene, location).losing_balance(frozenset(taken))


def lying_on(scene: Scene, item_id: str) -> frozenset[str]:
    """Find the items that lie on an item of a pile.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        Ids of items that lie on it, directly or through others, wholly or partly.
    """
    return _pile(scene, scene.find(item_id).location).lying_on(item_id)


def carriers_of(scene: Scene, item_id: str) -> frozenset[str]:
    """Find the items that an item of a pile lies on.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        Ids of items that it touches from above, or may.
    """
    contacts = _pile(scene, scene.find(item_id).location).touching[item_id]
    return frozenset(c.b.name for c in contacts if not c.b.is_firm and c.normal[2] >= CARRYING_NORMAL_Z)


def keeps_standing(scene: Scene, item_id: str) -> bool:
    """Whether an item keeps its balance where it is, if everything that it touches is fixed.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        True if it may.
    """
    pile = _pile(scene, scene.find(item_id).location)
    return bool(pile.missing_alone(item_id).max() <= WEIGHT_TOLERANCE) or pile.lies_level(item_id)


def fall_onto_others(scene: Scene, item_id: str) -> float:
    """Return how far an item falls until it meets another one of its place.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        m between its lowest point and the highest of the boxes of items that it is wholly above, within the
        errors of poses; infinite without any.
    """
    placed = {each.id: each for each in scene.in_location(scene.find(item_id).location)}
    item = _body(scene, placed.pop(item_id))
    boxes = _Boxes.around((item, *(_body(scene, each) for each in placed.values())))
    is_under = np.all((boxes.low < boxes.high[0])[:, :2] & (boxes.high > boxes.low[0])[:, :2], axis=1)
    falls = boxes.low[0, 2] - boxes.high[:, 2]
    least = [-TOUCH - item.bound - other.bound for other in boxes.bodies]
    return float(np.min(falls, where=is_under & (falls >= least), initial=np.inf))


def tips_as_it_lands(scene: Scene, item_id: str) -> bool:
    """Whether an item that is carried by others only may turn over their edge as it falls onto them.

    It first meets one edge of what carries it, in an inelastic blow, and all energy that this leaves goes
    into the turn over the opposite edge.

    Args:
        scene: The scene, with the item where it is let go.
        item_id: Id of the item.

    Returns:
        True if that energy lifts its centre over an edge.
    """
    pile = _pile(scene, scene.find(item_id).location)
    body = pile.bodies[item_id]
    below = [c.b for c in pile.touching[item_id] if c.normal[2] >= CARRYING_NORMAL_Z]
    if not below or any(other.is_firm for other in below):
        return False
    fall = max(fall_onto_others(scene, item_id), 0.0)
    x, y, z = 2.0 * body.shape.reach(body.T[:3, :3])
    turns = 2.0 * np.pi * np.arange(N_EDGES) / N_EDGES
    for way in np.column_stack([np.cos(turns), np.sin(turns), np.zeros(N_EDGES)]):
        edge, arm = (_reach_of(below, body, w) for w in (way, -way))
        rise = np.sqrt(max(edge, 0.0) ** 2 + z**2 / 4) - z / 2
        if rise < arm**2 / (arm**2 + (min(x, y) ** 2 + z**2) / 12) * fall:
            return True
    return False


def leans_too_low(scene: Scene, item_id: str) -> bool:
    """Whether an item stays only by leaning on what is lower than its centre.

    Forces that hold it there may exist, but as it falls against an edge below its centre, that goes on beyond
    the edge, and its lower end slides the other way. What can roll does not fall over what it is chocked by.

    Args:
        scene: The scene, with the item where it is let go.
        item_id: Id of the item.

    Returns:
        True if it would not stay without those things that it leans on and that are lower than its centre.
    """
    pile = _pile(scene, scene.find(item_id).location)
    body, contacts = pile.bodies[item_id], pile.touching[item_id]
    if item_id in pile.rollers:
        return False
    centre = body.T[2, 3] + body.bound
    footing = [c for c in contacts if c.normal[2] >= FOOTING_NORMAL_Z]
    beside = [c for c in contacts if c.normal[2] < FOOTING_NORMAL_Z]
    is_low = [support(c.b.shape, c.b.T, _UP)[2] - c.b.bound < centre for c in beside]
    low = [c for c, less in zip(beside, is_low, strict=True) if less]
    high = [c for c, less in zip(beside, is_low, strict=True) if not less]
    # What is high holds it up only on the side to which it leans.
    holding = footing + [c for c in high if any(c.normal @ other.normal > ALIKE for other in low)]
    if not low:
        return False
    without = replace(pile, touching={**pile.touching, item_id: holding})
    return bool(without.missing_alone(item_id).max() > WEIGHT_TOLERANCE)


def _reach_of(below: Sequence[RigidBody], body: RigidBody, way: Array) -> float:
    """Return how far in m along a horizontal direction bodies carry another one, from below its centre."""
    own, *others = (float(way @ (support(b.shape, b.T, way) - body.T[:3, 3])) for b in (body, *below))
    return min(own, max(others))


def is_borne(scene: Scene, item_id: str) -> bool:
    """Whether the items below an item keep their balance with it on them: all of these at once.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        True if they may, or if no items are below it.
    """
    pile = _pile(scene, scene.find(item_id).location)
    below = pile.carrying(item_id)
    with_it = pile.missing(below | {item_id}) if below else {}
    before = pile.without(item_id).missing(below)
    return all(
        bool((less <= before.get(name, 0.0) + WEIGHT_TOLERANCE).all()) for name, less in with_it.items()
    )


@dataclass(frozen=True, eq=False)
class _Pile:
    """Items in one place and their contacts.

    bodies: the items by id. touching: by id all contacts of each. hanging: ids of items that nothing carries
    at their stated poses. rollers: ids of items that can roll
    """

    bodies: Mapping[str, RigidBody]
    touching: Mapping[str, Sequence[PileContact]]
    hanging: frozenset[str]
    rollers: frozenset[str]

    @classmethod
    def at(cls, scene: Scene, location: str) -> _Pile:
        """Build the pile of all items in one place."""
        placed = {each.id: each for each in scene.in_location(location)}
        bodies = {name: _body(scene, each) for name, each in placed.items()}
        boxes = _Boxes.around((*bodies.values(), *_firm_bodies(scene)))
        contacts = list(_contacts(len(bodies), boxes))
        carried = {c.a.name for c in contacts if c.normal[2] >= CARRYING_NORMAL_Z}
        carried |= {c.b.name for c in contacts if c.normal[2] <= -CARRYING_NORMAL_Z}
        contacts += _falls(len(bodies), boxes, carried)
        rollers = frozenset(name for name, each in placed.items() if each.can_roll)
        touching = {name: _seen_from(name, contacts) for name in bodies}
        touching |= {name: _kept(touching[name]) for name in rollers}
        return cls(bodies, touching, frozenset(bodies.keys() - carried), rollers)

    def around(self, item_id: str) -> _Pile:
        """Return the part of the pile that is connected to an item by contacts."""
        found, todo = {item_id}, [item_id]
        while todo:
            others = {c.b.name for c in self.touching[todo.pop()] if not c.b.is_firm} - found
            found |= others
            todo += others
        return replace(self, bodies={name: body for name, body in self.bodies.items() if name in found})

    def lying_on(self, item_id: str) -> frozenset[str]:
        """Return ids of items that lie on an item, directly or through others, wholly or partly."""
        found: set[str] = set()
        todo = [item_id]
        while todo:
            above = {
                c.b.name
                for c in self.touching[todo.pop()]
                if not c.b.is_firm and -c.normal[2] >= LYING_NORMAL_Z
            }
            todo += above - found - {item_id}
            found |= above - {item_id}
        return frozenset(found)

    def carrying(self, item_id: str) -> frozenset[str]:
        """Return ids of items that carry an item, directly or through others."""
        found: set[str] = set()
        todo = [item_id]
        while todo:
            below = {
                c.b.name
                for c in self.touching[todo.pop()]
                if not c.b.is_firm and c.normal[2] >= CARRYING_NORMAL_Z
            }
            todo += below - found - {item_id}
            found |= below - {item_id}
        return frozenset(found)

    def lies_level(self, item_id: str, loose: Set[str] = frozenset()) -> bool:
        """Whether an item can roll, carries nothing, and lies level on bodies that are not loose.

        For a cylinder, level means level across its axis.
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
        """Return ids of items that are less balanced without some items than with them.

        All items are judged at once, except those that can roll or that are not balanced at their stated
        poses even with everything else fixed: these are judged separately, by whether they leaned on a
        removed item. Items that seem to hang in the air count as fixed.
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

    def without(self, *gone: str) -> _Pile:
        """Return the pile without some items."""
        left = {name: body for name, body in self.bodies.items() if name not in gone}
        touching = {name: [c for c in self.touching[name] if c.b.name not in gone] for name in left}
        return replace(self, bodies=left, touching=touching)

    def missing(self, of: Set[str]) -> dict[str, Array]:
        """Return (N_TILTS,) weights by id that some items lack for balance, for each tilt of the world.

        All other items are fixed. The world is tilted by the bound of the angular pose errors.
        """
        return self._missing_if_tilted(of, max((self.bodies[name].angle for name in of), default=0.0))

    def missing_alone(self, item_id: str) -> Array:
        """Return (N_TILTS,) weights that an item lacks for balance if everything that it touches is fixed.

        For items that can roll, the world is tilted by ``CHOCK_TILT``.
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


_pile = lru_cache(maxsize=16)(_Pile.at)


@dataclass(frozen=True, eq=False)
class _Boxes:
    """Bodies with their axis-aligned bounding boxes in the world.

    bodies: N. low, high: (N, 3) m
    """

    bodies: tuple[RigidBody, ...]
    low: Array
    high: Array

    @classmethod
    def around(cls, bodies: Sequence[RigidBody]) -> _Boxes:
        """Build the boxes of bodies."""
        middles = np.array([body.T[:3, 3] for body in bodies])
        reach = np.array([body.shape.reach(body.T[:3, :3]) for body in bodies])
        return cls(tuple(bodies), middles - reach, middles + reach)

    def near(self, k: int, reach: float) -> Iterator[RigidBody]:
        """Return later bodies whose boxes are within a reach, plus their own bounds, of the box of body k."""
        margin = reach + np.array([[other.bound] for other in self.bodies])
        is_near = np.all((self.low <= self.high[k] + margin) & (self.high >= self.low[k] - margin), axis=1)
        return (self.bodies[i] for i in np.flatnonzero(is_near) if i > k)

    def next_below(self, k: int) -> RigidBody | None:
        """Return the body that body k would fall on: the one with the highest top of those below its box."""
        is_under = np.all((self.low < self.high[k])[:, :2] & (self.high > self.low[k])[:, :2], axis=1)
        is_under &= (self.low + self.high)[:, 2] < (self.low + self.high)[k, 2]
        tops = np.where(is_under, self.high[:, 2], -np.inf)
        return self.bodies[int(np.argmax(tops))] if is_under.any() else None


def _contacts(n_items: int, boxes: _Boxes) -> Iterator[PileContact]:
    """Yield all contacts of items, which come first among the bodies; each once."""
    for k, item in enumerate(boxes.bodies[:n_items]):
        for other in boxes.near(k, TOUCH + item.bound):
            reach = TOUCH + item.bound + other.bound
            contact = PileContact.between(item, other, reach, _askew(item, other))
            if contact is not None:
                yield contact


def _falls(n_items: int, boxes: _Boxes, carried: Set[str]) -> Iterator[PileContact]:
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


def _body(scene: Scene, placed: PlacedItem) -> RigidBody:
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
