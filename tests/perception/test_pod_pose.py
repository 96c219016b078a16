"""The pod's pose from one depth picture: exact without noise, and known to millimetres with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import displaced
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse, rotation_angle
from pickcli.perception.depth_picture import DepthPicture, measure_depth
from pickcli.perception.pod_pose import locate_pod
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene
from pickcli.scene.scene import Scene
from support.scene_files import make_scene

KINECT = read_sensor(sensor_file("kinect_v2"))
# Camera frame at the waist of a robot before the pod: z ahead, x right, y down.
T_WAIST = np.array([[0, 0, 1, -1.45], [-1, 0, 0, 0.1], [0, -1, 0, 1.25], [0, 0, 0, 1]], dtype=np.float64)
CORNERS = [(x, y, yaw) for x in (-0.05, 0.05) for y in (-0.05, 0.05) for yaw in (-0.0523, 0.0523)]


def shifted(cell: Cell, x: float, y: float, yaw: float) -> Scene:
    """A box in every bin, and pod and boxes displaced."""
    scene = make_scene(cell)
    T = displaced(cell.T_world_pod, x, y, yaw)
    moved = T @ inverse(scene.T_world_pod)
    items = (replace(p, T_world_item=moved @ p.T_world_item) for p in scene.items if p.location != "tote")
    return replace(scene, T_world_pod=T, items=tuple(items))


def rendered(cell: Cell, scene: Scene) -> RenderedScene:
    home = cell.configurations["home"]
    solids = RenderedScene.of(scene, home.q, home.tool_state).solids
    return RenderedScene(tuple(solid for solid in solids if solid.kind is not OwnerKind.LINK))


def errors(cell: Cell, scene: Scene, picture: DepthPicture) -> tuple[float, float]:
    """m along the floor and rad that the estimate is off."""
    off: Array = inverse(scene.T_world_pod) @ locate_pod(picture, cell).T_world_pod
    assert off[2, 3] == pytest.approx(0.0, abs=1e-12)  # it stays on the floor, and upright
    np.testing.assert_allclose(off[:3, 2], [0.0, 0.0, 1.0], atol=1e-12)
    return float(np.hypot(*off[:2, 3])), rotation_angle(off[:3, :3])


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (0.013, -0.037, 0.02), *CORNERS])
def test_without_noise_it_is_found_anywhere_in_its_tolerance(
    cell: Cell, shift: tuple[float, float, float]
) -> None:
    scene = shifted(cell, *shift)
    view = rendered(cell, scene).seen_by(KINECT.camera, T_WAIST)
    position, angle = errors(cell, scene, DepthPicture(KINECT.camera, T_WAIST, view.depth))
    assert position < 5e-4 and angle < np.radians(0.03)


@pytest.mark.parametrize("seed", range(6))
def test_with_noise_it_is_known_to_two_millimetres(cell: Cell, seed: int) -> None:
    rng = np.random.default_rng([seed, 20161])
    scene = shifted(cell, *rng.uniform(-1.0, 1.0, 3) * [0.05, 0.05, 0.0523])
    position, angle = errors(cell, scene, measure_depth(rendered(cell, scene), KINECT, T_WAIST, seed))
    assert position < 2.5e-3 and angle < np.radians(0.15)


def test_the_same_picture_gives_the_same_bytes(cell: Cell) -> None:
    scene = shifted(cell, 0.02, 0.01, -0.01)
    picture = measure_depth(rendered(cell, scene), KINECT, T_WAIST, 1)
    first, again = (locate_pod(picture, cell) for _ in range(2))
    assert first.T_world_pod.tobytes() == again.T_world_pod.tobytes()
    assert 0.5 < first.explained <= 1.0 and first.n_points > 1000


def test_what_is_no_pod_is_refused(cell: Cell) -> None:
    camera = KINECT.camera
    empty = DepthPicture(camera, T_WAIST, np.full((camera.height, camera.width), np.nan, np.float32))
    with pytest.raises(InputError, match="only 0 points are measured around it"):
        locate_pod(empty, cell)
    rng = np.random.default_rng(0)
    clutter = rng.uniform(1.0, 2.2, (camera.height, camera.width)).astype(np.float32)
    with pytest.raises(InputError, match="of the points around it lie on it"):
        locate_pod(DepthPicture(camera, T_WAIST, clutter), cell)
    with pytest.raises(InputError, match="has no pod"):
        locate_pod(empty, load_cell("ur5e_crates"))
