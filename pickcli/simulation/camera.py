"""Pictures of a world, and films made of them."""

from __future__ import annotations

from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.cell import Cell
from pickcli.errors import InputError
from pickcli.files.atomic_write import write_bytes
from pickcli.geometry import Array, inverse, rotation_axis_angle, transform_points
from pickcli.kinematics.arm import Arm
from pickcli.scene.scene import Scene
from pickcli.simulation.engine import Engine
from pickcli.simulation.scene_bodies import add_items, add_statics


@dataclass(frozen=True)
class View:
    """Where a camera stands and what it looks at.

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
SMALL = (480, 360)  # pixels
MARGIN = 0.25  # m around the frames of an arm, for what its links reach beyond them
N_SAMPLES = 40  # of a motion, by which a view is chosen
OVER = 0.02  # m over the floor of a place at which it is to be seen
AROUND = np.radians([0.0, 40.0, -40.0, 80.0, -80.0, 120.0, -120.0, 180.0])  # turns about the vertical, tried
TOTE_VIEW = View((-1.05, -0.1, 1.75), (-1.045, -0.6165, 0.6), 32.0)  # down into the tote


def view_of(scene: Scene) -> View:
    """Where a picture of a scene's places is taken from.

    Args:
        scene: The scene.

    Returns:
        Straight into the bins where there is a pod, else down onto all places, from the side of the robot or
        that next to it from which obstacles hide the fewest.
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
    seen = np.array([*at, base]) + np.array([0.0, 0.0, OVER])
    eye = _least_hidden(middle, behind, seen, scene.cell)
    return View(tuple(eye.tolist()), tuple(middle.tolist()), 50.0)


def take_picture(engine: Engine, view: View, size: tuple[int, int] = (960, 720)) -> NDArray[np.uint8]:
    """Take a colour picture of a world.

    Args:
        engine: The world.
        view: Where the camera stands.
        size: Width and height in pixels.

    Returns:
        (height, width, 3).
    """
    return engine.picture(view.eye, view.target, view.fov, size)


def write_png(picture: NDArray[np.uint8], path: Path, replace: bool = True) -> None:
    """Write one picture in one step: a kill or a full disk leaves the old file or none.

    Args:
        picture: (height, width, 3).
        path: The file.
        replace: Whether a file that exists may be replaced.

    Raises:
        InputError: If the file cannot be written.
    """
    from PIL import Image

    content = BytesIO()
    Image.fromarray(picture).save(content, format="PNG")
    write_bytes(path, content.getvalue(), replace)


def overview(engine: Engine, scene: Scene) -> NDArray[np.uint8]:
    """The cell with its robot; beside it bins and tote, if there are, without the robot, which may hide them.

    Args:
        engine: The world.
        scene: What stands in it.

    Returns:
        (height, width, 3).
    """
    if not scene.cell.pod.bins:
        return take_picture(engine, view_of(scene))
    aside = [picture_of(scene, view, SMALL) for view in (POD_VIEW, TOTE_VIEW)]
    return np.hstack([take_picture(engine, CELL_VIEW), np.vstack(aside)])


def picture_of(
    scene: Scene, view: View | None = None, size: tuple[int, int] = (960, 720)
) -> NDArray[np.uint8]:
    """A picture of a scene without the robot.

    Args:
        scene: The scene.
        view: Where the camera stands; ``view_of`` the scene if None.
        size: Width and height in pixels.

    Returns:
        (height, width, 3).
    """
    engine = Engine(1e-3)
    try:
        add_statics(engine, scene)
        add_items(engine, scene)
        return take_picture(engine, view or view_of(scene), size)
    finally:
        engine.close()


