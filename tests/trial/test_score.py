"""Laws of the score: bounds, additivity, no influence of order; and the figures of the rules."""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.scene.scene import TOTE
from pickcli.simulation.places import OUTSIDE
from pickcli.trial.damage import Damage
from pickcli.trial.final_state import HELD, Drop, FinalItem, FinalState
from pickcli.trial.order import Order, OrderKind, Target
from pickcli.trial.order_file import BINS
from pickcli.trial.score import RULES, ScoringRules, item_bonuses, maximum_score, score, target_points
from support.order_builders import ITEMS, pick_order

BONUS = dict(zip(ITEMS, (0, 0, 1, 2, 3), strict=True))


def start_state(order: Order) -> FinalState:
    """Nothing has moved, and the output file says so."""
    places = [(name, b) for b, names in order.bin_contents.items() for name in names]
    places += [(name, TOTE) for name in order.tote_contents]
    items = tuple(FinalItem(f"{name}#{i}", name, place, place) for i, (name, place) in enumerate(places))
    return FinalState(items, truthful_claim(order, items))


def truthful_claim(order: Order, items: tuple[FinalItem, ...]) -> Order:
    """The output file that is right in everything."""
    contents = {b: tuple(i.name for i in items if i.end == b) for b in order.bin_contents}
    return Order(OrderKind.OUTPUT, 2016, contents, tuple(i.name for i in items if i.end == TOTE), ())


def moved(order: Order, state: FinalState, index: int, end: str) -> FinalState:
    """The state with one item elsewhere, and the output file still right."""
    items = list(state.items)
    items[index] = replace(items[index], end=end)
    return replace(state, items=tuple(items), claim=truthful_claim(order, tuple(items)))


@st.composite
def pick_orders(draw: st.DrawFn, years: tuple[int, ...] = (2015, 2016)) -> Order:
    """Orders with up to four items in a few bins."""
    names = st.lists(st.sampled_from(ITEMS), min_size=1, max_size=6).map(tuple)
    contents = {b: draw(names) for b in draw(st.sets(st.sampled_from(BINS), min_size=1, max_size=4))}
    copies = sorted((b, item) for b, items in contents.items() for item in items)
    targets = draw(st.permutations(copies))[: draw(st.integers(1, len(copies)))]
    return pick_order(contents, *targets, year=draw(st.sampled_from(years)))


@st.composite
def games(draw: st.DrawFn) -> tuple[Order, FinalState]:
    """Any order and any final state of it."""
    order = draw(pick_orders())
    start = start_state(order)
    ends = st.sampled_from([*order.bin_contents, TOTE, TOTE, OUTSIDE, HELD])
    items = tuple(
        replace(i, end=draw(st.just(i.start) | ends), protrusion=draw(st.sampled_from([0.0, 0.004, 0.02])))
        for i in start.items
    )
    claim = draw(st.sampled_from([None, start.claim, truthful_claim(order, items)]))
    ids = [i.id for i in items]
    drops = draw(st.lists(st.builds(Drop, st.sampled_from(ids), st.floats(0, 1), st.booleans()), max_size=3))
    damages = draw(st.lists(st.tuples(st.sampled_from(ids), st.sampled_from(Damage)), max_size=2))
    return order, FinalState(items, claim, tuple(drops), tuple(damages))


@given(games())
def test_score_lies_within_its_bounds(game: tuple[Order, FinalState]) -> None:
    order, final = game
    result = score(order, final, BONUS)
    n = len(final.items)
    worst_per_item = 10 + 2 * 10 + 5 + 12  # outside, claimed wrongly at two places, protruding, moved
    assert result.total <= result.maximum
    assert result.total >= -worst_per_item * n - 8 * len(final.drops) - 20 * len(final.damages)


@given(games(), st.randoms(use_true_random=False))
def test_order_of_items_drops_and_damages_does_not_matter(
    game: tuple[Order, FinalState], rng: random.Random
) -> None:
    order, final = game

    def shuffled(values: tuple) -> tuple:  # type: ignore[type-arg]
        return tuple(rng.sample(values, len(values)))

    other = FinalState(shuffled(final.items), final.claim, shuffled(final.drops), shuffled(final.damages))
    assert Counter(score(order, other, BONUS).lines) == Counter(score(order, final, BONUS).lines)


