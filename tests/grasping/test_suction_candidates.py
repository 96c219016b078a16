"""What candidates promise: cups whole on a face, the lance where the search wants it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.geometry import Array, is_pose, pose, rotation_axis_angle
from pickcli.grasping.grasp_target import GraspTarget
from pickcli.grasping.search import USUAL, WIDE_SEARCH, Search
from pickcli.grasping.suction_candidates import (
    LANCE_CLEAR,
    MAX_LEAN_ACROSS,
    MAX_LEAN_FROM_ABOVE,
    _tilt_over_the_lip,
    sample_suctions,
)
from pickcli.grasping.surfaces import faces, rolled, tilt_on, tilted
from pickcli.motion.plan import Grasp
from pickcli.scene.scene import TOTE
from support.tool_states import DOWN

CELL = load_cell("apc2016_delft")
TOOL, BIN = CELL.robot.tool, CELL.pod.bins["bin_E"]
TO_LANCE = TOOL.tip_to_lance(DOWN)
FLAT = pose([0.25, 0.0, -0.01], rpy=[0.0, 0.02, 0.3])
ON_EDGE = pose([0.2, 0.1, 0.01], rpy=[np.pi / 2, 0.0, 0.02])
ITEMS = [
    ("crayola_24_ct", FLAT),
    ("crayola_24_ct", ON_EDGE),
    ("rawlings_baseball", FLAT),
    ("folgers_classic_roast_coffee", FLAT),
    ("folgers_classic_roast_coffee", ON_EDGE),
]


def sampled(name: str, T: Array, search: Search, seed: int = 0) -> tuple[Grasp, ...]:
    item = CELL.item(name)
    rng = np.random.default_rng(seed)
    return sample_suctions(GraspTarget(name, item, T, BIN), TOOL, rng, search).grasps


@pytest.mark.parametrize("search", [USUAL, WIDE_SEARCH])
@pytest.mark.parametrize(("name", "T"), ITEMS)
def test_every_cup_is_whole_on_its_face_and_nearly_square(name: str, T: Array, search: Search) -> None:
    item = CELL.item(name)
    regions = {face.name: face.region for face in faces(item, TOOL)}
    grasps = sampled(name, T, search)
    assert grasps
    for grasp in grasps:
        assert is_pose(grasp.T_item_tip)
        assert tilt_on(grasp.face, grasp.T_item_tip) <= TOOL.cup.tilt + 1e-6
        at = np.abs(regions[grasp.face].displacement(grasp.T_item_tip)[:3])
        if grasp.face not in ("mantle", "sphere"):
            assert (at <= regions[grasp.face].bounds[:3, 1] + 1e-9).all()
        else:
            radius = np.linalg.norm(grasp.T_item_tip[: 3 if grasp.face == "sphere" else 2, 3])
            assert radius == pytest.approx(item.shape.size[0])
    assert list(grasps) == sorted(grasps, key=lambda g: g.score)


def test_a_grid_reaches_the_edges_of_a_face() -> None:
    region = next(f.region for f in faces(CELL.item("crayola_24_ct"), TOOL) if f.name == "+z")
    grasps = sampled("crayola_24_ct", FLAT, WIDE_SEARCH)
    places = np.array([region.displacement(g.T_item_tip)[:2] for g in grasps if g.face == "+z"])
    assert np.allclose([places.min(axis=0), places.max(axis=0)], region.bounds[:2].T)


def test_beside_an_item_the_lance_rises_towards_the_mouth_as_the_search_says() -> None:
    grasps = [g for g in sampled("crayola_24_ct", ON_EDGE, USUAL) if g.kind == "side"]
    lances = np.array([(ON_EDGE @ g.T_item_tip)[:3, 0] for g in grasps])
    assert (lances[:, 0] < 0.0).all()  # towards the mouth
    pitches = np.unique(np.round(np.arcsin(lances[:, 2]), 3))
    assert np.allclose(pitches, sorted(USUAL.pitches), atol=0.01)


@pytest.mark.parametrize(("search", "most"), [(USUAL, 119), (WIDE_SEARCH, 3588)])
def test_the_counts_of_the_search_bound_the_grasps(search: Search, most: int) -> None:
    """As docs/how-a-pick-works.md tells for a box that shows its front, top and both sides."""
    middle = pose([0.2, 0.0, 0.0])
    grasps = sampled("kleenex_tissue_box", middle, search)
    assert {g.face for g in grasps} == {"-x", "+z", "+y", "-y"}
    assert len(grasps) == most


@pytest.mark.parametrize(("name", "T"), ITEMS)
def test_the_same_seed_gives_the_same_candidates(name: str, T: Array) -> None:
    a, b = sampled(name, T, USUAL, 7), sampled(name, T, USUAL, 7)
    assert a and [g.score for g in a] == [g.score for g in b]
    assert all((g.T_item_tip == h.T_item_tip).all() for g, h in zip(a, b, strict=True))


LIMITED = ["woods_extension_cord", "clorox_utility_brush", "up_glucose_bottle"]  # in their areas


@pytest.mark.parametrize("search", [USUAL, WIDE_SEARCH])
@pytest.mark.parametrize("name", [*LIMITED, "dr_browns_bottle_brush"])
def test_the_whole_rim_is_on_the_part_of_the_face_that_seals(name: str, search: Search) -> None:
    """In an upright and a lying pose; the rim is checked point by point."""
    item = CELL.item(name, 2016)
    angles = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
    rim = TOOL.cup.radius * np.stack([np.cos(angles), np.sin(angles), np.zeros(32)], axis=1)
    seen = set()
    for T in (FLAT, ON_EDGE, pose([0.2, 0.0, 0.05], rpy=[0.0, np.pi / 2, 0.0])):
        for grasp in sampled(name, T, search):
            assert item.seals[grasp.face] > 0.0
            low, high = item.area(grasp.face)
            points = grasp.T_item_tip[:3, 3] + rim @ grasp.T_item_tip[:3, :3].T
            tilted = TOOL.cup.radius * (1.0 - np.cos(TOOL.cup.tilt)) + 1e-9
            assert ((points >= low - tilted) & (points <= high + tilted)).all()
            seen.add(grasp.face)
    assert seen


def test_no_candidate_is_on_a_face_that_does_not_seal() -> None:
    upright = pose([0.25, 0.0, 0.03])
    bowl = CELL.item("platinum_pets_dog_bowl", 2016)
    seals = {face: bowl.seals[face] for face in bowl.shape.face_names}
    item = replace(bowl, hollows=(), seals=seals)
    found = sample_suctions(
        GraspTarget(item.name, item, upright, BIN), TOOL, np.random.default_rng(0), WIDE_SEARCH
    )
    assert found.grasps == ()
    assert [reason.what for reason in found.rejected] == ["no face within reach"]
    lid_down = pose([0.25, 0.0, 0.03], rpy=[np.pi, 0.0, 0.0])
    assert {g.face for g in sampled(item.name, lid_down, USUAL)} == {"-z"}


def test_candidates_in_a_bowl_are_at_its_bottom_with_the_rim_inside_of_its_walls() -> None:
    item = CELL.item("platinum_pets_dog_bowl", 2016)
    (hollow,) = item.hollows
    grasps = sampled(item.name, pose([0.25, 0.0, 0.03]), WIDE_SEARCH)
    assert {g.face for g in grasps} == {"+z/bowl"}
    tips = np.array([g.T_item_tip[:3, 3] for g in grasps])
    np.testing.assert_allclose(tips[:, 2], item.height("+z/bowl"), atol=1e-12)
    assert hollow.radius is not None
    most = hollow.radius - TOOL.cup.radius - item.seal_inset
    assert 0.5 * most < np.hypot(tips[:, 0], tips[:, 1]).max() <= most + 1e-9


def test_the_best_grasp_of_a_box_is_next_to_its_centre_of_mass() -> None:
    best = next(g for g in sampled("staples_index_cards", FLAT, WIDE_SEARCH) if g.face == "+z")
    assert np.linalg.norm(best.T_item_tip[:2, 3]) < 0.005


@given(st.floats(-3.0, 3.0), st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3))
def test_turns_and_tilts_are_rotations_about_the_tool_s_own_axes(angle: float, rpy: list[float]) -> None:
    T = pose((0.1, -0.2, 0.3), rpy=rpy)
    for moved, axis in ((rolled(T, angle), (0.0, 0.0, 1.0)), (tilted(T, angle), (0.0, 1.0, 0.0))):
        np.testing.assert_allclose(moved, T @ pose(R=rotation_axis_angle(axis, angle)), atol=1e-12)
    assert (
        tilted(pose(), 0.1)[2, 0] < 0.0 < tilted(pose(rpy=(np.pi, 0.0, 0.0)), 0.1)[2, 0]
    )  # cup down: x rises


@given(st.floats(-0.1, 0.1), st.floats(0.0, 0.4), st.lists(st.floats(-0.3, 0.3), min_size=3, max_size=3))
def test_a_lance_is_tilted_by_the_first_step_that_takes_it_over_the_lip(
    height: float, depth: float, off: list[float]
) -> None:
    """Its axis runs over the tip as far as the tool says, towards the mouth along the tool's x axis."""
    pointing_down = pose(rpy=(0.0, np.pi, 0.0))  # its x axis towards the mouth
    T = pose((depth, 0.0, height)) @ pose(rpy=off) @ pointing_down
    most = 0.2

    def over_the_lip(tilt: float) -> float:
        now = tilted(T, tilt)
        on_axis, along = (now @ [*TO_LANCE, 1.0])[:3], now[:3, 0]
        return float((on_axis - on_axis[0] / along[0] * along)[2])

    spare = {tilt: over_the_lip(tilt) - LANCE_CLEAR for tilt in np.linspace(0.0, most, 5).tolist()}
    assume(min(map(abs, spare.values())) > 1e-9)
    clear = [tilt for tilt, over in spare.items() if over > 0.0]
    assert _tilt_over_the_lip(T, TO_LANCE, most) == pytest.approx(min(clear, default=0.0))


