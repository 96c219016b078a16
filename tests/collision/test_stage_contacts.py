"""Each stage of a pick allows the contacts that it needs, and no others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.stage_contacts import (
    ALONE_LINE_DEVIATION,
    CupPress,
    PickContacts,
    while_coming_free,
    while_resting_on,
)
from pickcli.geometry import pose
from pickcli.scene.scene import PoseNoise, Scene
from support.handmade_piles import lying_on

BIN, CASE, BOOK = "bin_K", "jane_eyre_dvd", "i_am_a_bunny_book"
FROM_ABOVE = CupPress((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), 0.004, 0.002)


@pytest.fixture(scope="module")
def scene(cell: Cell) -> Scene:
    """A thin case with a book on it."""
    return lying_on(cell, BIN, CASE, BOOK, PoseNoise())


def contacts_of(scene: Scene, target: str, ignored: frozenset[str] = frozenset()) -> PickContacts:
    floor = frozenset(scene.cell.pod.bins[BIN].support)
    return PickContacts(scene, scene.find(target), floor, ignored, 0.053)


def touched(contacts: AllowedContacts) -> tuple[set[str], set[str]]:
    return {name for name, _ in contacts.item}, {name for name, _ in contacts.tool}


def test_the_empty_tool_touches_nothing_on_its_way(scene: Scene) -> None:
    assert contacts_of(scene, BOOK).while_approaching() == AllowedContacts()
    ignoring = contacts_of(scene, BOOK, frozenset({CASE})).while_approaching()
    assert ignoring == AllowedContacts(absent=frozenset({CASE}))


def test_only_through_the_target_does_the_cup_meet_what_it_lies_on(scene: Scene) -> None:
    assert {BOOK, CASE} <= touched(contacts_of(scene, BOOK).while_pressing(FROM_ABOVE))[1]
    under = touched(contacts_of(scene, CASE).while_pressing(FROM_ABOVE))[1]
    assert CASE in under and BOOK not in under


def test_what_the_cup_is_pressed_on_gives_way_along_its_axis(scene: Scene) -> None:
    (way,) = {way for _, way in contacts_of(scene, BOOK).while_pressing(FROM_ABOVE).tool}
    assert way is not None and way[:2] == (0.0, 0.0)
    assert -0.006 < way[2] < -FROM_ABOVE.depth


def test_the_lift_frees_the_target_from_what_it_lies_on_and_from_nothing_else(scene: Scene) -> None:
    contacts = contacts_of(scene, BOOK)
    lifting = contacts.while_lifting(FROM_ABOVE)
    assert lifting.absent == {BOOK}
    assert touched(lifting)[0] == touched(lifting)[1] == set(contacts.near)
    assert contacts.while_carrying() == AllowedContacts(absent=frozenset({BOOK}))


def test_the_target_alone_may_sink_less_deep_than_in_the_cup(scene: Scene) -> None:
    contacts = contacts_of(scene, BOOK)
    alone, held = dict(contacts.item_while_lifting().item), dict(contacts.while_lifting(FROM_ABOVE).item)
    assert alone.keys() == held.keys() and alone
    for name in alone:
        a, h = alone[name], held[name]
        assert a is not None and h is not None
        assert np.linalg.norm(a) <= np.linalg.norm(h)
    assert alone != held


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_what_it_is_clear_of_at_rest_the_target_comes_no_nearer_to_than_lines_deviate(
    cell: Cell, noise: float
) -> None:
    """It counts as near as lines are followed only so well; the verifier measures that it is not touched."""
    apart = cell.clearance + 0.0006
    on_it = lying_on(cell, BIN, CASE, BOOK, PoseNoise(noise, 0.0))
    gap = contacts_of(on_it, BOOK).near[CASE].gap
    book = on_it.find(BOOK)
    up = pose((0.0, 0.0, apart + 2.0 * noise - gap))
    contacts = contacts_of(on_it.moved(replace(book, T_world_item=up @ book.T_world_item)), BOOK)
    near, way = contacts.near[CASE], dict(contacts.item_while_lifting().item)[CASE]
    assert near.gap == pytest.approx(apart + 2.0 * noise, abs=1e-6) and way is not None
    assert np.array(way) == pytest.approx((ALONE_LINE_DEVIATION - near.gap) * near.normal)


def test_outside_of_the_bin_no_neighbour_is_ignored(scene: Scene) -> None:
    contacts = contacts_of(scene, BOOK, frozenset({CASE}))
    assert contacts.while_carrying().absent == {BOOK, CASE}
    assert contacts.while_transferring().absent == {BOOK}


def test_one_that_rolls_is_asked_about_by_itself(cell: Cell, scene: Scene) -> None:
    book, case = scene.find(BOOK), scene.find(CASE)
    ball = replace(case, item=cell.item("dove_beauty_bar"))
    rolling = next(i for i in cell.items.values() if replace(ball, item=i).can_roll)
    beside = replace(scene, items=(replace(case, item=rolling), book))
    (alone,) = contacts_of(beside, BOOK).rolling_along()
    assert alone.absent == {BOOK} and CASE not in alone.names
    assert contacts_of(scene, BOOK).rolling_along() == ()


def test_where_an_item_is_set_down_it_sinks_into_nothing() -> None:
    resting = while_resting_on(("floor",), BOOK)
    assert resting.item == (("floor", (0.0, 0.0, 0.0)),) and resting.tool == ()
    assert resting.absent == {BOOK}


def test_a_way_out_of_a_stop_touches_what_is_near_however_deep() -> None:
    free = while_coming_free(frozenset({"wall"}), frozenset({("lance", BOOK)}))
    assert free.tool == (("wall", None),) and free.opening_pairs == {("lance", BOOK)}
    assert free.names == {"wall"}