@given(pick_orders())
def test_everything_delivered_and_nothing_else_is_the_maximum(order: Order) -> None:
    state, wanted = start_state(order), Counter((t.bin, t.item) for t in order.work_order)
    for k, item in enumerate(state.items):
        if wanted[item.start, item.name] > 0:
            wanted[item.start, item.name] -= 1
            state = moved(order, state, k, TOTE)
    result = score(order, state, BONUS)
    assert result.total == result.maximum == maximum_score(order, BONUS)


@given(games(), st.data())
def test_penalties_add_up(game: tuple[Order, FinalState], data: st.DataObject) -> None:
    order, final = game
    rules, before = RULES[order.year], score(order, final, BONUS).total
    item = data.draw(st.sampled_from(final.items))
    is_target = any((t.bin, t.item) == (item.start, item.name) for t in order.work_order)
    dropped = replace(final, drops=(*final.drops, Drop(item.id, 0.5)))
    cost = rules.high_drop + (rules.lost_target if is_target else 0)
    assert score(order, dropped, BONUS).total == before + cost
    low = replace(final, drops=(*final.drops, Drop(item.id, 0.29, is_release=True)))
    assert score(order, low, BONUS).total == before
    damaged = replace(final, damages=(*final.damages, ("shelf", Damage.MAJOR)))
    assert score(order, damaged, BONUS).total == before + rules.damage[Damage.MAJOR]


@pytest.mark.parametrize(
    ("year", "n_items", "points"),
    [
        *((2016, n, points) for n, points in ((1, 10), (2, 10), (3, 15), (4, 15), (5, 20), (9, 20))),
        *((2015, n, points) for n, points in ((1, 10), (2, 15), (3, 20), (4, 20))),
    ],
)
def test_fill_bonus_counts_the_bin_at_the_start(year: int, n_items: int, points: int) -> None:
    contents = {"bin_A": ("jane_eyre_dvd",) + ("crayola_24_ct",) * (n_items - 1)}
    order = pick_order(contents, ("bin_A", "jane_eyre_dvd"), year=year)
    state = moved(order, start_state(order), 0, TOTE)
    assert score(order, state, BONUS).total == points + BONUS["jane_eyre_dvd"]


def one_item(end: str, protrusion: float = 0.0) -> tuple[Order, FinalState]:
    """A game about a single item that was not moved on purpose."""
    order = pick_order({"bin_A": ("crayola_24_ct",)}, ("bin_A", "crayola_24_ct"))
    state = start_state(order)
    item = replace(state.items[0], end=end, protrusion=protrusion)
    return order, FinalState((item,), truthful_claim(order, (item,)))


def test_left_outside_costs_ten_but_not_while_held() -> None:
    assert score(*one_item(OUTSIDE), BONUS).total == -10
    assert score(*one_item(HELD), BONUS).total == 0


def test_protruding_costs_five_over_five_millimetres() -> None:
    assert score(*one_item("bin_A", 0.0051), BONUS).total == -5
    assert score(*one_item("bin_A", 0.0049), BONUS).total == 0


def test_a_wrong_place_in_the_output_file_costs_ten_per_item() -> None:
    order = pick_order({"bin_A": ("crayola_24_ct",) * 2}, ("bin_A", "crayola_24_ct"))
    state = start_state(order)
    picked = replace(moved(order, state, 0, TOTE), claim=state.claim)  # in the tote, the file says bin_A
    result = score(order, picked, BONUS)
    assert result.total == 10 - 10
    wrong = [line for line in result.lines if line.points < 0]
    assert wrong[0].reason == "output file says bin_A, the item is tote"
    fallen = replace(moved(order, state, 0, OUTSIDE), claim=state.claim)
    assert score(order, fallen, BONUS).total == -10 - 10


def test_a_second_copy_in_the_tote_gives_nothing_twice() -> None:
    order = pick_order({"bin_A": ("crayola_24_ct",) * 2}, ("bin_A", "crayola_24_ct"))
    state = moved(order, moved(order, start_state(order), 0, TOTE), 1, TOTE)
    assert score(order, state, BONUS).total == 10
    order_2015 = replace(order, year=2015)
    assert score(order_2015, state, BONUS).total == 15 - 12


