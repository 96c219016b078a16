"""Camera views for pictures and films: fixed ones for cells with a pod, computed ones for others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.geometry import Array, inverse, rotation_axis_angle, transform_points
from pickcli.kinematics.arm import Arm
from pickcli.scene.scene import Scene


@dataclass(frozen=True)
class View:
    """Position and target of a camera.

    Attributes:
        eye: m, world frame.
        target: m, world frame.
        fov: Vertical field of view, degrees.
    """

    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    fov: float = 50.0


CELL_VIEW = View((-2.6, 1.9, 2.3), (-0.55, -0.1, 1.05), 48.0)  # robot, pod and tote from behind on the left
POD_VIEW = View((-1.60, 0.0, 1.40), (0.2, 0.0, 1.28), 40.0)  # straight into the bins
TOTE_VIEW = View((-1.05, -0.1, 1.75), (-1.045, -0.6165, 0.6), 32.0)  # down into the tote
LINK_MARGIN = 0.25  # m around the link frames of an arm, for the links' extent
N_CONFIGURATIONS = 40  # configurations of a motion for which the view is chosen
POINT_HEIGHT = 0.02  # m above the floor of a place, of the point that should be visible
# turns about the vertical to try
TRIED_TURNS = np.radians([0.0, 40.0, -40.0, 80.0, -80.0, 120.0, -120.0, 180.0])


def view_of(scene: Scene) -> View:
    """Choose the view for pictures of a scene's places.

    Args:
        scene: The scene.

    Returns:
        The view into the bins if there is a pod, else a view down onto all places, from the side of the robot
        or the nearest direction in which obstacles hide the fewest points.
    """
    if scene.cell.pod.bins:
        return POD_VIEW
    at = [scene.T_world_place(place)[:3, 3] for place in scene.cell.places.values()]
    middle = np.mean(at, axis=0) if at else np.zeros(3)
    base = scene.cell.robot.T_world_base[:3, 3]
    spread = 0.6 + float(np.max([np.linalg.norm(p - middle) for p in at], initial=0.0))
    away = (middle - base) * (1.0, 1.0, 0.0)
    length = float(np.linalg.norm(away))
    towards = away / length if length > 0.1 else np.array([1.0, 0.0, 0.0])
    behind = 1.3 * spread * (np.array([0.0, 0.0, 1.0]) - towards)
    seen = np.array([*at, base]) + np.array([0.0, 0.0, POINT_HEIGHT])
    eye = _least_hidden(middle, behind, seen, scene.cell)
    return View(tuple(eye.tolist()), tuple(middle.tolist()), 50.0)


def view_of_motion(cell: Cell, Q: Array) -> View:
    """Choose the view for a film of a motion.

    Args:
        cell: The cell.
        Q: (N, n) configurations of the motion.

    Returns:
        The whole cell if it has a pod; else a view of the arm in all configurations, from the same side or
        the nearest direction in which obstacles hide the fewest points.
    """
    if cell.pod.bins:
        return CELL_VIEW
    robot = cell.robot
    chain = Arm(robot).chain(robot.tool.default_state)
    shown = Q[np.linspace(0, len(Q) - 1, N_CONFIGURATIONS).astype(int)]
    points = np.concatenate([robot.T_world_base[None, :3, 3], *(chain.fk(q)[:, :3, 3] for q in shown)])
    low, high = points.min(axis=0), points.max(axis=0)
    radius = float(np.linalg.norm(high - low)) / 2 + LINK_MARGIN
    away = np.subtract(CELL_VIEW.eye, CELL_VIEW.target)
    away *= radius / np.sin(np.radians(CELL_VIEW.fov) / 2) / np.linalg.norm(away)
    target = (low + high) / 2
    eye = _least_hidden(target, away, points, cell)
    return View(tuple(eye.tolist()), tuple(target.tolist()), CELL_VIEW.fov)


def _least_hidden(target: Array, away: Array, points: Array, cell: Cell) -> Array:
    """Candidate eye (3,) around a target that sees most of points (N, 3); the default one is preferred."""
    eyes = [target + rotation_axis_angle((0.0, 0.0, 1.0), turn) @ away for turn in TRIED_TURNS]
    return min(eyes, key=lambda eye: _n_hidden(eye, points, cell))


def _n_hidden(eye: Array, points: Array, cell: Cell) -> int:
    """Number of points (N, 3) that obstacles' boxes hide from an eye (3,)."""
    hidden = np.zeros(len(points), dtype=bool)
    for body in cell.obstacles.bodies:
        T, half = inverse(body.T_parent_shape), body.shape.extents / 2
        start, way = transform_points(T, eye[None])[0], transform_points(T, points)
        way = way - start
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.sort(np.stack([(-half - start) / way, (half - start) / way]), axis=0)
        hidden |= np.maximum(ends[0].max(axis=1), 0.0) < np.minimum(ends[1].min(axis=1), 1.0)
    return int(hidden.sum())
