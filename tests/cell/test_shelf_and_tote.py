"""The shelf's boxes against the figures measured on the pod's mesh, and against Delft's own bin meshes."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.makers.pod import FRONT_LEGS, REAR_LEGS
from pickcli.cell.place import Place
from pickcli.cell.shapes import Body
from pickcli.geometry import Array, inverse
from support.cell_copies import CellCopy

# Row: lip top, lower edge of the hanging lip, opening, floor behind the lip and at the back, ceiling.
ROWS = {
    "ABC": (1.5536, 1.7855, 0.2319, 1.5428, 1.5239, 1.8086),
    "DEF": (1.3250, 1.5188, 0.1938, 1.3142, 1.2953, 1.5418),
    "GHI": (1.0964, 1.2902, 0.1938, 1.0856, 1.0667, 1.3132),
    "JKL": (0.8297, 1.0616, 0.2319, 0.8189, 0.8000, 1.0846),
}
# Column: inside from and to, width of the mouth. y is left, so column 0 has positive y.
COLUMNS = ((0.1554, 0.4277, 0.249), (-0.1494, 0.1494, 0.2988), (-0.4277, -0.1554, 0.249))
CASES = [(f"bin_{letter}", row, i) for row in ROWS for i, letter in enumerate(row)]
RESOLUTION = 1.5e-4  # m, of the figures


def spans(bodies: tuple[Body, ...], point: Array, direction: Array) -> list[tuple[float, float]]:
    """Where the line point + t * direction runs inside a box, as intervals of t."""
    found = []
    for body in bodies:
        T = inverse(body.T_parent_shape)
        p, d = T[:3, :3] @ point + T[:3, 3], T[:3, :3] @ direction
        half = np.array(body.shape.size) / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.sort(np.array([(-half - p) / d, (half - p) / d]), axis=0)
        parallel = abs(d) < 1e-12
        if np.any(parallel & (abs(p) > half)):
            continue
        low, high = t[0][~parallel].max(), t[1][~parallel].min()
        if low < high:
            found.append((float(low), float(high)))
    return found


def free_span(cell: Cell, point: Array, axis: int) -> tuple[float, float]:
    """The free interval of a coordinate around a point of the pod frame that lies in the free."""
    inside = spans(cell.pod.bodies, point, np.eye(3)[axis])
    assert not any(low < 0 < high for low, high in inside), f"{point} is inside a body"
    below = max((high for _, high in inside if high <= 0), default=-np.inf)
    above = min((low for low, _ in inside if low >= 0), default=np.inf)
    return float(point[axis] + below), float(point[axis] + above)


def in_bin(cell_bin: Place, x: float, y: float, z: float) -> Array:
    return np.asarray(cell_bin.T_carrier_place[:3, 3] + (x, y, z))


@pytest.mark.parametrize(("name", "row", "column"), CASES)
def test_openings_floors_and_ceilings_are_as_measured(cell: Cell, name: str, row: str, column: int) -> None:
    b = cell.pod.bins[name]
    lip, hanging, opening, front, back, ceiling = ROWS[row]
    middle = b.access.height / 2
    low, high = free_span(cell, in_bin(b, 0.0105, 0.0, middle), axis=2)
    assert (low, high) == pytest.approx((lip, hanging), abs=RESOLUTION)
    assert high - low == pytest.approx(opening, abs=RESOLUTION)
    low, high = free_span(cell, in_bin(b, 0.0185, 0.0, middle), axis=2)
    assert low == pytest.approx(front, abs=1e-3)  # some millimetres behind the lip
    assert high == pytest.approx(ceiling, abs=1.2e-3)
    assert free_span(cell, in_bin(b, 0.40, 0.0, middle), axis=2)[0] == pytest.approx(back, abs=RESOLUTION)


@pytest.mark.parametrize(("name", "row", "column"), CASES)
def test_mouths_and_insides_are_as_wide_as_measured(cell: Cell, name: str, row: str, column: int) -> None:
    b = cell.pod.bins[name]
    inner, outer, mouth = COLUMNS[column]
    low, high = free_span(cell, in_bin(b, 0.2, 0.0, 0.1), axis=1)
    assert (low, high) == pytest.approx((inner, outer), abs=RESOLUTION)
    assert (low - b.T_carrier_place[1, 3], high - b.T_carrier_place[1, 3]) == pytest.approx(b.room.y_range)
    assert b.access.width == pytest.approx(mouth, abs=5e-4)
    at_post = free_span(cell, in_bin(b, 0.01, 0.0, 0.1), axis=1)
    assert at_post[1] - at_post[0] >= mouth - 5e-4
    if column != 1:
        assert max(map(abs, at_post)) == pytest.approx(0.4043, abs=RESOLUTION)


@pytest.mark.parametrize(("name", "row", "column"), CASES)
def test_the_bin_describes_its_own_boxes(cell: Cell, name: str, row: str, column: int) -> None:
    b = cell.pod.bins[name]
    for x in np.linspace(0.02, 0.43, 12):
        low, high = free_span(cell, in_bin(b, x, 0.0, 0.1), axis=2)
        assert (low - b.T_carrier_place[2, 3], high - b.T_carrier_place[2, 3]) == pytest.approx(
            (float(b.room.floor_at(x)), float(b.room.ceiling_at(x))), abs=2e-4
        )
    assert free_span(cell, in_bin(b, 0.3, 0.0, 0.1), axis=0)[1] == pytest.approx(b.room.depth)
    p = in_bin(b, 0.2, 0.0, 0.1)
    assert [n for n, each in cell.pod.bins.items() if each.holds(p - each.T_carrier_place[:3, 3])] == [name]


@pytest.mark.parametrize(("name", "row", "column"), CASES)
def test_floors_agree_with_delfts_bin_meshes(cell: Cell, name: str, row: str, column: int) -> None:
    """Theirs: 11 mm under the lip at 4.1 mm behind the face, 29.7 mm under it from 0.2142 m further on."""
    b = cell.pod.bins[name]
    for x in np.linspace(0.02, 0.42, 9):
        theirs = -0.011 + min((x - 0.0041) / 0.2142, 1.0) * (-0.0297 + 0.011)
        ours = free_span(cell, in_bin(b, x, 0.0, 0.1), axis=2)[0] - b.T_carrier_place[2, 3]
        assert -2e-4 < ours - theirs < 1e-3  # never lower: what is free here is free there


def test_outside_the_pod_is_as_large_as_measured(cell: Cell) -> None:
    corners = []
    for body in cell.pod.bodies:
        T, half = body.T_parent_shape, np.array(body.shape.size) / 2
        reach = abs(T[:3, :3]) @ half
        corners += [T[:3, 3] - reach, T[:3, 3] + reach]
    lower, upper = np.min(corners, axis=0), np.max(corners, axis=0)
    np.testing.assert_allclose(upper - lower, (0.8842, 0.8795, 2.3673), atol=1e-9)
    np.testing.assert_allclose(lower, (0.0, -0.8795 / 2, 0.0), atol=1e-9)


LEGS = "  legs: {width: 0.03545, depth: 0.020}\n"


def is_solid(cell: Cell, x: float, y: float, z: float) -> bool:
    point = np.array([x, y, z])
    return any(low < 0 < high for low, high in spans(cell.pod.bodies, point, np.array([0.0, 0.0, 1.0])))


def solids_at(cell: Cell, z: float) -> set[tuple[float, float]]:
    """Where on a raster of 10 mm over the pod and its surroundings something is at a height."""
    xs, ys = np.meshgrid(np.linspace(-0.045, 0.935, 99), np.linspace(-0.485, 0.485, 98))
    points = np.column_stack([xs.ravel(), ys.ravel(), np.full(xs.size, z), np.ones(xs.size)])
    is_solid = np.zeros(len(points), dtype=bool)
    for body in cell.pod.bodies:
        local = (points @ inverse(body.T_parent_shape).T)[:, :3]
        is_solid |= (np.abs(local) < np.array(body.shape.size) / 2).all(axis=1)
    return {(float(x), float(y)) for x, y in points[is_solid, :2]}


@pytest.mark.parametrize("z", [0.01, 0.4, 0.68, 0.79])
@pytest.mark.parametrize(("name", "arm"), [("apc2016_delft", None), ("apc2016_kth_picking", "right")])
def test_below_the_lowest_board_there_are_four_legs_and_nothing_else(
    name: str, arm: str | None, z: float
) -> None:
    """KTH's slice is 0.63 to 0.73 m over the floor."""
    at = solids_at(load_cell(name, arm), z)
    assert at == {(x, y) for x, y in at if (x < 0.02 or x > 0.8642) and 0.4043 < abs(y) < 0.43975}
    assert {(x > 0.4, y > 0.0) for x, y in at} == {(False, False), (False, True), (True, False), (True, True)}


