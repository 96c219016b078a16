"""What is believed after looks: answers with their own bounds, and all else unknown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.errors import InputError, NoPlanError, UnknownNameError
from pickcli.geometry import inverse, pose
from pickcli.motion.plan_file import motion_hash
from pickcli.perception.believed_scene import believed_scene
from pickcli.perception.items.item_observation import ItemObservation, PlaceObservation
from pickcli.perception.items.perceived_file import Perceived
from pickcli.perception.items.unknown_voxels import whole_room
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.scene.unknown_space import UnknownSpace
from pickcli.verification.verify import verify

ITEM = "dove_beauty_bar"
BOUND = PoseNoise(0.002, 0.0175)


@pytest.fixture(scope="module")
def true_scene(cell: Cell) -> Scene:
    return make_scene({"bin_C": (ITEM, "crayola_24_ct")}, cell, seed=1)


def exact(scene: Scene, name: str, refused: str = "") -> PlaceObservation:
    """A look that finds everything where it is, and refuses one item."""
    answers = tuple(
        ItemObservation(
            placed.id,
            placed.item,
            placed.T_world_item,
            1.0,
            "no" if placed.id == refused else "",
            BOUND,
            None,
        )
        for placed in scene.in_location(name)
    )
    return PlaceObservation(name, scene.T_world_place(scene.cell.places[name]), answers)


def look(scene: Scene, *seen: PlaceObservation) -> Perceived:
    T_world_camera = pose((-0.5, 0.0, 1.4))
    return Perceived(scene.cell.name, "hand", "ensenso", T_world_camera, seen)


def everywhere_but(cell: Cell, *names: str) -> tuple[str, ...]:
    return tuple(name for name in cell.places if name not in names)


def test_answers_become_items_with_bounds_that_hold_the_error_of_the_camera(true_scene: Scene) -> None:
    cell = true_scene.cell
    believed = believed_scene(cell, [look(true_scene, exact(true_scene, "bin_C"))], ["tote"])
    assert {placed.id for placed in believed.items} == {ITEM, "crayola_24_ct"}
    error = cell.cameras["hand"].error
    for placed in believed.items:
        within = believed.noise_of(placed)
        assert within.angle == pytest.approx(BOUND.angle + error.angle)
        assert within.position > BOUND.position + error.position
        assert within.position < BOUND.position + error.position + error.angle * 2.0


def test_what_is_refused_is_no_item(true_scene: Scene) -> None:
    seen = exact(true_scene, "bin_C", refused=ITEM)
    believed = believed_scene(true_scene.cell, [look(true_scene, seen)], [])
    assert [placed.id for placed in believed.items] == ["crayola_24_ct"]


def test_places_without_a_look_are_unknown_as_a_whole(true_scene: Scene) -> None:
    cell = true_scene.cell
    believed = believed_scene(cell, [look(true_scene, exact(true_scene, "bin_C"))], ["tote"])
    assert {space.place for space in believed.unknown} == set(everywhere_but(cell, "bin_C", "tote"))
    for space in believed.unknown:
        room = cell.places[space.place].room
        boxes = whole_room(room)
        boxes[:, 1, 2] = np.minimum(boxes[:, 1, 2], room.ceiling_front - cell.clearance)
        np.testing.assert_allclose(space.boxes, boxes)


def test_the_last_look_into_a_place_counts(true_scene: Scene) -> None:
    first = exact(true_scene, "bin_C", refused=ITEM)
    second = replace(exact(true_scene, "bin_C"), error=Displacement(0.001, 0.002, 0.003))
    believed = believed_scene(true_scene.cell, [look(true_scene, first), look(true_scene, second)])
    assert {placed.id for placed in believed.items} == {ITEM, "crayola_24_ct"}
    assert believed.pod_error == second.error


def test_unknown_space_is_grown_by_the_error_of_the_camera(true_scene: Scene) -> None:
    boxes = np.array([[[0.3, 0.0, 0.05], [0.35, 0.05, 0.1]]])
    seen = replace(exact(true_scene, "bin_C"), unknown=boxes)
    believed = believed_scene(
        true_scene.cell, [look(true_scene, seen)], everywhere_but(true_scene.cell, "bin_C")
    )
    (space,) = believed.unknown
    error = true_scene.cell.cameras["hand"].error
    assert (space.boxes[:, 0] < boxes[:, 0] - error.position).all()
    assert (space.boxes[:, 1] > boxes[:, 1] + error.position).all()
    np.testing.assert_allclose(space.boxes, boxes, atol=error.position + 2.0 * error.angle)


def test_unknown_space_does_not_grow_through_floor_walls_and_ceiling(true_scene: Scene) -> None:
    """A board between two bins is thinner than the error."""
    cell = true_scene.cell
    room = cell.places["bin_C"].room
    boxes = np.array([[room.low - 0.004, room.high + 0.004], [room.low + 0.05, room.high - 0.05]])
    boxes[0, 0, 0] = room.floor_flat_from  # behind the slope
    boxes[0, 1, 0] = room.high[0]
    seen = replace(exact(true_scene, "bin_C"), unknown=boxes)
    believed = believed_scene(cell, [look(true_scene, seen)], everywhere_but(cell, "bin_C"))
    (space,) = believed.unknown
    (low, high) = space.boxes[-2] if len(space.boxes) == 2 else space.boxes[0]
    assert low[2] == room.floor_back and high[2] == room.ceiling_back - cell.clearance
    assert high[0] == room.high[0] and low[0] < room.floor_flat_from - cell.cameras["hand"].error.position
    assert (low[1], high[1]) == (room.low[1], room.high[1])


def test_on_a_slope_unknown_space_grows_by_the_error_all_the_same(true_scene: Scene) -> None:
    """But for the 2 mm by which floor and ceiling slope along each part of it."""
    cell, slope = true_scene.cell, 0.002
    room, error = cell.places["bin_C"].room, cell.cameras["hand"].error
    boxes = np.array([[room.low + 0.02, room.high - 0.02]])
    boxes[0, 0, 2] = room.floor_front - 0.004
    far = room.low - 10.0, room.low - 9.0  # such boxes of a file made by hand are left out
    seen = replace(exact(true_scene, "bin_C"), unknown=np.concatenate([boxes, [far]]))
    (space,) = believed_scene(cell, [look(true_scene, seen)], everywhere_but(cell, "bin_C")).unknown
    assert len(space.boxes) > 5 and (space.boxes[:, 0] < space.boxes[:, 1]).all()
    for low, high in space.boxes:
        x = np.array([low[0], high[0]])
        grown = boxes[0, 0, 2] - error.position
        assert low[2] <= max(grown, float(room.floor_at(x).max())) + 1e-9
        assert low[2] >= float(room.floor_at(x).min()) - slope - 1e-9


def test_what_cannot_be_believed_is_told(true_scene: Scene) -> None:
    seen, cell = exact(true_scene, "bin_C"), true_scene.cell
    with pytest.raises(UnknownNameError, match="bin_Z"):
        believed_scene(cell, [look(true_scene, seen)], ["bin_Z"])
    with pytest.raises(InputError, match="bin_C is said to be empty, but was looked into"):
        believed_scene(cell, [look(true_scene, seen)], ["bin_C"])
    with pytest.raises(InputError, match="cell other"):
        believed_scene(cell, [replace(look(true_scene, seen), cell="other")])
    with pytest.raises(InputError, match=f"{ITEM} is in bin_C and in bin_D"):
        believed_scene(cell, [look(true_scene, seen, replace(seen, place="bin_D"))])
    with pytest.raises(UnknownNameError, match="hands"):
        believed_scene(cell, [replace(look(true_scene, seen), camera="hands")])


def test_planner_and_verifier_keep_out_of_unknown_space(true_scene: Scene) -> None:
    """A plan in a bin without unknown space is refused in one whose mouth nobody has seen through."""
    cell = true_scene.cell
    context = PlanningContext(cell)
    free = everywhere_but(cell, "bin_C")
    open_bin = believed_scene(cell, [look(true_scene, exact(true_scene, "bin_C"))], free)
    query, start = PickQuery("bin_C", ITEM), Start(cell.home.q, cell.home.tool_state)
    plan = plan_pick(context, open_bin, query, start, 1)
    verdict = verify(plan, open_bin)
    assert verdict.certificate is not None
    T_world_bin = open_bin.T_world_place(cell.places["bin_C"])
    shut = np.array([[[0.0, -0.2, 0.0], [0.02, 0.2, 0.3]]])
    closed = replace(open_bin, unknown=(UnknownSpace("bin_C", T_world_bin, shut),))
    refused = verify(replace(plan, scene_hash=scene_hash(closed)), closed)
    assert refused.certificate is None
    assert any("unknown_bin_C_0" in str(reason) for reason in refused.reasons)
    with pytest.raises(NoPlanError, match="unknown_bin_C_0"):
        plan_pick(context, closed, query, start, 1)


def test_what_stands_on_a_thin_shelf_is_lifted_over_a_bin_that_nobody_saw(cell: Cell) -> None:
    """The board under it is 1 mm thick, and what is unknown under that ends where no motion goes."""
    scene = make_scene({"bin_C": ("i_am_a_bunny_book",)}, cell, seed=3)
    looks, free = [look(scene, exact(scene, "bin_C"))], everywhere_but(cell, "bin_C", "bin_F")
    believed = believed_scene(cell, looks, free)
    (below,) = believed.unknown
    ceiling = below.T_world_place[2, 3] + cell.places["bin_F"].room.ceiling_front
    tops = [body.T_parent_shape[2, 3] + body.shape.extents[2] / 2 for body in below.bodies]
    assert max(tops) == pytest.approx(ceiling - cell.clearance)
    query, start = PickQuery("bin_C", "i_am_a_bunny_book"), Start(cell.home.q, cell.home.tool_state)
    plan = plan_pick(PlanningContext(cell), believed, query, start, 1)
    assert verify(plan, believed).certificate is not None


def test_nothing_is_taken_from_under_what_nobody_recognised(true_scene: Scene) -> None:
    """By planner and verifier: it lies on the target, and no motion comes near to it."""
    cell, item = true_scene.cell, true_scene.find(ITEM)
    context, free = PlanningContext(cell), everywhere_but(true_scene.cell, "bin_C")
    T_bin_item = inverse(true_scene.T_world_place(cell.places["bin_C"])) @ item.T_world_item
    top = T_bin_item[:3, 3] + np.array([0.02, 0.0, item.item.shape.reach(T_bin_item[:3, :3])[2]])
    query, start = PickQuery("bin_C", ITEM), Start(cell.home.q, cell.home.tool_state)
    plan = plan_pick(
        context, believed_scene(cell, [look(true_scene, exact(true_scene, "bin_C"))], free), query, start, 1
    )
    for above, is_on_it in ((0.006, True), (0.05, False)):
        middle, half = top + np.array([0.0, 0.0, above]), np.array([0.02, 0.02, 0.004])
        thing = np.array([[middle - half, middle + half]])
        seen = replace(exact(true_scene, "bin_C"), unrecognised=thing)
        scene = believed_scene(cell, [look(true_scene, seen)], free)
        verdict = verify(replace(plan, scene_hash=scene_hash(scene)), scene)
        told = [str(reason) for reason in verdict.reasons if "nobody recognised" in str(reason)]
        assert bool(told) is is_on_it is (verdict.certificate is None)
        if is_on_it:
            with pytest.raises(NoPlanError, match="what nobody recognised may rest on"):
                plan_pick(context, scene, query, start, 1)
        else:
            assert verify(plan_pick(context, scene, query, start, 1), scene).certificate is not None


def test_looks_that_answer_the_truth_within_bounds_lead_to_the_pick_of_bounded_errors(
    true_scene: Scene,
) -> None:
    """By a camera exactly mounted, that sees all there is: nothing else of a look changes a plan."""
    hand = true_scene.cell.cameras["hand"]
    cell = replace(true_scene.cell, cameras={"hand": replace(hand, error=MountError(0.0, 0.0))})
    seen = exact(true_scene, "bin_C")
    believed = believed_scene(cell, [look(true_scene, seen)], everywhere_but(cell, "bin_C"))
    assert believed.unknown == ()
    bounded = replace(true_scene, cell=cell, noise=BOUND)
    context, home = PlanningContext(cell), Start(cell.home.q, cell.home.tool_state)
    one, other = (
        plan_pick(context, scene, PickQuery("bin_C", ITEM), home, 3) for scene in (believed, bounded)
    )
    assert motion_hash(one) == motion_hash(other)
    assert verify(one, believed).certificate is not None
