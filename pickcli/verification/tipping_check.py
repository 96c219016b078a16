"""Check that a cup does not tip the item that it presses on over the edge of its support.

Press from above: planar statics. Weight and press act along lines, and the support can push up only where the
item lies on it. So the item tips over the edge of its support if the resultant passes outside of it (the
zero-moment point, Vukobratovic and Borovac, 2004). Press from the side: energy. The item turns over that edge
until the lifted weight balances the relaxing bellows, as if friction kept it from sliding; it falls over if
its centre passes the edge before, or if the impact of the cup throws it there. The bellows press evenly along
the lip, and each part of it until the item has left it: the lowest part stays on the longest.

The support is sampled on vertical lines: the item bears wherever its underside is as near to a solid below
as anywhere, within pose errors, and not steep: the side of an item that leans as perceived carries nothing.
Between the last bearing line and the next, bisection finds the edge, from inside. Against a press from
above, the support is enlarged by horizontal pose errors, so that a refused press tips the item for any of
them.

A wall close behind an item stops it before it falls: it leans on it. The wall has to be there above the cup,
on either side of it, as level lines through the item show within pose errors; what else may be behind it does
not count.

An item that does not stand by its weight is held from the side, which vertical lines do not show: it is not
judged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.shapes import Shape
from pickcli.cell.station import UNKNOWN
from pickcli.errors import Reason
from pickcli.geometry import GRAVITY, Array, inverse
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_overlap import TOUCH
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.quintic import positions_at
from pickcli.verification.ray_casting import cast_rays
from pickcli.verification.straightness_check import fastest_tip

N_LINES = 41  # along each side of the item's footprint
EDGE_WIDTH = 1e-3  # m, width of the edge of a support
N_HALVINGS = 6  # of the gap between two lines, to find the edge in it
STEEP = 1.0  # rise over run of an underside that does not carry: it slides off
SLOPE_STEP = 1e-4  # m between lines that measure a slope
N_ANGLES = 400  # angles up to the one at which an item falls over
N_LIP = 36  # parts of the lip that press each by itself
REBOUND = 2.0  # times the cup's speed: speed of an item that undamped bellows throw
NO_LEVER = 1e-6  # m
MOST_THROWN = 0.8  # of the energy that lifts the centre over the edge
MOST_LEAN = 0.07  # rad by which an item may lean on a wall: a lip follows, and friction holds its foot
MOST_FRICTION = 1.0  # of an item on its support: if tipping takes more, it slides
DIRECTION_ANGLES = np.radians(np.arange(360.0))
DIRECTIONS = np.column_stack([np.cos(DIRECTION_ANGLES), np.sin(DIRECTION_ANGLES)])
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Press:
    """A cup that is pressed on an item.

    Attributes:
        tip: (4, 4) the tool frame in the world.
        depth: m that the bellows are pressed in.
        stiffness: N/m of the bellows.
        speed: m/s at which the cup may meet the item.
        radius: m of the lip.
    """

    tip: Array
    depth: float
    stiffness: float
    speed: float
    radius: float = 0.0

    @property
    def force(self) -> Array:
        """(3,) N on the item, in world axes."""
        return np.asarray(self.stiffness * self.depth * self.tip[:3, 2])

    @property
    def lip(self) -> Array:
        """(36, 3) m in the world, points along the lip as it meets the item."""
        angles = np.linspace(0.0, 2.0 * np.pi, N_LIP, endpoint=False)
        around = self.radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(N_LIP)])
        return np.asarray(around @ self.tip[:3, :3].T + self.tip[:3, 3] - self.depth * self.tip[:3, 2])


def check_tipping(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check that no cup presses an item over the edge of its support.

    Args:
        plan: The plan.
        scene: The plan's scene.

    Yields:
        One fault for each contact that does so.
    """
    robot = scene.cell.robot
    if plan.grasp is None or robot.tool.grip.gives_way == 0.0:  # fingers close from both sides
        return
    for k, segment in enumerate(plan.segments):
        if segment.kind is not SegmentKind.CONTACT:
            continue
        placed = scene.find(plan.grasp.item)
        if placed.can_roll:  # an item that can roll is not kept in place by its balance
            continue
        links = link_poses(robot, positions_at(plan.trajectory, segment.t_end))
        tip = tip_poses(robot, links, segment.tool_state)[0]
        pressed = float((inverse(placed.T_world_item @ plan.grasp.T_item_tip) @ tip)[2, 3])
        speed = fastest_tip(plan, robot, segment.tool_state, segment.t_start, segment.t_end)
        press = Press(tip, max(0.0, pressed), robot.tool.grip.stiffness, speed, robot.tool.cup.radius)
        detail = _pressed_over(scene, placed, press, plan.grasp.kind == "top-down")
        if detail:
            yield Reason("tips the item", f"segment {k} ({segment.kind})", f"{placed.id}: {detail}")