# From above


CRATES = load_cell("ur5e_crates")


def from_above(name: str, lean: float, turn: float, search: Search) -> tuple[Grasp, ...]:
    """Grasps of an item in a crate whose top leans over by an angle, towards where it is turned."""
    place, item = CRATES.places["crate_left"], CRATES.item(name)
    R = rotation_axis_angle((0.0, 0.0, 1.0), turn) @ rotation_axis_angle((0.0, 1.0, 0.0), lean)
    T_entry_item = np.linalg.inv(place.T_place_entry) @ pose([0.0, 0.0, 0.06], R=R)
    target = GraspTarget(name, item, T_entry_item, place)
    return sample_suctions(target, CRATES.robot.tool, np.random.default_rng(0), search).grasps


@given(st.floats(0.0, 1.5), st.floats(-np.pi, np.pi))
def test_from_above_a_cup_leans_over_with_the_face_and_is_named_by_its_axis(lean: float, turn: float) -> None:
    """Cards whose flats alone seal: where they stand on edge, there is no grasp."""
    grasps = from_above("staples_index_cards", lean, turn, USUAL)
    assert bool(grasps) == bool(lean <= MAX_LEAN_FROM_ABOVE)
    R = rotation_axis_angle((0.0, 0.0, 1.0), turn) @ rotation_axis_angle((0.0, 1.0, 0.0), lean)
    for grasp in grasps:
        x, y, z = R @ grasp.T_item_tip[:3, 2]
        assert np.arccos(-z) <= MAX_LEAN_FROM_ABOVE + 1e-6
        nearest = {"frontal": x, "top-down": -z, "side": abs(y)}
        assert nearest[grasp.kind] == max(nearest.values())


