"""Slices of depth pictures as a laser scanner would scan them: against things whose place is known."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse, pose
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.planar_scan import FINEST, PlanarScan, ScannedThing
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene, RenderedSolid

CAMERA = PinholeCamera(400.0, 400.0, 319.5, 239.5, 640, 480)
LEVEL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # along x of the slice


def post(x: float, y: float, width: float, top: float = 2.0) -> RenderedSolid:
    shape = Shape(ShapeKind.BOX, (width, width, top))
    return RenderedSolid(OwnerKind.CARRIER, "post", shape, pose((x, y, top / 2)))


def pipe(x: float, y: float) -> RenderedSolid:
    return RenderedSolid(
        OwnerKind.CARRIER, "pipe", Shape(ShapeKind.CYLINDER, (0.025, 2.0)), pose((x, y, 1.0))
    )


def scanned(*solids: RenderedSolid, T_slice_camera: Array | None = None) -> PlanarScan:
    T = pose((0.0, 0.0, 1.0), R=LEVEL) if T_slice_camera is None else T_slice_camera
    depth = RenderedScene(solids).seen_by(CAMERA, T).depth
    return PlanarScan.of(DepthPicture(CAMERA, T, depth), inverse(T), 0.9, 1.1)


def the_one(scan: PlanarScan) -> ScannedThing:
    (thing,) = scan.things
    return thing


@pytest.mark.parametrize("y", [-0.5, 0.0, 0.31])
@pytest.mark.parametrize("turned", [(0.0, 0.0), (0.2, 0.0), (0.0, 0.15), (-0.1, -0.1)])
def test_a_pipe_is_where_it_is_however_the_camera_is_held(y: float, turned: tuple[float, float]) -> None:
    T = pose((0.0, 0.0, 1.05), R=LEVEL) @ pose(rpy=(turned[0], 0.0, turned[1]))
    thing = the_one(scanned(pipe(1.5, y), T_slice_camera=T))
    middle = np.array([1.5, y])
    # Half of its surface that is seen is nearer than 0.87 of its radius before the middle.
    near = middle * (1.0 - 0.866 * 0.025 / np.linalg.norm(middle))
    assert np.linalg.norm(thing.point - near) < 0.002
    assert thing.width == pytest.approx(0.05, abs=0.01)
    assert thing.is_whole and thing.n_returns > 200


def test_what_is_above_or_below_the_slice_is_not_scanned() -> None:
    assert scanned(post(1.5, 0.0, 0.3, top=0.89)).things == ()
    hanging = RenderedSolid(
        OwnerKind.CARRIER, "bar", Shape(ShapeKind.BOX, (0.1, 0.4, 0.2)), pose((1.5, 0.0, 1.21))
    )
    assert scanned(hanging).things == ()


def test_things_at_other_ranges_are_apart_and_in_order_of_their_bearing() -> None:
    scan = scanned(post(3.5, 0.0, 2.0), pipe(1.5, 0.2), pipe(1.5, -0.2))
    ranges = [thing.range for thing in scan.things]
    assert [r < 1.6 for r in ranges] == [False, True, False, True, False]
    bearings = [thing.bearing for thing in scan.things]
    assert bearings == sorted(bearings)


def test_of_a_thing_that_something_nearer_hides_in_part_it_is_said() -> None:
    behind, before = sorted(
        scanned(post(1.5, 0.0, 0.08), post(1.0, 0.03, 0.03)).things, key=lambda thing: -thing.range
    )
    assert not behind.is_whole and before.is_whole
    assert behind.width < 0.07


def test_a_stray_return_before_a_thing_does_not_tear_it() -> None:
    T = pose((0.0, 0.0, 1.0), R=LEVEL)
    depth = RenderedScene((post(1.5, 0.0, 0.1),)).seen_by(CAMERA, T).depth
    whole = the_one(PlanarScan.of(DepthPicture(CAMERA, T, depth), inverse(T), 0.9, 1.1))
    depth[240, 318] = 1.2
    assert the_one(PlanarScan.of(DepthPicture(CAMERA, T, depth), inverse(T), 0.9, 1.1)).extent == whole.extent


def test_nothing_measured_is_nothing_scanned() -> None:
    T = pose((0.0, 0.0, 1.0), R=LEVEL)
    depth = np.full((CAMERA.height, CAMERA.width), np.nan, np.float32)
    assert PlanarScan.of(DepthPicture(CAMERA, T, depth), inverse(T), 0.9, 1.1).things == ()


def test_bearings_are_as_fine_as_pixels_and_no_finer_than_those_of_kth() -> None:
    assert scanned(post(1.5, 0.0, 0.1)).step == pytest.approx(1 / 400)
    fine = PinholeCamera(3000.0, 3000.0, 319.5, 239.5, 640, 480)
    picture = DepthPicture(fine, np.eye(4), np.ones((480, 640), np.float32))
    assert PlanarScan.of(picture, np.eye(4), 0.9, 1.1).step == FINEST
