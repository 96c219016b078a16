"""Pictures and films."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL.GifImagePlugin import GifImageFile

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.errors import InputError
from pickcli.files.png_file import write_png
from pickcli.scene.cloud import Cloud
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.simulation.camera import GifRecorder, picture_of, take_picture
from pickcli.simulation.camera_view import CELL_VIEW, view_of, view_of_motion
from pickcli.simulation.engine import Engine
from pickcli.simulation.scene_bodies import add_statics
from pickcli.simulation.world import World
from support.pedestal import BuildWorld


def test_a_picture_shows_something_and_is_the_same_twice(build_world: BuildWorld, tmp_path: Path) -> None:
    from PIL import Image

    world = build_world()
    one, two = (take_picture(world.engine, CELL_VIEW, (160, 120)) for _ in range(2))
    assert one.shape == (120, 160, 3)
    assert np.array_equal(one, two)
    assert len(np.unique(one.reshape(-1, 3), axis=0)) > 20
    write_png(one, tmp_path / "picture.png")
    assert np.array_equal(np.asarray(Image.open(tmp_path / "picture.png")), one)


def test_a_film_has_a_frame_per_period(build_world: BuildWorld, tmp_path: Path) -> None:
    from PIL import Image

    world = build_world()
    film = GifRecorder(rate=10.0, size=(80, 60))
    world.act("cup_pivot", "straight")
    world.wait(0.1)  # until it has turned by more than a pixel: frames that are alike are stored once
    world.wait(0.35, lambda w: film.look(w.engine, w.t))
    film.write(tmp_path / "film.gif")
    with Image.open(tmp_path / "film.gif") as image:
        assert isinstance(image, GifImageFile) and image.n_frames == 4
        assert image.info["duration"] == 100


def test_a_film_that_cannot_be_written_is_refused_before_it_is_shot(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="animated GIF"):
        GifRecorder.named(tmp_path / "film.mp4")
    with pytest.raises(InputError, match="nothing was filmed"):
        GifRecorder().write(tmp_path / "film.gif")


def test_a_cloud_is_seen_and_met_by_nothing(cell: Cell) -> None:
    """A cube of points before the shelf, in a colour of its own, and no body for the physics."""
    y, z = np.meshgrid(np.arange(-0.2, 0.2, 0.01), np.arange(1.2, 1.6, 0.01))
    points = np.column_stack([np.full(y.size, -0.3), y.ravel(), z.ravel()])
    bare = Scene(cell, cell.T_world_pod, (), PoseNoise())
    seen = replace(bare, cloud=Cloud(Path("wall.npy"), np.eye(4), points, 0.005, 0.0))
    changed = np.any(picture_of(bare) != picture_of(seen), axis=2)
    assert 0.02 < changed.mean() < 0.5
    home = cell.configurations["home"].q
    worlds = World(bare, home), World(seen, home)
    for world in worlds:
        world.wait(0.02)
    assert worlds[0].q.tobytes() == worlds[1].q.tobytes()
    ray = np.array([[-1.0, 0.0, 1.4]]), np.array([[1.0, 0.0, 1.4]])
    assert worlds[0].engine.ray_faces(*ray) == worlds[1].engine.ray_faces(*ray)


def test_no_wall_hides_the_motion_that_is_filmed() -> None:
    panda = load_cell("panda_table")
    home = panda.configurations["home"].q
    view = view_of_motion(panda, home[None])
    world = World(Scene(panda, panda.T_world_pod, (), PoseNoise()), home)
    try:
        seen = np.array([world.tip[:3, 3], world.robot.T_world_base[:3, 3] + (0.0, 0.0, 0.3)])
        hits = world.engine.ray_faces(np.tile(view.eye, (2, 1)), seen)
    finally:
        world.close()
    assert [name for name, *_ in hits] == ["", ""]


def test_no_wall_hides_the_places_of_a_picture() -> None:
    panda = load_cell("panda_table")
    scene = Scene(panda, panda.T_world_pod, (), PoseNoise())
    view, engine = view_of(scene), Engine(1e-3)
    try:
        add_statics(engine, scene)
        middles = np.array([panda.T_world_place(place)[:3, 3] for place in panda.places.values()])
        hits = engine.ray_faces(np.tile(view.eye, (3, 1)), middles - (0.0, 0.0, 1e-3))
    finally:
        engine.close()
    assert [name for name, *_ in hits] == ["mat_front_top", "mat_right_top", "tray_floor"]