@given(st.floats(0.0, np.pi), st.floats(-np.pi, np.pi))
def test_from_above_a_cup_across_its_lance_meets_faces_that_are_nearly_upright(
    lean: float, turn: float
) -> None:
    """Cards whose flats alone seal, in a tote: the lance stands beside them, and leans no farther."""
    place, item = CELL.places[TOTE], CELL.item("staples_index_cards")
    R = rotation_axis_angle((0.0, 0.0, 1.0), turn) @ rotation_axis_angle((0.0, 1.0, 0.0), lean)
    T_entry_item = np.linalg.inv(place.T_place_entry) @ pose([0.0, 0.0, 0.06], R=R)
    target = GraspTarget("cards", item, T_entry_item, place)
    grasps = sample_suctions(target, TOOL, np.random.default_rng(0)).grasps
    across = [grasp for grasp in grasps if grasp.tool_state == DOWN]
    off = abs(lean - np.pi / 2)  # of the flats from upright
    assume(abs(off - MAX_LEAN_ACROSS) > 1e-6)
    assert bool(across) == (off < MAX_LEAN_ACROSS)
    for grasp in across:
        x, z = (R @ grasp.T_item_tip[:3, k] for k in (0, 2))
        assert abs(z[2]) <= np.sin(MAX_LEAN_ACROSS) + 1e-6  # the cup's axis is nearly level
        assert x[2] >= np.cos(2.0 * MAX_LEAN_ACROSS)  # the lance leaves the cup upwards