def test_a_copy_from_another_bin_does_not_count() -> None:
    order = pick_order({"bin_A": ("crayola_24_ct",), "bin_B": ("crayola_24_ct",)}, ("bin_A", "crayola_24_ct"))
    assert score(order, moved(order, start_state(order), 1, TOTE), BONUS).total == 0


def test_a_dropped_target_costs_three_in_2015() -> None:
    order, state = one_item("bin_A")
    order = replace(order, year=2015)
    assert score(order, replace(state, drops=(Drop(state.items[0].id, 0.1),)), BONUS).total == -3


def test_stowing_counts_the_bin_as_it_started() -> None:
    contents = {b: ("crayola_24_ct",) * n for b, n in zip(BINS, (1, 2, 3, 5) + (1,) * 8, strict=True)}
    order = Order(OrderKind.STOW, 2016, contents, ("jane_eyre_dvd", "dove_beauty_bar"), ())
    state = start_state(order)
    first = next(i for i, item in enumerate(state.items) if item.start == TOTE)
    state = moved(order, moved(order, state, first, "bin_C"), first + 1, "bin_D")
    result = score(order, state, BONUS)
    assert result.total == (15 + 3) + 20
    assert result.maximum == (20 + 3) + 20


def test_every_line_says_why() -> None:
    order, state = one_item(OUTSIDE)
    state = replace(state, drops=(Drop(state.items[0].id, 0.7),), damages=(("shelf", Damage.MINOR),))
    lines = {line.reason: line.points for line in score(order, state, BONUS).lines}
    assert lines == {
        "target of bin_A is not in the tote": 0,
        "left outside bins and tote": -10,
        "fell 0.70 m": -5,
        "minor damage": -5,
    }


def test_the_points_are_those_of_the_rules() -> None:
    """Every figure of docs/scoring.md, and none but these."""
    assert RULES[2016] == ScoringRules(
        fill=((5, 20), (3, 15), (1, 10)),
        outside=-10, wrong_claim=-10, protruding=-5, high_drop=-5, lost_target=0, wrong_item=0,
        damage={Damage.MINOR: -5, Damage.MAJOR: -20}, drop_limit=0.3, protrusion_limit=0.005,
    )  # fmt: skip
    assert RULES[2015] == ScoringRules(
        fill=((3, 20), (2, 15), (1, 10)),
        outside=0, wrong_claim=0, protruding=0, high_drop=0, lost_target=-3, wrong_item=-12,
        damage={Damage.MINOR: -5, Damage.MAJOR: -5}, drop_limit=0.3, protrusion_limit=0.005,
    )  # fmt: skip


def test_a_limit_itself_costs_nothing() -> None:
    order, state = one_item("bin_A", 0.005)
    assert score(order, state, BONUS).total == 0
    item = state.items[0].id
    for height, cost in ((0.3, 0), (0.301, -5)):
        final = replace(state, items=(replace(state.items[0], protrusion=0.0),), drops=(Drop(item, height),))
        assert score(order, final, BONUS).total == cost


def test_what_stands_out_of_no_bin_costs_nothing() -> None:
    for place in (TOTE, HELD):
        (order, state), (_, inside) = one_item(place, 0.5), one_item(place, 0.0)
        assert score(order, state, BONUS).lines == score(order, inside, BONUS).lines


def test_damage_costs_by_how_bad_it_is_and_by_the_year() -> None:
    order, state = one_item("bin_A")
    for year, damage, cost in ((2016, Damage.MINOR, -5), (2016, Damage.MAJOR, -20),
                               (2015, Damage.MINOR, -5), (2015, Damage.MAJOR, -5)):  # fmt: skip
        final = replace(state, damages=(("shelf", damage),))
        assert score(replace(order, year=year), final, BONUS).total == cost


@pytest.mark.parametrize(
    ("start", "end", "cost"),
    [
        ("bin_A", "bin_A", 0), ("bin_A", "bin_B", 0), ("bin_A", OUTSIDE, 0), ("bin_A", HELD, 0),
        ("bin_A", TOTE, 10), ("bin_B", "bin_B", 0), ("bin_B", "bin_A", -12), ("bin_B", TOTE, -12),
        ("bin_B", OUTSIDE, -12), ("bin_B", HELD, -12),
    ],
)  # fmt: skip
def test_in_2015_whatever_is_no_target_stays_where_it_is(start: str, end: str, cost: int) -> None:
    contents = {"bin_A": ("crayola_24_ct",), "bin_B": ("crayola_24_ct",)}
    order = pick_order(contents, ("bin_A", "crayola_24_ct"), year=2015)
    state = start_state(order)
    k = [item.start for item in state.items].index(start)
    assert score(order, moved(order, state, k, end), BONUS).total == cost


