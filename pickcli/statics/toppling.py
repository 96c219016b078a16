"""Toppling an item in an open box: across which of its sides a push turns it over, and how far.

A push above the centre turns an item that stands on edge about its lower edge on the far side, if friction
holds that edge (Mason, Mechanics of Robotic Manipulation, 2001, ch. 7). The push rises a little faster than
the pushed face, so that friction at the tool lifts that side instead of holding it down. Once the centre is
past that edge the item falls by itself, and the pushed face comes to lie on top. If friction does not hold,
it slides, which does no harm in a box.

What has no room for the tool beside it, or would slide, can be turned about the same edge from above, by the
friction of the cup that is pressed on its upper side: the press holds the edge on the floor.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from pickcli.cell.shapes import ShapeKind
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse, rotation_axis_angle
from pickcli.scene.touching import gaps
from pickcli.statics.pushing import HEAVIEST, pushable
from pickcli.statics.supports import Supports

STEEPEST = np.sin(np.radians(20.0))  # vertical part of a face's normal up to which the face is upright
FRICTION = 0.5  # below the item and at the tool, with which it turns over: cardboard on board has 0.25 to 0.5
LIFTED = 1.2  # slope of the push, over that at which the pushed point of the item rises by itself
MOST_SLOPE = np.tan(np.radians(48.0))  # of a push that goes across; wider items would slide
BEYOND = np.radians(8.0)  # rad, tilt past the balance on the edge, besides the angular pose error
MOST_TURN = np.radians(56.0)  # rad, of the cup that turns with an item from above: else it meets walls
WIDE = np.radians(
    45.0
)  # rad, tilt up to which there must be room to fall; leaning so far, a face is within reach
TILT_STEP = np.radians(4.0)  # rad between the tilts at which the room is looked at
MOST_TRAVEL, TRAVEL_STEP = 0.08, 0.0005  # m of a push after its first contact
MARGIN = 0.006  # m from the upper side of the item down to where it is pushed
# sine of the angle between a push in a bin and its breadth, up to which the item only turns to a side
SIDEWAYS = np.sin(np.radians(10.0))
GRAZE = 0.002  # m by which a tilting item may enter another that it would push aside
_CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))
_EDGES = np.array([(i, j) for i in range(8) for j in range(i + 1, 8) if bin(i ^ j).count("1") == 1])


@dataclass(frozen=True, eq=False)
class Topple:
    """A push that turns a box-shaped item over one of its lower edges.

    Attributes:
        item: Id of the item.
        face: Name of the pushed face, which comes to lie on top.
        upper: Name of the face on top before.
        direction: (3,) horizontal unit vector of the push, in the world.
        centre: (3,) m in the world, centre of the item.
        edge: (2,) m along ``direction`` and upwards, the edge about which it turns.
        corners: (8, 2) m along ``direction`` and upwards, corners of the item.
        tilt: rad by which it turns until it surely falls by itself.
        bound: m, bound of the pose error of any of its points.
        lowest: m in the world above which a push turns it over instead of sliding it.
        highest: m in the world, up to which the item surely reaches, with a margin for the tool.
        mass: kg at most, of the item with all that lies on it.
        sliding: Why a push from beside would slide it; "" if it turns it over.
    """

    item: str
    face: str
    upper: str
    direction: Array
    centre: Array
    edge: Array
    corners: Array
    tilt: float
    bound: float
    lowest: float
    highest: float
    mass: float
    sliding: str = ""

    @property
    def lever(self) -> float:
        """Way in m along ``direction`` from the centre to the edge, about which the weight turns it back."""
        return float(self.edge[0] - self.centre @ self.direction)

    def near_side(self, height: float, tilt: float = 0.0) -> float:
        """Compute where the item begins, above some height, as the side of an upright tool meets it.

        Args:
            height: m in the world.
            tilt: rad by which it is turned over its edge.

        Returns:
            m along ``direction``; infinite if the item is lower.
        """
        turned = self._turned(tilt)
        above = turned[turned[:, 1] >= height, 0]
        a, b = turned[_EDGES[:, 0]], turned[_EDGES[:, 1]]
        crosses = (a[:, 1] - height) * (b[:, 1] - height) < 0.0
        share = (height - a[crosses, 1]) / (b[crosses, 1] - a[crosses, 1])
        level = a[crosses, 0] + share * (b[crosses, 0] - a[crosses, 0])
        return float(np.concatenate([above, level]).min(initial=np.inf))

    def top(self, tilt: float) -> float:
        """Compute how high the item reaches as it turns over its edge.

        Args:
            tilt: rad by which it is turned.

        Returns:
            m in the world.
        """
        return float(self._turned(tilt)[:, 1].max())

    def travel(self, height: float, slope: float, tilt: float) -> float:
        """Compute how far a rising push goes from its first contact until the item is turned by some angle.

        Args:
            height: m in the world, at which the push begins.
            slope: m upwards per m along ``direction``.
            tilt: rad.

        Returns:
            m along ``direction``; infinite if the push passes over the item before, or needs
            ``MOST_TRAVEL`` or more.
        """
        ways = np.arange(0.0, MOST_TRAVEL, TRAVEL_STEP)
        first = self.near_side(height)
        sides = (self.near_side(height + slope * way, tilt) - first for way in ways.tolist())
        return next((way for way, side in zip(ways.tolist(), sides, strict=True) if side <= way), np.inf)

    def _turned(self, tilt: float) -> Array:
        """Return the corners (8, 2) of the item turned over its edge by an angle."""
        c, s = np.cos(tilt), np.sin(tilt)
        return np.asarray(self.edge + (self.corners - self.edge) @ np.array([[c, -s], [s, c]]))

    def slope(self, height: float) -> float:
        """Compute the slope of a push at which friction lifts the pushed face, as it turns over the edge.

        Args:
            height: m in the world, at which the push begins.

        Returns:
            m upwards per m along ``direction``.
        """
        return float(LIFTED * (self.edge[0] - self.near_side(height)) / (height - self.edge[1]))


def topples(supports: Supports, item_id: str) -> tuple[Topple, ...] | Reason:
    """Find the pushes that topple an item so that one of its sealing faces comes to lie on top.

    Args:
        supports: The support relation of the scene.
        item_id: Id of the item.

    Returns:
        The pushes, the one whose face seals best first; or why there are none.
    """
    placed, rim = supports.graph.items[item_id], supports.rim(item_id)
    place = supports.graph.scene.cell.places.get(placed.location)
    if rim is None and (place is None or place.access.is_from_above):
        why_not = f"{placed.location} is no bin, and no box that is open above"
        return Reason("cannot be toppled", item_id, why_not)
    if placed.item.shape.kind is not ShapeKind.BOX:
        return Reason("cannot be toppled", item_id, "its shape is no box")
    why = _why_not_in_bin(supports, item_id) if rim is None else why_not_safe(supports, item_id, rim)
    if why is not None:
        return Reason("cannot be toppled", item_id, why, item_id)
    R = placed.T_world_item[:3, :3]
    found: list[Topple] = []
    against: list[str] = []
    blocking: list[str] = []
    for face in placed.item.shape.face_names:
        normal = R[:, "xyz".index(face[1])] * (1.0 if face[0] == "+" else -1.0)
        if placed.item.seals.get(face, 0.0) > 0.0 and abs(normal[2]) <= STEEPEST:
            push = _topple(supports, item_id, face, normal)
            if isinstance(push, Topple):
                found.append(push)
            else:
                against.append(f"{face}: {push.detail}")
                blocking.append(push.in_the_way)
    if not found:
        why = "; ".join(against) or "no upright face of it seals"
        return Reason("cannot be toppled", item_id, why, next(filter(None, blocking), ""))
    return tuple(sorted(found, key=lambda push: (-_area(supports, push), push.face)))


def loaded_on(supports: Supports, item_id: str) -> tuple[str, ...]:
    """Return the items that move with an item when it is toppled: all that lies on it.

    Args:
        supports: The support relation of the scene.
        item_id: Id of the item.

    Returns:
        Ids, sorted.
    """
    return tuple(sorted(supports.graph.chain(supports.graph.lying_on, item_id)))


def why_not_safe(supports: Supports, item_id: str, rim: float) -> str | None:
    """Say why an item, or what lies on it, must not be pushed over: it is heavy, or could leave the box.

    Args:
        supports: The support relation of the scene.
        item_id: Id of the item.
        rim: m, height of the rim of its box in the world.

    Returns:
        The reason; None if it may be pushed.
    """
    graph, lying = supports.graph, loaded_on(supports, item_id)
    where = graph.items[item_id].location
    if found := graph.scene.unrecognised_in(where):
        return f"nobody recognised what is at {found[0].name}; look again"
    mass = _mass_with_all_on_it(supports, item_id)
    if mass > HEAVIEST:
        return f"it may have {mass:.2f} kg with all on it, at most {HEAVIEST}"
    if firm := sorted(set(lying) - pushable(supports, item_id)):
        return f"{firm[0]} lies on it and may not be pushed"
    for name in (item_id, *lying):
        # On whichever corner it turns, its centre is no higher above it than half its diagonal.
        k, moved = graph.index[name], graph.items[name]
        bottom = float(moved.T_world_item[2, 3] - graph.solids.upright[k, 2])
        highest = bottom + moved.item.shape.bounding_radius + float(graph.solids.bound[k])
        over = highest - supports.barrier(rim, name)
        if not over < 0.0:
            what = "it" if name == item_id else f"{name} on it"
            return f"{what} may get over the rim: its middle may come {1e3 * over:.0f} mm too high"
    return None


def _why_not_in_bin(supports: Supports, item_id: str) -> str | None:
    """Say why an item of a bin must not be pushed over: others need it, it is heavy, or is not wholly inside.

    It turns over to a side, by which nothing of it comes nearer to the mouth.
    """
    graph = supports.graph
    scene, placed = graph.scene, graph.items[item_id]
    place = scene.cell.places[placed.location]
    if found := scene.unrecognised_in(place.name):
        return f"nobody recognised what is at {found[0].name}; look again"
    if placed.item.heaviest > HEAVIEST:
        return f"it may have {placed.item.heaviest:.2f} kg, at most {HEAVIEST}"
    if falling := supports.falling(item_id):
        return f"{falling[0]} rests or leans on it"
    T_place_item = inverse(scene.T_world_place(place)) @ placed.T_world_item
    front = float(T_place_item[0, 3] - placed.item.shape.reach(T_place_item[:3, :3])[0]) - scene.bound(placed)
    return f"it may reach {-1e3 * front:.0f} mm out of the mouth" if front < 0.0 else None


def _is_sideways(supports: Supports, item_id: str, direction: Array) -> bool:
    """Whether a direction (3,) leads neither into the bin of an item nor out of it, or it is in no bin."""
    place = supports.graph.scene.cell.places[supports.graph.items[item_id].location]
    inwards = supports.graph.scene.T_world_place(place)[:3, 0]
    return place.access.is_from_above or abs(float(inwards @ direction)) <= SIDEWAYS


def _mass_with_all_on_it(supports: Supports, item_id: str) -> float:
    items = supports.graph.items
    return float(sum(items[name].item.heaviest for name in (item_id, *loaded_on(supports, item_id))))


def _topple(supports: Supports, item_id: str, face: str, normal: Array) -> Topple | Reason:
    """Return the push against one upright face, or why it does not topple the item."""

    def no(why: str, blocked_by: str = "") -> Reason:
        return Reason("cannot be toppled", item_id, why, blocked_by)

    graph = supports.graph
    placed, k = graph.items[item_id], graph.index[item_id]
    T, bound = placed.T_world_item, float(graph.solids.bound[k])
    direction = -np.array([normal[0], normal[1], 0.0]) / float(np.hypot(normal[0], normal[1]))
    if not _is_sideways(supports, item_id, direction):
        return no("in a bin it may only turn over to a side")
    points = T[:3, 3] + (_CORNERS * placed.item.shape.extents) @ T[:3, :3].T
    corners = np.column_stack([points @ direction, points[:, 2]])
    carried = supports.balance.footing(item_id, is_sure=False) @ direction
    if len(carried) == 0:
        return no("nothing carries it")
    edge = np.array([float(np.clip(carried.max(), *np.sort(corners[:, 0])[[0, -1]])), corners[:, 1].min()])
    centre = np.array([T[:3, 3] @ direction, T[2, 3]])
    width, height = edge[0] - centre[0], centre[1] - edge[1]
    if width <= 0.0:
        return no("its middle is not behind the edge")
    tilt = float(np.arctan2(width, height)) + BEYOND + graph.scene.noise_of(placed).angle
    # The push is at most what friction holds, and lifts the near side: both moments about the edge count.
    breadth = edge[0] - corners[:, 0].min()
    lever = width * (1.0 + FRICTION**2) / FRICTION - FRICTION * breadth
    lowest = float(edge[1] + max(height, lever))
    highest = float(corners[:, 1].max() - bound)
    sliding = ""
    if max(lowest, edge[1] + LIFTED * breadth / MOST_SLOPE) >= highest - MARGIN:
        sliding = f"it would slide: {1e3 * width:.0f} mm to its edge, {1e3 * (highest - edge[1]):.0f} mm high"
        if tilt > MOST_TURN:
            return no(sliding)
    push = Topple(
        item_id, face, _upper_face(T), direction, T[:3, 3], edge, corners, tilt, bound, lowest,
        highest - MARGIN, _mass_with_all_on_it(supports, item_id), sliding,
    )  # fmt: skip
    if (blocked := _blocked(supports, push)) is None:
        return push
    name, tilt = blocked
    return no(
        f"no room to fall: {name} at {np.degrees(tilt):.0f} degrees", name if name in graph.items else ""
    )


def _upper_face(T: Array) -> str:
    """Return the name of the face of a box (4, 4) that is on top."""
    axis = int(np.argmax(np.abs(T[2, :3])))
    return ("+" if T[2, axis] > 0.0 else "-") + "xyz"[axis]


def _blocked(supports: Supports, push: Topple) -> tuple[str, float] | None:
    """Return what an item meets as it turns over its edge, and at which tilt in rad; None if it has room."""
    graph, name = supports.graph, push.item
    solids, k = graph.solids, graph.index[name]
    left_out = {name, *graph.carriers(name), *loaded_on(supports, name)}
    where = graph.items[name].location
    others = np.array([
        i for i, other in enumerate(solids.names)
        if other not in left_out and (other not in graph.items or graph.items[other].location == where)
    ])  # fmt: skip
    T = solids.T[k]
    about = push.edge[0] * push.direction + np.array([0.0, 0.0, push.edge[1]])
    about = about + (T[:3, 3] - (T[:3, 3] @ push.direction) * push.direction) * np.array([1.0, 1.0, 0.0])
    axis = np.cross([0.0, 0.0, 1.0], push.direction)
    for tilt in np.arange(TILT_STEP, max(WIDE, push.tilt) + TILT_STEP, TILT_STEP):
        R = rotation_axis_angle(axis, float(tilt))
        turned = solids.T.copy()
        turned[k, :3, :3] = R @ T[:3, :3]
        turned[k, :3, 3] = about + R @ (T[:3, 3] - about)
        found = gaps(replace(solids, T=turned), np.full(len(others), k), others)
        deepest = int(np.argmin(found.width))
        if found.width[deepest] < -GRAZE - push.bound:
            return str(solids.names[others[deepest]]), float(tilt)
    return None


def _area(supports: Supports, push: Topple) -> float:
    """Sealing of the pushed face, times its area: larger faces take more cups."""
    item = supports.graph.items[push.item].item
    sides = [item.shape.extents[i] for i in range(3) if "xyz"[i] != push.face[1]]
    return float(item.seals[push.face] * np.prod(sides))
