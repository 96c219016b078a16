"""Places of a cell's own: solids around free rooms, names, fingerprints, mistakes told where they stand."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.place import Place
from pickcli.cell.shapes import ShapeKind
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse
from support.cell_copies import CellCopy
from support.place_cells import BENCH, CRATES, NICHE, RACK, with_places

NAMES = ("crate_left", "crate_right", "rack_1_1", "rack_1_2", "rack_2_1", "rack_2_2", "bench", "niche")
INSIDE = 0.003  # m from a surface
N_PROBES = 400


@pytest.fixture
def own(cell_copy: CellCopy) -> Cell:
    return with_places(cell_copy, CRATES, RACK, BENCH, NICHE).load()


def bodies_at(cell: Cell, place: Place, points: Array) -> list[frozenset[str]]:
    """Names of the bodies of a place's carrier that each of the points (N, 3) of the place's frame is in."""
    found: list[set[str]] = [set() for _ in points]
    in_carrier = points @ place.T_carrier_place[:3, :3].T + place.T_carrier_place[:3, 3]
    for body in cell.carriers[place.carrier].bodies:
        T = inverse(body.T_parent_shape)
        p = in_carrier @ T[:3, :3].T + T[:3, 3]
        if body.shape.kind is ShapeKind.BOX:
            is_in = (np.abs(p) <= body.shape.extents / 2).all(axis=1)
        else:
            radius, length = body.shape.size
            is_in = (np.hypot(p[:, 0], p[:, 1]) <= radius) & (np.abs(p[:, 2]) <= length / 2)
        for k in np.flatnonzero(is_in):
            found[k].add(body.name)
    return [frozenset(names) for names in found]


def probes(place: Place) -> Array:
    """(N, 3) points all over the room, INSIDE of its floor, ceiling and walls, and behind a lip."""
    room, rng = place.room, np.random.default_rng(1)
    lip = 0.015 if place.name.startswith("rack") else 0.0
    x = rng.uniform(room.x_range[0] + lip + INSIDE, room.x_range[1] - INSIDE, N_PROBES)
    y = rng.uniform(room.y_range[0] + INSIDE, room.y_range[1] - INSIDE, N_PROBES)
    low, high = room.floor_at(x) + INSIDE, room.ceiling_at(x) - INSIDE
    return np.column_stack([x, y, low + (high - low) * rng.random(N_PROBES)])


def test_a_cell_without_a_tote_has_its_bins_and_its_own_places(own: Cell) -> None:
    assert own.tote is None
    assert list(own.places) == [*own.pod.bins, *NAMES]
    assert [place.carrier for place in own.places.values()][12:] == [
        "crate_left", "crate_right", "rack", "rack", "rack", "rack", "bench", "niche"
    ]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_the_room_is_free_and_its_support_carries_it(own: Cell, name: str) -> None:
    place = own.places[name]
    points = probes(place)
    assert not any(bodies_at(own, place, points))
    below = points.copy()
    below[:, 2] = place.room.floor_at(points[:, 0]) - INSIDE
    assert place.support and all(set(place.support) & names for names in bodies_at(own, place, below))


@pytest.mark.parametrize(
    "name", ["crate_left", "crate_right", "rack_1_1", "rack_1_2", "rack_2_1", "rack_2_2"]
)
def test_walls_stand_where_the_room_ends(own: Cell, name: str) -> None:
    place = own.places[name]
    points, room = probes(place), place.room
    sides = [(1, room.y_range[0] - INSIDE), (1, room.y_range[1] + INSIDE), (0, room.x_range[1] + INSIDE)]
    if place.access.is_from_above:
        sides.append((0, room.x_range[0] - INSIDE))
    for axis, at in sides:
        beyond = points.copy()
        beyond[:, axis] = at
        assert all(bodies_at(own, place, beyond)), (axis, at)
    if not place.access.is_from_above:  # under the next board, or the top
        above = points.copy()
        above[:, 2] = room.ceiling_at(points[:, 0]) + INSIDE
        assert all(bodies_at(own, place, above))


@pytest.mark.parametrize("name", NAMES)
def test_the_way_through_the_mouth_is_free(own: Cell, name: str) -> None:
    place = own.places[name]
    access, rng = place.access, np.random.default_rng(2)
    width, height = (side / 2 - INSIDE for side in (access.width, access.height))
    in_mouth = np.column_stack(
        [rng.uniform(*ends, N_PROBES) for ends in ((-0.1, 0.004), (-width, width), (-height, height))]
    )  # fmt: skip
    if name == "bench":
        in_mouth[:, 0] = -np.abs(in_mouth[:, 0]) - INSIDE  # the mouth is the top itself
    T = access.T_place_mouth
    assert not any(bodies_at(own, place, in_mouth @ T[:3, :3].T + T[:3, 3]))


def test_walls_keep_things_in_a_crate_and_not_on_a_bench(own: Cell) -> None:
    assert own.places["crate_left"].is_open_box and not own.places["bench"].is_open_box


def test_names_of_a_grid_may_be_stated(cell_copy: CellCopy) -> None:
    named = RACK.replace("depth: 0.35", "depth: 0.35, names: [[top_left, top_right], [low_left, low_right]]")
    cell = with_places(cell_copy, CRATES, named).load()
    assert list(cell.places)[-4:] == ["top_left", "top_right", "low_left", "low_right"]
    assert (
        cell.places["top_left"].T_carrier_place[1, 3] > 0.0 > cell.places["top_right"].T_carrier_place[1, 3]
    )
    assert cell.places["top_left"].T_carrier_place[2, 3] > cell.places["low_left"].T_carrier_place[2, 3]


@pytest.mark.parametrize(
    ("old", "new"),
    [("xyz: [-0.9,", "xyz: [-0.91,"), ("0.24, 0.14]", "0.24, 0.13]"), ("yaw: 0.02", "yaw: 0.03"),
     ("floor_slope: 0.06", "floor_slope: 0.05"), ("upper: [0.4, 0.25, 0.4]", "upper: [0.4, 0.25, 0.39]")],
)  # fmt: skip
def test_the_fingerprint_follows_every_figure(own: Cell, cell_copy: CellCopy, old: str, new: str) -> None:
    text = cell_copy.yaml.path.read_text()
    assert old in text
    cell_copy.yaml.path.write_text(text.replace(old, new, 1))
    assert cell_copy.load().fingerprint != own.fingerprint


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("kind: box, T_world_place: {xyz: [-0.9", "kind: bin, T_world_place: {xyz: [-0.9",
         'crate_left.kind: expected bodies, box, conveyor, grid or table, got "bin"; correct it'),
        ("{kind: box, T_world_place: {xyz: [-0.9", "{T_world_place: {xyz: [-0.9",
         "crate_left.kind: expected bodies, box, conveyor, grid or table, got nothing; add it"),
        ("inner: [0.3, 0.24", "innner: [0.3, 0.24", "innner: unknown key; did you mean 'inner'?"),
        ("inner: [0.3, 0.24, 0.14], wall_thickness: 0.006}\n  crate_r", "wall_thickness: 0.006}\n  crate_r",
         "crate_left.inner: expected m, clear inside [x, y, z], z from the inner floor to the rim, got"),
        ("inner: [0.3, 0.24", "inner: [300, 0.24", "lengths are in m, not mm"),
        ("rpy: [0, 0, 0.2]", "rpy: [0.3, 0, 0.2]", "stands upright, only its yaw is free"),
        ("columns: [0.3, 0.26]", "columns: [0.3, 0.26], names: [[a, b], [c]]", "expected 2 lists of 2"),
        ("columns: [0.3, 0.26]", "columns: [0.3, 0.26], names: [[a, b], [c, a]]",
         "places.rack.names[1][1]: the name 'a' stands twice"),
        ("crate_right:", "rack_1_2:", "places.rack: the name 'rack_1_2' stands twice"),
        ("columns: [0.3, 0.26]", "columns: [0.3, 0.26], names: [[a, b], [c, bin_A]]", "'bin_A' stands twice"),
        ("crate_right:", "pod:", "'pod' is the name of something else in cells; rename it"),
        ("support: [niche_floor]", "support: [niche_flor]", "no body of this place is named 'niche_flor'"),
        ("name: niche_post", "name: niche_left", "the name 'niche_left' stands twice; rename one"),
        ("name: niche_post", "name: cabinet_low", "'cabinet_low' has the name of another one in the cell"),
        ("box: [0.4, 0.5, 0.02]", "mesh: no.stl", "no.stl"),
        ("box: [0.4, 0.5, 0.02]", "mesh: ../no.stl", "expected a path inside the cell's folder"),
        ("box: [0.4, 0.5, 0.02]", "xyzw: 3", "unknown key; did you mean 'xyz'?"),
        (", box: [0.4, 0.5, 0.02]", "", "expected one of box, cylinder or mesh, got nothing"),
        ("access: front", "access: front\n    lip: 0.4", "expected a lip lower than the room"),
        ("lip: {height: 0.015", "lip: {height: 0.3", "expected a lip lower than its row, 0.25 m; got 0.3"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_where_it_stands(
    own: Cell, cell_copy: CellCopy, old: str, new: str, told: str
) -> None:
    assert own.places
    line = cell_copy.yaml.replace(old, new)
    with pytest.raises(InputError) as caught:
        cell_copy.load()
    assert told in str(caught.value)
    where = [int(text.split(":")[1]) for text in str(caught.value).splitlines()]
    assert any(0 <= at - line <= 8 or 0 <= line - at <= 12 for at in where)
    assert str(caught.value).count("\n") <= 1


def test_a_mesh_becomes_boxes_around_its_convex_pieces(cell_copy: CellCopy) -> None:
    """An L of two blocks: neither piece is as large as the whole."""
    corners = [(0, 0), (0.4, 0), (0.4, 0.1), (0.1, 0.1), (0.1, 0.4), (0, 0.4)]
    lines = [f"v {x} {y} {z}" for z in (0.0, 0.1) for x, y in corners]
    lines += ["f 3 2 1", "f 4 3 1", "f 5 4 1", "f 6 5 1", "f 7 8 9", "f 7 9 10", "f 7 10 11", "f 7 11 12"]
    for k in range(6):
        a, b = k + 1, (k + 1) % 6 + 1
        lines += [f"f {a} {b} {b + 6}", f"f {a} {b + 6} {a + 6}"]
    (cell_copy.folder / "corner.obj").write_text("\n".join(lines) + "\n")
    mesh = NICHE.replace("box: [0.4, 0.5, 0.02], xyz: [0.2, 0, -0.01]", "mesh: corner.obj, xyz: [0, 0, -0.1]")
    cell = with_places(cell_copy, CRATES, mesh).load()
    pieces = [body for body in cell.carriers["niche"].bodies if body.name.startswith("niche_floor")]
    assert len(pieces) > 1
    assert cell.places["niche"].support == tuple(body.name for body in pieces)
    assert sum(body.shape.volume for body in pieces) < 0.011