def test_a_lost_target_costs_in_2015_only_if_it_is_one_and_was_not_let_go() -> None:
    contents = {"bin_A": ("crayola_24_ct", "jane_eyre_dvd")}
    order = pick_order(contents, ("bin_A", "crayola_24_ct"), year=2015)
    state = start_state(order)
    target, other = (item.id for item in state.items)
    for drop, cost in ((Drop(target, 0.01), -3), (Drop(target, 0.9), -3), (Drop(target, 0.9, True), 0),
                       (Drop(other, 0.9), 0), (Drop("shelf", 0.9), 0)):  # fmt: skip
        assert score(order, replace(state, drops=(drop,)), BONUS).total == cost


def claims(actual: dict[str, tuple[str, ...]], claimed: dict[str, tuple[str, ...]]) -> list[str]:
    """What is wrong with an output file, by places and names."""
    order = pick_order({"bin_A": ("crayola_24_ct",)}, ("bin_A", "crayola_24_ct"))
    items = tuple(
        FinalItem(f"{name}#{place}{i}", name, place, place)
        for place, names in actual.items()
        for i, name in enumerate(names)
    )
    contents = {b: claimed.get(b, ()) for b in BINS}
    file = Order(OrderKind.OUTPUT, 2016, contents, claimed.get(TOTE, ()), ())
    lines = score(order, FinalState(items, file), BONUS).lines
    assert all(line.points == -10 for line in lines if "output file" in line.reason)
    return [f"{line.subject}: {line.reason}" for line in lines if "output file" in line.reason]


def test_an_output_file_is_wrong_once_for_each_copy_that_is_elsewhere() -> None:
    a, b = "crayola_24_ct", "jane_eyre_dvd"
    assert claims({"bin_A": (a, a), TOTE: (b,)}, {"bin_A": (a, a), TOTE: (b,)}) == []
    assert claims({"bin_A": (a,)}, {"bin_B": (a,)}) == [f"{a}: output file says bin_B, the item is bin_A"]
    assert claims({"bin_A": (a, a)}, {"bin_A": (a,)}) == [f"{a}: output file says nowhere, the item is bin_A"]
    assert claims({"bin_A": (a,)}, {"bin_A": (a, a)}) == [
        f"{a}: output file says bin_A, the item is not there"
    ]
    assert len(claims({"bin_A": (a, a, b)}, {"bin_B": (a, a), TOTE: (b,)})) == 3
    assert claims({OUTSIDE: (a,)}, {}) == [] and len(claims({OUTSIDE: (a,)}, {"bin_A": (a,)})) == 1
    assert claims({HELD: (a,)}, {}) == []


def test_without_an_output_file_and_in_2015_nothing_is_claimed() -> None:
    order, state = one_item("bin_A")
    wrong = replace(truthful_claim(order, ()), tote_contents=("crayola_24_ct",))
    assert score(order, replace(state, claim=None), BONUS).total == 0
    assert score(order, replace(state, claim=wrong), BONUS).total == -10
    assert score(replace(order, year=2015), replace(state, claim=wrong), BONUS).total == 0


def test_stowing_is_told_item_by_item() -> None:
    contents: dict[str, tuple[str, ...]] = {b: ("crayola_24_ct",) if b != "bin_B" else () for b in BINS}
    tote = ("jane_eyre_dvd", "dove_beauty_bar", "scotch_duct_tape")
    order = Order(OrderKind.STOW, 2016, contents, tote, ())
    state = start_state(order)
    first = next(i for i, item in enumerate(state.items) if item.start == TOTE)
    state = moved(order, moved(order, state, first, "bin_B"), first + 1, "bin_A")
    found = score(order, state, BONUS).lines
    assert [line.subject for line in found] == [i.id for i in state.items if i.start == TOTE]
    lines = {line.reason: line.points for line in found}
    assert lines == {
        "stowed into bin_B, which started with 0, item bonus 3": 13,
        "stowed into bin_A, which started with 1": 10,
        "is in no bin": 0,
    }


