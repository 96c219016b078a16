"""What a level of recovery claims is checked: contact may open, never deepen, and no more than that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from pickcli.geometry import Array, pose
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import Grasp, Plan, RecoveryLevel
from pickcli.motion.segment import SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import HeldItem, PlacedItem, PoseNoise, Scene
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.recovery_check import _strayed
from pickcli.verification.verify import verify
from support.handmade_plans import CRAYOLA, Builder, bound, cell, make_scene, pick, tip

OPENING, SLOWLY, JOG = RecoveryLevel.OPENING, RecoveryLevel.SLOWLY, RecoveryLevel.JOG
Q = np.asarray(cell().configurations["home"].q)
DEEP = 0.003  # m that the cup stands in the item at the start


def in_the_air(deep: float = DEEP) -> Scene:
    """One box in the air in front of the tool, into which the cup reaches by so much."""
    item, T = cell().item(CRAYOLA), tip(Q)
    half = float(item.shape.extents[2]) / 2
    T_world_item = T @ pose([0.0, 0.0, half - deep])
    return make_scene(PlacedItem(CRAYOLA, item, "bin_A", T_world_item))


def moved(ways: Sequence[float], seconds: float = 3.0, touching: tuple[str, ...] = ()) -> Builder:
    """The tool along its axis, by so many metres one after the other; touching: on the first line."""
    builder, T = Builder(Q), tip(Q)
    for way in ways:
        T = T @ pose([0.0, 0.0, way])
        if touching and not builder.segments:
            builder.line(SegmentKind.DEPART, T, seconds, touching=touching)
        else:
            builder.line(SegmentKind.RETREAT, T, seconds)
    return builder


def plan_of(builder: Builder, scene: Scene, level: RecoveryLevel | None) -> Plan:
    plan = Plan("recover", "", "", 0, tuple(builder.segments), builder.trajectory(), (), recovery=level)
    return bound(plan, scene)


def reasons(plan: Plan, scene: Scene) -> set[str]:
    return {reason.what for reason in verify(plan, scene).reasons}


@pytest.mark.parametrize("level", [OPENING, RecoveryLevel.BACKWARDS])
def test_what_is_in_contact_may_open(level: RecoveryLevel) -> None:
    scene = in_the_air()
    assert reasons(plan_of(moved([-0.05]), scene, level), scene) == set()


@pytest.mark.parametrize("level", [None, RecoveryLevel.AS_PLANNED])
def test_no_other_plan_may_begin_in_contact(level: RecoveryLevel | None) -> None:
    scene = in_the_air()
    assert "collision" in reasons(plan_of(moved([-0.05]), scene, level), scene)


@pytest.mark.parametrize("ways", [[0.004], [-0.002, 0.006], [-0.05, 0.05], [-0.05, 0.0515]])
@pytest.mark.parametrize("deep", [DEEP, -0.001])
@pytest.mark.parametrize("touching", [(), (CRAYOLA,)])
@pytest.mark.parametrize("level", [OPENING, SLOWLY])
def test_what_has_opened_may_not_close_again(
    ways: list[float], deep: float, touching: tuple[str, ...], level: RecoveryLevel
) -> None:
    """Also if the cup may touch it at first; on a second line of ``opening`` it touches nothing."""
    scene = in_the_air(deep)
    faults = {"collision", "too close"} if level is OPENING and len(ways) > 1 else {"closes again"}
    assert faults & reasons(plan_of(moved(ways, touching=touching), scene, level), scene)


def test_a_cup_may_touch_what_it_comes_free_of_over_the_first_line() -> None:
    scene = in_the_air()
    assert reasons(plan_of(moved([-0.04, -0.02], touching=(CRAYOLA,)), scene, OPENING), scene) == set()
    assert reasons(plan_of(moved([-0.06], touching=(CRAYOLA,)), scene, OPENING), scene) == {
        "touching too long"
    }


@pytest.mark.parametrize("deep", [DEEP, -0.001])
@pytest.mark.parametrize("touching", [(), (CRAYOLA,)])
def test_a_cup_has_come_free_at_the_end_of_the_first_line(deep: float, touching: tuple[str, ...]) -> None:
    """It does not slide along what it was bent against, and leads no lip through it on a second line."""
    scene, fault = in_the_air(deep), "collision" if deep > 0.001 else "too close"
    late = plan_of(moved([-0.001, -0.05], touching=touching), scene, OPENING)
    assert reasons(late, scene) == {fault}
    (reason,) = verify(late, scene).reasons
    assert reason.where.startswith("segment 1 ")
    beside = Builder(Q)
    beside.line(SegmentKind.DEPART, tip(Q) @ pose([0.0, -0.01, 0.0]), 2.0, touching=touching)
    beside.line(SegmentKind.RETREAT, tip(Q) @ pose([0.0, -0.02, 0.0]), 2.0)
    beside.line(SegmentKind.RETREAT, tip(Q) @ pose([0.0, -0.02, -0.05]), 3.0)
    sliding = plan_of(beside, scene, OPENING)
    assert reasons(sliding, scene) == {fault}


def test_on_the_slow_level_a_cup_may_come_free_on_any_line() -> None:
    scene = in_the_air()
    late = plan_of(moved([-0.001, -0.02]), scene, SLOWLY)
    assert reasons(late, scene) == set()


def test_what_was_not_near_at_the_start_is_kept_clear_of() -> None:
    scene = in_the_air(-0.02)
    assert reasons(plan_of(moved([0.01]), scene, OPENING), scene) == set()
    assert "collision" in reasons(plan_of(moved([0.03]), scene, OPENING), scene)


def test_a_slow_way_out_is_slow_and_a_jog_is_short() -> None:
    scene = in_the_air()
    assert reasons(plan_of(moved([-0.02], seconds=3.0), scene, SLOWLY), scene) == set()
    assert reasons(plan_of(moved([-0.1], seconds=1.0), scene, SLOWLY), scene) == {"not slow"}
    assert reasons(plan_of(moved([-0.02], seconds=3.0), scene, JOG), scene) == set()
    assert reasons(plan_of(moved([-0.05], seconds=9.0), scene, JOG), scene) == {"not a jog"}


def test_only_a_slow_way_out_takes_items_where_they_were_seen() -> None:
    # Seen 6 mm ahead of the cup, with an error of up to 8 mm: 3 mm ahead is inside the error, 8 mm is in it.
    scene = replace(in_the_air(-0.006), noise=PoseNoise(0.008, 0.0))
    assert "closes again" in reasons(plan_of(moved([0.003]), scene, OPENING), scene)
    assert reasons(plan_of(moved([0.003]), scene, SLOWLY), scene) == set()
    assert "closes again" in reasons(plan_of(moved([0.008]), scene, SLOWLY), scene)


def test_the_error_of_poses_counts_for_what_is_not_near_at_the_start() -> None:
    """A box beside the cup, and one 30 mm ahead, known to 8 mm: 25 mm nearer is inside of the error."""
    size, item = cell().item(CRAYOLA).shape.extents, cell().item(CRAYOLA)
    beside = float(size[1]) / 2 + cell().robot.tool.cup.radius + 0.001
    ahead = PlacedItem(f"{CRAYOLA}#2", item, "bin_A", tip(Q) @ pose([0.0, -0.01, float(size[2]) / 2 + 0.030]))
    near = PlacedItem(CRAYOLA, item, "bin_A", tip(Q) @ pose([0.0, beside, -0.02]))
    scene = make_scene(near, ahead, noise=PoseNoise(0.008, 0.0))
    assert reasons(plan_of(moved([0.015]), scene, SLOWLY), scene) == set()
    assert "collision" in reasons(plan_of(moved([0.025]), scene, SLOWLY), scene)


def inwards(way: float) -> Builder:
    """From in front of an empty bin along the tool's axis, slowly."""
    builder = Builder(np.asarray(cell().configurations["bin_H"].q))
    builder.line(SegmentKind.RETREAT, tip(builder.q) @ pose([0.0, 0.0, way]), 20.0)
    return builder


