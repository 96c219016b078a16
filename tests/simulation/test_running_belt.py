"""The running belt of the simulated world: items ride exactly, and are taken only by a cup that keeps up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.errors import InputError
from pickcli.geometry import pose
from pickcli.motion.plan import times_at_work
from pickcli.motion.segment import SegmentKind
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.operator_stop import OperatorStop, signal_of
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.reality import IDEAL
from pickcli.simulation.world import World
from pickcli.verification.verify import verify
from support.belt_picks import belt_pick, cell, context, home, pick_on_the_way, stream


def world(scene: Scene, speed: float) -> World:
    start = home()
    running = World(scene, start.q, start.tool_state, reality=IDEAL)
    running.run_belt("belt", speed)
    return running


@pytest.mark.parametrize("speed", [0.1, 0.5])
def test_items_ride_at_the_speed_of_the_belt(speed: float) -> None:
    scene = stream(speed).scene_at(3.0)
    running = world(scene, speed)
    running.wait(0.8)
    for placed in scene.items:
        way = running.engine.pose(placed.id)[:3, 3] - placed.T_world_item[:3, 3]
        assert way == pytest.approx([0.8 * speed, 0.0, 0.0], abs=1e-3)
    running.close()


def test_items_that_are_not_on_the_belt_yet_come_onto_it() -> None:
    items = replace(stream(), items=stream().items[-1:])
    t = items.items[0].stamp - 6.0  # 2 m before the infeed, beyond the floor of the hall
    running = world(items.scene_at(t), 0.33)
    running.wait(1.0)
    (placed,) = running.scene.items
    way = running.engine.pose(placed.id)[:3, 3] - placed.T_world_item[:3, 3]
    assert way == pytest.approx([0.33, 0.0, 0.0], abs=1e-3)
    running.close()


@pytest.mark.parametrize("t_change", [2.6, 4.2, 4.5])
def test_a_belt_that_strays_from_the_plan_stops_it_by_name_and_the_arm_leaves_it(t_change: float) -> None:
    """It becomes faster than the plan can follow: while the arm comes, on its lines, and on the item."""
    pick = belt_pick()
    running = world(pick.scene, 0.33)

    def change_speed(at: World) -> None:
        if at.t == pytest.approx(t_change):
            at.belts["belt"].change_speed(0.5, 0.5)

    run = execute(pick.plan, running, on_step=change_speed)
    assert run.stop is not None and run.stop.cause is StopCause.BELT and "ahead of" in run.stop.where
    assert run.limit_violations == () and run.collisions == () and run.is_clear
    stood_at = running.q
    running.wait(0.5)
    assert running.contacts.since(0.0) == () and np.allclose(running.q, stood_at, atol=1e-3)
    running.close()


@pytest.mark.parametrize(
    ("t_stop", "ends"), [(1.0, True), (3.9, True), (4.2, True), (4.5, False), (5.6, False)]
)
def test_stopped_by_the_operator_the_arm_leaves_the_belt_and_goes_on_with_the_item(
    t_stop: float, ends: bool
) -> None:
    """Before the item is met, the motion ends: coming, coming up to the speed of the belt, on the lines."""
    pick = belt_pick()
    assert pick.plan.grasp is not None
    running = world(pick.scene, 0.33)
    run = execute(pick.plan, running, operator=signal_of([OperatorStop(t_stop, t_stop + 2.0)]))
    assert run.collisions == () and run.limit_violations == ()
    assert len(run.operator_stops) == 1 and run.operator_stops[0].begin == pytest.approx(t_stop, abs=2e-3)
    where = running.placed(pick.plan.grasp.item).location
    if ends:
        assert run.stop is not None and run.stop.cause is StopCause.OPERATOR and run.is_clear
        assert where == "belt" and run.operator_stops[0].end is None
    else:
        assert run.stop is None and where == "tote"
        # Released while it still brakes with the item, it comes to rest first.
        assert run.operator_stops[0].end is not None
        assert t_stop + 2.0 - 2e-3 <= run.operator_stops[0].end <= t_stop + 2.5
    running.close()


@pytest.mark.parametrize("t_stop", [0.0, 0.02, 0.3, 0.8, 1.1, 1.3, 1.48, 1.56])
def test_stopped_on_its_way_to_the_belt_the_arm_rests_clear_of_it(t_stop: float) -> None:
    """On its path, if it can rest there before the lines begin; else, but for its axis, where they begin."""
    pick = pick_on_the_way()
    t_works, over_tote = times_at_work(pick.plan.segments)[0], cell().configurations["drop_01"]
    running = World(pick.scene, over_tote.q, over_tote.tool_state, reality=IDEAL)
    running.run_belt("belt", 0.33)
    run = execute(pick.plan, running, operator=signal_of([OperatorStop(t_stop, t_stop + 2.0)]))
    assert t_stop < t_works and run.collisions == () and run.limit_violations == ()
    assert run.stop is not None and run.stop.cause is StopCause.OPERATOR and run.is_clear
    assert run.stops_on_way_off == () and running.t < t_stop + 1.2
    path = pick.plan.trajectory.sample(np.linspace(0.0, t_works, 3000))
    assert np.abs(path - running.q)[:, 1:].max(axis=1).min() < 2e-3
    if t_stop < 1.0:
        assert np.abs(path - running.q).max(axis=1).min() < 2e-3
    running.close()


def test_stopped_among_the_items_of_a_belt_that_stands_the_arm_leaves_it() -> None:
    pick = belt_pick()
    contact = next(s for s in pick.plan.segments if s.kind is SegmentKind.CONTACT)
    running = world(pick.scene, 0.33)
    stands_from = contact.t_start - 0.5

    def stand(at: World) -> None:
        if abs(at.t - stands_from) < at.time_step / 2:
            at.belts["belt"].change_speed(0.0, 0.5)

    t_stop = contact.t_start + 1.0
    run = execute(pick.plan, running, operator=signal_of([OperatorStop(t_stop, 60.0)]), on_step=stand)
    assert run.stop is not None and run.stop.cause is StopCause.OPERATOR and run.is_clear
    assert run.collisions == () and running.belts["belt"].speed == 0.0
    ready = pick.plan.trajectory.sample(np.array([times_at_work(pick.plan.segments)[0]]))[0]
    assert running.q[1:] == pytest.approx(ready[1:], abs=3e-3)
    running.close()


def test_an_arm_that_was_stopped_over_the_belt_plans_from_there() -> None:
    pick = belt_pick()
    running = world(pick.scene, 0.33)
    execute(pick.plan, running, operator=signal_of([OperatorStop(4.2, 20.0)]))
    start, t = Start(running.q.copy(), running.tool_state), pick.now + running.t
    running.close()
    met = [each for each in pick.stream.items if -0.6 < pick.stream.travel_at(each, t) - 0.6 < 0.6]
    assert met
    plan = plan_intercept(context(), pick.stream, InterceptQuery(met[0].id, t), start)
    assert verify(plan, pick.stream.scene_at(t)).reasons == ()


def test_without_an_encoder_an_uncertain_speed_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    pick = belt_pick()
    assert pick.plan.tracking is not None
    running = world(pick.scene, 0.33)
    monkeypatch.setattr(running, "belt_travel", lambda conveyor: None)
    unsure = replace(pick.plan, tracking=replace(pick.plan.tracking, speed_error=0.01))
    with pytest.raises(InputError, match="without an encoder"):
        execute(unsure, running)
    running.close()


def test_an_item_put_down_at_rest_is_taken_along() -> None:
    scene = stream().scene_at(3.0)
    item = scene.cell.item("crayola_24_ct")
    T = pose((-1.0, 0.65, 0.60 + float(item.shape.extents[2]) / 2))
    placed = PlacedItem("late", item, "tote", T)  # not on the belt by the scene, so that it begins at rest
    running = world(replace(scene, items=(placed,)), 0.33)
    running.wait(0.5)
    speed, _ = running.engine.speed("late")
    behind = 0.5 * 0.33 - float(running.engine.pose("late")[0, 3] - T[0, 3])
    assert speed == pytest.approx(0.33, abs=2e-3)
    # By friction alone it slips by v^2 / (2 mu g).
    assert behind == pytest.approx(0.33**2 / (2 * 0.8 * 0.6 * 9.81), rel=0.25)
    running.close()


@pytest.mark.parametrize("speed", [0.1, 0.33, 0.5])
def test_the_item_of_a_plan_comes_into_the_tote(speed: float) -> None:
    pick = belt_pick(speed)
    assert pick.plan.grasp is not None
    running = world(pick.scene, speed)
    run = execute(pick.plan, running)
    assert run.stop is None and run.collisions == () and run.limit_violations == ()
    assert running.placed(pick.plan.grasp.item).location == "tote"
    running.close()


@pytest.mark.parametrize("change", [(4.2, 0.264, 0.2), (4.7, 0.264, 0.2), (4.6, 0.0, 0.5)])
def test_a_belt_that_slows_down_or_stops_costs_nothing_but_time(change: tuple[float, float, float]) -> None:
    """While the arm follows it; a belt that has stopped runs on after a second and a half."""
    pick, (t_change, speed, acceleration) = belt_pick(), change
    assert pick.plan.grasp is not None
    running = world(pick.scene, 0.33)

    def change_speed(at: World) -> None:
        if at.t == pytest.approx(t_change):
            at.belts["belt"].change_speed(speed, acceleration)
        if speed == 0.0 and at.t == pytest.approx(t_change + 1.5):
            at.belts["belt"].change_speed(0.33, acceleration)

    run = execute(pick.plan, running, on_step=change_speed)
    assert run.stop is None and run.collisions == () and run.limit_violations == ()
    assert running.placed(pick.plan.grasp.item).location == "tote"
    assert running.t > pick.plan.trajectory.duration + 0.15
    running.close()


def test_a_cup_that_does_not_keep_up_with_the_belt_holds_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The belt is slower than the plan by 60 mm/s, and no encoder tells: the cup slides over the item."""
    pick = belt_pick()
    assert pick.plan.grasp is not None
    running = world(pick.scene, 0.27)
    monkeypatch.setattr(running, "belt_travel", lambda conveyor: None)
    execute(pick.plan, running)
    assert running.placed(pick.plan.grasp.item).location != "tote"
    running.close()


def test_the_same_world_is_the_same_to_the_bit() -> None:
    scene = stream().scene_at(3.0)
    poses = []
    for _ in range(2):
        running = world(scene, 0.33)
        running.wait(0.3)
        poses.append(np.stack([running.engine.pose(placed.id) for placed in scene.items]))
        running.close()
    assert np.array_equal(poses[0], poses[1])
