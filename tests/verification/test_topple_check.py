"""What an empty tool may topple: every condition is the verifier's own, and every edit is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pickcli.geometry import Array, pose
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.planning.topple import TopplingQuery, plan_topple
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.scene.unknown_space import UnknownSpace
from pickcli.statics.supports import supports_of
from pickcli.statics.toppling import Topple, topples
from pickcli.verification.push_check import HEAVIEST, MOST_SPEED
from pickcli.verification.topple_check import check_topple, is_toppling
from pickcli.verification.verify import verify
from support.standing import BOX, CRATE, CRATES, SHELF, box, crate, lying, standing

HOME = CRATES.configurations["home"]
CARDS, KIND = "mead_index_cards", SegmentKind


@pytest.fixture(scope="module")
def scene() -> Scene:
    return crate(standing(BOX, 0.0, 0.0), lying(CARDS, -0.12, 0.0))


@pytest.fixture(scope="module")
def plan(scene: Scene) -> Plan:
    return plan_topple(
        PlanningContext(CRATES), scene, TopplingQuery(CRATE, BOX), Start(HOME.q, HOME.tool_state)
    )


def told(plan: Plan, scene: Scene) -> str:
    """All that the verifier has against a plan in another scene than its own."""
    return "; ".join(map(str, verify(replace(plan, scene_hash=scene_hash(scene)), scene).reasons))


def checked(plan: Plan, scene: Scene) -> str:
    """What this check alone has against a plan."""
    return "; ".join(map(str, check_topple(plan, scene)))


def with_segments(plan: Plan, change: Callable[[Segment], Segment]) -> Plan:
    return replace(plan, segments=tuple(change(segment) for segment in plan.segments))


def moved(plan: Plan, by: Callable[[Array], Array]) -> Plan:
    """The plan with other positions (N, n), as functions of the old ones."""
    return replace(plan, trajectory=replace(plan.trajectory, positions=by(plan.trajectory.positions)))


def test_the_plan_is_accepted(plan: Plan, scene: Scene) -> None:
    assert is_toppling(plan) and verify(plan, scene).reasons == ()


def test_nothing_is_toppled_where_something_is_that_nobody_recognised(plan: Plan, scene: Scene) -> None:
    thing = np.array([[[-0.1, 0.1, 0.0], [-0.09, 0.11, 0.01]]])
    T = scene.T_world_place(scene.cell.places[CRATE])
    with_it = replace(scene, unknown=(UnknownSpace(CRATE, T, np.zeros((0, 2, 3)), thing),))
    assert "may not be toppled: nobody recognised what is at" in told(plan, with_it)
    found = topples(supports_of(with_it), BOX)
    assert "nobody recognised what is at" in str(found)


def test_without_the_statement_it_is_a_collision(plan: Plan, scene: Scene) -> None:
    found = told(with_segments(plan, lambda s: replace(s, pushing=())), scene)
    assert f"cup and {BOX}" in found and "collision" in found


def test_only_the_named_items_may_be_met(plan: Plan) -> None:
    """Another item stands where the tool goes to push."""
    push, *_ = topples_of(crate(standing(BOX, 0.0, 0.0)))
    other = standing(f"{BOX}#2", -0.06 * float(push.direction[0]), -0.06 * float(push.direction[1]))
    assert f"{BOX}#2" in told(plan, crate(standing(BOX, 0.0, 0.0), lying(CARDS, -0.12, 0.1), other))


def topples_of(scene: Scene) -> tuple[Topple, ...]:
    found = topples(supports_of(scene), BOX)
    assert isinstance(found, tuple)
    return found


@pytest.mark.parametrize(
    "change",
    [
        lambda s: replace(s, pushing=(BOX,)),  # before the push, too
        lambda s: replace(s, pushing=(BOX,) if s.kind is KIND.PUSH else ()),  # not on the way out
        lambda s: replace(s, kind=KIND.RETREAT if s.kind is KIND.DEPART else s.kind),
        lambda s: replace(s, kind=KIND.DEPART if s.kind is KIND.PUSH else s.kind),
    ],
)
def test_only_a_push_and_the_way_out_after_it_may(
    plan: Plan, scene: Scene, change: Callable[[Segment], Segment]
) -> None:
    assert "pushing not allowed" in checked(with_segments(plan, change), scene)


def test_no_recovery_may(plan: Plan, scene: Scene) -> None:
    assert "pushing not allowed" in checked(replace(plan, recovery=RecoveryLevel.AS_PLANNED), scene)


@pytest.mark.parametrize(("name", "why"), [("nothing", "it is not in the scene"), (CARDS, "kg")])
def test_only_items_of_the_scene_that_are_light_together(
    plan: Plan, scene: Scene, name: str, why: str
) -> None:
    cards = scene.find(CARDS)
    heavy = scene.moved(replace(cards, item=replace(cards.item, mass=HEAVIEST)))
    named = with_segments(plan, lambda s: replace(s, pushing=tuple(sorted((BOX, name))) if s.pushing else ()))
    assert why in checked(named, heavy)


def test_not_what_is_in_another_place_or_in_two(plan: Plan) -> None:
    shelf = crate(standing(BOX, 0.1, 0.0, place=SHELF), lying(CARDS, -0.12, 0.0))
    assert f"the tool is not over the floor of {SHELF}" in checked(plan, shelf)
    both = with_segments(plan, lambda s: replace(s, pushing=(BOX, CARDS) if s.pushing else ()))
    assert "pushes outside of a box" in checked(both, shelf)


def test_not_what_is_heavy_or_could_leave_the_box(plan: Plan) -> None:
    heavy = crate(standing(BOX, 0.0, 0.0, item=box(0.095, 0.07, 0.025, mass=HEAVIEST)))
    assert f"at most {HEAVIEST}" in checked(plan, heavy)
    large = crate(standing(BOX, 0.0, 0.0, item=box(0.25, 0.07, 0.025)))
    assert "over the rim" in checked(plan, large)


def test_what_lies_on_it_must_be_named(plan: Plan) -> None:
    on_it = lying(CARDS, 0.0, 0.0, up=float(CRATES.item(BOX).shape.extents[1]) + 0.0002)
    scene = crate(standing(BOX, 0.0, 0.0), on_it)
    assert f"{CARDS} lies on it and is not named" in checked(plan, scene)
    named = with_segments(plan, lambda s: replace(s, pushing=(BOX, CARDS) if s.pushing else ()))
    assert "lies on it" not in checked(named, scene)


def test_not_faster(plan: Plan, scene: Scene) -> None:
    trajectory = plan.trajectory
    fast = replace(trajectory, times=trajectory.times / 2, velocities=2 * trajectory.velocities,
                   accelerations=4 * trajectory.accelerations)  # fmt: skip
    twice = with_segments(plan, lambda s: replace(s, t_start=s.t_start / 2, t_end=s.t_end / 2))
    assert f"at most {MOST_SPEED}" in checked(replace(twice, trajectory=fast), scene)


def test_not_downwards_and_not_straight_up(plan: Plan, scene: Scene) -> None:
    """The departure stated as a push; and the way in, after a transit that might have moved the item."""
    first = next(k for k, s in enumerate(plan.segments) if s.kind is KIND.PUSH)
    lifted = list(plan.segments)
    lifted[-1] = replace(lifted[-1], kind=KIND.PUSH)
    assert "lifts instead of pushing" in checked(replace(plan, segments=tuple(lifted)), scene)
    down = list(plan.segments)
    for k in (first - 2, first - 1):
        down[k] = replace(down[k], kind=KIND.PUSH, pushing=(BOX,))
    assert "pushes downwards" in checked(replace(plan, segments=tuple(down)), scene)


@pytest.fixture(scope="module")
def beside_a_wall() -> Scene:
    return crate(standing(BOX, 0.16, 0.0, item=box(0.095, 0.07, 0.03)))


@pytest.fixture(scope="module")
def from_above(beside_a_wall: Scene) -> Plan:
    """The cup is pressed on the item's upper side, and turns with it."""
    query, start = TopplingQuery(CRATE, BOX), Start(HOME.q, HOME.tool_state)
    return plan_topple(PlanningContext(CRATES), beside_a_wall, query, start)


