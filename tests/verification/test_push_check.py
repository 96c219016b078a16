"""What a plan may push aside: every condition is the verifier's own, and every edit is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import NoPlanError
from pickcli.geometry import GRAVITY, inverse, pose
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.pick_settings import Neighbours
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.recovery.retrace import ItemRecovery, StoppedMotion, bring_item
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.scene.unknown_space import UnknownSpace
from pickcli.statics.pushing import mass_above, pushable, riders
from pickcli.statics.supports import supports_of
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.hold_choice import load_ratios
from pickcli.verification.load_check import held_wrenches
from pickcli.verification.pile_statics import lying_on
from pickcli.verification.push_check import (
    HEAVIEST,
    MOST_LOAD,
    MOST_SPEED,
    PushedHeap,
    check_push,
)
from pickcli.verification.verify import PUSH_CHECKS, verify
from support.heaps import APART, BOOK, BOX, OTHER, bridge, in_tote

ELSEWHERE = "dove_beauty_bar"  # in a bin
CRATES, CRATE = load_cell("ur5e_crates"), "crate_left"
OUTWARDS = (SegmentKind.LIFT, SegmentKind.RETREAT)


@pytest.fixture(scope="module")
def heap(cell: Cell) -> Scene:
    scene = bridge(cell)
    return replace(scene, items=(*scene.items, in_tote(cell, ELSEWHERE, 0.2, 0.0, 0.005, "bin_A")))


@pytest.fixture(scope="module")
def pushing(cell: Cell, heap: Scene) -> Plan:
    home = cell.configurations["home"]
    query = PickQuery(TOTE, BOX, neighbours=Neighbours.PUSH)
    return plan_pick(PlanningContext(cell), heap, query, Start(home.q, home.tool_state))


def told(plan: Plan, scene: Scene) -> str:
    """All that the verifier has against a plan in another scene than its own."""
    return "; ".join(map(str, verify(replace(plan, scene_hash=scene_hash(scene)), scene).reasons))


def with_book_of(heap: Scene, heaviest: float) -> Scene:
    """The heap with a book that may have so many kg."""
    book = heap.find(BOOK)
    return heap.moved(replace(book, item=replace(book.item, mass=heaviest / (1.0 + book.item.mass_error))))


def pushes(plan: Plan, *names: str, at: Callable[[Segment], bool] = lambda s: s.kind in OUTWARDS) -> Plan:
    """The plan with other items stated as pushed in some segments."""
    segments = tuple(replace(s, pushing=names if at(s) else s.pushing) for s in plan.segments)
    return replace(plan, segments=segments)


def test_it_is_accepted_and_the_certificate_names_the_check(pushing: Plan, heap: Scene) -> None:
    certificate = verify(pushing, heap).certificate
    assert certificate is not None and set(PUSH_CHECKS) <= set(certificate.checks)


def test_without_the_statement_the_book_is_in_the_way(pushing: Plan, heap: Scene) -> None:
    found = told(pushes(pushing), heap)
    assert f"{BOX}: takes away what others need: {BOOK} lies on it" in found
    assert "too close" in found or "collision" in found


def test_what_touches_only_one_of_them_needs_the_other_stated_too(pushing: Plan, heap: Scene) -> None:
    found = told(pushes(pushing, OTHER), heap)
    assert f"{BOOK} lies on it and may not be pushed" in found


@pytest.mark.parametrize("name", [ELSEWHERE, BOX, "tote_wall_far", "nothing"])
def test_only_other_items_of_the_box_may_be_pushed(pushing: Plan, heap: Scene, name: str) -> None:
    found = told(pushes(pushing, OTHER, BOOK, name), heap)
    assert f"{name}: may not be pushed: it is no other item in tote" in found


@pytest.mark.parametrize(
    "kind",
    [SegmentKind.PREAPPROACH, SegmentKind.APPROACH, SegmentKind.CONTACT, SegmentKind.TRANSFER],
)
def test_only_a_held_item_on_its_way_out_pushes(pushing: Plan, heap: Scene, kind: SegmentKind) -> None:
    found = told(pushes(pushing, OTHER, BOOK, at=lambda s: s.kind is kind), heap)
    assert "pushing not allowed" in found and f"({kind})" in found


def test_nothing_is_pushed_on_a_second_way(pushing: Plan, heap: Scene) -> None:
    """A segment that is called a lift or retreat, but comes after the transfer."""
    renamed = tuple(
        replace(s, kind=SegmentKind.LIFT, pushing=(BOOK,)) if s.kind is SegmentKind.PLACE else s
        for s in pushing.segments
    )
    place = [s.kind for s in pushing.segments].index(SegmentKind.PLACE)
    assert f"segment {place} (lift): pushing not allowed" in told(replace(pushing, segments=renamed), heap)


def test_what_is_heavy_or_high_may_not_be_pushed(pushing: Plan, heap: Scene) -> None:
    book, heavy = heap.find(BOOK), with_book_of(heap, 1.1 * HEAVIEST)
    assert f"{BOOK}: may not be pushed: it may have 0.66 kg, at most 0.6" in told(pushing, heavy)
    high = heap.moved(replace(book, T_world_item=pose([0.0, 0.0, 0.17]) @ book.T_world_item))
    assert "over the rim of tote" in told(pushing, high)


def test_nothing_is_pushed_where_something_is_that_nobody_recognised(
    cell: Cell, pushing: Plan, heap: Scene
) -> None:
    """Planner and verifier: wherever in the box it is."""
    T = cell.T_world_place(cell.places[TOTE])
    thing = np.array([[[-0.2, 0.1, 0.0], [-0.19, 0.11, 0.01]]])
    with_it = replace(heap, unknown=(UnknownSpace(TOTE, T, np.zeros((0, 2, 3)), thing),))
    assert f"{BOOK}: may not be pushed: nobody recognised what is at unrecognised_tote_0" in told(
        pushing, with_it
    )
    home = cell.configurations["home"]
    query = PickQuery(TOTE, BOX, neighbours=Neighbours.PUSH)
    with pytest.raises(NoPlanError, match=f"{BOOK} would fall"):
        plan_pick(PlanningContext(cell), with_it, query, Start(home.q, home.tool_state))


def test_nothing_rides_along(pushing: Plan, heap: Scene) -> None:
    book = heap.find(BOOK)
    over = heap.moved(replace(book, T_world_item=pose([-0.08, 0.0, 0.0]) @ book.T_world_item))
    assert f"{BOX}: carries another item along: {BOOK} lies over it" in told(pushing, over)


def test_it_is_slow(pushing: Plan, heap: Scene) -> None:
    """The whole plan a little faster: the tool is over its speed where it pushes."""
    T_tip_item = pose_in_tool(pushing, heap)
    faster = 1.1 * MOST_SPEED / 0.095
    t = pushing.trajectory
    hasty = replace(
        pushing,
        trajectory=Trajectory(
            t.joint_names, t.times / faster, t.positions, t.velocities * faster,
            t.accelerations * faster**2,
        ),
        segments=tuple(
            replace(s, t_start=s.t_start / faster, t_end=s.t_end / faster) for s in pushing.segments
        ),
    )  # fmt: skip
    assert "pushes too fast" in "; ".join(map(str, check_push(hasty, heap, T_tip_item)))
    assert check_push(pushing, heap, T_tip_item) == ()


def test_it_does_not_press_down(pushing: Plan, heap: Scene) -> None:
    """The same plan backwards in time, with lift and retreat as they are called."""
    t = pushing.trajectory
    back = replace(
        pushing,
        trajectory=Trajectory(
            t.joint_names, t.duration - t.times[::-1], t.positions[::-1], -t.velocities[::-1],
            t.accelerations[::-1],
        ),
        segments=tuple(
            replace(s, t_start=t.duration - s.t_end, t_end=t.duration - s.t_start)
            for s in pushing.segments
        ),
    )  # fmt: skip
    found = "; ".join(map(str, check_push(back, heap, pose_in_tool(pushing, heap))))
    assert "pushes downwards" in found


def test_the_load_leaves_a_reserve_for_what_lies_on_it(cell: Cell, pushing: Plan, heap: Scene) -> None:
    """The load by the box grows with its mass, and that by the book with its own at the farthest corner."""
    assert lying_on(heap, BOX) == {BOOK}
    box, T_tip_item = heap.find(BOX), pose_in_tool(pushing, heap)
    assert T_tip_item is not None and pushing.grasp is not None
    times, wrenches = held_wrenches(pushing, heap, T_tip_item)
    loads = load_ratios(pushing, heap, wrenches)
    on_the_way = [(times >= s.t_start) & (times <= s.t_end) for s in pushing.segments if s.pushing]
    load = float(max(loads[at].max() for at in on_the_way))

    def is_refused(share: float, on_it: float) -> bool:
        """With a box that loads the tool by a share, and a book of so many kg."""
        heavier = replace(box, item=replace(box.item, mass=box.item.mass * share / load))
        found = check_push(pushing, with_book_of(heap, on_it).moved(heavier), T_tip_item)
        return "no reserve for pushing" in "; ".join(map(str, found))

    assert not is_refused(0.95 * MOST_LOAD, 0.0) and is_refused(1.05 * MOST_LOAD, 0.0)
    limits, seal = cell.robot.tool.cup.limits, box.item.seals[pushing.grasp.face]
    tip = inverse(T_tip_item)[:3, 3]
    lever = float(np.hypot(*(box.item.shape.extents / 2 + np.abs(tip))[:2]))  # m to the farthest corner
    of_one = GRAVITY * (1.0 / limits.max_pull + lever / limits.max_moment) / seal  # load by one kg there
    most = MOST_LOAD / of_one  # less what the box itself takes, which is next to nothing
    assert not is_refused(0.01, 0.95 * most) and is_refused(0.01, 1.05 * most)


def test_it_goes_on_pushing_after_a_stop_but_not_back(cell: Cell, pushing: Plan, heap: Scene) -> None:
    lift = next(s for s in pushing.segments if s.kind is SegmentKind.LIFT)
    stopped = StoppedMotion(pushing, (lift.t_start + lift.t_end) / 2)
    held = stopped.held_item(cell.robot, heap.find(BOX))
    scene = replace(heap.without(BOX), held=held)
    limits = PlanningContext(cell).arm.limits
    on = bring_item(stopped, ItemRecovery.ON, scene, limits, 0)
    assert on.recovery is RecoveryLevel.AS_PLANNED and on.segments[0].pushing == (OTHER, BOOK)
    assert verify(on, scene).reasons == ()
    back = bring_item(stopped, ItemRecovery.BACK, scene, limits, 0)
    assert not any(segment.pushing for segment in back.segments)
    assert "pushing not allowed" in told(pushes(back, OTHER, BOOK), scene)
    gone = bring_item(stopped, ItemRecovery.ON, replace(scene, items=()), limits, 0)
    assert not any(segment.pushing for segment in gone.segments)


def test_out_of_a_bin_nothing_is_pushed(pushing: Plan, heap: Scene) -> None:
    shelved = tuple(replace(p, location="bin_A") if p.id == BOX else p for p in heap.items)
    found = check_push(pushing, replace(heap, items=shelved), pose_in_tool(pushing, heap))
    assert "pushes outside of an open box" in "; ".join(map(str, found))


def test_the_statement_may_be_longer_than_needed(cell: Cell, pushing: Plan, heap: Scene) -> None:
    """An item that is far away may be stated: that it is not met proves nothing less."""
    far = PlacedItem("far", cell.item(ELSEWHERE), TOTE, in_tote(cell, ELSEWHERE, 0.2, 0.12, 0.0).T_world_item)
    more = replace(heap, items=(*heap.items, far))
    assert told(pushes(pushing, BOOK, OTHER, "far"), more) == ""


@st.composite
def heaps(draw: st.DrawFn) -> Scene:
    """Boxes of any size and mass in a crate, each lowered at a place onto those that are there."""
    cell, items = CRATES, []
    lows, highs = np.empty((0, 2)), np.empty((0, 2))
    tops = np.empty(0)
    for k in range(draw(st.integers(2, 7))):
        size = np.array(draw(st.tuples(*[st.floats(0.02, 0.12)] * 3)))
        xy = np.array(draw(st.tuples(st.floats(-0.12, 0.12), st.floats(-0.08, 0.08))))
        low, high = xy - size[:2] / 2, xy + size[:2] / 2
        is_below = ((lows < high) & (highs > low)).all(axis=1)
        floor = float(tops[is_below].max(initial=0.0)) + APART
        shape = Shape(ShapeKind.BOX, tuple(size.tolist()))
        item = replace(cell.item("crayola_24_ct"), shape=shape, mass=draw(st.floats(0.05, 0.7)))
        T = cell.T_world_place(cell.places[CRATE]) @ pose([*xy, floor + size[2] / 2])
        items.append(PlacedItem(f"item{k}", item, CRATE, T))
        lows, highs = np.vstack([lows, low]), np.vstack([highs, high])
        tops = np.append(tops, floor + size[2])
    noise = PoseNoise(draw(st.sampled_from([0.0, 0.003])), draw(st.sampled_from([0.0, 0.02])))
    return Scene(cell, cell.T_world_pod, tuple(items), noise)


@given(heaps())
@settings(deadline=None, max_examples=200)
def test_what_the_planner_pushes_the_verifier_lets_it_push(scene: Scene) -> None:
    """And what would ride along by the verifier's rules does so by the planner's, which are more cautious."""
    supports, taken = supports_of(scene), scene.find("item0")
    heap = PushedHeap(scene, scene.cell.places[CRATE], taken)
    pushed = pushable(supports, taken.id)
    assert list(heap.not_pushable(pushed)) == []
    assert {reason.in_the_way for reason in heap.carried_along(pushed)} <= set(riders(supports, taken.id))
    assert heap.mass_on_it(pushed) <= mass_above(supports, taken.id) + 1e-9
