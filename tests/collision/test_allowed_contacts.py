"""Planned contact: so deep and no deeper, for who is named and for nobody else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.collision.allowed_contacts import NO_CONTACTS, AllowedContacts
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.checker import SceneChecker
from pickcli.collision.free_flyer import FreeItem, FreeItemChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import UnknownNameError
from pickcli.geometry import Array, pose
from support.solid_helpers import MakeChecker, MakeScene, box_item
from support.tool_states import ALL_STATES

SIDE = 0.08
CUBE = box_item((SIDE, SIDE, SIDE))
numbers = st.floats(-0.1, 0.1)


def beside(
    model: CollisionModel, make_scene: MakeScene, way: Array | None, overlap: float = 0.0
) -> FreeItemChecker:
    """A cube beside item0, which stands on its +x side and into which it may be pushed along ``way``."""
    T = pose((-0.6, 0.0, 1.7))
    scene = make_scene((CUBE, pose((SIDE - overlap, 0.0, 0.0)) @ T))
    touching = NO_CONTACTS if way is None else AllowedContacts.of(item={"item0": way})
    return FreeItemChecker(model, scene, FreeItem(CUBE, T, np.eye(3), 0.004), touching)


def pushed(cube: FreeItemChecker, x: float, z: float = 0.0) -> bool:
    d = np.array([x, 0.0, z, 0.0, 0.0, 0.0])
    is_free = cube.is_valid_path(np.stack([np.zeros(6), d]))
    assert is_free == (cube.is_valid(np.zeros(6)) and cube.is_valid(d))
    assert cube.are_valid(np.stack([np.zeros(6), d])).tolist() == [
        cube.is_valid(np.zeros(6)),
        cube.is_valid(d),
    ]
    return is_free


def test_without_leave_it_keeps_the_clearance(model: CollisionModel, make_scene: MakeScene) -> None:
    assert not beside(model, make_scene, None).is_valid(np.zeros(6))


@pytest.mark.parametrize("overlap", [0.0, 0.003])
def test_it_may_stay_and_leave_and_go_no_deeper(
    model: CollisionModel, make_scene: MakeScene, overlap: float
) -> None:
    cube = beside(model, make_scene, np.array([overlap + 0.001, 0.0, 0.0]), overlap)
    assert pushed(cube, 0.0) and pushed(cube, -0.05) and pushed(cube, 0.0, 0.05)
    assert pushed(cube, 0.0008)
    assert not pushed(cube, 0.0012) and not pushed(cube, 0.02)


def test_an_overlap_that_is_not_explained_is_none_that_is_allowed(
    model: CollisionModel, make_scene: MakeScene
) -> None:
    assert not beside(model, make_scene, np.array([0.001, 0.0, 0.0]), overlap=0.003).is_valid(np.zeros(6))


@given(st.dictionaries(st.sampled_from("abcd"), st.tuples(numbers, numbers, numbers)))
def test_equal_ways_are_one_key(ways: dict[str, tuple[float, float, float]]) -> None:
    arrays = {name: np.array(way) for name, way in ways.items()}
    one, other = AllowedContacts.of(arrays), AllowedContacts.of(dict(reversed(arrays.items())))
    assert one == other and hash(one) == hash(other)
    assert one.names == frozenset(ways)
    assert replace(one, absent=frozenset(ways)).of_present == AllowedContacts(absent=frozenset(ways))


def test_ways_are_equal_to_a_nanometre() -> None:
    """So that the same contact, computed twice, is one key."""
    exact, rounded, other = (
        AllowedContacts.of({"a": np.array([x, 0, 0])}) for x in (0.1, 0.1 + 2e-10, 0.1 + 2e-9)
    )
    assert exact == rounded and exact != other


def test_each_neighbour_gives_way_as_far_as_it_may_and_to_its_own_side(
    model: CollisionModel, make_scene: MakeScene
) -> None:
    """One before it by 1 mm, one behind it by 4 mm, one above it by 2 mm."""
    T = pose((-0.6, 0.0, 1.7))
    places = [pose((SIDE, 0.0, 0.0)), pose((-SIDE, 0.0, 0.0)), pose((0.0, 0.0, SIDE))]
    ways = {
        "item0": np.array([0.001, 0.0, 0.0]),
        "item1": np.array([-0.004, 0.0, 0.0]),
        "item2": np.array([0.0, 0.0, 0.002]),
    }
    scene = make_scene(*((CUBE, place @ T) for place in places))
    cube = FreeItemChecker(model, scene, FreeItem(CUBE, T, np.eye(3), 0.004), AllowedContacts.of(item=ways))
    assert pushed(cube, 0.0009) and not pushed(cube, 0.0011)
    assert pushed(cube, -0.0039) and not pushed(cube, -0.0041)
    assert pushed(cube, 0.0, 0.0019) and not pushed(cube, 0.0, 0.0021)


def test_the_cup_gives_along_its_axis_and_the_held_item_has_a_leave_of_its_own(
    make_scene: MakeScene, make_checker: MakeChecker, T_home_tip: Array, home: Array, model: CollisionModel
) -> None:
    axis = T_home_tip[:3, 2]
    scene = make_scene((CUBE, T_home_tip @ pose((0, 0, SIDE / 2 - 0.004))))  # the cup is 4 mm in it

    def is_free(by: float, item: bool = False, cup: bool = False) -> bool:
        ways = {"item0": by * axis}
        touching = AllowedContacts.of(ways if item else None, ways if cup else None)
        return make_checker(scene, contacts=touching).is_valid(home)

    assert not is_free(0.02, item=True)
    assert not is_free(0.003, cup=True)
    assert is_free(0.0045 + model.tip_excess, cup=True)


def test_what_goes_too_deep_is_named(
    make_scene: MakeScene, make_checker: MakeChecker, T_home_tip: Array, home: Array
) -> None:
    scene = make_scene((CUBE, T_home_tip @ pose((0, 0, SIDE / 2 - 0.004))))
    touching = AllowedContacts.of(tool={"item0": 0.001 * T_home_tip[:3, 2]})
    checker: SceneChecker = make_checker(scene, contacts=touching)
    reason = checker.explain(home)
    assert reason.what == "planned contact too deep" and reason.in_the_way == "item0"
    moved = home.copy()
    moved[0] -= 0.01
    assert checker.explain_path(np.stack([moved, home])).what == "planned contact too deep"
    assert not checker.is_valid_edge(moved, home) and checker.first_blocked_edge(np.stack([moved, home])) == 0
    folded = np.array(
        [0.5, 0, 0, 0, 2.2689, 0, 1.9198, 0]
    )  # collides with itself: a later edge, another rule
    path = np.stack([moved, home, folded])
    assert checker.explain(folded).what == "collision" and not checker.is_valid_edge(home, folded)
    assert checker.first_blocked_edge(path) == 0
    assert checker.explain_path(path).what == "planned contact too deep"


def test_a_held_item_may_lie_on_what_it_may_touch_and_sink_into_nothing(
    make_scene: MakeScene, make_checker: MakeChecker, T_home_tip: Array, home: Array
) -> None:
    held = AttachedItem(CUBE, pose((0, 0, SIDE / 2)), 0.003)
    for gap, is_free in ((0.0005, True), (-0.0005, False)):
        scene = make_scene((CUBE, T_home_tip @ pose((0, 0, 1.5 * SIDE + gap))))
        touching = AllowedContacts.of(item={"item0": np.zeros(3)})
        assert make_checker(scene, held=held, contacts=touching).is_valid(home) is is_free
        assert not make_checker(scene, held=held).is_valid(home)


def test_unknown_names_are_refused(make_checker: MakeChecker) -> None:
    with pytest.raises(UnknownNameError, match="row_ABC_lib"):
        make_checker(contacts=AllowedContacts.of(item={"row_ABC_lib": np.zeros(3)}))


def test_every_tool_state_knows_its_cup(cell: Cell, make_checker: MakeChecker, home: Array) -> None:
    floor = AllowedContacts.of(tool={"row_ABC_floor_flat": np.zeros(3)})
    for tool_state in ALL_STATES:
        assert make_checker(tool_state=tool_state, contacts=floor).is_valid(home) == make_checker(
            tool_state=tool_state
        ).is_valid(home)


def test_one_contact_that_is_only_so_deep_makes_a_limit() -> None:
    limited = AllowedContacts.of(tool={"a": np.zeros(3)})
    assert limited.is_limited and AllowedContacts.of(item={"a": np.ones(3)}).is_limited
    assert not AllowedContacts.at_any_depth(["a", "b"]).is_limited and not NO_CONTACTS.is_limited
    mixed = AllowedContacts(item=(("b", None),), tool=limited.tool)
    assert mixed.is_limited and mixed.names == frozenset("ab")
    assert not replace(mixed, absent=frozenset("a")).of_present.is_limited
    assert mixed.of_empty_tool.names == frozenset("a")
