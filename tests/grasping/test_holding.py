"""The planned load on the cup against cases worked by hand, and laws that hold for every motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tools.gripper import Finger, ParallelGripper
from pickcli.cell.tools.pinch_limits import PinchLimits
from pickcli.geometry import GRAVITY, Array, inverse, pose, rotation_axis_angle, rotation_rpy
from pickcli.grasping.holding import GripLoad, Hold, loads_at_rest
from pickcli.grasping.pinch_grasping import PinchGrasping
from pickcli.grasping.suction_grasping import SuctionGrasping
from pickcli.kinematics.tip_motion import TipMotion

CELL = load_cell("apc2016_delft")
TOOL = CELL.robot.tool
DOWN = np.diag([1.0, -1.0, -1.0])
FORWARD = rotation_rpy(0.0, np.pi / 2, 0.0)  # tool z along world x
DASANI = CELL.item("dasani_water_bottle", 2016)
BOTTLE = replace(DASANI, seals=dict.fromkeys(DASANI.seals, 1.0))
ZERO = np.zeros(3)
vectors = st.tuples(*[st.floats(-5.0, 5.0)] * 3).map(np.array)


def held(item: Item, p_tip_com: tuple[float, ...], face: str = "mantle", R: Array | None = None) -> Hold:
    """Nothing is known to be heavier than stated, so that figures are plain."""
    return SuctionGrasping(TOOL).hold(
        replace(item, mass_error=0.0), face, pose(p_tip_com, R=np.eye(3) if R is None else R)
    )


def moving(R: Array, a: Array = ZERO, omega: Array = ZERO, alpha: Array = ZERO) -> TipMotion:
    return TipMotion(pose(R=R)[None], ZERO[None], omega[None], a[None], alpha[None])


def test_item_hanging_below_the_cup_only_pulls() -> None:
    load = held(BOTTLE, (0.0, 0.0, 0.05)).at_rest(DOWN[None])
    assert load.pull == pytest.approx(0.52 * GRAVITY)
    assert (load.shear, load.moment, load.twist) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert load.ratio == pytest.approx(0.52 * GRAVITY / 42.0)


def test_item_held_level_bends_and_shears() -> None:
    """0.52 kg at 97.5 mm in front of the cup."""
    load = held(BOTTLE, (0.0, 0.0, 0.0975)).at_rest(FORWARD[None])
    assert load.moment == pytest.approx(0.52 * GRAVITY * 0.0975)
    assert load.shear == pytest.approx(0.52 * GRAVITY)
    assert (load.pull, load.twist) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_item_beside_a_level_cup_twists() -> None:
    """The weight acts at a lever across the cup's axis: it turns the item about that axis."""
    load = held(BOTTLE, (0.0, 0.03, 0.0)).at_rest(FORWARD[None])
    assert load.twist == pytest.approx(0.52 * GRAVITY * 0.03)
    assert load.moment == pytest.approx(0.0, abs=1e-12)
    assert load.ratio == pytest.approx(np.hypot(0.52 * GRAVITY / 21.0, 0.52 * GRAVITY * 0.03 / 0.21))


def test_turning_about_the_axis_of_the_cup_takes_the_item_s_inertia() -> None:
    """A bottle held in the middle of its mantle, its own axis across the cup's: m (3 r^2 + l^2) / 12."""
    across = pose(R=rotation_rpy(np.pi / 2, 0.0, 0.0))[:3, :3]
    hold = held(BOTTLE, (0.0, 0.0, 0.0335), R=across)
    load = hold.in_motion(moving(DOWN, alpha=np.array([0.0, 0.0, 10.0])))
    assert load.twist == pytest.approx(0.52 * (3 * 0.0335**2 + 0.195**2) / 12 * 10.0)


def test_swinging_in_a_circle_pulls_outwards() -> None:
    """The centre of mass 0.1 m from the axis through the tip: m w^2 r on top of the weight."""
    load = held(BOTTLE, (0.1, 0.0, 0.0)).in_motion(moving(DOWN, omega=np.array([0.0, 0.0, 3.0])))
    assert load.shear == pytest.approx(0.52 * 9.0 * 0.1)
    assert load.moment == pytest.approx(0.52 * GRAVITY * 0.1)


def test_free_fall_loads_nothing() -> None:
    load = held(BOTTLE, (0.02, 0.0, 0.05)).in_motion(moving(DOWN, a=np.array([0.0, 0.0, -GRAVITY])))
    assert max(load.pull, load.shear, load.moment, load.twist, load.ratio) < 1e-12