def _pressed_over(scene: Scene, placed: PlacedItem, press: Press, is_from_above: bool) -> str:
    """Return how an item tips under a press, "" if it does not."""
    if is_from_above:
        beside = beside_support(scene, placed, press.force, press.tip[:3, 3])
        force = float(np.linalg.norm(press.force))
        detail = f"{force:.1f} N and its weight lead {beside * 1e3:.0f} mm beside what carries it"
        return detail if beside > 0.0 else ""
    if not falls_over(scene, placed, press):
        return ""
    return f"pressed {press.depth * 1e3:.1f} mm from aside, it falls over the edge of what carries it"


def beside_support(scene: Scene, placed: PlacedItem, force: Array, point: Array) -> float:
    """Return how far outside of an item's support the resultant of weight and press passes.

    Args:
        scene: The scene.
        placed: The item.
        force: (3,) N, world axes, downwards.
        point: (3,) m in the world, where the force acts.

    Returns:
        m, beyond pose errors; 0 if it passes inside, or if the item does not stand by its weight.
    """
    support, aside = _support(scene, placed)
    middle, weight = placed.T_world_item[:2, 3], placed.item.lightest * GRAVITY
    if len(support) == 0 or _outside(support[:, :2], middle) > 0.0:
        return 0.0
    press = max(-float(force[2]), 1e-9)
    pressed = point[:2] + force[:2] / press * (float(point[2]) - float(support[:, 2].mean()))
    through = (weight * middle + press * pressed) / (weight + press)
    return max(0.0, _outside(support[:, :2], through) - aside)


def falls_over(scene: Scene, placed: PlacedItem, press: Press) -> bool:
    """Whether a press from the side may push an item over an edge of its support, within pose errors.

    Args:
        scene: The scene.
        placed: The item.
        press: The planned press.

    Returns:
        True if it may; False also if the item does not stand by its weight.
    """
    support = _support(scene, placed)[0]
    centre, point = placed.T_world_item[:3, 3], press.tip[:3, 3] - press.depth * press.tip[:3, 2]
    if len(support) == 0 or _outside(support[:, :2], centre[:2]) > 0.0:
        return False
    ways = _sides(support[:, :2])[:, :2]
    edges = np.array([_beside(support, way, centre) for way in ways])
    centres, points = _across(centre - edges, ways), _across(point - edges, ways)
    way = np.column_stack([ways @ press.tip[:2, 2], np.full(len(ways), press.tip[2, 2])])
    arms = points[:, 1] * way[:, 0] - points[:, 0] * way[:, 1]
    lasts = np.divide(-centres[:, 0], arms, out=np.full(len(ways), np.inf), where=arms > 0.0)
    first = int(np.argmin(lasts))  # the edge over which the least force tips it
    if lasts[first] >= MOST_FRICTION:
        return False
    if _leans_on_wall(scene, placed, press, edges[first], ways[first]):
        return False
    noise, arm = scene.noise_of(placed), np.linalg.norm(np.cross(point - centre, press.tip[:3, 2]))
    depth = press.depth + float(noise.at(np.array(arm)))
    most = float(np.arctan2(-centres[first, 0], centres[first, 1])) - noise.angle
    angles = np.linspace(0.0, max(most, 0.0), N_ANGLES)
    lifted = _turned(centres[first], angles)[:, 1]
    lip = _across(press.lip - edges[first], np.repeat(ways[first : first + 1], N_LIP, axis=0))
    given = np.array([(_turned(part, angles) - part) @ way[first] for part in lip])
    work = placed.item.lightest * GRAVITY * lifted
    relaxed = press.stiffness / 2.0 * (np.maximum(0.0, depth - given) ** 2).sum(axis=0) / N_LIP
    lowest = max(float((lip[:, 1] * way[first, 0] - lip[:, 0] * way[first, 1]).min()), NO_LEVER)
    turn = REBOUND * press.speed / lowest
    thrown, energy = _energy(placed, centre - edges[first], ways[first]) * turn**2, work + relaxed
    return bool(np.all(np.diff(energy) < 0.0) or thrown > MOST_THROWN * (energy[-1] - energy.min()))