def test_only_the_bellows_press_from_above(from_above: Plan, beside_a_wall: Scene) -> None:
    """Where the item is higher than stated by what they have left, the rigid part of the cup meets it."""
    assert verify(from_above, beside_a_wall).reasons == ()
    placed = beside_a_wall.find(BOX)
    top = placed.item.shape.extents[1] / 2
    spare = CRATES.robot.tool.cup.stroke / 2 - float(beside_a_wall.noise.at(top))
    for up, is_met in ((0.8 * spare, False), (1.5 * spare, True)):
        T = pose((0.0, 0.0, up)) @ placed.T_world_item
        raised = beside_a_wall.moved(replace(placed, T_world_item=T))
        assert (f"with its rigid part onto {BOX}" in checked(from_above, raised)) == is_met


def test_not_below_the_middle_of_all_items(plan: Plan) -> None:
    """The same motion, against an item that is much higher."""
    high = crate(standing(BOX, 0.0, 0.0, item=box(0.03, 0.12, 0.025)))
    raised = high.find(BOX)
    above = high.moved(replace(raised, T_world_item=pose((0.0, 0.0, 0.03)) @ raised.T_world_item))
    assert "below their middle" in checked(plan, above)


def test_not_onto_a_wall_and_not_outside(plan: Plan) -> None:
    """The same motion beside walls that stand elsewhere: an item as thick as the room that is left."""
    thick = crate(standing(BOX, 0.0, 0.0, item=box(0.19, 0.19, 0.19)))
    assert "squeezes onto a wall" in checked(plan, thick)
    turned = moved(plan, lambda Q: Q + np.array([0.6, *np.zeros(5)]))
    assert "is not over the floor" in checked(turned, crate(standing(BOX, 0.0, 0.0)))


def test_not_far(plan: Plan, scene: Scene) -> None:
    stretched = moved(plan, lambda Q: Q[0] + 4.0 * (Q - Q[0]))
    assert "at most 150" in checked(stretched, scene)


def test_it_is_straight_and_keeps_the_walls_clear_as_ever(plan: Plan, scene: Scene) -> None:
    first = next(k for k, s in enumerate(plan.segments) if s.kind is KIND.PUSH)
    one, two = plan.segments[first : first + 2]
    joined = replace(
        plan, segments=(*plan.segments[:first], replace(one, t_end=two.t_end), *plan.segments[first + 2 :])
    )
    assert "not straight" in told(joined, scene)
