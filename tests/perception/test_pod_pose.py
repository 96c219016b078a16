"""The pod's pose from one depth picture: exact without noise, and with it within the stated bounds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.pod_pose import AT_WAIST, SENSORS, Draw, draw, measure
from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import Displacement, displaced, yaw_of
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse, pose, rotation_angle, rotation_axis_angle
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.pod_pose import EXACT, PodEstimate, locate_pod
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene
from pickcli.scene.scene import Scene
from support.cell_copies import CellCopy
from support.scene_files import make_scene

KINECT = read_sensor(sensor_file("kinect_v2"))
assert KINECT.depth is not None
NOISE = KINECT.depth
# Camera frame at the waist of a robot before the pod: z ahead, x right, y down.
T_WAIST = np.array([[0, 0, 1, -1.45], [-1, 0, 0, 0.1], [0, -1, 0, 1.25], [0, 0, 0, 1]], dtype=np.float64)
T_MIDDLE = np.array([[0, 0, 1, -1.45], [-1, 0, 0, 0.0], [0, -1, 0, 1.25], [0, 0, 0, 1]], dtype=np.float64)
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


def exact_picture(cell: Cell, scene: Scene, T_world_camera: Array = T_WAIST) -> DepthPicture:
    view = rendered(cell, scene).seen_by(KINECT.camera, T_world_camera)
    return DepthPicture(KINECT.camera, T_world_camera, view.depth)


def located(drawn: Draw, cell: Cell, mount: MountError = EXACT) -> tuple[PodEstimate, Array]:
    """The estimate, and the true pod in its frame."""
    found = locate_pod(drawn.picture, cell, drawn.noise, mount)
    return found, inverse(found.T_world_pod) @ drawn.T_world_pod


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (0.013, -0.037, 0.02), *CORNERS])
def test_without_noise_it_is_found_anywhere_in_its_tolerance(
    cell: Cell, shift: tuple[float, float, float]
) -> None:
    scene = shifted(cell, *shift)
    found = locate_pod(exact_picture(cell, scene), cell, NOISE)
    off = inverse(scene.T_world_pod) @ found.T_world_pod
    assert off[2, 3] == pytest.approx(0.0, abs=1e-12)  # it stays on the floor, and upright
    np.testing.assert_allclose(off[:3, 2], [0.0, 0.0, 1.0], atol=1e-12)
    assert np.hypot(*off[:2, 3]) < 5e-4 and rotation_angle(off[:3, :3]) < np.radians(0.03)


@pytest.mark.parametrize("sensor", SENSORS)
@pytest.mark.parametrize("k", range(3))
def test_with_noise_all_errors_are_within_their_bounds(cell: Cell, sensor: str, k: int) -> None:
    found, off = located(draw(cell, sensor, 20161, k, EXACT), cell)
    assert found.error.allows(off)
    assert found.error.x < 1e-3 and found.error.y < 2e-3 and found.error.yaw < np.radians(0.15)
    for y in (-0.44, 0.44):
        end = np.array([0.0, y, 0.0])
        assert np.linalg.norm(off[:3, :3] @ end + off[:3, 3] - end) <= found.front_error


@pytest.mark.parametrize("sensor", ["kinect_v2", "ensenso"])
@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_bounds_hold_for_a_camera_that_is_off_by_the_most_that_is_stated(
    cell: Cell, sensor: str, axis: int, way: float
) -> None:
    mount = MountError(0.002, 0.004)
    drawn = draw(cell, sensor, 20162, axis, EXACT)
    along = way * np.eye(3)[axis % 3]
    off = pose(mount.position * along) if axis < 3 else pose(R=rotation_axis_angle(along, mount.angle))
    picture = replace(drawn.picture, T_world_camera=drawn.picture.T_world_camera @ off)
    found, true = located(replace(drawn, picture=picture), cell, mount)
    assert found.error.allows(true)
    exact, _ = located(replace(drawn, picture=picture), cell)
    assert min(found.error.x - exact.error.x, found.error.y - exact.error.y) > mount.position / 2


def test_moving_world_and_guess_moves_the_estimate(cell: Cell) -> None:
    drawn = draw(cell, "kinect_v2", 20163, 0, EXACT)
    first, _ = located(drawn, cell)
    W = pose((1.2, -0.7, 0.3), rpy=(0.0, 0.0, 2.0))
    picture = replace(drawn.picture, T_world_camera=W @ drawn.picture.T_world_camera)
    moved = locate_pod(picture, cell, drawn.noise, T_world_guess=W @ cell.T_world_pod)
    np.testing.assert_allclose(moved.T_world_pod, W @ first.T_world_pod, atol=1e-6)
    np.testing.assert_allclose(moved.front_error, first.front_error, rtol=1e-3)


@pytest.mark.parametrize("shift", [(0.02, 0.03, 0.01), (-0.03, 0.05, -0.04)])
def test_the_mirrored_picture_gives_the_mirrored_pose(cell: Cell, shift: tuple[float, float, float]) -> None:
    x, y, yaw = shift
    scene = replace(shifted(cell, x, y, yaw), items=())  # the pod is its own mirror image
    picture = exact_picture(cell, scene, T_MIDDLE)
    camera = replace(picture.camera, cx=picture.camera.width - 1 - picture.camera.cx)
    mirrored = DepthPicture(camera, T_MIDDLE, np.ascontiguousarray(picture.depth[:, ::-1]))
    one, other = (
        inverse(cell.T_world_pod) @ locate_pod(each, cell, NOISE).T_world_pod for each in (picture, mirrored)
    )
    np.testing.assert_allclose(other[:2, 3], one[:2, 3] * [1.0, -1.0], atol=2e-4)
    assert yaw_of(other) == pytest.approx(-yaw_of(one), abs=2e-4)


def test_the_same_picture_gives_the_same_bytes(cell: Cell) -> None:
    drawn = draw(cell, "kinect_v2", 20164, 0, EXACT)
    (first, _), (again, _) = (located(drawn, cell) for _ in range(2))
    assert first.T_world_pod.tobytes() == again.T_world_pod.tobytes()
    assert first.error == again.error
    assert 0.5 < first.explained <= 1.0 and first.n_pixels > 1000


def test_depth_is_read_in_steps_as_well(cell: Cell) -> None:
    """A picture in steps of 0.1 mm says the same."""
    drawn = draw(cell, "kinect_v2", 20165, 0, EXACT)
    steps = drawn.picture.in_steps
    depth = np.where(steps > 0, 1e-4 * steps, np.nan).astype(np.float32)
    (one, _), (other, _) = (
        located(replace(drawn, picture=picture), cell)
        for picture in (drawn.picture, replace(drawn.picture, depth=depth))
    )
    np.testing.assert_allclose(other.T_world_pod, one.T_world_pod, atol=1e-4)


def test_what_is_no_pod_is_refused(cell: Cell) -> None:
    camera = KINECT.camera
    rng = np.random.default_rng(0)
    clutter = rng.uniform(1.0, 2.2, (camera.height, camera.width)).astype(np.float32)
    with pytest.raises(InputError, match=r"two places, .* explain the picture as well"):
        locate_pod(DepthPicture(camera, T_WAIST, clutter), cell, NOISE)
    with pytest.raises(InputError, match="has no pod"):
        locate_pod(DepthPicture(camera, T_WAIST, clutter), load_cell("ur5e_crates"), NOISE)


def test_a_plane_before_the_pod_is_refused(cell: Cell, cell_copy: CellCopy) -> None:
    """It shows nothing of y: another place explains it as well, or any, if most of the front is flat."""
    wall = np.full((KINECT.camera.height, KINECT.camera.width), 1.45, np.float32)
    with pytest.raises(InputError, match=r"two places, .* explain the picture as well"):
        locate_pod(DepthPicture(KINECT.camera, T_WAIST, wall), cell, NOISE)
    cell_copy.yaml.replace("  legs: {width: 0.03545, depth: 0.020}\n", "")  # the front is closed to the floor
    with pytest.raises(InputError, match="pixels along y tell where it is"):
        locate_pod(DepthPicture(KINECT.camera, T_WAIST, wall), cell_copy.load(), NOISE)


@pytest.mark.parametrize("beyond", [(0.09, 0.0, 0.0), (0.0, 0.08, 0.0), (0.0, 0.0, 0.09)])
def test_a_pod_beyond_its_tolerance_is_refused(cell: Cell, beyond: tuple[float, float, float]) -> None:
    with pytest.raises(InputError, match="beyond its tolerance"):
        locate_pod(exact_picture(cell, shifted(cell, *beyond)), cell, NOISE)


def test_a_pod_that_may_stand_a_bin_aside_is_refused(cell: Cell) -> None:
    """Bins look alike: the nearest divider may be another one's."""
    far = replace(cell, pod=replace(cell.pod, displacement=Displacement(0.05, 0.3, 0.05)))
    with pytest.raises(InputError, match=r"narrow pod\.displacement.y"):
        locate_pod(exact_picture(cell, shifted(cell, 0.0, 0.0, 0.0)), far, NOISE)


