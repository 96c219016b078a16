"""What is in the way is found by thinking it away, and nothing more than that is moved."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import inverse, pose
from pickcli.motion.plan import Certify, Plan
from pickcli.planning.blockers import MOST_BLOCKERS, blocking_items, from_the_mouth
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.trial.action_values import MOST_CLEARINGS
from pickcli.trial.clearing import destinations
from pickcli.trial.loop import run_trial
from pickcli.trial.order import Target
from pickcli.trial.trial_result import Outcome
from support.order_builders import pick_order
from support.scripted_trial import ScriptedTrial, scene_of

TARGET = "crayola_24_ct"
NAMES = ("dove_beauty_bar", "jane_eyre_dvd", "scotch_duct_tape", "command_hooks", "up_glucose_bottle")
ORDER = pick_order(
    {"bin_A": ("crayola_24_ct", *NAMES), "bin_B": ("dasani_water_bottle",)}, ("bin_A", "crayola_24_ct")
)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return scene_of(ORDER, load_cell("apc2016_delft"))


class Planner:
    """Plans once a set of items is gone; blames what is left of it, and decoys, by rank."""

    def __init__(self, needed: frozenset[str], blamed: tuple[str, ...] = NAMES) -> None:
        self.needed, self.blamed = needed, blamed
        self.n_calls = 0

    def __call__(self, scene: Scene) -> None:
        self.n_calls += 1
        there = {placed.id for placed in scene.items}
        if self.needed & there:
            ranked = [name for name in self.blamed if name in there]
            counts = Counter({name: len(ranked) - k for k, name in enumerate(ranked)})
            raise NoPlanError("pick", [Reason("collision", "", "", name) for name in counts.elements()])


@given(st.sets(st.sampled_from(NAMES), max_size=3))
def test_those_and_no_others_are_found(scene: Scene, needed: set[str]) -> None:
    ranked = (*sorted(needed), *(name for name in NAMES if name not in needed))
    assert set(blocking_items(Planner(frozenset(needed), ranked), scene, scene.find(TARGET))) == needed


def test_a_target_is_never_in_its_own_way(scene: Scene) -> None:
    """A tool that cannot get at one of its faces for the item itself names that item."""
    planner = Planner(frozenset(NAMES[:1]), (TARGET, *NAMES))
    assert blocking_items(planner, scene, scene.find(TARGET)) == NAMES[:1]
    refused_before = blocking_items(
        Planner(frozenset()), scene, scene.find(TARGET), blamed=(TARGET, NAMES[1])
    )
    assert TARGET not in refused_before


def test_decoys_are_dropped_again(scene: Scene) -> None:
    decoy, needed = NAMES[0], NAMES[1]
    assert blocking_items(Planner(frozenset({needed}), NAMES), scene, scene.find(TARGET)) == (needed,)
    assert decoy != needed


def test_too_many_in_the_way_or_something_that_is_fixed_is_no_help(scene: Scene) -> None:
    endless = Planner(frozenset(NAMES) | {"crayola_24_ct"})
    assert blocking_items(endless, scene, scene.find(TARGET)) == ()
    elsewhere = Planner(frozenset({"dasani_water_bottle"}), ("dasani_water_bottle",))
    assert blocking_items(elsewhere, scene, scene.find(TARGET)) == ()
    assert elsewhere.n_calls == 1


@pytest.mark.parametrize("needed", [*combinations(NAMES, MOST_BLOCKERS)])
def test_the_planner_is_asked_a_bounded_number_of_times(scene: Scene, needed: tuple[str, ...]) -> None:
    planner = Planner(frozenset(needed))
    blocking_items(planner, scene, scene.find(TARGET))
    assert planner.n_calls <= 2 * MOST_BLOCKERS


def test_the_emptiest_bin_comes_first_and_one_with_targets_last(scene: Scene) -> None:
    bins = list(destinations(scene, "bin_A", [Target("bin_C", "jane_eyre_dvd")]))
    assert bins == ["bin_D", "bin_E", "bin_F", "bin_G"]  # empty; two others are not, or are waited for
    few = list(destinations(scene, "bin_A", [Target(f"bin_{c}", "x") for c in "CDEFGHIJKL"]))
    assert few[0] == "bin_B"  # it holds something, but no target waits there


def test_what_lies_on_a_blocker_is_moved_before_it(scene: Scene) -> None:
    """Two layers over the target: the failed plan of the lower one names the upper one."""
    lower, upper = "jane_eyre_dvd", "dove_beauty_bar"
    fake = ScriptedTrial(scene, blocked={"crayola_24_ct": lower, lower: upper})
    result = run_trial(ORDER, fake.interfaces())
    assert [plan.query for plan in fake.executed] == [
        f"pick {upper} into bin_C",
        f"pick {lower} into bin_D",
        "pick crayola_24_ct",
    ]
    assert result.items_in_tote == 1


def test_what_is_blamed_is_moved_at_last_even_if_that_alone_does_not_help(scene: Scene) -> None:
    stubborn = Planner(frozenset({"up_glucose_bottle", "crayola_24_ct"}), ("up_glucose_bottle",))
    assert blocking_items(stubborn, scene, scene.find(TARGET)) == ()
    assert blocking_items(stubborn, scene, scene.find(TARGET), is_hopeful=True) == ("up_glucose_bottle",)


def test_what_no_bin_takes_goes_into_the_tote_and_counts_as_moved_aside(scene: Scene) -> None:
    blocker = "jane_eyre_dvd"
    fake = ScriptedTrial(scene, blocked={"crayola_24_ct": blocker})
    plan = fake.plan

    def no_room(scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        if query.item == blocker and query.into != TOTE:
            raise NoPlanError("pick", [Reason("no free place on the floor", query.into)])
        return plan(scene, query, start, seed, certify)

    fake.plan = no_room  # type: ignore[method-assign]
    result = run_trial(ORDER, fake.interfaces())
    (aside,) = (a for a in result.attempts if a.item == blocker and a.execution is not None)
    assert (aside.into, aside.outcome, aside.is_aside) == (TOTE, Outcome.MOVED, True)
    assert result.score.total == result.score.maximum
    assert [target.outcome for target in result.targets] == [Outcome.IN_TOTE]
    assert result.final.claim is not None and blocker in result.final.claim.tote_contents


class NoRoomThere(ScriptedTrial):
    """No place takes the blocker, for what lies in a bin: an item that has nothing to do with the target."""

    def plan(self, scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        if query.into != TOTE or query.item == NAMES[0]:
            self.planned.append((query.item, 0, ()))
            raise NoPlanError(f"pick {query.item}", [Reason("too close", "place", "", "dasani_water_bottle")])
        return super().plan(scene, query, start, seed, certify)


def test_what_lies_in_the_bin_that_would_take_a_blocker_is_left_there(scene: Scene) -> None:
    fake = NoRoomThere(scene, blocked={"crayola_24_ct": NAMES[0]})
    run_trial(ORDER, fake.interfaces())
    assert {item for item, _, _ in fake.planned} == {"crayola_24_ct", *NAMES}  # the bottle is elsewhere


def test_what_does_not_come_out_is_offered_to_the_tote_alone(scene: Scene) -> None:
    fake = ScriptedTrial(scene, blocked={"crayola_24_ct": NAMES[0]}, no_plan=frozenset(NAMES))
    result = run_trial(ORDER, fake.interfaces())
    asides = [attempt for attempt in result.attempts if attempt.is_aside]
    assert {(a.item, a.into) for a in asides} == {(name, TOTE) for name in NAMES}
    assert [a.item for a in asides].count(NAMES[0]) <= MOST_CLEARINGS


def test_what_is_not_blamed_is_moved_where_what_is_blamed_cannot_be(scene: Scene) -> None:
    """The target waits for one item, that one for another that nobody names."""
    fake = ScriptedTrial(scene, blocked={"crayola_24_ct": NAMES[0], NAMES[0]: NAMES[1]})
    plan = fake.plan

    def unnamed(*args):  # type: ignore[no-untyped-def]
        try:
            return plan(*args)
        except NoPlanError as error:
            if args[2] == NAMES[0]:
                raise NoPlanError("pick", [Reason("no room for the tool", "lift")]) from error
            raise

    fake.plan = unnamed  # type: ignore[method-assign]
    result = run_trial(ORDER, fake.interfaces())
    assert result.items_in_tote == 1
    moved = [attempt.item for attempt in result.attempts if attempt.outcome is Outcome.MOVED]
    assert moved.index(NAMES[1]) < moved.index(NAMES[0]) == len(moved) - 1
    asked = [attempt.item for attempt in result.attempts if attempt.is_aside]
    assert asked[0] == NAMES[0]  # what is blamed is asked for first


def test_nothing_is_planned_for_the_others_while_what_is_blamed_can_be_moved(scene: Scene) -> None:
    fake = ScriptedTrial(scene, blocked={"crayola_24_ct": NAMES[0]})
    assert run_trial(ORDER, fake.interfaces()).items_in_tote == 1
    assert [item for item, _, _ in fake.planned] == [
        "crayola_24_ct",  # refused
        "crayola_24_ct",  # what if it were not for the one that is blamed
        NAMES[0],  # does it come out
        NAMES[0],  # into another bin
        "crayola_24_ct",
    ]


def test_the_nearest_to_the_mouth_comes_first(scene: Scene) -> None:
    place = scene.cell.places["bin_A"]
    T_entry_world = inverse(scene.T_world_place(place) @ place.T_place_entry)
    items = [
        replace(p, T_world_item=p.T_world_item @ pose((0.01 * (k % 3), 0.0, 0.0)))
        for k, p in enumerate(scene.in_location("bin_A"))
    ]
    depths = [float((T_entry_world @ p.T_world_item)[0, 3]) for p in from_the_mouth(scene, items)]
    assert depths == sorted(depths)


def test_the_mouth_of_a_box_is_above_it() -> None:
    cell = load_cell("ur5e_crates")
    place, item = cell.places["crate_left"], cell.item("dove_beauty_bar")
    lying, over = (
        PlacedItem(name, item, place.name, cell.T_world_place(place) @ pose((0.0, 0.0, z)))
        for name, z in (("a", 0.02), ("b", 0.08))
    )
    scene = Scene(cell, cell.T_world_pod, (lying, over), PoseNoise())
    assert [placed.id for placed in from_the_mouth(scene, scene.items)] == ["b", "a"]


def test_what_cannot_be_held_is_not_offered_to_every_bin() -> None:
    order = pick_order({"bin_A": ("crayola_24_ct", "fitness_gear_3lb_dumbbell")}, ("bin_A", "crayola_24_ct"))
    blocker = "fitness_gear_3lb_dumbbell"
    fake = ScriptedTrial(
        scene_of(order, load_cell("apc2016_delft")),
        blocked={"crayola_24_ct": blocker}, no_plan=frozenset({blocker}),
    )  # fmt: skip
    result = run_trial(order, fake.interfaces())
    asked = [item for item, _, _ in fake.planned].count(blocker)
    assert asked == sum(attempt.item == blocker for attempt in result.attempts) <= MOST_CLEARINGS
    assert [target.outcome for target in result.targets] == [Outcome.NO_PLAN]


def test_what_turns_out_to_be_reachable_is_picked_by_the_same_look() -> None:
    """Refused by what was seen then; seen again since, thinking nothing away helps."""
    order = pick_order(
        {"bin_A": ("crayola_24_ct", "jane_eyre_dvd", "scotch_duct_tape"), "bin_B": ("dove_beauty_bar",)},
        ("bin_A", "crayola_24_ct"),
        ("bin_B", "dove_beauty_bar"),
    )
    fake = ScriptedTrial(scene_of(order, load_cell("apc2016_delft")))
    plan, refused = fake.plan, list[str]()

    def refuse_once(scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        if query.item == "crayola_24_ct" and not refused:
            refused.append(query.item)
            raise NoPlanError("pick", [Reason("collision", "lift", "", "jane_eyre_dvd")])
        return plan(scene, query, start, seed, certify)

    fake.plan = refuse_once  # type: ignore[method-assign]
    result = run_trial(order, fake.interfaces())
    assert result.items_in_tote == 2
    assert [query.query for query in fake.executed] == ["pick dove_beauty_bar", "pick crayola_24_ct"]


def test_a_pick_that_was_refused_is_not_planned_again_in_the_same_scene() -> None:
    fake = ScriptedTrial(
        scene_of(ORDER, load_cell("apc2016_delft")), blocked={"crayola_24_ct": "jane_eyre_dvd"}
    )
    assert run_trial(ORDER, fake.interfaces()).items_in_tote == 1
    asked = [
        id(seen)
        for (item, _, _), seen in zip(fake.planned, fake.perceived, strict=True)
        if item == "crayola_24_ct"
    ]
    assert len(asked) == len(set(asked))  # no scene twice


def test_what_cannot_be_held_is_not_planned_for_as_something_to_move_aside() -> None:
    order = pick_order({"bin_A": ("crayola_24_ct", "fitness_gear_3lb_dumbbell")}, ("bin_A", "crayola_24_ct"))
    fake = ScriptedTrial(
        scene_of(order, load_cell("apc2016_delft")), blocked={"crayola_24_ct": "fitness_gear_3lb_dumbbell"}
    )
    assert run_trial(order, fake.interfaces()).items_in_tote == 0
    assert {item for item, _, _ in fake.planned} == {"crayola_24_ct"}
