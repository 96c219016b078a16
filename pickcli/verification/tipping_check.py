"""What a cup presses on from above does not tip over the edge of what carries it.

Statics in a plane: weight and press act along lines, what is below pushes up, and that it can only where the
item lies on it. So the item turns over the edge of its support where the resultant leads beside that (the
zero-moment point, Vukobratovic and Borovac, 2004). The support is looked up on vertical lines: the item bears
wherever its underside is as near to what is below as it is anywhere, but for what poses may be off.

The support counts as grown by what poses may be off aside, so that what is refused tips by any of them. What
does not stand by its weight alone is kept from aside, of which vertical lines tell nothing: it is not judged.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import Reason
from pickcli.geometry import GRAVITY, Array, inverse
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_overlap import TOUCH
from pickcli.verification.forward_kinematics import link_poses, tip_poses

N_LINES = 41  # along each side of the item's footprint
PARALLEL = 1e-12  # slope of a vertical line to a face that is as upright
FLAT_AXES = {ShapeKind.BOX: (0, 1, 2), ShapeKind.CYLINDER: (2,), ShapeKind.SPHERE: ()}


def check_tipping(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check that no cup from above presses an item over the edge of what carries it.

    Args:
        plan: The plan.
        scene: The plan's scene.

    Yields:
        One fault for each contact that does.
    """
    if plan.grasp is None or plan.grasp.kind != "top-down":
        return
    robot = scene.cell.robot
    for k, segment in enumerate(plan.segments):
        if segment.kind is not SegmentKind.CONTACT:
            continue
        placed = scene.find(plan.grasp.item)
        if placed.can_roll:  # balance is not what keeps it where it is
            continue
        links = link_poses(robot, plan.trajectory.sample(segment.t_end))
        tip = tip_poses(robot, links, segment.tool_state)[0]
        pressed = float((inverse(placed.T_world_item @ plan.grasp.T_item_tip) @ tip)[2, 3])
        press = robot.tool.cup.stiffness * max(0.0, pressed)
        beside = beside_support(scene, placed, press * tip[:3, 2], tip[:3, 3])
        if beside > 0.0:
            detail = f"{press:.1f} N and its weight lead {beside * 1e3:.0f} mm beside what carries it"
            yield Reason("tips the item", f"segment {k} ({segment.kind})", f"{placed.id}: {detail}")


def beside_support(scene: Scene, placed: PlacedItem, force: Array, point: Array) -> float:
    """How far an item's weight and a press on it lead beside what carries it.

    Args:
        scene: The scene.
        placed: The item.
        force: (3,) N, world axes, downwards.
        point: (3,) m in the world, where it presses.

    Returns:
        m, beyond what poses may be off; 0 where they do not, or where the item does not stand by its weight.
    """
    support, aside = _support(scene, placed)
    middle, weight = placed.T_world_item[:2, 3], placed.item.mass * GRAVITY
    if len(support) == 0 or _outside(support[:, :2], middle) > 0.0:
        return 0.0
    press = max(-float(force[2]), 1e-9)
    pressed = point[:2] + force[:2] / press * (float(point[2]) - float(support[:, 2].mean()))
    through = (weight * middle + press * pressed) / (weight + press)
    return max(0.0, _outside(support[:, :2], through) - aside)


def _support(scene: Scene, placed: PlacedItem) -> tuple[Array, float]:
    """Points (N, 3) of the underside on which an item may rest, and how far (m) they may be off aside."""
    shape, T, own = placed.item.shape, placed.T_world_item, scene.noise.bound(placed.item)
    lines, spacing = _lines_through(shape, T)
    underside, reach = _heights(shape, T, lines)[0], shape.reach(T[:3, :3])
    gaps, aside = np.full(len(lines), np.inf), 0.0
    for other, T_other, bound in _others(scene, placed):
        if np.any(np.abs(T_other[:2, 3] - T[:2, 3]) > (other.reach(T_other[:3, :3]) + reach)[:2]):
            continue
        gap = underside - _heights(other, T_other, lines)[1] - bound
        is_below = gap >= -2.0 * bound - own - TOUCH
        if is_below.any():
            gaps, aside = np.minimum(gaps, np.where(is_below, gap, np.inf)), max(aside, bound)
    bears = gaps <= max(0.0, float(gaps.min())) + own + TOUCH
    return np.column_stack([lines, underside])[bears & np.isfinite(gaps)], own + aside + spacing


def _lines_through(shape: Shape, T: Array) -> tuple[Array, float]:
    """Vertical lines (N, 2) that meet a solid, on a grid, and the spacing of the grid (m)."""
    half = shape.reach(T[:3, :3])[:2]
    x, y = (np.linspace(c - h, c + h, N_LINES) for c, h in zip(T[:2, 3], half, strict=True))
    lines = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    return lines[np.isfinite(_heights(shape, T, lines)[0])], float(2.0 * half.max() / (N_LINES - 1))


def _others(scene: Scene, placed: PlacedItem) -> Iterator[tuple[Shape, Array, float]]:
    """Shape, pose and bound (m) of the error of that, of everything that may be below the item."""
    for other in scene.in_location(placed.location):
        if other.id != placed.id:
            yield other.item.shape, other.T_world_item, scene.noise.bound(other.item)
    pod = {body.name for body in scene.cell.pod.bodies}
    for body, T in scene.standing:
        reach = float(np.linalg.norm(body.T_parent_shape[:2, 3]) + np.linalg.norm(body.shape.extents) / 2)
        yield body.shape, T @ body.T_parent_shape, scene.pod_error.bound(reach) if body.name in pod else 0.0


def _heights(shape: Shape, T: Array, columns: Array) -> tuple[Array, Array]:
    """Lowest and highest point of a solid on vertical lines.

    Args:
        shape: The solid.
        T: (4, 4) its pose.
        columns: (N, 2) m, where the lines are.

    Returns:
        (N,) m each; NaN where a line misses the solid.
    """
    start = (np.column_stack([columns, np.zeros(len(columns))]) - T[:3, 3]) @ T[:3, :3]
    up = T[2, :3] + np.where(T[2, :3] == 0.0, PARALLEL, 0.0)
    low, high = np.full(len(columns), -np.inf), np.full(len(columns), np.inf)
    for axis in FLAT_AXES[shape.kind]:
        ends = (np.array([[-0.5], [0.5]]) * shape.extents[axis] - start[:, axis]) / up[axis]
        low, high = np.maximum(low, ends.min(axis=0)), np.minimum(high, ends.max(axis=0))
    if round_axes := [axis for axis in range(3) if axis not in FLAT_AXES[shape.kind]]:
        a, b = float(up[round_axes] @ up[round_axes]), start[:, round_axes] @ up[round_axes]
        room = b * b - a * ((start[:, round_axes] ** 2).sum(axis=1) - shape.size[0] ** 2)
        wide = np.sqrt(np.maximum(room, 0.0))
        low = np.where(room >= 0.0, np.maximum(low, (-b - wide) / a), np.inf)
        high = np.minimum(high, (-b + wide) / a)
    is_met = low <= high
    return np.where(is_met, low, np.nan), np.where(is_met, high, np.nan)


def _outside(points: Array, p: Array) -> float:
    """How far (m) a point (2,) is from the convex hull of points (N, 2); below 0 inside."""
    turns = np.radians(np.arange(360.0))
    directions = np.column_stack([np.cos(turns), np.sin(turns)])
    return float((directions @ p - (points @ directions.T).max(axis=0)).max())
