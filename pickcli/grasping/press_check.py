"""Decide whether an item that a cup presses on keeps its footing, or tips over.

A cup from above must press within the item's support. A cup from the side may tip an item that is tall for
its depth: the item turns about the edge of its footing on the far side. It returns, or is held leaning, as
long as its centre is not over that edge. An item that needs more force than its weight to tip slides instead;
below that, sliding is neglected. A wall close behind the item stops it before it falls (``backing``); what
else is behind it does not count.

Let D be the travel of the cup beyond the face, k the stiffness of its bellows, W the weight, l the lever arm
of a part of the lip about the edge and d how far the face is back from the edge there, both seen along the
press, b and z the level and vertical distance of the item's centre from the edge. Leaning back by an angle a,
the item gives way to that part by g = l sin a + d (1 - cos a), so the lip loses it from above. It comes to
rest where the moments of all parts, k (D - g) g' in the mean, are no more than that of the weight,
W (b cos a - z sin a). Its centre is over the edge at atan(b / z).

Before that, the cup throws it: bellows are springs, and a solid that they meet leaves them at up to twice
their speed, where the lip stays on longest: at its lowest part. The energy of that turn, and the energy left
in the bellows, raises the centre further; so the cup meets slender items more slowly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.tool import Tool
from pickcli.collision.stage_contacts import PickContacts
from pickcli.geometry import GRAVITY, Array
from pickcli.grasping.backing import is_backed
from pickcli.grasping.cup_press import max_press_depth, overtravel
from pickcli.motion.plan import Grasp
from pickcli.scene.scene import PlacedItem

EDGE_TOLERANCE = 1e-3  # m that a press from above stays within the edge of the support
MAX_TILT_SHARE = 0.95  # of the angle at which an item falls over, to which a press may tip it
MOST_SPEED = 0.8  # of the speed at which a cup throws the item over
REBOUND = 2.0  # times the cup's speed: speed at which an item leaves undamped bellows
MOST_FRICTION = 1.1  # of an item on its support: cardboard, plastic and cloth on board have 0.25 to 0.5
SLOWEST = 0.05  # of the tool's contact speed: a grasp that throws the item over even at that is rejected
ON_A_POINT = 0.5  # of the tool's contact speed: for an item that is seen to stand on no area at all
LEVEL = np.cos(np.radians(10.0))  # of the angle to the vertical, up to which an item stands on a side
NO_ARM = 1e-6  # m
LENGTH_ROUNDING = 1e-6  # m, shorter edges are points
N_TILTS = 200  # angles up to the one at which an item falls over
LIP_ANGLES = np.linspace(0.0, np.pi, 9)  # rad from the highest part of the lip to the lowest
LIP_SHARES = np.array([0.5, *np.ones(len(LIP_ANGLES) - 2), 0.5]) / (len(LIP_ANGLES) - 1)  # of the press
_AROUND = np.array(
    [(x, y, 0.0) for x in (-EDGE_TOLERANCE, EDGE_TOLERANCE) for y in (-EDGE_TOLERANCE, EDGE_TOLERANCE)]
)


def contact_speed(contacts: PickContacts, tool: Tool, grasp: Grasp) -> float | None:
    """Return the highest speed at which the cup may meet the target without tipping it over.

    A cup from above must not tip it at all: a tipped end rises towards the lance, and hardly any tipped face
    seals. An item that can roll is not limited by its balance: it rolls wherever the cup meets it. An item
    that would not stand by its weight at its stated pose is held by something unknown; if its centre is over
    its footing, so must be the press. One that is seen to stand on a point or a line is met at half speed.

    Args:
        contacts: The scene, the target in it, and its support.
        tool: The tool with the cup.
        grasp: Grasp of the target.

    Returns:
        m/s, at most the tool's contact speed; None if the cup tips the target at any useful speed.
    """
    fastest = tool.contact_speed
    if contacts.target.can_roll:
        return fastest
    if grasp.kind == "top-down":
        return None if _tips_below(contacts, tool, grasp) else fastest
    press = _press(contacts, tool, grasp)
    if press is None:
        return fastest if len(_least_footing(contacts).edges) else ON_A_POINT * fastest
    speed = MOST_SPEED * press.throwing_speed
    is_tipped = press.tilt > MAX_TILT_SHARE * press.balance or speed < SLOWEST * fastest
    if not is_tipped:
        return min(fastest, speed)
    pressed_at = (contacts.target.T_world_item @ grasp.T_item_tip)[:3, 3]
    return fastest if is_backed(contacts, press.edge, press.way, pressed_at, tool.cup.radius) else None


@dataclass(frozen=True, eq=False)
class _Footing:
    """Outline, seen from above, of the contacts that carry an item.

    Attributes:
        starts: (K, 3) m, start of each edge.
        edges: (K, 3) m, from there to its end.
        outwards: (K, 2) level unit normals, pointing out of the footing.
        height: m, mean of the contacts.
    """

    starts: Array
    edges: Array
    outwards: Array
    height: float

    @classmethod
    def of(cls, corners: Array) -> _Footing:
        """Find the outline of corners (N, 3) m of contacts; without edges if they span no area."""
        if len(corners) == 0:
            return cls(np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 2)), np.nan)
        a, b = (corners[k] for k in np.nonzero(~np.eye(len(corners), dtype=bool)))
        along = b - a
        length = np.hypot(along[:, 0], along[:, 1])
        a, along, length = (
            a[length > LENGTH_ROUNDING],
            along[length > LENGTH_ROUNDING],
            length[length > LENGTH_ROUNDING, None],
        )
        ways = np.column_stack([along[:, 1], -along[:, 0]]) / length
        beyond = (ways @ corners[:, :2].T - np.einsum("ni,ni->n", ways, a[:, :2])[:, None]).max(axis=1)
        outer = beyond < LENGTH_ROUNDING
        return cls(a[outer], along[outer], ways[outer], float(corners[:, 2].mean()))

    def is_beside(self, points: Array) -> NDArray[np.bool_]:
        """Whether points (N, 3) m are over no part of the footing, (N,)."""
        if len(self.outwards) == 0:
            return np.ones(len(points), dtype=bool)
        beyond = points[:, None, :2] - self.starts[:, :2]
        return np.asarray((np.einsum("nki,ki->nk", beyond, self.outwards) > 0.0).any(axis=1))

    def feet(self, point: Array) -> Array:
        """Return the foot (K, 3) m of a point (3,) m on the line of each edge, seen from above.

        Beyond an edge it has the height of the edge's nearer end.
        """
        along, beyond = self.edges[:, :2], point[:2] - self.starts[:, :2]
        share = np.einsum("ni,ni->n", beyond, along) / np.einsum("ni,ni->n", along, along)
        feet = self.starts + share[:, None] * self.edges
        feet[:, 2] = self.starts[:, 2] + np.clip(share, 0.0, 1.0) * self.edges[:, 2]
        return np.asarray(feet)


@dataclass(frozen=True, eq=False)
class _Press:
    """A press from the side, and the edge about which the item would tip under it.

    Attributes:
        edge: (3,) m in the world, the edge's nearest point to the item's centre.
        way: (2,) level unit vector across the edge, outwards.
        inside: m that the item's centre is inside of the edge.
        below: m that the edge is below the centre.
        arm: m from the edge to the line of the press.
        back: m from there to the face, against the press.
        lip: m, radius of the lip around that line.
        balance: rad that the item may turn at least until its centre is over the edge.
        inertia: kg m2 of the item about the edge, per kg of the item.
        weight: N, smallest weight of the item.
        press_depth: m that the cup goes beyond the face at most.
        stiffness: N/m of the bellows.
    """

    edge: Array
    way: Array
    inside: float
    below: float
    arm: float
    back: float
    lip: float
    balance: float
    inertia: float
    weight: float
    press_depth: float
    stiffness: float

    @property
    def tilt(self) -> float:
        """Angle in rad at which the item rests on the bellows; infinite if there is none."""
        angles = np.linspace(0.0, self.balance, N_TILTS)
        sin, cos = np.sin(angles)[:, None], np.cos(angles)[:, None]
        levers = self._lip_arms * cos + self.back * sin
        pushed = self.stiffness * (self._pressed_in(angles) * levers) @ LIP_SHARES
        rests = np.nonzero(pushed <= self.weight * (self.inside * cos - self.below * sin)[:, 0])[0]
        return float(angles[rests[0]]) if len(rests) else np.inf

    @property
    def throwing_speed(self) -> float:
        """Speed (m/s) of a cup that just throws the item over the edge from there, helped by the bellows."""
        if self.tilt >= self.balance:
            return 0.0
        upright = np.arctan2(self.inside, self.below)
        heights = np.hypot(self.inside, self.below) * np.cos(upright - np.array([self.tilt, self.balance]))
        helped = (
            self.stiffness
            / (2.0 * self.weight)
            * float(self._pressed_in(np.array([self.tilt]))[0] ** 2 @ LIP_SHARES)
        )
        lift = max(0.0, float(heights[1] - heights[0]) - helped)
        return float(self._lip_arms.min()) / REBOUND * float(np.sqrt(2.0 * GRAVITY * lift / self.inertia))

    @property
    def _lip_arms(self) -> Array:
        """Distances (9,) m of parts of the lip from the edge; what is below the edge has no lever."""
        return np.maximum(0.0, self.arm + self.lip * np.cos(LIP_ANGLES))

    def _pressed_in(self, angles: Array) -> Array:
        """Return how far (N, 9), m, bellows are pressed in by an item that leans by angles (N,), rad."""
        sin, cos = np.sin(angles)[:, None], np.cos(angles)[:, None]
        return np.maximum(0.0, self.press_depth - self._lip_arms * sin - self.back * (1.0 - cos))


def _tips_below(contacts: PickContacts, tool: Tool, grasp: Grasp) -> bool:
    """Whether a cup from above presses outside of the target's support."""
    target, balance, footing = contacts.target, contacts.supports.balance, _stated_footing(contacts)
    tip, centre = target.T_world_item @ grasp.T_item_tip, target.T_world_item[:3, 3]
    beyond = overtravel(grasp, tool, contacts.scene.noise_of(target))
    press = tool.cup.stiffness * beyond * tip[:3, 2]
    around, weight = tip[:3, 3] + _AROUND, target.item.lightest * GRAVITY
    met = np.empty((0, 3))
    if not footing.is_beside(centre[None])[0]:  # it stands by its weight
        met = around - np.outer((around[:, 2] - footing.height) / press[2], press)
        if footing.is_beside((weight * centre - press[2] * met) / (weight - press[2])).any():
            return True  # even if a neighbour might hold it by friction
    if all(balance.stays_under(target.id, press, point) for point in around):
        return False
    return _stays_unpressed(contacts) or bool(footing.is_beside(met).any())


