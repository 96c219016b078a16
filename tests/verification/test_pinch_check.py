"""Two fingers hold an item: what the pads meet and bear, counted by hand, on both sides of every bound."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tool import MOVING, ToolState
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.errors import Reason
from pickcli.geometry import GRAVITY, Array, inverse, pose
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import HeldItem, PlacedItem, PoseNoise, Scene
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.hold_choice import check_hold, load_ratios
from pickcli.verification.pinch_check import Pads, check_pinch, pads_on
from support.gripper_cell import CLOSED, FORCE, FRICTION, OPEN, PAD, WIDEST

STEP = PAD[0] / 15  # m between the points of a pad, which is square; the outermost are half of it inside
OUTERMOST = 7 * STEP
BOX = Shape(ShapeKind.BOX, (0.1, 0.06, 0.08))
CAN = Shape(ShapeKind.CYLINDER, (0.03, 0.08))
BALL = Shape(ShapeKind.SPHERE, (0.03,))
ERASER = "expo_dry_erase_board_eraser"
K = SegmentKind


@pytest.fixture
def gripper(gripper_cell: Cell) -> ParallelGripper:
    found = gripper_cell.robot.tool.gripper
    assert found is not None
    return found


def on(shape: Shape, T: Array, gripper: ParallelGripper) -> Pads:
    found = pads_on(shape, T, gripper)
    assert found is not None
    return found


# What the pads meet


@pytest.mark.parametrize(
    ("shape", "T", "width"),
    [
        (BOX, pose(), 0.06),
        (BOX, pose(rpy=(0.0, 0.0, np.pi / 2)), 0.1),
        (BOX, pose(rpy=(np.pi / 2, 0.0, 0.0)), 0.08),
        (BOX, pose((0.02, 0.0, -0.015), rpy=(0.0, 0.7, 0.0)), 0.06),
        (BOX, pose((0.02, 0.021, -0.015)), 0.06),
        (CAN, pose(rpy=(np.pi / 2, 0.0, 0.0)), 0.08),
        (CAN, pose((0.01, 0.0, 0.013), rpy=(-np.pi / 2, 0.0, 0.0)), 0.08),
    ],
)
def test_between_flat_faces_all_of_the_pads_touches(
    shape: Shape, T: Array, width: float, gripper: ParallelGripper
) -> None:
    pads = on(shape, T, gripper)
    assert pads.width == pytest.approx(width, abs=1e-9)
    assert (pads.share, len(pads.points)) == (1.0, 225)
    assert pads.steepest == pytest.approx(0.0, abs=1e-6)
    assert_allclose(pads.points.max(axis=0), OUTERMOST)
    assert_allclose(pads.points.min(axis=0), -OUTERMOST)


@pytest.mark.parametrize(
    ("T", "n_x", "n_z"),
    [
        (pose((0.0503, 0.0, 0.0)), 7, 15), (pose((-0.0503, 0.0, 0.0)), 7, 15),
        (pose((0.0, 0.0, 0.0403)), 15, 7), (pose((0.0503, 0.0, -0.0403)), 7, 7),
    ],
)  # fmt: skip
def test_what_stands_out_over_a_face_touches_nothing(
    T: Array, n_x: int, n_z: int, gripper: ParallelGripper
) -> None:
    pads = on(BOX, T, gripper)
    assert [len(np.unique(pads.points[:, k].round(6))) for k in (0, 1)] == [n_x, n_z]
    assert pads.share == pytest.approx(n_x * n_z / 225)
    assert pads.width == pytest.approx(0.06, abs=1e-9)


@pytest.mark.parametrize("angle", [0.03, -0.03])
def test_rubber_gives_way_by_half_a_millimetre(angle: float, gripper: ParallelGripper) -> None:
    """The faces turned about z: where one stands out at one end, the other does at the other."""
    pads = on(BOX, pose(rpy=(0.0, 0.0, angle)), gripper)
    touching = np.abs(np.arange(-7, 8)) * STEP <= 0.0005 / np.tan(0.03) - OUTERMOST
    assert pads.share == pytest.approx(touching.mean())
    assert pads.width == pytest.approx(0.06 / np.cos(angle) + 2 * OUTERMOST * np.tan(0.03), abs=1e-9)
    assert pads.steepest == pytest.approx(0.03, abs=1e-6)
    assert pads_on(BOX, pose(rpy=(0.0, 0.0, 3 * angle)), gripper) is None


@pytest.mark.parametrize("lower", [0.0, 0.02])
def test_round_sides_touch_as_far_as_they_stand_back_by_that(lower: float, gripper: ParallelGripper) -> None:
    reach = np.sqrt(0.03**2 - (0.03 - 0.0005) ** 2)
    x, z = (grid.ravel() for grid in np.meshgrid(*[np.arange(-7, 8) * STEP] * 2))
    for shape, T, off in (
        (CAN, pose((0.0, 0.0, lower)), np.abs(x)),
        (CAN, pose((0.0, lower, 0.0)), np.abs(x)),
        (BALL, pose((0.0, lower, 0.0)), np.hypot(x, z)),
    ):
        pads, touches = on(shape, T, gripper), off <= reach
        assert pads.share == pytest.approx(touches.mean())
        assert pads.width == pytest.approx(0.06, abs=1e-9)
        assert pads.steepest == pytest.approx(np.arcsin(off[touches].max() / 0.03), abs=1e-6)


def test_a_ball_beside_its_middle_is_met_at_a_slope(gripper: ParallelGripper) -> None:
    """Only the column next to its middle stands out: the others are over half a millimetre behind it."""
    pads = on(BALL, pose((0.025, 0.0, 0.0)), gripper)
    x = pads.points[:, 0] + 0.025
    assert x.min() == pytest.approx(0.025 - OUTERMOST)
    half = np.sqrt(0.03**2 - (0.025 - OUTERMOST) ** 2)
    assert pads.width == pytest.approx(2 * half, abs=1e-9)
    at = np.sqrt(0.03**2 - x**2 - pads.points[:, 1] ** 2)
    assert (at >= half - 0.0005 - 1e-9).all()
    assert pads.steepest == pytest.approx(np.arccos(at.min() / 0.03), abs=1e-6)


@pytest.mark.parametrize("shape", [BOX, CAN, BALL])
@pytest.mark.parametrize("xyz", [(0.2, 0.0, 0.0), (0.0, 0.0, 0.2)])
def test_beside_an_item_there_is_nothing(
    shape: Shape, xyz: tuple[float, float, float], gripper: ParallelGripper
) -> None:
    assert pads_on(shape, pose(xyz), gripper) is None


# What the pads bear

CORNERS = np.array([[-0.01, -0.006], [-0.01, 0.006], [0.01, -0.006], [0.01, 0.006]])
BOTH, GRIPS, LEVER = 2 * FORCE, 2 * FORCE * FRICTION, float(np.hypot(0.01, 0.006))


@pytest.mark.parametrize("middle", [(0.0, 0.0), (0.003, -0.002)])
@pytest.mark.parametrize(
    ("wrench", "ratio"),
    [
        ((8.0, 0.0, 6.0, 0.0, 0.0, 0.0), 10.0 / GRIPS),
        ((0.0, 0.0, 0.0, 0.0, -0.2, 0.0), 0.2 / (GRIPS * LEVER)),
        ((6.0, 0.0, 0.0, 0.0, 0.1, 0.0), np.hypot(6.0 / GRIPS, 0.1 / (GRIPS * LEVER))),
        ((0.0, -20.0, 0.0, 0.0, 0.0, 0.0), 20.0 / BOTH),
        ((0.0, 0.0, 0.0, 0.3, 0.0, 0.0), 0.3 / (BOTH * 0.006)),
        ((0.0, 0.0, 0.0, 0.0, 0.0, 0.3), 0.3 / (BOTH * 0.01)),
        ((0.0, 20.0, 0.0, 0.12, 0.0, 0.2), (20.0 + np.hypot(0.12 / 0.006, 0.2 / 0.01)) / BOTH),
    ],
)  # fmt: skip
def test_pads_bear_shear_and_twist_by_friction_and_the_rest_by_their_pressure(
    wrench: tuple[float, ...], ratio: float, middle: tuple[float, float], gripper: ParallelGripper
) -> None:
    """About the middle of what touches, wherever on the pads that is."""
    pads = Pads(0.06, CORNERS + middle, 0.0, 1.0)
    w = np.array(wrench)
    about_tip = np.append(w[:3], w[3:] + np.cross([middle[0], 0.0, middle[1]], w[:3]))
    assert pads.ratio(np.array([about_tip, np.zeros(6)]), gripper) == pytest.approx([ratio, 0.0])


# A plan that rests: the item is taken, held and let go where the arm stands

MASS = 0.1


class Hold:
    """A box between the pads of an arm that rests at home, and the plan that takes and holds it there."""

    def __init__(self, cell: Cell, T_item_tip: Array | None = None, **item: Any) -> None:
        self.cell, self.T_item_tip = cell, pose() if T_item_tip is None else T_item_tip
        self.item = replace(cell.item(ERASER), **{"shape": BOX, "mass": MASS, "mass_error": 0.0, **item})
        self.q = np.asarray(cell.configurations["home"].q)
        self.tip = tip_poses(cell.robot, link_poses(cell.robot, self.q[None]), OPEN)[0]

    def scene(self, held: Array | None = None) -> Scene:
        placed = PlacedItem(ERASER, self.item, "tote", self.tip @ inverse(self.T_item_tip))
        cell = replace(self.cell, items={**self.cell.items, (self.item.name, self.item.year): self.item})
        scene = Scene(cell, cell.T_world_pod, (placed,), PoseNoise())
        return scene if held is None else replace(scene, held=HeldItem(ERASER, self.item, held))

    def plan(self, *parts: tuple[SegmentKind, ToolState, bool], **grasp: Any) -> Plan:
        """Segments of a second each."""
        still = np.zeros((2, len(self.q)))
        times = np.array([0.0, float(len(parts))])
        trajectory = Trajectory(self.cell.robot.joint_names, times, np.tile(self.q, (2, 1)), still, still)
        segments = tuple(
            Segment(kind, float(k), k + 1.0, state, ERASER if is_held else None)
            for k, (kind, state, is_held) in enumerate(parts)
        )
        force = MASS * GRAVITY * self.tip[2, :3]
        loads = {"pull": abs(force[1]), "shear": float(np.hypot(force[0], force[2])), "moment": 0.0}
        stated = {**loads, "twist": 0.0, "T_item_tip": self.T_item_tip, **grasp}
        of = Grasp(ERASER, "side", "y", OPEN, pose(), 0.1, 0.0, 0.0, 0.0, 0.0, 0.0)
        return Plan("pick", "", "", 0, segments, trajectory, (), replace(of, **stated))

    def said(self, plan: Plan, scene: Scene | None = None) -> list[str]:
        T_tip_item = inverse(self.T_item_tip)
        return whats(check_pinch(plan, scene or self.scene(), T_tip_item))


def whats(reasons: Iterable[Reason]) -> list[str]:
    return [reason.what for reason in reasons]


def width(m: float) -> ToolState:
    return ToolState.of_width(m)


TAKEN = (K.APPROACH, OPEN, False), (K.CONTACT, MOVING, False), (K.LIFT, width(0.06), True)


def test_a_hold_that_is_as_it_says_is_accepted(gripper_cell: Cell) -> None:
    hold = Hold(gripper_cell)
    assert hold.said(hold.plan(*TAKEN)) == []
    assert check_hold(replace(hold.plan(*TAKEN), grasp=None), hold.scene(), pose()) == ()
    assert check_hold(hold.plan(*TAKEN), hold.scene(), None) == ()


@pytest.mark.parametrize(
    ("at", "is_wrong"), [(0.0591, False), (0.0609, False), (0.0589, True), (0.0611, True)]
)
def test_the_width_is_that_of_the_item_to_a_millimetre(at: float, is_wrong: bool, gripper_cell: Cell) -> None:
    hold = Hold(gripper_cell)
    plan = hold.plan(*TAKEN[:2], (K.LIFT, width(at), True))
    assert hold.said(plan) == ["wrong width"] * is_wrong
    told = str(check_pinch(plan, hold.scene(), pose())[:1])
    assert not is_wrong or ("segment 2 (lift)" in told and f"{1e3 * at:.1f} mm stated" in told)


def test_fingers_that_move_while_they_hold_have_no_width(gripper_cell: Cell) -> None:
    """They are told by another check."""
    hold = Hold(gripper_cell)
    assert hold.said(hold.plan(*TAKEN[:2], (K.LIFT, MOVING, True))) == []


@pytest.mark.parametrize(("at", "is_open"), [(0.0601, True), (0.06 - 1e-9, False), (0.03, False)])
def test_fingers_come_wider_than_the_item(at: float, is_open: bool, gripper_cell: Cell) -> None:
    hold = Hold(gripper_cell)
    plan = hold.plan((K.APPROACH, width(at), False), *TAKEN[1:])
    assert hold.said(plan) == ["fingers not open"] * (not is_open)
    before = hold.plan((K.PREAPPROACH, width(at), False), *TAKEN)
    assert hold.said(before) == []


def test_fingers_close_in_the_contact(gripper_cell: Cell) -> None:
    hold = Hold(gripper_cell)
    assert hold.said(hold.plan(TAKEN[0], (K.CONTACT, OPEN, False), TAKEN[2])) == ["wrong tool state"]


@pytest.mark.parametrize(
    ("off", "misses"),
    [
        (pose((0.0019, 0.0, 0.0)), False), (pose((0.0021, 0.0, 0.0)), True),
        (pose((0.0, 0.0, -0.0019)), False), (pose((0.0, 0.0, -0.0021)), True),
        (pose((0.0, 0.0021, 0.0)), True), (pose((0.0015, 0.0, 0.0015)), True),
        (pose(rpy=(0.0, np.radians(0.95), 0.0)), False), (pose(rpy=(0.0, np.radians(1.05), 0.0)), True),
    ],
)  # fmt: skip
def test_fingers_close_within_2_mm_and_a_degree_of_where_the_grasp_says(
    off: Array, misses: bool, gripper_cell: Cell
) -> None:
    hold = Hold(gripper_cell, pose((0.01, 0.0, 0.01), rpy=(0.0, 0.4, 0.0)))
    scene = hold.scene()
    T = scene.items[0].T_world_item @ hold.T_item_tip @ off @ inverse(hold.T_item_tip)
    there = replace(scene, items=(replace(scene.items[0], T_world_item=T),))
    found = whats(check_pinch(hold.plan(*TAKEN), there, inverse(hold.T_item_tip)))
    assert ("misses the item" in found) is misses


@pytest.mark.parametrize(("aside", "misses"), [(0.0019, False), (0.0021, True)])
def test_what_is_held_from_the_start_is_held_as_the_grasp_says(
    aside: float, misses: bool, gripper_cell: Cell
) -> None:
    hold = Hold(gripper_cell)
    plan = hold.plan((K.TRANSFER, width(0.06), True))
    assert ("misses the item" in hold.said(plan, hold.scene(pose((aside, 0.0, 0.0))))) is misses
    assert "misses the item" not in hold.said(plan)
    taking = hold.plan(*TAKEN)
    assert "misses the item" not in hold.said(taking, hold.scene(pose((0.1, 0.0, 0.0))))


def test_pads_of_which_less_than_a_tenth_touches_are_refused(gripper_cell: Cell) -> None:
    """Two of fifteen columns are more, one is less."""
    for columns, is_refused in ((2, False), (1, True)):
        hold = Hold(gripper_cell, pose((0.0503 + (7 - columns) * STEP, 0.0, 0.0)))
        said = hold.said(hold.plan(*TAKEN))
        assert ("pads beside the item" in said, len(said) == 1) == (is_refused, is_refused)


@pytest.mark.parametrize(("friction", "is_refused"), [(0.0299, True), (0.0302, False)])
def test_faces_stand_in_the_cone_of_friction(friction: float, is_refused: bool, gripper_cell: Cell) -> None:
    """Turned by 0.03 rad, whose tangent is 0.030009."""
    tool, gripper = gripper_cell.robot.tool, gripper_cell.robot.tool.gripper
    assert gripper is not None
    smooth = replace(gripper, limits=replace(gripper.limits, friction=friction))
    robot = replace(gripper_cell.robot, tool=replace(tool, grip=smooth))
    hold = Hold(replace(gripper_cell, robot=robot), pose(rpy=(0.0, 0.0, 0.03)))
    assert ("outside of the friction cone" in hold.said(hold.plan(*TAKEN))) is is_refused


def test_the_faces_are_as_stated(gripper_cell: Cell) -> None:
    hold = Hold(gripper_cell)
    for face in ("x", "y", "z", "mantle"):
        assert hold.said(hold.plan(*TAKEN, face=face)) == ["wrong face"] * (face != "y")


@pytest.mark.parametrize("name", ["pull", "shear", "moment", "twist"])
def test_the_load_is_as_stated_to_a_hundredth(name: str, gripper_cell: Cell) -> None:
    """Of 10 N and 1 Nm; of less, to 0.01 N or Nm."""
    hold = Hold(gripper_cell)
    stated = getattr(hold.plan(*TAKEN).grasp, name)
    room = max(0.01, 0.01 * stated)
    for share, is_wrong in ((0.99, False), (1.01, True), (-0.99, False), (-1.01, True)):
        plan = hold.plan(*TAKEN, **{name: stated + share * room})
        assert hold.said(plan) == ["load not as stated"] * is_wrong
        found = check_pinch(plan, hold.scene(), pose())
        assert all(f"grasp.{name}" in str(reason) for reason in found)


def test_torques_are_those_of_a_weight_beside_the_pads(gripper_cell: Cell) -> None:
    """30 mm from the tip along x of the tool, and 20 mm along y and z."""
    hold = Hold(gripper_cell, pose((-0.03, 0.02, -0.02)))
    force = MASS * GRAVITY * hold.tip[2, :3]
    torque = np.cross([0.03, -0.02, 0.02], force)
    loads = {"moment": float(np.hypot(torque[0], torque[2])), "twist": abs(float(torque[1]))}
    assert hold.said(hold.plan(*TAKEN, **loads)) == []
    assert min(loads.values()) > 0.015


@pytest.mark.parametrize(("share", "holds"), [(0.99, True), (1.01, False)])
def test_what_is_heavier_than_the_pads_bear_does_not_hold(
    share: float, holds: bool, gripper_cell: Cell
) -> None:
    light = Hold(gripper_cell)
    up = light.tip[2, :3]
    pads = on(BOX, pose(), gripper_cell.robot.tool.gripper)  # type: ignore[arg-type]
    of_one = pads.ratio(np.array([[*(GRAVITY * up), 0.0, 0.0, 0.0]]), gripper_cell.robot.tool.gripper)[0]  # type: ignore[arg-type]
    heavy = Hold(gripper_cell, mass=share / of_one / 1.1, mass_error=0.1)
    found = check_pinch(heavy.plan(*TAKEN), heavy.scene(), pose())
    assert ("does not hold" in whats(found)) is not holds
    if not holds:
        assert f"{share:.2f} of what the pads bear at 2.000 s" in str(found[0])


def test_loads_are_shares_of_what_the_pads_bear_while_they_hold(gripper_cell: Cell) -> None:
    """Infinite where the fingers closed on nothing."""
    gripper, hold = gripper_cell.robot.tool.gripper, Hold(gripper_cell)
    assert gripper is not None
    wrenches = np.array([[[*(MASS * GRAVITY * hold.tip[2, :3]), 0.0, 0.0, 0.0]] * 3] * 2)
    loads = load_ratios(hold.plan(*TAKEN), hold.scene(), wrenches)
    assert loads.shape == (2, 3)
    assert_allclose(loads, on(BOX, pose(), gripper).ratio(wrenches[0, :1], gripper)[0])
    beside = Hold(gripper_cell, pose((0.3, 0.0, 0.0)))
    assert np.isinf(load_ratios(beside.plan(*TAKEN), beside.scene(), wrenches)).all()


def test_what_is_never_held_has_no_load(gripper_cell: Cell) -> None:
    hold = Hold(gripper_cell)
    assert hold.said(hold.plan(*TAKEN[:2], shear=100.0)) == []


def test_fingers_closed_on_nothing_are_refused(gripper_cell: Cell) -> None:
    hold = Hold(gripper_cell, pose((0.3, 0.0, 0.0)))
    assert hold.said(hold.plan(*TAKEN)) == ["nothing between the pads"]
    assert CLOSED != OPEN and WIDEST > 0.06


def test_the_kind_is_that_of_the_way_in_but_for_what_is_held_from_the_start(gripper_cell: Cell) -> None:
    hold = Hold(gripper_cell)
    down = pose(rpy=(np.pi, 0.0, 0.0))
    scene = hold.scene()
    T = scene.T_world_place(scene.cell.places["tote"]) @ pose((0.0, 0.0, 0.1))
    there = replace(scene, items=(replace(scene.items[0], T_world_item=T),))
    for kind, is_wrong in (("frontal", True), ("top-down", False), ("side", True)):
        plan = hold.plan(*TAKEN, T_item_tip=down, kind=kind)
        assert ("wrong kind" in whats(check_hold(plan, there, down))) is is_wrong
        held = hold.plan((K.TRANSFER, width(0.06), True), T_item_tip=down, kind=kind)
        assert "wrong kind" not in whats(check_hold(held, there, down))


def test_pads_have_to_bear_what_stands_off_by_its_pose_error(gripper_cell: Cell) -> None:
    """A can by the upper end, its weight along the pads: askew by a degree, a narrower strip is held."""
    gripper = gripper_cell.robot.tool.gripper
    assert gripper is not None
    hold = Hold(gripper_cell, pose((0.0, 0.0, 0.028), rpy=(0.0, np.pi, 0.0)), shape=CAN)
    R = hold.tip[:3, :3]
    force = MASS * GRAVITY * R[2]
    torque = np.cross(inverse(hold.T_item_tip)[:3, 3], force)
    of_one = on(CAN, hold.T_item_tip, gripper).ratio(np.append(force, torque)[None], gripper)[0]
    heavy = Hold(gripper_cell, hold.T_item_tip, shape=CAN, mass=0.9 * MASS / of_one)
    plan, scene = heavy.plan(*TAKEN), heavy.scene()
    T_tip_item = inverse(heavy.T_item_tip)
    exact = check_hold(plan, scene, T_tip_item)
    assert "does not hold" not in whats(exact)
    off = check_hold(plan, replace(scene, noise=PoseNoise(0.002, np.radians(1.0))), T_tip_item)
    assert "does not hold" in whats(off)
    assert any("2.0 mm and 1.0 degrees off: 1." in str(reason) for reason in off)
    own = replace(scene.items[0], noise=PoseNoise())
    known = replace(scene, items=(own,), noise=PoseNoise(0.002, np.radians(1.0)))
    assert whats(check_hold(plan, known, T_tip_item)) == whats(exact)
    askew = check_hold(plan, replace(scene, noise=PoseNoise(0.002, np.radians(5.0))), T_tip_item)
    assert any("touch it on no common part" in str(reason) for reason in askew)
