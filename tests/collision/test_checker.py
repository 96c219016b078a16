"""What a checker promises about scenes, held items, contacts and margins."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from pickcli.cell.cell import AllowedPair, Cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tool import MOVING
from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import StaleError, UnknownNameError
from pickcli.geometry import Array, inverse, pose, transform_points
from pickcli.kinematics.arm import Arm
from pickcli.scene.scene import PoseNoise
from support.solid_helpers import MakeChecker, MakeScene, box_item, link_points
from support.tool_states import ALL_STATES, DOWN, STRAIGHT

DELFT_HOME = np.array([0.2191, 0, -1.0945, 0, -1.7267, 0, -0.9443, 0])
CUBE = box_item((0.1, 0.1, 0.1))


def test_named_configurations_are_free(cell: Cell, make_checker: MakeChecker) -> None:
    """Delft's own poses, but for three over the tote that put our longer tool into its wall."""
    checkers = {tool_state: make_checker(tool_state=tool_state) for tool_state in ALL_STATES}
    blocked = {c.name for c in cell.configurations.values() if not checkers[c.tool_state].is_valid(c.q)}
    assert blocked == {"tote_10h", "tote_11h", "tote_12h"}
    assert checkers[STRAIGHT].is_valid(DELFT_HOME)


def test_no_collision_of_the_exact_shapes_is_missed(
    cell: Cell, arm: Arm, model: CollisionModel, make_checker: MakeChecker
) -> None:
    """Points of the links themselves against the boxes, by forward kinematics: a hit is never called free."""
    rng = np.random.default_rng(5)
    checker = make_checker(tool_state=DOWN, margin=0.0)
    clouds = [link_points(cell, name, rng, 60) for name in model.frame_names]
    Q = arm.random_seeds(rng, 150)
    free, n_hits = checker.are_valid(Q), 0
    for q, is_free in zip(Q, free, strict=True):
        frames = arm.chain(DOWN).fk(q)
        hit = False
        for k, cloud in enumerate(clouds):
            world = transform_points(frames[k], cloud)
            for b in range(len(checker.world.names)):
                if not int(checker.world.ignored_frames[b]) >> k & 1:
                    local = transform_points(inverse(checker.world.T_world_box[b]), world)
                    hit = hit or bool((np.abs(local) < checker.world.half_extents[b]).all(axis=1).any())
        n_hits += hit
        assert not (hit and is_free)
    assert n_hits > 20


def test_moving_is_free_only_where_both_ends_are(arm: Arm, make_checker: MakeChecker) -> None:
    rng = np.random.default_rng(6)
    Q = arm.random_seeds(rng, 2000)
    moving, straight, down = (
        make_checker(tool_state=tool_state).are_valid(Q) for tool_state in (MOVING, STRAIGHT, DOWN)
    )
    assert moving.any() and not (moving & ~straight).any() and not (moving & ~down).any()


def test_items_block_and_can_be_left_out(
    make_scene: MakeScene, make_checker: MakeChecker, home: Array
) -> None:
    scene = make_scene((CUBE, pose((-0.6, 0, 1.7))))
    assert not make_checker(scene).is_valid(home)
    assert make_checker(scene, contacts=AllowedContacts(absent=frozenset({"item0"}))).is_valid(home)


def test_noise_inflates_items(
    make_scene: MakeScene, make_checker: MakeChecker, T_home_tip: Array, home: Array
) -> None:
    """An item 12 mm in front of the cup is clear, unless it may be 10 mm nearer (3 mm must be kept)."""
    T = T_home_tip @ pose((0, 0, 0.05 + 0.012))
    assert make_checker(make_scene((CUBE, T))).is_valid(home)
    assert not make_checker(make_scene((CUBE, T), noise=PoseNoise(0.010, 0.0))).is_valid(home)
    turned = PoseNoise(0.0, 0.010 / (np.sqrt(3) * 0.05))
    assert not make_checker(make_scene((CUBE, T), noise=turned)).is_valid(home)


