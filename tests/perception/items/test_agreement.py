"""What two looks agree on is sure, and what they do not agree on is not."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.sensors.material import Material
from pickcli.cell.sensors.sensor_model import SensorModel
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse, pose
from pickcli.perception.items.agreement import (
    DOUBTFUL,
    SURE_BY_PRINT,
    SURE_BY_VOTES,
    Votes,
    agreed_confidence,
    matched,
    votes_on,
)
from pickcli.perception.items.item_observation import Agreement, FoundBy
from pickcli.perception.items.item_perception import PlaceLook, concluded
from pickcli.perception.items.item_search import PoseEstimate
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.pose_bound import LEAST_CONFIDENCE_OF_BOUND, agreed_bound_of
from pickcli.scene.scene import PoseNoise
from support.filled_bins import Filled, looked_at, looked_at_aslant


def apart(mm: float, degrees: float = 0.2) -> PoseNoise:
    """By how much two poses differ."""
    return PoseNoise(1e-3 * mm, np.radians(degrees), 1e-3 * mm)


def test_confidence_grows_with_agreement(looks: tuple[PlaceLook, PlaceLook]) -> None:
    one, _ = looks
    for i, found in one.found.items():
        at = [
            agreed_confidence(found.support, one.lost(i), len(one.listed), Agreement(0.9, apart(mm)))
            for mm in (0.2, 1.0, 4.0, 40.0)
        ]
        assert all(near > far for near, far in pairwise(at))


def test_copies_that_were_taken_for_each_other_are_put_right(cell: Cell) -> None:
    item, other = cell.item("crayola_24_ct", 2016), cell.item("kleenex_tissue_box", 2016)
    here, there = pose((0.1, 0.0, 0.0)), pose((0.1, 0.1, 0.0))
    near = pose((0.001, 0.0, 0.0))
    items = [item, other, item]
    found = matched(items, {0: here, 1: here, 2: there}, {0: there @ near, 2: here @ near})
    assert found == {0: (0, 2), 2: (2, 0)}
    assert matched(items, {0: here}, {2: here}) == {0: (0, 2)}
    assert matched(items, {0: here}, {}) == {}


@pytest.fixture(scope="module")
def looks(filled: Filled) -> tuple[PlaceLook, PlaceLook]:
    """Two looks into a bin, from different places."""
    return filled.looked(), looked_at_aslant(filled.scene).looked()


def elsewhere(look: PlaceLook, i: int, by: float = 0.04) -> PlaceLook:
    """The look with one of its poses so many m aside."""
    aside = look.found[i].T_camera_item @ pose((0.0, by, 0.0))
    return replace(look, found={**look.found, i: PoseEstimate(aside, look.found[i].support)})


def test_two_looks_agree_on_what_is_there(filled: Filled, looks: tuple[PlaceLook, PlaceLook]) -> None:
    observed = concluded(looks)
    believed = [answer for answer in observed.items if answer.bound is not None]
    assert believed
    for answer in believed:
        assert answer.agreement is not None and answer.T_world_item is not None
        assert answer.bound is not None and answer.bound.holds(filled.error_of(answer))


def test_what_they_do_not_agree_on_has_no_bound(looks: tuple[PlaceLook, PlaceLook]) -> None:
    one, other = looks
    for i in one.found:
        answer = concluded([one, elsewhere(other, i)]).items[i]
        assert answer.bound is None and answer.confidence < LEAST_CONFIDENCE_OF_BOUND


def test_what_one_of_two_looks_does_not_find_is_refused(looks: tuple[PlaceLook, PlaceLook]) -> None:
    one, other = looks
    i = next(iter(one.found))
    without = replace(other, found={k: found for k, found in other.found.items() if k != i})
    answer = concluded([one, without]).items[i]
    assert not answer.is_answer and "no two looks" in answer.refusal


def test_a_look_from_the_same_place_is_no_second_opinion(filled: Filled) -> None:
    again = looked_at(filled.scene, noise_seed=2).looked()
    observed, alone = concluded([filled.looked(), again]), concluded([again])
    assert [answer.confidence for answer in observed.items] == [answer.confidence for answer in alone.items]
    assert all(answer.agreement is None for answer in observed.items)


def test_a_third_look_puts_right_what_two_differ_on(looks: tuple[PlaceLook, PlaceLook]) -> None:
    one, other = looks
    i = next(iter(one.found))
    answer = concluded([elsewhere(one, i), one, other]).items[i]
    expected = concluded([one, other]).items[i]
    np.testing.assert_array_equal(answer.T_world_item, expected.T_world_item)
    assert answer.confidence == expected.confidence


def test_copies_that_looks_number_otherwise_are_each_in_their_own_place(
    looks: tuple[PlaceLook, PlaceLook],
) -> None:
    found = sorted(looks[0].found.keys() & looks[1].found.keys())
    i, k = sorted(found, key=lambda n: looks[0].listed[n].item.shape.extents.min())[:2]
    one, other = (replace(look, listed=as_copies(look.listed, i, k)) for look in looks)
    swapped = replace(other, found=other.found | {i: other.found[k], k: other.found[i]})
    answers = concluded([swapped, one, other]).items
    middles = [answers[n].T_world_item for n in (i, k)]
    assert middles[0] is not None and middles[1] is not None
    apart_by = np.linalg.norm(middles[0][:3, 3] - middles[1][:3, 3])
    assert apart_by == pytest.approx(np.linalg.norm(one.poses[i][:3, 3] - one.poses[k][:3, 3]), abs=0.02)
    assert [answers[n].id for n in (i, k)] == [one.listed[n].id for n in (i, k)]


def as_copies(listed: tuple[ListedItem, ...], i: int, k: int) -> tuple[ListedItem, ...]:
    """The list with the k-th item as a copy of the i-th."""
    return tuple(replace(each, item=listed[i].item) if n == k else each for n, each in enumerate(listed))


def test_what_is_clear_in_one_look_is_free(filled: Filled) -> None:
    """Two looks without any item that is known leave no more unknown than each of them alone."""
    none: list[ListedItem] = []
    one, other = filled.looked(none), looked_at_aslant(filled.scene).looked(none)
    alone, both = (concluded(seen).unknown for seen in ([one], [one, other]))
    volumes = [np.prod(boxes[:, 1] - boxes[:, 0], axis=1).sum() for boxes in (both, alone)]
    assert 0.0 < volumes[0] < volumes[1]


def test_bounds_know_how_far_both_looks_are_apart_and_how_coarsely_depth_is_rounded(
    looks: tuple[PlaceLook, PlaceLook],
) -> None:
    """And whether depths are mixed at edges."""
    support, item = next(iter(looks[0].found.values())).support, looks[0].listed[0].item
    fine = looks[0].rgbd.sensor
    assert fine.depth is not None

    def surface(sensor: SensorModel, mm: float) -> float:
        bound = agreed_bound_of(item, support, sensor, 0.999, Agreement(0.99, apart(mm)))
        assert bound is not None and bound.displacement is not None
        return bound.displacement

    mixing = replace(fine, depth=replace(fine.depth, mixes_edges=True))
    coarse = replace(fine, depth=replace(fine.depth, disparity_step=0.125 * fine.camera.fx / 570.0))
    assert surface(fine, 0.2) < surface(fine, 2.0)
    assert surface(mixing, 0.2) == pytest.approx(1.2 * surface(fine, 0.2))
    assert surface(coarse, 0.2) == pytest.approx(1.22 * surface(fine, 0.2))
    assert agreed_bound_of(item, support, fine, 0.98, Agreement(0.99, apart(0.2))) is None


def test_bounds_cover_sides_that_are_exchanged(looks: tuple[PlaceLook, PlaceLook]) -> None:
    """Both looks may exchange them alike, and keep the faces that they see: 62 by 60 mm are no 61 by 61."""
    support, sensor = next(iter(looks[0].found.values())).support, looks[0].rgbd.sensor

    def bounds(sides: tuple[float, float]) -> Array:
        item = replace(looks[0].listed[0].item, shape=Shape(ShapeKind.BOX, (*sides, 0.12)))
        bound = agreed_bound_of(item, support, sensor, 0.999, Agreement(0.99, apart(0.2)))
        assert bound is not None and bound.displacement is not None
        return np.array([bound.position, bound.displacement, bound.angle])

    middle, behind = np.hypot(0.001, 0.001), np.hypot(0.002, 0.002)
    np.testing.assert_allclose(bounds((0.062, 0.060)) - bounds((0.061, 0.061)), [middle, behind, 0.0])


def test_of_few_looks_the_best_pair_is_believed() -> None:
    assert Votes(3, 2, 1).weighed(0.997) == 0.997
    assert Votes(2, 2, 0).weighed(0.6) == 0.6


def test_of_many_looks_most_decide() -> None:
    assert Votes(6, 4, 2).weighed(0.7) == SURE_BY_VOTES >= LEAST_CONFIDENCE_OF_BOUND
    assert Votes(6, 5, 0).weighed(0.9999) == 0.9999
    assert Votes(6, 3, 0).weighed(0.997) == 0.997
    assert Votes(6, 3, 1).weighed(0.997) == DOUBTFUL < LEAST_CONFIDENCE_OF_BOUND
    assert Votes(6, 2, 0).weighed(0.999) == DOUBTFUL
    assert Votes(6, 2, 0).weighed(0.4) == 0.4


def test_votes_are_counted_by_place_and_copies_do_not_speak_against_each_other(cell: Cell) -> None:
    item, T, copy = cell.item("crayola_24_ct", 2016), pose((0.1, 0.0, 0.0)), pose((0.1, 0.2, 0.0))
    near, far = T @ pose((0.003, 0.0, 0.0)), pose((0.2, 0.0, 0.0))
    found = [
        [(near, 0.1)],  # for, however unsure that look is
        [(far, 0.9), (near, 0.9)],  # for: one of its copies is there
        [(far, 0.4)],  # unsure, so not against
        [(far, 0.6)],  # against
        [(copy, 0.9)],  # that was the copy
        [],  # hidden
    ]
    assert votes_on(item, T, found, [copy]) == Votes(6, 2, 1)
    assert votes_on(item, T, found, []) == Votes(6, 2, 2)


def test_what_two_of_four_looks_agree_on_gets_no_bound(
    looks: tuple[PlaceLook, PlaceLook], cell: Cell
) -> None:
    """The same two looks are enough by themselves; from two places more it is said to be elsewhere."""
    one, other = looks
    sure = concluded(looks).items
    assert all(answer.bound is not None for answer in sure)
    i = max(range(len(sure)), key=lambda k: min(one.confidence(k), other.confidence(k)))
    against = [
        from_aside(elsewhere(look, i, y), by) for look, y, by in ((one, 0.04, 0.5), (other, 0.08, 0.6))
    ]
    doubtful = concluded((*against, one, other)).items
    assert doubtful[i].bound is None and doubtful[i].confidence <= DOUBTFUL
    for k, answer in enumerate(doubtful):
        if k != i:  # four looks are for these
            assert answer.bound is not None and answer.confidence >= SURE_BY_VOTES


def by_print(look: PlaceLook, i: int) -> PlaceLook:
    """The look as if it had found one of its poses by a print."""
    return replace(look, found={**look.found, i: replace(look.found[i], found_by=FoundBy.PRINT)})


def test_what_two_looks_recognise_by_its_print_no_votes_make_unsure(
    looks: tuple[PlaceLook, PlaceLook],
) -> None:
    """Nor does it take more than two looks, or any that are sure by shape; but both have to find it there.

    If one recognised it, and the other has it there, it is as sure as these two make it.
    """
    one, other = looks
    for i in one.found.keys() & other.found.keys():
        against = [
            from_aside(elsewhere(look, i, y), by) for look, y, by in ((one, 0.04, 0.5), (other, 0.08, 0.6))
        ]
        printed = [by_print(look, i) for look in looks]
        answer = concluded([*against, *printed]).items[i]
        assert answer.agreement is not None and answer.agreement.is_by_print
        assert answer.found_by is FoundBy.PRINT and answer.confidence >= SURE_BY_PRINT
        assert SURE_BY_PRINT >= LEAST_CONFIDENCE_OF_BOUND
        elsewhere_too = concluded([printed[0], elsewhere(other, i, 0.005)]).items[i]
        assert elsewhere_too.confidence <= DOUBTFUL and elsewhere_too.bound is None
        by_one, alone = concluded([*against, printed[0], other]), concluded([printed[0], other])
        assert by_one.items[i].confidence == alone.items[i].confidence


def test_bounds_of_what_two_looks_recognise_by_its_print_are_closer(
    looks: tuple[PlaceLook, PlaceLook],
) -> None:
    """Where little is seen of an item its pose by shape may be another that looks alike; its print tells."""
    support, item = next(iter(looks[0].found.values())).support, looks[0].listed[0].item
    little, sensor = replace(support, surface_spread=4.0 * support.surface_spread), looks[0].rgbd.sensor
    by_shape, by_its_print = (
        agreed_bound_of(item, little, sensor, 0.996, Agreement(0.99, apart(1.5), n_prints))
        for n_prints in (0, 2)
    )
    assert by_shape is not None and by_its_print is not None
    for one, other in ((by_its_print.position, by_shape.position), (by_its_print.angle, by_shape.angle)):
        assert one < other


def test_bounds_by_print_are_wide_where_hardly_any_depth_comes_back(
    looks: tuple[PlaceLook, PlaceLook],
) -> None:
    support, item = next(iter(looks[0].found.values())).support, looks[0].listed[0].item
    agreement = Agreement(0.99, apart(0.2), 2)
    matte, clear = (
        agreed_bound_of(replace(item, material=each), support, looks[0].rgbd.sensor, 0.996, agreement)
        for each in (Material.MATTE, Material.CLEAR)
    )
    assert matte is not None and clear is not None
    assert clear.angle > 1.5 * matte.angle and clear.position > 1.5 * matte.position


def from_aside(look: PlaceLook, by: float) -> PlaceLook:
    """The look as if the camera had been aside, and had found all where it did."""
    T = look.rgbd.T_world_camera
    moved = pose((0.0, by, 0.0)) @ T
    found = {
        i: replace(each, T_camera_item=inverse(moved) @ T @ each.T_camera_item)
        for i, each in look.found.items()
    }
    return replace(look, rgbd=replace(look.rgbd, T_world_camera=moved), found=found)