def test_legs_carry_what_is_over_them(cell: Cell) -> None:
    """Where a leg ends the pod begins, and what it carries is closed to below."""
    bodies = {body.name: body for body in cell.pod.bodies}
    for name in (*FRONT_LEGS, *REAR_LEGS):
        middle, half = bodies[name].T_parent_shape[:3, 3], np.array(bodies[name].shape.size) / 2
        assert middle[2] - half[2] == pytest.approx(0.0) and middle[2] + half[2] == pytest.approx(0.7990)
        assert is_solid(cell, middle[0], middle[1], 0.8)
    for x, y in ((0.1, 0.0), (0.3, 0.3), (0.43, -0.42), (0.7, 0.2)):
        assert free_span(cell, np.array([x, y, 0.5]), axis=2)[1] < 0.82


def test_a_pod_without_legs_is_solid_to_the_floor_as_before(cell: Cell, cell_copy: CellCopy) -> None:
    cell_copy.yaml.replace(LEGS, "")
    solid = cell_copy.load()
    assert len(solids_at(solid, 0.4)) > len(solids_at(cell, 0.79)) * 20
    assert free_span(solid, np.array([-0.2, 0.0, 0.4]), axis=0)[1] == pytest.approx(0.0)
    bottom, others = solid.pod.bins["bin_K"], solid.pod.bins["bin_H"]
    assert "body_below" in bottom.support and "body_below" not in others.support
    for name, each in cell.pod.bins.items():
        np.testing.assert_array_equal(each.T_carrier_place, solid.pod.bins[name].T_carrier_place)
    assert solid.fingerprint != cell.fingerprint