def test_a_cup_from_above_is_tilted_to_every_side_where_few_grasps_do_not_do() -> None:
    """So it stands nearly upright on a face that leans to any side by no more than it takes up."""
    lean = 0.9 * CRATES.robot.tool.cup.tilt
    for turn in np.arange(4) * np.pi / 2:
        R = rotation_axis_angle((0.0, 0.0, 1.0), turn) @ rotation_axis_angle((0.0, 1.0, 0.0), lean)
        axes = [R @ g.T_item_tip[:3, 2] for g in from_above("staples_index_cards", lean, turn, WIDE_SEARCH)]
        assert min(np.arccos(min(1.0, -axis[2])) for axis in axes) < 0.5 * lean


def test_into_a_bin_a_lance_leans_no_farther_than_before() -> None:
    flat = pose([0.25, 0.0, -0.01], rpy=[0.0, np.radians(35.0), 0.0])
    for search in (USUAL, WIDE_SEARCH):
        for grasp in sampled("crayola_24_ct", flat, search):
            along = (flat @ grasp.T_item_tip)[0, 2]
            assert grasp.kind != "frontal" or along >= np.cos(np.radians(30.0) + TOOL.cup.tilt + 1e-6)


def test_what_lies_on_a_side_says_how_far_its_faces_lean() -> None:
    place, item = CRATES.places["crate_left"], CRATES.item("staples_index_cards")
    on_edge = np.linalg.inv(place.T_place_entry) @ pose([0.0, 0.0, 0.06], rpy=[np.pi / 2, 0.0, 0.0])
    target = GraspTarget("cards", item, on_edge, place)
    (told,) = sample_suctions(target, CRATES.robot.tool, np.random.default_rng(0)).rejected
    assert str(told) == "cards: no face within reach: +z, -z lean by over 80 degrees, or point down"


@pytest.mark.parametrize("lean", [-75, -60, -45, -30, 30, 45, 60, 75])
def test_a_face_that_leans_to_a_side_is_met_by_a_lance_that_rolls(lean: float) -> None:
    """Into a bin: the cup faces the leaning face squarely, and the lance still lies along the way in."""
    T = pose([0.25, 0.0, 0.05], rpy=(np.radians(lean), 0.0, 0.0))
    grasps = sampled("jane_eyre_dvd", T, USUAL)
    kind = "top-down" if abs(lean) < 45 else "side"
    assert grasps and (abs(lean) == 45 or {grasp.kind for grasp in grasps} == {kind})
    for grasp in grasps:
        tip = (T @ grasp.T_item_tip)[:3, :3]
        assert abs(tip[:, 2] @ T[:3, 2]) >= np.cos(TOOL.cup.tilt + 1e-6)
        assert max(abs(tip[0, 2]), tip[2, 2]) <= np.sin(np.radians(25.0) + TOOL.cup.tilt)


@pytest.mark.parametrize(("pitch", "is_met"), [(20.0, True), (40.0, False)])
def test_a_lance_across_is_pitched_little(pitch: float, is_met: bool) -> None:
    T = pose([0.25, 0.0, 0.05], rpy=(0.0, np.radians(pitch), 0.0))  # its face leans into the bin
    assert bool(sampled("jane_eyre_dvd", T, USUAL)) is is_met