def test_margin_is_kept(
    make_scene: MakeScene, make_checker: MakeChecker, T_home_tip: Array, home: Array
) -> None:
    scene = make_scene((CUBE, T_home_tip @ pose((0, 0, 0.05 + 0.012))))
    distance = make_checker(scene).clearance(home).distance
    assert 0.008 <= distance <= 0.012
    assert make_checker(scene, margin=distance - 1e-3).is_valid(home)
    assert not make_checker(scene, margin=distance + 1e-3).is_valid(home)


def test_the_pod_is_where_the_scene_says(
    cell: Cell, arm: Arm, make_scene: MakeScene, make_checker: MakeChecker
) -> None:
    """The pod moved so that a divider of bin E comes to stand where the cup is."""
    q = cell.configurations["bin_E"].q
    divider = next(b for b in cell.pod.bodies if b.name == "row_DEF_divider_left").T_parent_shape
    moved = pose(arm.tip(q, STRAIGHT)[:3, 3] - divider[:3, 3])
    assert make_checker().is_valid(q)
    checker = make_checker(make_scene(T_world_pod=moved))
    assert not checker.is_valid(q)
    assert checker.clearance(q).kind == "pod"


def test_touching_frees_the_cup_but_no_other_link(
    make_scene: MakeScene, make_checker: MakeChecker, T_home_tip: Array, home: Array
) -> None:
    at_cup = make_scene((CUBE, T_home_tip @ pose((0, 0, 0.045))))
    touching = frozenset({"item0"})
    assert not make_checker(at_cup).is_valid(home)
    assert make_checker(at_cup, contacts=AllowedContacts.at_any_depth(touching)).is_valid(home)
    at_lance = make_scene((CUBE, T_home_tip @ pose((0.02, 0, -0.3))))
    assert not make_checker(at_lance, contacts=AllowedContacts.at_any_depth(touching)).is_valid(home)


def test_held_items_count_and_may_touch(
    make_scene: MakeScene, make_checker: MakeChecker, T_home_tip: Array, home: Array
) -> None:
    held = AttachedItem(CUBE, pose((0, 0, 0.05)), 0.0)
    scene = make_scene((CUBE, T_home_tip @ pose((0, 0, 0.05 + 0.08))))
    assert make_checker(scene).is_valid(home)
    assert not make_checker(scene, held=held).is_valid(home)
    assert make_checker(scene, held=held, contacts=AllowedContacts.at_any_depth({"item0"})).is_valid(home)
    assert make_checker(held=held).is_valid(home)


def test_a_held_item_inflated_reaches_farther(
    make_scene: MakeScene, make_checker: MakeChecker, T_home_tip: Array, home: Array
) -> None:
    scene = make_scene((CUBE, T_home_tip @ pose((0, 0, 0.1 + 0.05 + 0.02))))
    for inflate, is_free in ((0.0, True), (0.014, True), (0.016, False)):
        held = AttachedItem(CUBE, pose((0, 0, 0.05)), inflate)
        assert make_checker(scene, held=held, margin=0.005).is_valid(home) == is_free


@pytest.mark.parametrize("kind", [ShapeKind.CYLINDER, ShapeKind.SPHERE])
def test_round_items_leave_the_corners_of_their_boxes_free(
    kind: ShapeKind, make_scene: MakeScene, make_checker: MakeChecker, T_home_tip: Array, home: Array
) -> None:
    """The cup in a corner of the box around a round item, and the same item in the cup beside a cube."""
    size = (0.1, 0.2) if kind is ShapeKind.CYLINDER else (0.1,)
    item, box = replace(CUBE, shape=Shape(kind, size)), box_item((0.2, 0.2, 0.2))
    T = T_home_tip @ pose((0.098, 0.098, 0.0))
    assert make_checker(make_scene((item, T))).is_valid(home)
    assert not make_checker(make_scene((box, T))).is_valid(home)
    beside = make_scene((CUBE, T_home_tip @ pose((0.13, 0.13, 0.1))))
    in_cup = pose((0.0, 0.0, 0.1))
    assert make_checker(beside, held=AttachedItem(item, in_cup), margin=0.012).is_valid(home)
    assert not make_checker(beside, held=AttachedItem(item, in_cup), margin=0.014).is_valid(home)
    assert not make_checker(beside, held=AttachedItem(box, in_cup), margin=0.0).is_valid(home)