@pytest.mark.parametrize("level", [OPENING, SLOWLY, RecoveryLevel.BACKWARDS])
def test_no_way_out_leads_into_the_pod(level: RecoveryLevel) -> None:
    scene = make_scene()
    assert "leads into the pod" in reasons(plan_of(inwards(0.42), scene, level), scene)
    assert reasons(plan_of(inwards(0.42), scene, RecoveryLevel.AS_PLANNED), scene) == set()


def test_a_slow_way_out_begins_in_the_pod_or_near_to_something() -> None:
    scene = make_scene()
    assert reasons(plan_of(moved([-0.01]), scene, SLOWLY), scene) == {"not a way out"}
    assert reasons(plan_of(moved([-0.01]), scene, JOG), scene) == {"not a way out"}


def test_a_way_back_leads_along_the_motion_that_stopped() -> None:
    """Also into the pod, where that came from there; and nowhere else."""
    scene = make_scene()
    plan = plan_of(inwards(0.42), scene, RecoveryLevel.BACKWARDS)
    assert verify(plan, scene, reversed_in_time(inwards(0.44).trajectory())).reasons == ()
    bowed = Builder(np.asarray(cell().configurations["bin_H"].q))
    bowed.line(SegmentKind.RETREAT, tip(bowed.q) @ pose([0.0, 0.03, 0.42]), 20.0)
    elsewhere, onwards = reversed_in_time(bowed.trajectory()), inwards(0.44).trajectory()
    for stopped in (elsewhere, onwards):
        found = verify(plan, scene, stopped).reasons
        assert {reason.what for reason in found} == {"not back the way it came"}


