"""What may be touched is what is near at rest, and no deeper than it is there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import Array, inverse, pose
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.statics.supports import supports_of
from pickcli.verification.exemptions import exemptions
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.moving_parts import parts_of_segments
from pickcli.verification.static_solids import plan_fixtures
from pickcli.verification.verify import sampled, verify
from support.handmade_plans import (
    CRAYOLA,
    Builder,
    bound,
    cell,
    make_scene,
    move_plan,
    pick,
    pick_pushing,
    place,
    tip,
)

Q = np.asarray(cell().configurations["home"].q)


def box_at(xyz: Sequence[float], noise: float = 0.0) -> Scene:
    """A box in the air, its middle at a place (3,) in the tool frame."""
    item = cell().item(CRAYOLA)
    placed = PlacedItem(CRAYOLA, item, "bin_A", tip(Q) @ pose(xyz))
    return make_scene(placed, noise=PoseNoise(noise, 0.0))


def leaving(scene: Scene, way: Sequence[float], back: float = 0.0, touching: str = CRAYOLA) -> Plan:
    """A way out of a stop that begins with a line on which the cup may touch something, and goes back then.

    way: (3,) m along the tool's axes. back: m along its axis, afterwards. touching: the box, or another
    """
    builder = Builder(Q)
    there = tip(Q) @ pose(way)
    builder.line(SegmentKind.DEPART, there, 2.0, touching=(touching,))
    if back:
        builder.line(SegmentKind.RETREAT, there @ pose((0.0, 0.0, -back)), 2.0)
    return replace(move_plan(scene, builder), recovery=RecoveryLevel.AS_PLANNED)


def test_what_rolls_is_not_pushed() -> None:
    """A ball beside the item, on level ground: the depth of a touch would be within what lines may be off."""
    plan, scene = pick()
    target, ball = scene.find(CRAYOLA), cell().item("rawlings_baseball")
    r, half = float(ball.shape.extents[0]) / 2, float(target.item.shape.reach(target.T_world_item[:3, :3])[1])
    low = float(target.item.shape.reach(target.T_world_item[:3, :3])[2])
    middle = target.T_world_item[:3, 3] + (0.0, -half - r - 2e-4, r - low)
    with_ball = replace(scene, items=(target, PlacedItem("ball", ball, "bin_B", pose(middle))))
    k = next(k for k, s in enumerate(plan.segments) if s.kind is SegmentKind.LIFT)
    assert supports_of(with_ball).rolling(CRAYOLA) == ("ball",)
    for aside, is_pushed in ((0.0, False), (-0.0013, True)):
        segments = list(pick_pushing(aside).segments)
        segments[k] = replace(segments[k], touching=(*segments[k].touching, "ball"))
        touching = bound(replace(pick_pushing(aside), segments=tuple(segments)), with_ball)
        assert ("pushes what rolls" in told(touching, with_ball)) is is_pushed


def told(plan: Plan, scene: Scene) -> str:
    return "; ".join(map(str, verify(plan, scene).reasons))


def test_a_way_out_touches_only_what_it_is_near_to() -> None:
    """The box is 20 mm ahead and known to 8 mm: the bellows would take what the cup is driven into it."""
    half = float(cell().item(CRAYOLA).shape.extents[2]) / 2
    scene = box_at((0.0, 0.0, half + 0.020), noise=0.008)
    assert "not near where" in told(leaving(scene, (0.0, 0.0, 0.024)), scene)
    near = box_at((0.0, 0.0, half + 0.001))
    assert told(leaving(near, (0.0, 0.0, -0.03)), near) == ""


def test_the_bellows_do_not_give_sideways() -> None:
    """The box is 1 mm beside the rim and reaches 6 mm back along the cup, which its bellows take."""
    size = cell().item(CRAYOLA).shape.extents
    beside = float(size[1]) / 2 + cell().robot.tool.cup.radius + 0.001
    scene = box_at((0.0, beside, float(size[2]) / 2 - 0.006))
    assert "planned contact too deep" in told(leaving(scene, (0.0, 0.005, 0.0), back=0.03), scene)
    assert told(leaving(scene, (0.0, -0.005, 0.0), back=0.03), scene) == ""


def plate_before_the_cup() -> Array:
    """Pose (4, 4) in the world of a plate of 20 mm, 1 mm before the cup."""
    return np.asarray(tip(Q) @ pose((0.0, 0.0, 0.011)))


PLATE = Shape(ShapeKind.BOX, (0.2, 0.2, 0.02))


def test_what_stands_in_the_cell_stands_where_the_cell_says() -> None:
    """A plate 1 mm before the cup: nothing but the rounding of lines explains that the cup is in it."""
    plate = Body("plate", PLATE, plate_before_the_cup())
    obstacles = replace(cell().obstacles, bodies=(*cell().obstacles.bodies, plate))
    scene = replace(make_scene(), cell=replace(cell(), obstacles=obstacles))
    for forward, is_refused in ((0.002, False), (0.003, True)):
        way_out = leaving(scene, (0.0, 0.0, forward), touching="plate")
        assert ("cup and plate" in told(way_out, scene)) is is_refused
        assert ("planned contact too deep" in told(way_out, scene)) is is_refused


def test_a_pod_that_may_be_turned_explains_as_much_as_that_moves_its_parts() -> None:
    """A plate of the pod, 0.6 m from its axis and 1.7 m up, and a turn of 2 mrad: 1.2 mm at its edges."""
    plate = Body("plate", PLATE, inverse(cell().T_world_pod) @ plate_before_the_cup())
    pod = replace(cell().pod, bodies=(*cell().pod.bodies, plate))
    scene = replace(make_scene(), cell=replace(cell(), pod=pod), pod_error=Displacement(0.0, 0.0, yaw=0.002))
    for forward, is_refused in ((0.0036, False), (0.005, True)):
        way_out = leaving(scene, (0.0, 0.0, forward), touching="plate")
        assert ("planned contact too deep" in told(way_out, scene)) is is_refused


def test_an_uncertain_item_explains_as_much_as_its_pose_may_be_off_whatever_else_lies_there() -> None:
    """A box 1 mm before the cup and known to 4 mm, and a ball elsewhere."""
    scene = box_at((0.0, 0.0, float(cell().item(CRAYOLA).shape.extents[2]) / 2 + 0.001), noise=0.004)
    ball = place("rawlings_baseball", (0.2, 0.0, 0.05), "bin_H")
    for items in (scene.items, (*scene.items, ball), (ball, *scene.items)):
        there = replace(scene, items=items)
        for forward, is_refused in ((0.006, False), (0.007, True)):
            refused = "planned contact too deep" in told(leaving(there, (0.0, 0.0, forward)), there)
            assert refused is is_refused


def test_what_is_named_but_far_is_kept_clear_of_like_anything_else() -> None:
    plan, scene = pick()
    k = next(k for k, s in enumerate(plan.segments) if s.kind is SegmentKind.LIFT)
    T = pose_in_tool(plan, scene)
    moving, world = parts_of_segments(plan, scene, T), plan_fixtures(plan, scene, T)
    every = tuple(fixture.name for fixture in world.before)
    named = [replace(s, touching=every) if j in (k - 1, k) else s for j, s in enumerate(plan.segments)]
    plan = replace(plan, segments=tuple(named))
    found = exemptions(plan, scene, sampled(plan, scene, moving), moving, world)
    floor = set(cell().pod.bins["bin_B"].support)
    assert found[k - 1].touching == {CRAYOLA} | floor
    assert found[k].touching == floor


def test_what_is_taken_lies_at_most_3_mm_deep_where_poses_are_exact() -> None:
    """1.5 mm as settled items may stand in each other, 1.5 mm for lines and bounds; it lies 0.2 mm clear."""
    plan, scene = pick()
    target = scene.find(CRAYOLA)
    for down, is_refused in ((0.0031, False), (0.0033, True)):
        sunk = replace(target, T_world_item=pose((0.0, 0.0, -down)) @ target.T_world_item)
        lower = scene.moved(sunk)
        assert ("3.0 explained" in told(bound(plan, lower), lower)) is is_refused


def test_contact_that_is_not_planned_is_a_collision_and_nothing_else() -> None:
    """The item stands too deep in a floor that it is not said to touch, beside a bar that it may touch."""
    plan, scene = pick()
    target, bar = scene.find(CRAYOLA), cell().item("dove_beauty_bar")
    beside = (target.item.shape.extents[1] + bar.shape.extents[1]) / 2 + 0.001
    sunk = replace(target, T_world_item=pose((0.0, 0.0, -0.0035)) @ target.T_world_item)
    y, z = float(beside), float(scene.find("dove_beauty_bar").T_world_item[2, 3])
    there = make_scene(sunk, place("dove_beauty_bar", (float(sunk.T_world_item[0, 3]), y, z), "bin_B"))
    lift = [s.kind for s in plan.segments].index(SegmentKind.LIFT)
    for touching, what in (
        (("dove_beauty_bar",), "collision"),
        (("dove_beauty_bar", *plan.segments[lift].touching), "planned contact too deep"),
    ):
        segments = list(plan.segments)
        segments[lift] = replace(segments[lift], touching=touching)
        reasons = verify(bound(replace(plan, segments=tuple(segments)), there), there).reasons
        at = f"segment {lift} (lift)"
        assert {r.what for r in reasons if "floor_flat" in r.detail and r.where == at} == {what}