def test_a_held_item_must_clear_the_arm(make_checker: MakeChecker, home: Array) -> None:
    long = box_item((0.1, 0.1, 0.6))
    backwards = AttachedItem(long, pose((0.1, 0, -0.4)), 0.0)  # reaches back along the lance to the wrist
    contact = make_checker(held=backwards).clearance(home)
    assert contact.distance < 0 and contact.kind == "robot"
    assert "held carton" in (contact.a, contact.b)


def test_a_held_item_swings_with_the_moving_cup(
    make_scene: MakeScene, make_checker: MakeChecker, T_home_tip: Array, home: Array
) -> None:
    below = make_scene((CUBE, T_home_tip @ pose((0.15, 0, 0.1))))
    held = AttachedItem(CUBE, pose((0, 0, 0.05)), 0.0)
    assert make_checker(below, held=held).is_valid(home)
    assert not make_checker(below, tool_state=MOVING, held=held).is_valid(home)


def test_unknown_names_are_refused(make_checker: MakeChecker) -> None:
    with pytest.raises(UnknownNameError, match="row_ABC_lip"):
        make_checker(contacts=AllowedContacts.at_any_depth({"row_ABC_lib"}))
    with pytest.raises(UnknownNameError, match="item9"):
        make_checker(contacts=AllowedContacts(absent=frozenset({"item9"})))


def test_a_scene_of_another_cell_is_refused(
    cell: Cell, make_scene: MakeScene, make_checker: MakeChecker
) -> None:
    other = replace(make_scene(), cell=replace(cell, name="other", fingerprint="0123456789abcdef"))
    with pytest.raises(StaleError, match=f"0123456789ab.*{cell.fingerprint[:12]}"):
        make_checker(other)


def test_touching_may_name_what_is_left_out(
    make_scene: MakeScene, make_checker: MakeChecker, home: Array
) -> None:
    scene = make_scene((CUBE, pose((-0.6, 0, 1.7))))
    assert make_checker(
        scene, contacts=AllowedContacts.at_any_depth({"item0"}, absent=frozenset({"item0"}))
    ).is_valid(home)


def test_allowed_pairs_are_never_tested(cell: Cell, home: Array, make_scene: MakeScene) -> None:
    """Without its exemptions the carriage stands in the rail bed."""
    bare = replace(cell, allowed_pairs=())
    assert not SceneChecker(CollisionModel(bare), replace(make_scene(), cell=bare), STRAIGHT).is_valid(home)
    pairs = (*cell.allowed_pairs, AllowedPair("cup", "table", "test"))
    exempt = replace(cell, allowed_pairs=pairs)
    world = SceneChecker(CollisionModel(exempt), replace(make_scene(), cell=exempt), STRAIGHT).world
    table = world.names.index("table")
    assert int(world.ignored_frames[table]) == 1 << (len(cell.robot.joints) - 1)


def test_edges_and_paths_agree_with_their_configurations(cell: Cell, make_checker: MakeChecker) -> None:
    checker = make_checker()
    named = [cell.configurations[n].q for n in ("home", "bin_E", "cam_E", "tote", "tote_10h")]
    path = np.array(named)
    assert checker.is_valid_path(path[:3])
    assert checker.first_blocked_edge(path) == 3
    assert not checker.is_valid_edge(path[3], path[4])
    for a, b in pairwise(path[:3]):
        assert checker.is_valid_edge(a, b)
        assert checker.are_valid(np.linspace(a, b, 300)).all()


def test_slack_makes_edges_harder(cell: Cell, make_checker: MakeChecker, home: Array) -> None:
    checker = make_checker()
    q = cell.configurations["bin_E"].q
    assert checker.is_valid_path(np.stack([home, q]), np.full((1, 8), 1e-3))
    assert not checker.is_valid_path(np.stack([home, q]), np.full((1, 8), 0.5))


def test_expensive_parts_are_shared(make_scene: MakeScene, make_checker: MakeChecker) -> None:
    scene = make_scene((CUBE, pose((0.2, 0, 1.4))))
    first, second = make_checker(scene), make_checker(scene, contacts=AllowedContacts.at_any_depth({"item0"}))
    assert first.world is second.world