@pytest.mark.filterwarnings("error")
def test_a_pod_that_can_only_turn_and_slide_aside_stays_where_it_is_along_x(cell: Cell) -> None:
    fixed = replace(cell, pod=replace(cell.pod, displacement=Displacement(0.0, 0.05, 0.05)))
    found = locate_pod(exact_picture(cell, shifted(cell, 0.0, 0.02, 0.01)), fixed, NOISE)
    assert abs((inverse(cell.T_world_pod) @ found.T_world_pod)[0, 3]) < 1e-3


@pytest.mark.parametrize("mount", [MountError(0.15, 0.0), MountError(0.0, 0.1)])
def test_bounds_that_no_scene_may_state_are_refused(cell: Cell, mount: MountError) -> None:
    with pytest.raises(InputError, match="calibrate its mount"):
        locate_pod(exact_picture(cell, shifted(cell, 0.0, 0.0, 0.0)), cell, NOISE, mount)


def test_a_part_of_the_picture_is_known_less_well_or_refused(cell: Cell) -> None:
    drawn = draw(cell, "kinect_v2", 20166, 0, EXACT)
    errors = [located(drawn, cell)[0].error.y]
    for share in (0.5, 0.25, 0.1, 0.02):
        depth = drawn.picture.depth.copy()
        depth[int(share * len(depth)) :] = np.nan
        try:
            found, off = located(replace(drawn, picture=replace(drawn.picture, depth=depth)), cell)
        except InputError as refusal:
            assert "pod not located" in str(refusal)
            continue
        assert found.error.allows(off)
        errors.append(found.error.y)
    assert errors == sorted(errors) and 1 < len(errors) < 5


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda depth: np.full_like(depth, np.nan), "nothing was measured in any pixel"),
        (lambda depth: depth[:-1], "512 x 423 px, but the camera has 512 x 424"),
        (lambda depth: 1000.0 * depth, "is it in another unit, as mm"),
        (lambda depth: 0.001 * depth, "is it in another unit"),
        (lambda depth: np.where(np.isnan(depth), np.inf, depth), "must be above 0 and finite"),
        (lambda depth: np.where(np.isnan(depth), 0.0, depth), "must be above 0 and finite"),
    ],
)
def test_bad_pictures_are_refused(cell: Cell, change, told: str) -> None:  # type: ignore[no-untyped-def]
    picture = draw(cell, "kinect_v2", 20167, 0, EXACT).picture
    bad = replace(picture, depth=change(picture.depth).astype(np.float32))
    with pytest.raises(InputError, match=told):
        locate_pod(bad, cell, NOISE)
    askew = replace(picture, T_world_camera=np.diag([2.0, 1.0, 1.0, 1.0]))
    with pytest.raises(InputError, match="no rigid pose"):
        locate_pod(askew, cell, NOISE)


@pytest.mark.slow
@pytest.mark.parametrize("sensor", SENSORS)
def test_bounds_are_kept_on_fresh_draws(sensor: str) -> None:
    mount = load_cell("apc2016_delft").cameras["hand"].error
    for off in (EXACT, mount):
        found = measure(sensor, 100, 20168, off, any_view=False)
        assert found["failures"] == 0 and found["bounds_kept"] >= 0.99
    assert measure(sensor, 50, 20169, EXACT, any_view=False)["yaw_deg_p95"] < (
        0.1 if sensor in AT_WAIST else 0.05
    )