def test_legs_may_end_under_a_body_below_the_lowest_board(cell_copy: CellCopy) -> None:
    cell_copy.yaml.replace(LEGS, LEGS.replace("}", ", height: 0.7}"))
    cell = cell_copy.load()
    assert free_span(cell, np.array([0.2, 0.0, 0.5]), axis=2) == pytest.approx((-np.inf, 0.7))
    assert is_solid(cell, 0.2, 0.0, 0.75) and not is_solid(cell, 0.2, 0.0, 0.69)
    assert "body_below" in cell.pod.bins["bin_J"].support


def test_floors_are_named_and_no_two_bodies_alike(cell: Cell) -> None:
    names = [body.name for body in cell.pod.bodies]
    assert len(names) == len(set(names))
    assert cell.pod.bins
    for b in cell.pod.bins.values():
        assert b.support and set(b.support) <= set(names)


def test_names_of_all_bodies_are_their_own(cell: Cell) -> None:
    links = [link.name for link in cell.robot.links]
    bodies = [b.name for b in (*cell.pod.bodies, *cell.tote_bodies, *cell.obstacles.bodies)]
    assert len({*links, *bodies}) == len(links) + len(bodies)


def test_the_tote_is_open_above_and_closed_elsewhere(cell: Cell) -> None:
    floor_centre = cell.places["tote"].T_carrier_place[:3, 3]
    np.testing.assert_allclose(floor_centre, (-1.0455, -0.6165, 0.580), atol=1e-9)
    np.testing.assert_allclose(cell.places["tote"].room.size, (0.539, 0.359, 0.201), atol=1e-9)
    middle = floor_centre + np.array([0.0, 0.0, 0.1])
    for axis, half in ((0, 0.539 / 2), (1, 0.359 / 2)):
        ends = [t for span in spans(cell.tote_bodies, middle, np.eye(3)[axis]) for t in span]
        assert min(abs(t) for t in ends) == pytest.approx(half)
    up = spans(cell.tote_bodies, middle, np.array([0.0, 0.0, 1.0]))
    assert max(high for _, high in up) == pytest.approx(-0.1)
    rim = spans(cell.tote_bodies, floor_centre + np.array([0.0, 0.0, 0.19]), np.array([1.0, 0.0, 0.0]))
    assert max(high for _, high in rim) == pytest.approx(-0.737 + 1.0455)
