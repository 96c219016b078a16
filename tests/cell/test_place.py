"""Places: what a bin and the tote have in common, and what makes them differ."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from pickcli.cell.cell import Cell
from pickcli.cell.place import Room
from pickcli.cell.station import POD, TOTE
from pickcli.geometry import pose
from pickcli.scene.scene import PoseNoise, Scene


def test_a_cell_has_its_bins_and_the_tote_as_places(cell: Cell) -> None:
    assert len(cell.pod.bins) == 12 and list(cell.places) == [*cell.pod.bins, "tote"]
    assert all(place.name == name for name, place in cell.places.items())


def test_the_way_in_leads_through_the_middle_of_the_mouth(cell: Cell) -> None:
    """Along +x into each bin, straight down into the tote, from a mouth that is level with its rim."""
    assert cell.pod.bins
    for cell_bin in cell.pod.bins.values():
        assert_allclose(cell_bin.access.direction, (1.0, 0.0, 0.0))
        assert_allclose(cell_bin.access.T_place_mouth[:3, 3], (0.0, 0.0, cell_bin.access.height / 2))
        assert not cell_bin.access.is_from_above
    access, room = cell.places["tote"].access, cell.places["tote"].room
    assert_allclose(access.direction, (0.0, 0.0, -1.0))
    assert_allclose(access.T_place_mouth[:3, 3], (0.0, 0.0, room.high[2]))
    R = access.T_place_mouth[:3, :3]
    assert_allclose(np.abs(R.T @ room.size)[1:], (access.width, access.height))
    assert_allclose(np.linalg.det(R), 1.0)
    assert access.is_from_above


def test_a_place_stands_where_its_carrier_does(cell: Cell) -> None:
    moved = cell.T_world_pod @ pose((0.01, 0.02, 0.0), rpy=(0.0, 0.0, 0.03))
    scene = Scene(cell, moved, (), PoseNoise())
    assert {place.carrier for place in cell.places.values()} == {POD, TOTE}
    for place in cell.places.values():
        T = scene.T_world_place(place)
        if place.carrier == POD:
            assert_allclose(T, moved @ place.T_carrier_place)
        else:
            assert_allclose(T, cell.T_world_place(place))


def test_every_place_knows_which_bodies_carry_what_lies_in_it(cell: Cell) -> None:
    pod, tote = ({body.name for body in bodies} for bodies in (cell.pod.bodies, cell.tote_bodies))
    assert cell.places and pod and tote
    for place in cell.places.values():
        assert place.support
        assert set(place.support) <= (pod if place.carrier == POD else tote)


@pytest.mark.parametrize("name", ["bin_A", "bin_K", "tote"])
def test_a_room_holds_what_is_between_its_corners_and_a_heap_above_an_open_one(cell: Cell, name: str) -> None:
    place = cell.places[name]
    low, high = place.room.low, place.room.high
    for axis in range(3):
        for edge, outwards in ((low, -1.0), (high, 1.0)):
            p = (low + high) / 2
            p[axis] = edge[axis] - 1e-6 * outwards
            assert place.holds(p)
            p[axis] = edge[axis] + 0.01 * outwards
            assert not place.holds(p)
            is_heap = axis == 2 and outwards > 0 and place.access.is_from_above
            assert place.holds(p, above=0.02) is is_heap


def test_a_box_has_a_level_floor_around_its_origin() -> None:
    room = Room.box(0.4, 0.6, 0.2)
    assert_allclose(room.low, (-0.2, -0.3, 0.0))
    assert_allclose(room.size, (0.4, 0.6, 0.2))
    assert room.volume == pytest.approx(0.048)
    height, pitch = room.rest(np.array([-0.1, 0.1]), np.array(0.05))
    assert_allclose(height, 0.0)
    assert_allclose(pitch, 0.0)