def _press(contacts: PickContacts, tool: Tool, grasp: Grasp) -> _Press | None:
    """Return the press, with the edge of the footing over which the least force tips; None if none tips."""
    target = contacts.target
    noise = contacts.scene.noise_of(target)
    T, tip = target.T_world_item, target.T_world_item @ grasp.T_item_tip
    footing = _least_footing(contacts)
    edges, ways = footing.feet(T[:3, 3]), footing.outwards
    # It turns about its own edge, also if that is seen above what it stands on.
    edges[:, 2] = np.maximum(edges[:, 2], _underside(target, edges))
    to_centre, to_tip = T[:3, 3] - edges, tip[:3, 3] - edges
    inside = -np.einsum("ni,ni->n", to_centre[:, :2], ways)
    arms = to_tip[:, 2] * (ways @ tip[:2, 2]) - np.einsum("ni,ni->n", to_tip[:, :2], ways) * tip[2, 2]
    if len(edges) == 0 or inside.min() <= -(EDGE_TOLERANCE + noise.bound(target.item)):
        return None  # it does not stand by its weight: what holds it from the side is not known
    inside = np.maximum(inside, 0.0)  # if it may not stand, any press over that edge tips it
    friction = np.where(arms > NO_ARM, inside / np.maximum(arms, NO_ARM), np.inf)  # required for tipping
    first = int(np.argmin(friction))
    if friction[first] >= MOST_FRICTION:
        return None
    b, z, (x, y) = float(inside[first]), float(to_centre[first, 2]), ways[first]
    axis = T[:3, :3].T @ (-y, x, 0.0)
    inertia = float(axis @ target.item.shape.inertia_per_mass @ axis) + b**2 + z**2
    balance = max(0.0, float(np.arctan2(b, z)) - noise.angle)
    weight, press_depth = target.item.lightest * GRAVITY, max_press_depth(grasp, tool, noise)
    back = -float(to_tip[first] @ (*(tip[:2, 2] @ ways[first] * ways[first]), tip[2, 2]))
    arm, cup = float(arms[first]), tool.cup
    return _Press(
        edges[first],
        ways[first],
        b,
        z,
        arm,
        back,
        cup.radius,
        balance,
        inertia,
        weight,
        press_depth,
        cup.stiffness,
    )