def test_of_two_copies_in_the_tote_the_one_that_is_stowed_counts_first() -> None:
    order = Order(OrderKind.STOW, 2016, dict.fromkeys(BINS, ("crayola_24_ct",)), ("jane_eyre_dvd",) * 2, ())
    state = start_state(order)
    last = max(i for i, item in enumerate(state.items) if item.start == TOTE)
    found = score(order, moved(order, state, last, "bin_A"), BONUS)
    assert [line.points for line in found.lines] == [13, 0]
    assert found.lines[0].subject == state.items[last].id


def test_what_is_stowed_and_stands_out_or_lies_elsewhere_than_claimed_costs_points() -> None:
    order = Order(OrderKind.STOW, 2016, dict.fromkeys(BINS, ("crayola_24_ct",)), ("dove_beauty_bar",) * 3, ())
    state = start_state(order)
    first = next(i for i, item in enumerate(state.items) if item.start == TOTE)
    state = moved(order, moved(order, state, first, "bin_A"), first + 1, OUTSIDE)
    items = list(state.items)
    items[first] = replace(items[first], protrusion=0.006)
    claimed = truthful_claim(order, tuple(items))
    said = {**claimed.bin_contents, "bin_B": (*claimed.bin_contents["bin_B"], "dove_beauty_bar")}
    state = replace(state, items=tuple(items), claim=replace(claimed, bin_contents=said))
    lines = [line.points for line in score(order, state, BONUS).lines]
    assert sorted(lines) == [-10, -10, -5, 0, 0, 10]  # outside, wrongly claimed, protruding; in no bin twice


def test_the_bonus_of_an_item_is_that_of_its_year() -> None:
    cell = load_cell("apc2016_delft")
    order = pick_order({"bin_A": ("crayola_24_ct", "jane_eyre_dvd")}, ("bin_A", "crayola_24_ct"))
    order = replace(order, tote_contents=("dove_beauty_bar",))
    found = item_bonuses(cell, order)
    assert list(found) == ["crayola_24_ct", "dove_beauty_bar", "jane_eyre_dvd"]
    assert found == {name: cell.item(name, 2016).bonus for name in found}


def test_every_move_is_one_point_for_a_copy_of_its_own_that_is_where_it_is_wanted() -> None:
    """Two copies are wanted in two places, another item in one; what comes from elsewhere does not count."""
    one, other = ITEMS[:2]
    moves = Target("bin_A", one, "bin_B"), Target("bin_A", one, "bin_C"), Target("bin_D", other, TOTE)
    order = Order(OrderKind.MOVE, 2016, {"bin_A": (one, one), "bin_D": (other,)}, (), moves)
    assert maximum_score(order, BONUS) == 3
    for ends, points in (
        (("bin_B", "bin_C", TOTE), (1, 1, 1)), (("bin_C", "bin_B", TOTE), (1, 1, 1)),
        (("bin_B", "bin_B", "bin_D"), (1, 0, 0)), (("bin_A", "bin_C", OUTSIDE), (0, 1, 0)),
        (("bin_A", "bin_A", HELD), (0, 0, 0)),
    ):  # fmt: skip
        items = (FinalItem("1", one, "bin_A", ends[0]), FinalItem("2", one, "bin_A", ends[1]),
                 FinalItem("3", other, "bin_D", ends[2]), FinalItem("4", one, "bin_E", "bin_C"))  # fmt: skip
        for shuffled in (items, items[::-1]):
            found = score(order, FinalState(shuffled), BONUS)
            assert tuple(line.points for line in found.lines) == points
            assert (found.total, found.maximum) == (sum(points), 3)


def test_an_item_of_which_no_bonus_is_known_has_none() -> None:
    order = pick_order({"bin_A": (ITEMS[0],) * 3}, ("bin_A", ITEMS[0]))
    assert target_points(order, "bin_A", ITEMS[0], {}) == target_points(order, "bin_A", ITEMS[0], BONUS) == 15
    assert target_points(order, "bin_A", ITEMS[0], {ITEMS[0]: 2, ITEMS[1]: 5}) == 17
    assert target_points(order, "bin_B", ITEMS[0], {}) == 10