def test_pushing_onto_the_item_is_no_pull() -> None:
    assert held(BOTTLE, (0.0, 0.0, 0.05)).at_rest(np.eye(3)[None]).ratio == 0.0  # the cup under the item


def test_an_item_is_held_as_if_it_were_as_heavy_as_it_may_be() -> None:
    heavy, stated = replace(BOTTLE, mass_error=0.25), replace(BOTTLE, mass_error=0.0)
    loads = [
        SuctionGrasping(TOOL)
        .hold(item, "mantle", pose([0.01, 0.02, 0.05]))
        .in_motion(moving(FORWARD, np.ones(3), np.ones(3), 5.0 * np.ones(3)))
        for item in (heavy, stated)
    ]
    assert loads[0].ratio == pytest.approx(1.25 * loads[1].ratio)
    assert loads[0].twist == pytest.approx(1.25 * loads[1].twist)


@given(st.floats(0.05, 1.0), vectors, vectors, vectors)
def test_what_a_leaking_face_bears_falls_with_its_seal(
    share: float, a: Array, w: Array, alpha: Array
) -> None:
    leaking = replace(BOTTLE, seals={**BOTTLE.seals, "mantle": share})
    motion, p = moving(FORWARD, a, w, alpha), (0.01, 0.02, 0.05)
    ratios = [held(item, p).in_motion(motion).ratio for item in (leaking, BOTTLE)]
    assert ratios[0] == pytest.approx(ratios[1] / share)


@given(st.floats(-np.pi, np.pi), vectors, vectors, vectors)
def test_the_load_is_the_same_turned_about_the_axis_of_the_cup(
    angle: float, a: Array, w: Array, alpha: Array
) -> None:
    """The same item in the same motion, in a tool frame that is turned about its own z."""
    turn = rotation_axis_angle((0.0, 0.0, 1.0), angle)
    T = pose([0.01, 0.02, 0.05], rpy=[0.3, 0.2, 0.1])
    method = SuctionGrasping(TOOL)
    hold, turned = (method.hold(BOTTLE, "mantle", at) for at in (T, pose(R=turn).T @ T))
    one = hold.in_motion(moving(FORWARD, a, w, alpha))
    other = turned.in_motion(moving(FORWARD @ turn, a, w, alpha))
    for name in ("pull", "shear", "moment", "twist", "ratio"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-9, abs=1e-9)


def test_a_place_near_the_centre_of_mass_is_loaded_least() -> None:
    """The same face at growing distances from the middle, in any orientation of the tool."""
    orientations = np.stack([DOWN, FORWARD, rotation_rpy(0.4, 2.0, 1.0)])
    ratios = [held(BOTTLE, (0.0, d, 0.0335)).at_rest(orientations).ratio for d in np.linspace(0.0, 0.08, 9)]
    assert ratios == sorted(ratios)
    assert ratios[-1] > 2.0 * ratios[0]


@given(st.lists(st.tuples(vectors, vectors, vectors), min_size=1, max_size=4))
def test_the_load_of_a_motion_is_the_worst_of_its_states(states: list[tuple[Array, Array, Array]]) -> None:
    hold = held(BOTTLE, (0.01, 0.02, 0.05))
    each = [hold.in_motion(moving(FORWARD, a, w, alpha)) for a, w, alpha in states]
    a, w, alpha = (np.array(column) for column in zip(*states, strict=True))
    n = len(states)
    whole = hold.in_motion(TipMotion(np.tile(pose(R=FORWARD), (n, 1, 1)), np.zeros((n, 3)), w, a, alpha))
    for name in ("pull", "shear", "moment", "twist", "ratio"):
        assert getattr(whole, name) == pytest.approx(max(getattr(one, name) for one in each), abs=1e-12)


def test_the_load_at_rest_is_the_worst_of_all_orientations() -> None:
    hold, orientations = held(BOTTLE, (0.01, 0.02, 0.05)), np.stack([DOWN, FORWARD, np.eye(3)])
    each = [hold.at_rest(R[None]) for R in orientations]
    for name in ("pull", "shear", "moment", "twist", "ratio"):
        assert getattr(hold.at_rest(orientations), name) == max(getattr(one, name) for one in each)


@given(vectors.map(lambda v: rotation_rpy(*v)), vectors)
def test_at_rest_is_a_motion_without_speed(R: Array, p: Array) -> None:
    hold = held(BOTTLE, tuple(0.01 * p))
    rest, motion = hold.at_rest(R[None]), hold.in_motion(moving(R))
    for name in ("pull", "shear", "moment", "twist", "ratio"):
        assert getattr(rest, name) == pytest.approx(getattr(motion, name), abs=1e-9)


