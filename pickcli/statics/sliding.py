"""Pushing an item off what it lies on, in an open box: in which directions, and how far.

An item that no tool can take keeps all below it in a heap. A level push at its middle or above
slides it along or turns it over (Lynch and Mason, Stable pushing, 1996) until its centre is past all that
carries it and it falls, which does no harm between the walls of a box. On its way it comes near to nothing
but what carries it, within the errors of both poses: pushed against something firm it would jam. Where no
way is free as far as that, it is pushed along as far as one is: there it lies otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.shapes import Shape
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse, transform_points
from pickcli.scene.touching import gaps
from pickcli.statics.supports import Supports
from pickcli.statics.toppling import GRAZE, loaded_on, why_not_safe

N_DIRECTIONS = 16  # horizontal ones
BEYOND = 0.01  # m that the centre comes past what carries the item, besides both pose errors
MOST_WAY = 0.13  # m that the item moves
LEANING = 0.04  # m that an item moves whose centre is past its carriers already: it leans on a wall or others
LEAST_WAY, ALONG = 0.03, 0.07  # m at least and most that it moves along what carries it, not off that
FINE_STEP = 0.001  # m between the points at which the surface of the item is looked for
STEP = 0.01  # m between the places on its way at which the room is looked at


@dataclass(frozen=True, eq=False)
class Slide:
    """A level push that moves an item off what it lies on, or along it.

    Attributes:
        item: Id of the item.
        direction: (3,) horizontal unit vector of the push, in the world.
        across: (3,) horizontal unit vector across it.
        shape: Shape of the item.
        T_world_item: (4, 4) its pose.
        width: m, its extent along ``across``.
        way: m that it moves.
        bound: m, bound of the pose error of any of its points.
        against: Name of what keeps it on what it lies on, as it would be pushed against that; empty if
            nothing does.
    """

    item: str
    direction: Array
    across: Array
    shape: Shape
    T_world_item: Array
    width: float
    way: float
    bound: float
    against: str = ""

    @property
    def is_free(self) -> bool:
        """Whether nothing is in the way that leads past all that the item lies on."""
        return not self.against

    @property
    def centre(self) -> Array:
        """(3,) m in the world, centre of the item."""
        return self.T_world_item[:3, 3]

    def near_side(self, aside: float, height: float) -> float:
        """Compute where a line along the push enters the item.

        Args:
            aside: m along ``across``, of the line from the centre.
            height: m in the world, of the line.

        Returns:
            m along ``direction`` from the centre, within ``FINE_STEP`` before the surface; infinite if the
            line does not meet the item.
        """
        radius = self.shape.bounding_radius
        ways = np.arange(-radius, radius, FINE_STEP)
        lifted = np.array([0.0, 0.0, height - self.centre[2]])
        points = self.centre + aside * self.across + lifted + ways[:, None] * self.direction
        inside = self.shape.contains(transform_points(inverse(self.T_world_item), points))
        return float(ways[np.argmax(inside)] - FINE_STEP) if inside.any() else np.inf

    def top_at(self, aside: float) -> float:
        """Compute up to which height lines along the push meet the item.

        Args:
            aside: m along ``across``, of the lines from the centre.

        Returns:
            m in the world, within ``FINE_STEP``; minus infinity if none does.
        """
        half = float(self.shape.reach(self.T_world_item[:3, :3])[2])
        heights = self.centre[2] + np.arange(half, -half, -FINE_STEP)
        return next((z for z in heights.tolist() if np.isfinite(self.near_side(aside, z))), -np.inf)


def slides(supports: Supports, item_id: str) -> tuple[Slide, ...] | Reason:
    """Find the pushes that move an item off the items that it lies on, or else along them.

    Args:
        supports: The support relation of the scene.
        item_id: Id of the item.

    Returns:
        The pushes off, the shortest first, and then those along, the longest first; or why there are none.
    """
    what, graph, rim = "cannot be pushed off", supports.graph, supports.rim(item_id)
    if rim is None:
        return Reason(what, item_id, f"{graph.items[item_id].location} is no box that is open above")
    below = [name for name in graph.carriers(item_id) if name in graph.items]
    if not below:
        return Reason(what, item_id, "it lies on no other item")
    if (why := why_not_safe(supports, item_id, rim)) is not None:
        return Reason(what, item_id, why, item_id)
    moved = {item_id, *loaded_on(supports, item_id)}
    over = [
        name for name in supports.falling(item_id) if name not in moved and supports.may_leave_over(rim, name)
    ]
    if over:
        return Reason(what, item_id, f"{over[0]} leans on it and could fall over the rim", over[0])
    found = [
        _slide(supports, item_id, below, turn)
        for turn in 2.0 * np.pi * np.arange(N_DIRECTIONS) / N_DIRECTIONS
    ]
    free = [_freely(supports, slide) for slide in found]
    off = [slide for slide in free if slide.is_free and slide.way <= MOST_WAY]
    rest = [slide for slide in free if slide not in off and slide.way >= LEAST_WAY]
    along = [replace(slide, way=min(slide.way, ALONG)) for slide in rest]
    pushes = sorted(off, key=lambda slide: round(slide.way, 3))
    pushes += sorted(along, key=lambda slide: -round(slide.way, 3))
    if pushes:
        return tuple(pushes)
    against = next(slide.against for slide in free if slide.against)
    why = f"no way is free for {1e3 * LEAST_WAY:.0f} mm; one leads against {against}"
    return Reason(what, item_id, why, against if against in graph.items else "")


def _slide(supports: Supports, item_id: str, below: list[str], turn: float) -> Slide:
    """Return the push in one direction, so many rad from the world's x axis, off the items below."""
    solids, index, placed = supports.graph.solids, supports.graph.index, supports.graph.items[item_id]
    direction = np.array([np.cos(turn), np.sin(turn), 0.0])
    across = np.array([-direction[1], direction[0], 0.0])
    k, carriers = index[item_id], np.array([index[name] for name in below])
    half_width = float(solids.half_widths(np.array([k]), across[None, None])[0, 0])
    ahead = solids.half_widths(carriers, np.tile(direction, (len(carriers), 1, 1)))[:, 0]
    ends = solids.T[carriers, :3, 3] @ direction + ahead + solids.bound[carriers]
    bound, centre = float(solids.bound[k]), placed.T_world_item[:3, 3]
    left = float(ends.max() - centre @ direction)
    way = (left if left > 0.0 else LEANING) + bound + BEYOND
    shape, T = placed.item.shape, placed.T_world_item
    return Slide(item_id, direction, across, shape, T, 2.0 * half_width, way, bound)


def _freely(supports: Supports, slide: Slide) -> Slide:
    """Return a push as far as the item meets nothing but what it lies on, and what it would meet next."""
    graph, name = supports.graph, slide.item
    solids, k = graph.solids, graph.index[name]
    left_out = {name, *graph.chain(graph.carriers, name), *loaded_on(supports, name)}
    where = graph.items[name].location
    others = np.array([
        i for i, other in enumerate(solids.names)
        if other not in left_out and (other not in graph.items or graph.items[other].location == where)
    ])  # fmt: skip
    clear, free = np.zeros(len(others)), 0.0
    for way in np.linspace(0.0, slide.way, 1 + int(np.ceil(slide.way / STEP))).tolist():
        T = solids.T.copy()
        T[k, :3, 3] += way * slide.direction
        found = gaps(replace(solids, T=T), np.full(len(others), k), others)
        if way == 0.0:  # what is nearer than the errors already does not come nearer
            clear = np.minimum(found.width, solids.bound[others] + slide.bound)
        nearer = clear - found.width
        if nearer.max() > GRAZE:
            return replace(slide, way=free, against=str(solids.names[others[int(np.argmax(nearer))]]))
        free = way
    return slide
