"""Pictures and films of a world."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pickcli.errors import InputError
from pickcli.files.atomic_write import write_bytes
from pickcli.scene.scene import Scene
from pickcli.simulation.camera_view import CELL_VIEW, POD_VIEW, TOTE_VIEW, View, view_of
from pickcli.simulation.engine import Engine
from pickcli.simulation.scene_bodies import add_items, add_statics

SMALL = (480, 360)  # pixels


def take_picture(engine: Engine, view: View, size: tuple[int, int] = (960, 720)) -> NDArray[np.uint8]:
    """Take a colour picture of a world.

    Args:
        engine: The world.
        view: The camera's view.
        size: Width and height in pixels.

    Returns:
        (height, width, 3).
    """
    return engine.picture(view.eye, view.target, view.fov, size)


def overview(engine: Engine, scene: Scene) -> NDArray[np.uint8]:
    """Take a picture of the cell; with a pod, beside pictures of bins and tote without the robot.

    Args:
        engine: The world.
        scene: The scene of the world.

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
    """Take a picture of a scene without the robot.

    Args:
        scene: The scene.
        view: The camera's view; by default ``view_of`` the scene.
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


class GifRecorder:
    """Frames at a fixed rate of simulated time, written as an animated GIF.

    Args:
        view: The camera's view.
        rate: Frames per simulated second.
        size: Width and height in pixels.
    """

    def __init__(self, view: View = CELL_VIEW, rate: float = 8.0, size: tuple[int, int] = (480, 360)) -> None:
        self._view, self._period, self._size = view, 1.0 / rate, size
        self._frames: list[NDArray[np.uint8]] = []
        self._next = 0.0

    @classmethod
    def named(cls, path: Path, view: View = CELL_VIEW) -> GifRecorder:
        """Create the recorder for a file.

        Args:
            path: The file.
            view: The camera's view.

        Returns:
            The recorder.

        Raises:
            InputError: The film could not be written; raised before anything moves.
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
        """Write the frames taken so far.

        Args:
            path: The file.
            replace: Whether an existing file may be replaced.

        Raises:
            InputError: No frame was taken, or the file cannot be written.
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
