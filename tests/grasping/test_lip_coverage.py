"""Cups across faces that are narrower than they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.cell.item import LEAST_SHARE
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import pose, rotation_axis_angle
from pickcli.grasping.grasp_target import GraspTarget
from pickcli.grasping.lip_coverage import bearing_share, kept_vacuum, lip_on
from pickcli.grasping.search import USUAL
from pickcli.grasping.suction_candidates import sample_suctions
from pickcli.grasping.suction_grasping import SuctionGrasping
from pickcli.grasping.surfaces import faces, narrow_faces, wide_faces
from pickcli.scene.scene import PoseNoise

CELL = load_cell("apc2016_delft")
TOOL, BIN = CELL.robot.tool, CELL.pod.bins["bin_E"]
BRUSH = CELL.item("oral_b_toothbrush_red")
FLAT = pose([0.25, 0.0, -0.05], rpy=[0.0, 0.0, 0.3])
NOISE = PoseNoise(0.002, np.radians(1.0))


@given(
    lean=st.floats(-0.12, 0.12),
    about=st.floats(0.0, np.pi),
    depth=st.floats(0.0, 0.006),
    x=st.floats(0.0, 0.05),
)
def test_a_leaning_cup_that_is_pressed_on_bears_what_it_bears_where_it_met_the_face(
    lean: float, about: float, depth: float, x: float
) -> None:
    """Pressed on along its axis, its lip is moved across the face, perhaps off an edge that it stands on."""
    item = CELL.item("kleenex_tissue_box")
    half = item.shape.extents / 2
    axis = np.array([np.cos(about), np.sin(about), 0.0])
    R = rotation_axis_angle(axis, np.pi + lean)
    T_met = pose([half[0] - x, half[1] - TOOL.cup.radius, half[2]], R=R)
    T_pressed = T_met @ pose([0.0, 0.0, depth])
    np.testing.assert_allclose(lip_on(item, "+z", T_pressed), T_met[:3, 3], atol=1e-12)
    method = SuctionGrasping(TOOL)
    share, pressed = (method.bears(item, "+z", T, NOISE).share for T in (T_met, T_pressed))
    assert share == pytest.approx(pressed, abs=1e-9)


@given(width=st.floats(0.005, 0.06), length=st.floats(0.04, 0.3))
def test_a_face_is_wide_or_narrow_or_too_narrow(width: float, length: float) -> None:
    item = replace(BRUSH, shape=Shape(ShapeKind.BOX, (length, width, 0.01)))
    inset = TOOL.cup.radius + item.seal_inset
    wide, narrow = ({face.name for face in found(item, TOOL)} for found in (wide_faces, narrow_faces))
    assert not wide & narrow
    assert ("+z" in wide) == (min(width, length) >= 2.0 * inset)
    if narrow:
        assert min(width, length) < 2.0 * inset
        (face,) = (face for face in faces(item, TOOL) if face.name == "+z")
        tip = face.region.centre()[:3, 3]
        assert kept_vacuum(item, "+z", tip, TOOL.cup) >= LEAST_SHARE


def test_the_cup_is_put_on_the_middle_line_within_what_pose_errors_allow() -> None:
    target = GraspTarget("brush", BRUSH, FLAT, BIN, NOISE)
    grasps = sample_suctions(target, TOOL, np.random.default_rng(0), USUAL)
    assert grasps.grasps
    for grasp in grasps.grasps:
        tip = grasp.T_item_tip[:3, 3]
        assert abs(tip[1]) < 1e-9
        assert abs(tip[0]) <= 2.0 * TOOL.cup.radius + 1e-9
        assert kept_vacuum(BRUSH, grasp.face, tip, TOOL.cup, NOISE) >= LEAST_SHARE


def test_too_large_an_error_is_told_with_what_the_pump_keeps() -> None:
    target = GraspTarget("brush", BRUSH, FLAT, BIN, PoseNoise(0.005, np.radians(1.0)))
    found = sample_suctions(target, TOOL, np.random.default_rng(0), USUAL)
    assert not found.grasps
    (reason,) = found.rejected
    assert reason.what == "does not seal"
    assert "of the vacuum, needs 22.5%" in reason.detail


def test_a_small_pump_holds_no_toothbrush() -> None:
    tool = load_cell("apc2016_kth_picking", "right").robot.tool
    assert faces(BRUSH, tool) == ()


def test_an_area_narrower_than_the_cup_is_held_across_as_a_face_is() -> None:
    """Whether edges are those of the box or of an area in it makes no difference."""
    shape = Shape(ShapeKind.BOX, (0.2, 0.08, 0.016))
    area = {"+z": {"y": (-0.0125, 0.0125)}}
    within = replace(BRUSH, shape=shape, seals={**BRUSH.seals, "-z": 0.0}, areas=area)
    (of_area,), (of_face, *_) = narrow_faces(within, TOOL), narrow_faces(BRUSH, TOOL)
    assert of_area.name == of_face.name == "+z"
    for y in (0.0, 0.002):
        tip = np.array([0.01, y, 0.008])
        shares = [bearing_share(item, "+z", tip, TOOL.cup, NOISE) for item in (within, BRUSH)]
        assert shares[0] == pytest.approx(shares[1])


def test_scissors_are_held_at_one_place_where_their_handles_meet() -> None:
    scissors = CELL.item("fiskars_scissors_red")
    for R, name in ((FLAT, "+z"), (FLAT @ pose([0.0, 0.0, 0.0], rpy=[np.pi, 0.0, 0.0]), "-z")):
        target = GraspTarget("scissors", scissors, R, BIN, NOISE)
        grasps = sample_suctions(target, TOOL, np.random.default_rng(0), USUAL).grasps
        assert grasps
        for grasp in grasps:
            assert grasp.face == name
            np.testing.assert_allclose(grasp.T_item_tip[:2, 3], [0.008, -0.002], atol=1e-3)
    small = load_cell("apc2016_kth_picking", "right")
    assert faces(small.item("fiskars_scissors_red"), small.robot.tool) == ()


@given(error=st.floats(0.0, 0.004))
def test_what_the_cup_bears_falls_with_the_vacuum_and_with_the_width(error: float) -> None:
    tip, noise = np.array([0.0, 0.0, 0.008]), PoseNoise(error)
    kept = kept_vacuum(BRUSH, "+z", tip, TOOL.cup, noise)
    lever = (0.0125 - error) / TOOL.cup.radius
    assert bearing_share(BRUSH, "+z", tip, TOOL.cup, noise) == pytest.approx(kept * lever)


def test_a_surely_covered_lip_keeps_the_seal_whatever_the_error() -> None:
    item = CELL.item("crayola_24_ct")
    face = next(face for face in wide_faces(item, TOOL) if item.seals[face.name] > 0.0)
    tip = face.region.centre()[:3, 3]
    assert bearing_share(item, face.name, tip, TOOL.cup, NOISE) == item.seals[face.name]


def test_an_error_that_leads_over_an_edge_costs_vacuum_on_wide_faces_too() -> None:
    """A face of 30 mm takes the whole cup if there is no inset, and no error."""
    item = replace(BRUSH, shape=Shape(ShapeKind.BOX, (0.2, 0.03, 0.03)), seal_inset=0.0)
    tip = np.array([0.0, 0.0, 0.015])
    assert kept_vacuum(item, "+z", tip, TOOL.cup) == item.seals["+z"]
    assert kept_vacuum(item, "+z", tip, TOOL.cup, NOISE) < 0.95 * item.seals["+z"]
    far = np.array([0.08, 0.0, 0.015])
    assert kept_vacuum(item, "+z", far, TOOL.cup, NOISE) < kept_vacuum(item, "+z", tip, TOOL.cup, NOISE)