def _leans_on_wall(scene: Scene, placed: PlacedItem, press: Press, edge: Array, way: Array) -> bool:
    """Whether a wall surely stops an item that turns about an edge (3,) along a level direction (2,)."""
    shape, T = placed.item.shape, placed.T_world_item
    ahead, across = np.array([*way, 0.0]), np.array([-way[1], way[0], 0.0])
    axes = np.column_stack([ahead, across, [0.0, 0.0, 1.0]])
    half = shape.reach(axes.T @ T[:3, :3])
    low, high = float(press.lip[:, 2].max()), float(T[2, 3] + half[2])
    aside, up = np.meshgrid(np.linspace(-half[1], half[1], N_LINES), np.linspace(low, high, N_LINES))
    starts = np.column_stack([np.zeros(aside.size), aside.ravel(), up.ravel() - T[2, 3]]) @ axes.T + T[:3, 3]
    back = _along_ray(shape, T, starts, ahead)[1]
    gaps = np.full(len(starts), np.inf)
    for carrier in scene.posed_carriers:
        for body in carrier.bodies if carrier.name != UNKNOWN else ():
            off = scene.bound(placed) + carrier.uncertainty(body)
            T_body = carrier.T_world_carrier @ body.T_parent_shape
            ahead_by = _along_ray(body.shape, T_body, starts, ahead)[0] - back
            gaps = np.fmin(gaps, np.where(ahead_by >= -off, np.maximum(ahead_by, 0.0) + off, np.inf))
    stops = gaps <= np.sin(MOST_LEAN) * (starts[:, 2] - edge[2])
    here = float((press.tip[:3, 3] - T[:3, 3]) @ across)
    return bool(stops[aside.ravel() <= here].any() and stops[aside.ravel() >= here].any())


def _along_ray(shape: Shape, T: Array, starts: Array, along: Array) -> tuple[Array, Array]:
    """Return where rays from (N, 3) in the world enter and leave a solid at a pose (4, 4), m, or NaN."""
    return cast_rays(shape, (starts - T[:3, 3]) @ T[:3, :3], along @ T[:3, :3])


def _energy(placed: PlacedItem, from_edge: Array, way: Array) -> float:
    """Return the energy in J of an item that turns forward about an edge across a direction (2,) at 1 rad/s.

    from_edge: (3,) m to its centre
    """
    axis = np.array([-way[1], way[0], 0.0])
    own = placed.T_world_item[:3, :3].T @ axis
    inertia = own @ placed.item.shape.inertia_per_mass @ own + np.sum(np.cross(axis, from_edge) ** 2)
    return float(placed.item.lightest * inertia / 2.0)


def _sides(points: Array) -> Array:
    """Return the (K, 3) sides of the hull of points (N, 2): unit outward normal, negative offset (m)."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(ConvexHull(points).equations)
    except QhullError:  # all points on one line
        return np.column_stack([DIRECTIONS, -(points @ DIRECTIONS.T).max(axis=0)])


def _beside(support: Array, way: Array, centre: Array) -> Array:
    """Return (3,) m, the point nearest to a centre on the edge of a support in a level direction."""
    out, along = support[:, :2] @ way, np.array([-way[1], way[0]])
    last = support[out > out.max() - EDGE_WIDTH]
    t = last[:, :2] @ along
    at = float(np.clip(centre[:2] @ along, t.min(), t.max()))
    height = np.polyfit(t - at, last[:, 2], 1)[1] if np.ptp(t) > EDGE_WIDTH else last[:, 2].mean()
    return np.array([*(out.max() * way + at * along), height])


def _across(offsets: Array, ways: Array) -> Array:
    """Return offsets (N, 3) from edges as (N, 2): along the level direction (N, 2) across each, and up."""
    return np.column_stack([np.einsum("ni,ni->n", offsets[:, :2], ways), offsets[:, 2]])


def _turned(offset: Array, angles: Array) -> Array:
    """Turn an offset (2,), along and up, forward by angles (N,) in rad; return (N, 2)."""
    c, s = np.cos(angles), np.sin(angles)
    return np.column_stack([c * offset[0] + s * offset[1], c * offset[1] - s * offset[0]])


def _support(scene: Scene, placed: PlacedItem) -> tuple[Array, float]:
    """Return points (N, 3) of the underside that an item may rest on, and their horizontal error (m)."""
    T, own = placed.T_world_item, scene.bound(placed)
    reach = placed.item.shape.reach(T[:3, :3])
    below = [
        (shape, T_other, bound)
        for shape, T_other, bound in _others(scene, placed)
        if np.all(np.abs(T_other[:2, 3] - T[:2, 3]) <= (shape.reach(T_other[:3, :3]) + reach)[:2])
    ]
    R = _along(placed)
    half = placed.item.shape.reach(R.T @ T[:3, :3])
    x, y = (np.linspace(-h, h, N_LINES) for h in half[:2])
    lines = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1) @ R[:2, :2].T + T[:2, 3]
    gaps, aside = _gaps(placed, own, below, lines.reshape(-1, 2))
    if not np.isfinite(gaps).any():
        return np.empty((0, 3)), own
    most = max(0.0, float(np.nanmin(gaps))) + own + TOUCH

    def bears(at: Array) -> Mask:
        return np.asarray(_gaps(placed, own, below, at)[0] <= most) & ~_is_steep(placed, at)

    is_borne = (gaps <= most) & ~_is_steep(placed, lines.reshape(-1, 2))
    is_borne = is_borne.reshape(N_LINES, N_LINES)
    points = np.vstack([lines[is_borne], _edges(lines, is_borne, bears)])
    return np.column_stack([points, _heights(placed.item.shape, T, points)[0]]), own + aside


def _along(placed: PlacedItem) -> Array:
    """Return the (3, 3) rotation about the vertical that aligns x with an item's longest level extent."""
    T, extents = placed.T_world_item, placed.item.shape.extents
    axis = T[:2, int(np.argmax(extents * np.hypot(T[0, :3], T[1, :3])))]
    x, y = axis / np.linalg.norm(axis)
    return np.array([[x, -y, 0.0], [y, x, 0.0], [0.0, 0.0, 1.0]])


