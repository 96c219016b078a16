"""Which solids count as near an item, against the distances that the verifier measures."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from pickcli.cell.cell_file import load_cell
from pickcli.geometry import Array, pose
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.statics.supports import supports_of
from pickcli.verification.fcl_solids import Solid

CELL = load_cell("apc2016_delft")
NOISE = PoseNoise(0.002, float(np.radians(1.0)))
NAMES = ("up_glucose_bottle", "dasani_water_bottle", "rawlings_baseball", "crayola_24_ct", "jane_eyre_dvd")
REACH = 0.0042  # m
TOLERANCE = 1e-4  # m, of both measures
FAR = 1.0  # m between centres, farther than any two of these items are long

parts, angles = st.floats(-1.0, 1.0), st.floats(-3.1, 3.1)
directions = st.tuples(parts, parts, parts).filter(lambda v: np.linalg.norm(v) > 0.1)
turns = st.tuples(angles, angles, angles).map(lambda rpy: pose(rpy=rpy))


def measured(a: PlacedItem, b: PlacedItem) -> float:
    solids = [Solid(each.item.shape) for each in (a, b)]
    for solid, each in zip(solids, (a, b), strict=True):
        solid.place(each.T_world_item)
    return solids[0].distance(solids[1])


@given(st.sampled_from(NAMES), st.sampled_from(NAMES), turns, turns, directions, st.floats(-5e-4, 5e-4))
@settings(max_examples=200, deadline=None)
def test_near_are_those_that_the_verifier_measures_as_near(
    a: str, b: str, T_a: Array, T_b: Array, direction: Array, off: float
) -> None:
    """Two items a little nearer to each other than the reach, or a little less near."""
    assume(abs(off) > TOLERANCE)
    one = PlacedItem("one", CELL.item(a), TOTE, T_a)
    across = np.array(direction) / np.linalg.norm(direction)
    limit = REACH + NOISE.bound(CELL.item(a)) + NOISE.bound(CELL.item(b))

    def other(way: float) -> PlacedItem:
        return PlacedItem("other", CELL.item(b), TOTE, pose(way * across) @ T_b)

    way = brentq(lambda s: measured(one, other(s)) - limit - off, 0.0, FAR, xtol=1e-6)
    scene = Scene(CELL, CELL.T_world_pod, (one, other(way)), NOISE)
    near = {contact.b: contact.gap for contact in supports_of(scene).graph.near("one", REACH)}
    assert ("other" in near) is (off < 0.0)
    assert abs(near.get("other", limit + off) - limit - off) < TOLERANCE


def test_round_solids_that_no_direction_of_the_batch_test_separates_are_not_near() -> None:
    """Two bottles across each other, 5.5 mm apart: every one of 20 directions sees them overlap."""
    one = PlacedItem("one", CELL.item("up_glucose_bottle"), TOTE, pose(rpy=(0.5, 1.0, 0.5)))
    T = pose(0.14 * np.array([0.7, 0.67, -0.25]), rpy=(-1.0, -0.8, 1.4))
    other = PlacedItem("other", CELL.item("dasani_water_bottle"), TOTE, T)
    apart = measured(one, other)
    assert 0.005 < apart < 0.006
    graph = supports_of(Scene(CELL, CELL.T_world_pod, (one, other), PoseNoise())).graph
    assert "other" not in {contact.b for contact in graph.near("one", REACH)}
    (gap,) = [contact.gap for contact in graph.near("one", 0.01) if contact.b == "other"]
    assert abs(gap - apart) < TOLERANCE