def reversed_in_time(trajectory: Trajectory) -> Trajectory:
    """The same curve from its end to its start."""
    return replace(
        trajectory, times=trajectory.duration - trajectory.times[::-1], positions=trajectory.positions[::-1],
        velocities=-trajectory.velocities[::-1], accelerations=trajectory.accelerations[::-1],
    )  # fmt: skip


def along(*corners: tuple[float, float]) -> Trajectory:
    """Two joints from corner to corner, at rest at each, a second for every way."""
    q = np.array(corners)
    still = np.zeros_like(q)
    return Trajectory(("a", "b"), np.arange(float(len(q))), q, still, still)


def states_of(trajectory: Trajectory, begin: float, end: float) -> Array:
    """Configurations (N, n) from one time to another, also an earlier one."""
    return trajectory.sample(np.linspace(begin, end, 1 + round(100 * abs(end - begin))))


ASIDE = (0.0, 0.0), (0.3, 0.0), (0.3, 0.3), (0.0, 0.3)
SPUR = (0.0, 0.0), (0.3, 0.0), (0.3, 0.3), (0.3, 0.0), (0.6, 0.0)  # passes one place twice
HAIRPIN = (0.0, 0.0), (0.3, 0.0), (0.3, 0.004), (0.0, 0.004)  # comes back beside itself
SHAKE = (0.0, 0.0), (0.3, 0.0), *(((0.29, 0.0), (0.3, 0.0)) * 5), (0.6, 0.0)


@pytest.mark.parametrize("path", [ASIDE, SPUR, HAIRPIN, SHAKE], ids=["aside", "spur", "hairpin", "shake"])
@pytest.mark.parametrize("share", [0.1, 0.37, 0.5, 0.81, 1.0])
@pytest.mark.parametrize("off", [0.0, 0.0045, -0.0045])
def test_back_along_any_motion_from_any_time(
    path: Sequence[tuple[float, float]], share: float, off: float
) -> None:
    motion = along(*path)
    assert _strayed(states_of(motion, share * motion.duration, 0.0) + off, motion) is None


def test_states_of_a_way_back_may_be_unevenly_far_apart() -> None:
    """Straight from one to the next, at every corner too: nothing in between is left out."""
    motion = along(*ASIDE)
    times = np.array([2.9, 2.8, 2.0, 1.9, 1.5, 1.0, 0.95, 0.3, 0.0])
    assert _strayed(motion.sample(times), motion) is None