def _gaps(
    placed: PlacedItem, own: float, below: Sequence[tuple[Shape, Array, float]], lines: Array
) -> tuple[Array, float]:
    """Return gaps (N,), m, under an item on vertical lines (N, 2), infinite over nothing; their bound (m)."""
    underside = _heights(placed.item.shape, placed.T_world_item, lines)[0]
    gaps, aside = np.full(len(lines), np.inf), 0.0
    for other, T_other, bound in below:
        gap = underside - _heights(other, T_other, lines)[1] - bound
        is_below = gap >= -2.0 * bound - own - TOUCH
        if is_below.any():
            gaps, aside = np.minimum(gaps, np.where(is_below, gap, np.inf)), max(aside, bound)
    return gaps, aside


def _is_steep(placed: PlacedItem, lines: Array) -> Mask:
    """Whether the underside of an item is steep on vertical lines (N, 2); on an edge by its flatter side."""
    shape, T = placed.item.shape, placed.T_world_item
    here, slopes = _heights(shape, T, lines)[0], []
    for step in SLOPE_STEP * np.eye(2):
        rises = [np.abs(_heights(shape, T, lines + way * step)[0] - here) for way in (-1.0, 1.0)]
        slopes.append(np.fmin(*rises) / SLOPE_STEP)
    return np.asarray(np.hypot(*slopes) > STEEP)


def _edges(lines: Array, is_borne: Mask, bears: Callable[[Array], Mask]) -> Array:
    """Return points (N, 2) that still bear, just inside the support's edge, between neighbours of a grid.

    lines: (K, K, 2). is_borne: (K, K) whether each line bears the item. bears: whether any given points do
    """
    ends: list[Array] = []
    for axis in (0, 1):
        grid, borne = np.swapaxes(lines, 0, axis), np.swapaxes(is_borne, 0, axis)
        for a, b in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
            is_end = borne[a] & ~borne[b]
            ends.append(np.stack([grid[a][is_end], grid[b][is_end]]))
    inner, outer = np.concatenate(ends, axis=1)
    for _ in range(N_HALVINGS):
        middle = (inner + outer) / 2.0
        is_inner = bears(middle)[:, None]
        inner, outer = np.where(is_inner, middle, inner), np.where(is_inner, outer, middle)
    return np.asarray(inner)


def _others(scene: Scene, placed: PlacedItem) -> Iterator[tuple[Shape, Array, float]]:
    """Yield shape, pose and error bound (m) of everything that may be below the item."""
    for other in scene.in_location(placed.location):
        if other.id != placed.id:
            yield other.item.shape, other.T_world_item, scene.bound(other)
    for carrier in scene.posed_carriers:
        for body in carrier.bodies:
            T = carrier.T_world_carrier @ body.T_parent_shape
            yield body.shape, T, carrier.uncertainty(body)


def _heights(shape: Shape, T: Array, columns: Array) -> tuple[Array, Array]:
    """Return the lowest and highest point of a solid on vertical lines.

    Args:
        shape: The solid.
        T: (4, 4) its pose.
        columns: (N, 2) m, horizontal positions of the lines.

    Returns:
        (N,) m each; NaN if a line misses the solid.
    """
    starts = (np.column_stack([columns, np.zeros(len(columns))]) - T[:3, 3]) @ T[:3, :3]
    return cast_rays(shape, starts, T[2, :3])


def _outside(points: Array, p: Array) -> float:
    """Return the signed distance (m) of a point (2,) from the sides of the convex hull of points (N, 2)."""
    sides = _sides(points)
    return float((sides[:, :2] @ p + sides[:, 2]).max())