def view_of_motion(cell: Cell, Q: Array) -> View:
    """The view that a motion is filmed from.

    Args:
        cell: The cell.
        Q: (N, n) configurations that the motion goes through.

    Returns:
        The whole cell where it has a shelf; else the arm wherever it goes, from the same side, or the side
        next to it from which obstacles hide the least of the motion.
    """
    if cell.pod.bins:
        return CELL_VIEW
    robot = cell.robot
    chain = Arm(robot).chain(robot.tool.default_state)
    shown = Q[np.linspace(0, len(Q) - 1, N_SAMPLES).astype(int)]
    points = np.concatenate([robot.T_world_base[None, :3, 3], *(chain.fk(q)[:, :3, 3] for q in shown)])
    low, high = points.min(axis=0), points.max(axis=0)
    radius = float(np.linalg.norm(high - low)) / 2 + MARGIN
    away = np.subtract(CELL_VIEW.eye, CELL_VIEW.target)
    away *= radius / np.sin(np.radians(CELL_VIEW.fov) / 2) / np.linalg.norm(away)
    target = (low + high) / 2
    eye = _least_hidden(target, away, points, cell)
    return View(tuple(eye.tolist()), tuple(target.tolist()), CELL_VIEW.fov)


def _least_hidden(target: Array, away: Array, points: Array, cell: Cell) -> Array:
    """Of eyes (3,) around a target, the usual one first, that which sees the most of points (N, 3)."""
    eyes = [target + rotation_axis_angle((0.0, 0.0, 1.0), turn) @ away for turn in AROUND]
    return min(eyes, key=lambda eye: _n_hidden(eye, points, cell))


def _n_hidden(eye: Array, points: Array, cell: Cell) -> int:
    """How many of points (N, 3) the boxes around obstacles hide from an eye (3,)."""
    hidden = np.zeros(len(points), dtype=bool)
    for body in cell.obstacles.bodies:
        T, half = inverse(body.T_parent_shape), body.shape.extents / 2
        start, way = transform_points(T, eye[None])[0], transform_points(T, points)
        way = way - start
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.sort(np.stack([(-half - start) / way, (half - start) / way]), axis=0)
        hidden |= np.maximum(ends[0].max(axis=1), 0.0) < np.minimum(ends[1].min(axis=1), 1.0)
    return int(hidden.sum())


class GifRecorder:
    """Frames at a fixed rate of simulated time, written as an animated GIF.

    Args:
        view: Where the camera stands.
        rate: Frames per simulated second.
        size: Width and height in pixels.
    """

    def __init__(self, view: View = CELL_VIEW, rate: float = 8.0, size: tuple[int, int] = (480, 360)) -> None:
        self._view, self._period, self._size = view, 1.0 / rate, size
        self._frames: list[NDArray[np.uint8]] = []
        self._next = 0.0

    @classmethod
    def named(cls, path: Path, view: View = CELL_VIEW) -> GifRecorder:
        """The recorder of a file.

        Args:
            path: The file.
            view: Where the camera stands.

        Returns:
            The recorder.

        Raises:
            InputError: If the film could not be written; raised before anything moves.
        """
        import importlib.util

        if path.suffix.lower() != ".gif":
            raise InputError(f"{path}: films are animated GIFs; give the file a name ending in .gif")
        if importlib.util.find_spec("PIL") is None:
            raise InputError(f"{path}: writing films needs pillow; install it with: pip install pillow")
        return cls(view)

    def look(self, engine: Engine, t: float) -> None:
        """Take a frame if one is due.

        Args:
            engine: The world.
            t: Simulated time, s.
        """
        if t >= self._next:
            self._frames.append(take_picture(engine, self._view, self._size))
            self._next = t + self._period

    def write(self, path: Path, replace: bool = True) -> None:
        """Write the frames that were taken so far.

        Args:
            path: The file.
            replace: Whether a file that exists may be replaced.

        Raises:
            InputError: If no frame was taken, or the file cannot be written.
        """
        from PIL import Image

        if path.suffix.lower() != ".gif":
            raise InputError(
                f"{path}: films are written as animated GIF; give the file a name ending in .gif"
            )
        if not self._frames:
            raise InputError(f"{path}: nothing was filmed, so there is nothing to write")
        frames = [Image.fromarray(frame).quantize(128) for frame in self._frames]
        duration = round(self._period * 1000)
        content = BytesIO()
        frames[0].save(
            content, format="GIF", save_all=True, append_images=frames[1:], duration=duration, loop=0
        )
        write_bytes(path, content.getvalue(), replace)