@given(vectors.map(lambda v: rotation_rpy(*v)), st.lists(st.tuples(vectors, vectors), min_size=1, max_size=3))
def test_at_rest_at_each_place_the_worst_of_how_it_lies_and_hangs_straight_down_counts(
    lying: Array, places: list[tuple[Array, Array]]
) -> None:
    method, T = SuctionGrasping(TOOL), [pose(0.01 * p, R=rotation_rpy(*rpy)) for p, rpy in places]
    found = loads_at_rest(BOTTLE, method.bears(BOTTLE, "mantle", T[0]), np.array(T), lying)
    for load, T_item_tip in zip(found, T, strict=True):
        ways = np.stack([lying @ T_item_tip[:3, :3], DOWN])
        expected = method.hold(BOTTLE, "mantle", inverse(T_item_tip)).at_rest(ways)
        for name in ("pull", "shear", "moment", "twist", "ratio"):
            assert getattr(load, name) == pytest.approx(getattr(expected, name), abs=1e-9)


def test_an_item_beside_the_cup_loads_it_by_hand_in_every_figure() -> None:
    """0.52 kg at (0.01, 0.02, 0.05) m, gravity along the tool's x: torque p x F about the tip."""
    weight = 0.52 * GRAVITY
    load = held(BOTTLE, (0.01, 0.02, 0.05)).at_rest(FORWARD[None])
    assert (load.pull, load.shear) == pytest.approx((0.0, weight), abs=1e-9)
    assert (load.moment, load.twist) == pytest.approx((0.05 * weight, 0.02 * weight))
    lip, slip = load.moment / 0.6, np.hypot(load.shear / 21.0, load.twist / 0.21)
    assert load.ratio == pytest.approx(max(lip, slip))


def test_a_load_is_told_in_its_units() -> None:
    load = held(BOTTLE, (0.0, 0.03, 0.0)).at_rest(FORWARD[None])
    assert str(load) == "pull 0.0 N, shear 5.1 N, moment 0.00 Nm, twist 0.15 Nm"


def test_the_torque_of_the_weight_counts_by_what_the_cup_bears_of_it() -> None:
    bent, turned = held(BOTTLE, (0.0, 0.0, 0.05)), held(BOTTLE, (0.0, 0.01, 0.0))
    weight = 0.52 * GRAVITY
    assert bent.torque_at_rest(FORWARD) == pytest.approx(weight * 0.05 / TOOL.cup.limits.max_moment)
    assert turned.torque_at_rest(FORWARD) == pytest.approx(weight * 0.01 / TOOL.cup.limits.max_twist)
    assert bent.torque_at_rest(DOWN) == pytest.approx(0.0, abs=1e-12)
    leaking = replace(bent, share=0.5)
    assert leaking.torque_at_rest(FORWARD) == pytest.approx(2.0 * bent.torque_at_rest(FORWARD))


def test_the_worst_of_two_loads_has_each_figure_from_where_it_is_larger() -> None:
    loads = (GripLoad(1.0, 5.0, 0.1, 0.4, 0.3), GripLoad(2.0, 4.0, 0.2, 0.3, 0.5))
    assert GripLoad.worst(loads) == GripLoad(2.0, 5.0, 0.2, 0.4, 0.5)


def test_pads_bear_by_their_friction_whatever_a_cup_would_have_of_the_faces() -> None:
    """A weight along the pads of 20 N at a friction of 0.5: 20 N of both; all of them lies on the box."""
    limits = PinchLimits(20.0, 0.5, (0.02, 0.02))
    fingers = tuple(Finger(f"finger_{side:.0f}", f"joint_{side:.0f}", side, 1.0) for side in (1.0, -1.0))
    gripper = ParallelGripper(fingers, (0.02, 0.02), 0.0, limits, 0.1, 0.1)  # type: ignore[arg-type]
    method = PinchGrasping(replace(TOOL, grip=gripper), gripper)
    box = Shape(ShapeKind.BOX, (0.1, 0.04, 0.1))
    for seal in (0.1, 1.0):
        item = replace(BOTTLE, shape=box, mass=1.0, mass_error=0.0, seals=dict.fromkeys(box.face_names, seal))
        (at_rest,) = loads_at_rest(item, method.bears(item, "y", np.eye(4)), np.eye(4)[None], np.eye(3))
        assert at_rest.ratio == pytest.approx(GRAVITY / 20.0)
        hold = method.hold(item, "y", np.eye(4))
        assert hold.at_rest(np.eye(3)[None]).ratio == pytest.approx(GRAVITY / 20.0)