def test_a_way_back_keeps_the_order_of_the_motion_and_leaves_nothing_out() -> None:
    aside, spur, hairpin = along(*ASIDE), along(*SPUR), along(*HAIRPIN)
    onwards = states_of(aside, 1.0, 2.0)
    back_and_on = np.vstack([states_of(aside, 2.5, 1.5), states_of(aside, 1.5, 2.5)])
    past_the_spur = np.vstack([states_of(spur, 4.0, 3.0), states_of(spur, 1.0, 0.0)])
    jumps = np.vstack([states_of(hairpin, 3.0, 2.5), states_of(hairpin, 0.5, 0.0)])  # by 4 mm, over 300 mm
    for motion, Q in ((aside, onwards), (aside, back_and_on), (spur, past_the_spur), (hairpin, jumps)):
        strayed = _strayed(Q, motion)
        assert strayed is not None and "does not go on backwards" in strayed[1]
        assert 0 < strayed[0] < len(Q)
    assert _strayed(states_of(aside, 3.0, 0.0) + np.array([0.0, 0.0051]), aside) is not None


@pytest.mark.parametrize(("depth", "is_refused"), [(0.0145, False), (0.0155, True)])
def test_a_way_back_may_leave_out_20_mm_at_once(depth: float, is_refused: bool) -> None:
    """A spur: 5 mm into it, and out again, a way back that passes it by is still near enough."""
    spur = along((0.0, 0.0), (0.3, 0.0), (0.3, depth), (0.3, 0.0), (0.6, 0.0))
    past_it = np.vstack([states_of(spur, 4.0, 3.0), states_of(spur, 1.0, 0.0)])
    assert (_strayed(past_it, spur) is not None) is is_refused


def test_a_way_back_does_not_leave_out_a_loop_that_ends_beside_its_start() -> None:
    """A motion around a square that stopped 9 mm before it was where it began."""
    loop = along((0.0, 0.0), (0.2, 0.0), (0.2, 0.2), (0.0, 0.2), (0.0, 0.009))
    short_cut = states_of(along((0.0, 0.009), (0.0, 0.0)), 0.0, 1.0)
    strayed = _strayed(short_cut, loop)
    assert strayed is not None and "does not go on backwards" in strayed[1]
    assert _strayed(short_cut[:30], loop) is None, "the first few mm are near enough to where it stopped"


def test_a_way_out_switches_nothing() -> None:
    scene, builder = in_the_air(), moved([-0.05])
    event = Event("valve", "off", Anchor(AnchorKind.SEGMENT_END, 0, 0.0), 0.05, 3.0, 2.95)
    plan = replace(plan_of(builder, scene, OPENING), events=(event,))
    assert "not a way out" in reasons(plan, scene)


def _taken() -> tuple[Grasp, Array]:
    """A grasp, and the pose of its item in the tool."""
    plan, scene = pick()
    T_tip_item = pose_in_tool(plan, scene)
    assert plan.grasp is not None and T_tip_item is not None
    return plan.grasp, T_tip_item


@pytest.mark.parametrize("level", [SLOWLY, JOG])
def test_a_slow_way_out_carries_nothing(level: RecoveryLevel) -> None:
    scene = in_the_air()
    (grasp, T_tip_item), moves = _taken(), moved([-0.01])
    scene = replace(scene, held=HeldItem(CRAYOLA, cell().item(CRAYOLA), T_tip_item))
    plan = plan_of(moves, scene, level)
    carried = tuple(replace(s, held=CRAYOLA) for s in plan.segments)
    verdict = verify(replace(plan, segments=carried, grasp=grasp), scene)
    assert any("carries an item" in str(reason) for reason in verdict.reasons)


def test_the_level_is_part_of_what_is_certified() -> None:
    from pickcli.motion.plan_file import motion_hash

    scene = in_the_air()
    plan = plan_of(moved([-0.05]), scene, OPENING)
    assert motion_hash(plan) != motion_hash(replace(plan, recovery=None))


def test_the_start_of_a_test_is_what_it_says() -> None:
    T: Array = tip(Q)
    item = in_the_air().items[0]
    ahead = float((item.T_world_item[:3, 3] - T[:3, 3]) @ T[:3, 2])
    assert ahead == pytest.approx(float(item.item.shape.extents[2]) / 2 - DEEP)
