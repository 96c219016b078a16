"""What is touched: faces that are those of the cell's solids, and room for the lip on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.calibration.tote_shape import ToteShape, tote_shape
from pickcli.calibration.touch_points import N_FIRST, touch_points
from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell, load_workcell
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse

LIP = 0.015


@pytest.fixture(scope="module", params=["apc2016_delft", "apc2016_kth"])
def cell(request: pytest.FixtureRequest) -> Cell:
    return load_workcell(request.param).preferred


@pytest.fixture
def shape(cell: Cell) -> ToteShape:
    return tote_shape(cell)


def distances(cell: Cell, p: Array) -> dict[str, float]:
    """Signed distance of a point of the world to each solid of the tote, by name."""
    assert cell.tote is not None
    found = {}
    for body in cell.tote.bodies:
        out = np.abs((inverse(body.T_parent_shape) @ [*p, 1.0])[:3]) - body.shape.extents / 2
        found[body.name] = float(np.linalg.norm(np.maximum(out, 0.0)) + min(0.0, out.max()))
    return found


@pytest.mark.parametrize("n", [6, 8, 10])
def test_points_are_on_a_solid_of_the_face_and_the_lip_is_before_it(
    cell: Cell, shape: ToteShape, n: int
) -> None:
    for aim in touch_points(shape, n, LIP):
        T = shape.T_world_tote
        at = distances(cell, (T @ [*aim.point, 1.0])[:3])
        nearest = min(at, key=lambda name: abs(at[name]))
        assert abs(at[nearest]) < 1e-9 and nearest in aim.face.bodies
        before = (T @ [*(aim.point + 0.01 * aim.face.normal), 1.0])[:3]
        assert min(distances(cell, before).values()) == pytest.approx(0.01)
        behind = (T @ [*(aim.point - 0.001 * aim.face.normal), 1.0])[:3]
        assert min(distances(cell, behind).values()) < 0.0


def test_the_whole_lip_is_on_the_face(cell: Cell, shape: ToteShape) -> None:
    for aim in touch_points(shape, 10, LIP):
        across = np.cross(aim.face.normal, aim.face.along)
        for angle in np.arange(0.0, 2 * np.pi, 0.5):
            rim = LIP * (np.cos(angle) * aim.face.along + np.sin(angle) * across)
            p = (shape.T_world_tote @ [*(aim.point + rim - 1e-4 * aim.face.normal), 1.0])[:3]
            assert min(distances(cell, p).values()) < 0.0


def test_the_first_touches_fix_x_y_and_yaw_and_each_has_a_name_of_its_own(shape: ToteShape) -> None:
    for n in (6, 7, 8, 9, 10):
        aims = touch_points(shape, n, LIP)
        assert len(aims) == n == len({aim.name for aim in aims})
        first = np.array([[*aim.face.normal[:2], np.cross(aim.point, aim.face.normal)[2]] for aim in aims])
        assert np.linalg.matrix_rank(first[:N_FIRST], tol=1e-3) == 3
        assert sum(aim.face.name.startswith("rim") for aim in aims) == 3


@pytest.mark.parametrize("n", [5, 11, 0, -1])
def test_other_numbers_of_touches_are_refused(shape: ToteShape, n: int) -> None:
    with pytest.raises(InputError, match=f"--touches {n}: expected 6 to 10"):
        touch_points(shape, n, LIP)


def test_a_rim_without_room_for_the_lip_is_refused(shape: ToteShape) -> None:
    with pytest.raises(InputError, match="no two opposite sides as wide as the lip \\(60 mm\\)"):
        touch_points(shape, 8, 0.03)


def test_a_flat_tote_is_refused(shape: ToteShape) -> None:
    flat = {side: replace(face, width=0.06) for side, face in shape.walls.items()}
    with pytest.raises(InputError, match="the tote is 60 mm deep: too flat"):
        touch_points(replace(shape, walls=flat), 8, LIP)


def test_a_cell_without_a_tote_is_refused() -> None:
    with pytest.raises(InputError, match="ur5e_crates: has no tote to be located"):
        tote_shape(load_cell("ur5e_crates"))