def _underside(target: PlacedItem, points: Array) -> Array:
    """Return the height (N,), m, of the side of an item that faces down most at level positions (N, 3)."""
    T, extents = target.T_world_item, target.item.shape.extents
    axis = int(np.argmax(np.abs(T[2, :3])))
    down = -np.sign(T[2, axis]) * T[:3, axis]
    on_it = T[:3, 3] + extents[axis] / 2 * down
    if -down[2] < LEVEL:  # none of its sides is what it stands on
        return np.full(len(points), -np.inf)
    return np.asarray(on_it[2] - (points[:, :2] - on_it[:2]) @ down[:2] / down[2])


# The following are cached by the identity of the contacts: they are asked for every grasp of a pick.


@lru_cache(maxsize=8)
def _stated_footing(contacts: PickContacts) -> _Footing:
    """Return the target's footing at its stated pose."""
    return _Footing.of(contacts.supports.balance.footing(contacts.target.id, is_sure=False))


@lru_cache(maxsize=8)
def _least_footing(contacts: PickContacts) -> _Footing:
    """Return the target's certain footing; that at the stated pose if its centre is outside of it."""
    sure = _Footing.of(contacts.supports.balance.footing(contacts.target.id))
    is_outside = sure.is_beside(contacts.target.T_world_item[None, :3, 3])[0]
    return _stated_footing(contacts) if is_outside else sure


@lru_cache(maxsize=8)
def _stays_unpressed(contacts: PickContacts) -> bool:
    """Whether the target keeps its balance by its weight only."""
    target = contacts.target
    return contacts.supports.balance.stays_under(target.id, np.zeros(3), target.T_world_item[:3, 3])
