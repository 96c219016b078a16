"""The cup: seals, holds to its stated limits, breaks beyond them, and obeys the valve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tools.lip_leak import FULL_VACUUM
from pickcli.geometry import Array
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.suction import BREAK_TIME, face_at
from pickcli.simulation.world import World
from support.pedestal import STATED_MASS, BuildWorld, cube, evacuate
from support.tool_states import STRAIGHT

DOWN, ASIDE = np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])
WEIGHT = 0.1 * 9.81


def push(world: World, force: Array, offset: Array, duration: float) -> None:
    """A force on the held cube at an offset from the tip, in world axes."""
    for _ in range(round(duration / world.time_step)):
        if world.held is None:
            return
        world.engine.apply_force("cube", force, world.tip[:3, 3] + offset)
        world.step()


def twist(world: World, moment: float, duration: float) -> None:
    """A pure moment about the y axis: two opposite forces 0.1 m apart."""
    for _ in range(round(duration / world.time_step)):
        if world.held is None:
            return
        tip = world.tip[:3, 3]
        for side in (-0.05, 0.05):
            force = np.array([0.0, 0.0, np.sign(side) * moment / 0.1])
            world.engine.apply_force("cube", force, tip + np.array([side, 0.0, 0.0]))
        world.step()


def test_the_load_is_the_weight_and_hangs_straight(holding: World) -> None:
    load = holding.suction.load
    assert load.pull == pytest.approx(WEIGHT, rel=0.01)
    assert load.shear == pytest.approx(0.0, abs=0.02)
    assert load.bending == pytest.approx(0.0, abs=0.002)
    assert load.twist == pytest.approx(0.0, abs=0.001)
    assert holding.act("vacuum_sensor", "read") is True


@pytest.mark.parametrize(("share", "holds"), [(0.95, True), (1.06, False)])
def test_pull(holding: World, share: float, holds: bool) -> None:
    limit = holding.robot.tool.cup.limits.max_pull
    push(holding, DOWN * (share * limit - WEIGHT), np.zeros(3), 0.2)
    assert (holding.held == "cube") is holds


@pytest.mark.parametrize(("share", "holds"), [(0.93, True), (1.06, False)])
def test_shear(holding: World, share: float, holds: bool) -> None:
    push(holding, ASIDE * share * holding.robot.tool.cup.limits.max_shear, np.zeros(3), 0.2)
    assert (holding.held == "cube") is holds


@pytest.mark.parametrize(("share", "holds"), [(0.93, True), (1.06, False)])
def test_moment(holding: World, share: float, holds: bool) -> None:
    twist(holding, share * holding.robot.tool.cup.limits.max_moment, 0.2)
    assert (holding.held == "cube") is holds


@pytest.mark.parametrize(("share", "holds"), [(0.45, True), (0.56, False)])
def test_half_the_vacuum_holds_half(holding: World, share: float, holds: bool) -> None:
    vacuum = holding.suction.vacuum
    holding.act("pump", "off")
    vacuum.line = vacuum.cup = 0.5 * FULL_VACUUM
    push(holding, DOWN * (share * holding.robot.tool.cup.limits.max_pull - WEIGHT), np.zeros(3), 0.1)
    assert (holding.held == "cube") is holds


def test_a_peak_shorter_than_three_measured_steps_does_not_break_it(holding: World) -> None:
    push(holding, DOWN * 60.0, np.zeros(3), BREAK_TIME - 2 * holding.time_step)
    holding.wait(0.05)
    assert holding.held == "cube"


def test_breaking_away_is_reported_and_not_wanted(holding: World) -> None:
    push(holding, DOWN * 60.0, np.zeros(3), 0.1)
    (release,) = holding.suction.releases
    assert (release.item, release.is_wanted) == ("cube", False)
    assert release.load.pull > holding.robot.tool.cup.limits.max_pull


def test_the_valve_lets_go(holding: World) -> None:
    holding.act("valve", "off")
    holding.wait(0.15)
    assert holding.held is None
    (release,) = holding.suction.releases
    assert release.is_wanted
    holding.wait(0.2)
    assert holding.engine.pose("cube")[2, 3] < release.T_world_item[2, 3] - 0.1


def test_no_seal_without_vacuum_gap_or_face(build_world: BuildWorld) -> None:
    without_pump = build_world()
    without_pump.act("valve", "on")
    without_pump.wait(0.5)
    assert without_pump.held is None
    for world in (build_world(gap=0.003), build_world(shift=(0.016, 0.0))):  # too far; over the edge
        evacuate(world)
        world.act("valve", "on")
        world.wait(0.5)
        assert world.held is None
        assert world.act("vacuum_sensor", "read") is False


def test_within_the_gap_it_seals(build_world: BuildWorld) -> None:
    world = build_world(gap=0.001)
    evacuate(world)
    world.act("valve", "on")
    world.wait(0.4)
    assert world.held == "cube"


def frontal_pick(world: World, shift: float, dwell: float = 0.25) -> None:
    """By the rail alone: 40 mm towards the item, a dwell in s on it, and back; the valve opens ``shift`` s
    later than it should."""
    evacuate(world)
    speed, depth = world.robot.tool.cup.contact_speed, 0.043
    start = world.t
    t_contact = start + depth / speed
    home = world.q.copy()
    is_opened = False
    while world.t < t_contact + dwell + 0.3:
        if not is_opened and world.t >= t_contact - 0.05 + shift:
            world.act("valve", "on")
            is_opened = True
        forward = min(world.t - start, depth / speed) * speed
        back = max(0.0, world.t - t_contact - dwell)
        q = home.copy()
        q[0] += forward - min(1.0 * back**2, 0.25 * back)
        world.command(q)
        world.step()


@pytest.mark.parametrize(("shift", "holds"), [(0.0, True), (-0.3, True), (0.3, False)])
def test_a_valve_that_opens_when_the_cup_leaves_is_too_late(
    build_world: BuildWorld, shift: float, holds: bool
) -> None:
    world = build_world(gap=0.04, tool_state=STRAIGHT)
    frontal_pick(world, shift)
    assert (world.held == "cube") is holds
    assert not world.suction.releases


def test_a_valve_that_opens_too_early_holds_with_what_vacuum_is_left(build_world: BuildWorld) -> None:
    left = []
    for shift in (0.0, -0.3):
        world = build_world(gap=0.04, tool_state=STRAIGHT)
        frontal_pick(world, shift)
        assert world.held == "cube"
        left.append(world.suction.vacuum.cup)
    assert left[1] < 0.85 * left[0]


@pytest.mark.parametrize(("gap", "holds"), [(-0.0005, True), (0.001, False)])
def test_the_friction_of_a_lip_that_touches_stops_what_moves_easily(
    build_world: BuildWorld, gap: float, holds: bool
) -> None:
    """On ice the cube is dragged along, where a heavy plate is not, nor what is in front of the lip."""
    world = build_world(gap=gap)
    world.engine._dynamics("cube", lateralFriction=0.0)
    evacuate(world)
    q, before = world.q.copy(), world.engine.pose("cube")[:3, 3]
    world.act("valve", "on")
    for _ in range(400):
        q[0] += 0.01 * world.time_step
        world.command(q)
        world.step()
    assert (world.held == "cube") is holds
    moved = float(np.linalg.norm((world.engine.pose("cube")[:3, 3] - before)[:2]))
    assert (moved > 5e-4) is holds


def test_an_open_valve_drags_a_light_item_and_not_a_heavy_one(build_world: BuildWorld) -> None:
    moved = []
    for mass in (0.02, 1.0):
        world = build_world(cube(mass=mass), gap=0.004, shift=(0.012, 0.0))
        evacuate(world)
        before = world.engine.pose("cube")
        world.act("valve", "on")
        world.wait(0.3)
        moved.append(float(np.abs(world.engine.pose("cube") - before).max()))
        world.act("valve", "off")
    assert moved[0] > 1e-4
    assert moved[1] < 2e-5


def sealed(world: World, wait: float = 0.6) -> World:
    """Pump and open the valve, and give it a time in s."""
    evacuate(world)
    world.act("valve", "on")
    world.wait(wait)
    return world


def test_the_relaxed_bellows_push_like_a_spring(build_world: BuildWorld) -> None:
    for pressed in (0.001, 0.003, 0.006):
        world = build_world(gap=-pressed)
        world.wait(0.3)
        (point,) = world.suction.contact_points
        assert point.force == pytest.approx(world.robot.tool.cup.stiffness * pressed, rel=0.03)
        assert point.depth == pytest.approx(pressed, abs=1e-4)
    assert world.contacts.collisions == ()


def flat(thickness: float, mass: float = 0.1) -> Item:
    """A thin book."""
    return cube(mass=mass, size=(0.12, 0.08, thickness))


def test_a_thin_book_is_pressed_on_its_shelf_with_the_force_of_the_bellows(build_world: BuildWorld) -> None:
    world = build_world(flat(0.004), gap=-0.003)
    world.planned = PlannedContacts().also(frozenset({"cube", "pedestal"}))
    forces = []
    evacuate(world)
    world.act("valve", "on")
    for _ in range(500):
        world.step()
        forces += [point.force for point in world.engine.contact_points("robot")]
    assert world.held == "cube"
    assert world.contacts.collisions == () and world.suction.releases == []
    assert max(forces, default=0.0) < 5.0
    world.engine.remove("pedestal")
    world.wait(0.2)
    assert world.suction.load.pull == pytest.approx(WEIGHT, rel=0.01)


def test_beyond_the_stroke_the_cup_is_solid(build_world: BuildWorld) -> None:
    world = build_world(gap=0.005)
    q = world.q.copy()
    for _ in range(300):
        q[2] += 2e-4  # the cup points down: the arm presses by its elbow
        world.command(q)
        world.step()
    hard = [c for c in world.contacts.collisions if c.a == "cup" and c.force > 50.0]
    assert hard, "a planned contact that stands on the solid cup is told"


@pytest.mark.parametrize(("share", "holds"), [(1.0, True), (0.3, True), (0.0, False)])
def test_a_face_holds_as_well_as_it_seals(build_world: BuildWorld, share: float, holds: bool) -> None:
    seals = {**cube().seals, "+z": share}
    world = sealed(build_world(replace(cube(), seals=seals)), wait=2.0)
    assert (world.held == "cube") is holds
    assert world.act("vacuum_sensor", "read") is holds
    assert world.suction.vacuum.cup == pytest.approx(share * FULL_VACUUM, rel=0.02, abs=10.0)
    if holds:
        world.engine.remove("pedestal")
        limit = share * world.robot.tool.cup.limits.max_pull
        push(world, DOWN * (0.93 * limit - WEIGHT), np.zeros(3), 0.2)
        assert world.held == "cube"
        push(world, DOWN * (1.06 * limit - WEIGHT), np.zeros(3), 0.2)
        assert world.held is None


@pytest.mark.parametrize(("edge", "holds"), [(0.017, True), (0.013, True), (0.007, False)])
def test_the_rim_wants_the_part_that_seals(build_world: BuildWorld, edge: float, holds: bool) -> None:
    areas = {"+z": {"y": (-edge, edge)}}
    assert (sealed(build_world(replace(cube(), areas=areas))).held == "cube") is holds


@pytest.mark.parametrize(("aside", "kept"), [(0.0, 0.37), (0.002, 0.30)])
def test_a_lip_over_the_edges_of_a_narrow_face_keeps_what_the_pump_draws(
    build_world: BuildWorld, aside: float, kept: float
) -> None:
    item = cube(size=(0.2, 0.025, 0.016), mass=0.02)
    world = sealed(build_world(item, shift=(aside, 0.0)), wait=2.0)
    assert world.held == "cube"
    assert world.suction.vacuum.cup == pytest.approx(kept * FULL_VACUUM, rel=0.05)
    world.engine.remove("pedestal")
    limit = kept * (0.0125 - aside) / 0.015 * world.robot.tool.cup.limits.max_pull
    push(world, DOWN * (0.9 * limit - 0.2), np.zeros(3), 0.2)
    assert world.held == "cube"
    push(world, DOWN * (1.1 * limit - 0.2), np.zeros(3), 0.2)
    assert world.held is None


@pytest.mark.parametrize(("aside", "kept"), [(0.0, 0.37), (0.002, 0.30)])
def test_an_area_that_is_narrower_than_the_lip_holds_as_such_a_face_does(
    build_world: BuildWorld, aside: float, kept: float
) -> None:
    item = replace(cube(size=(0.2, 0.08, 0.016), mass=0.02), areas={"+z": {"y": (-0.0125, 0.0125)}})
    world = sealed(build_world(item, shift=(aside, 0.0)), wait=2.0)
    assert world.held == "cube"
    assert world.suction.vacuum.cup == pytest.approx(kept * FULL_VACUUM, rel=0.05)


def test_faces_are_airtight_where_reality_says_so(build_world: BuildWorld) -> None:
    item = replace(cube(), seals=dict.fromkeys(cube().seals, 0.0))
    assert sealed(build_world(item, reality=replace(STATED_MASS, honest_seals=False))).held == "cube"


@pytest.mark.parametrize(("speed", "holds"), [(0.0, True), (0.002, True), (0.02, False), (0.1, False)])
def test_a_face_that_slides_under_the_cup_does_not_seal(
    build_world: BuildWorld, speed: float, holds: bool
) -> None:
    # 19 N of friction on the pedestal, more than the 15 N of the lip at the vacuum that a slide leaves
    world = build_world(cube(size=(0.3, 0.3, 0.04), mass=4.0), gap=-0.0005)
    evacuate(world)
    q = world.q.copy()
    world.act("valve", "on")
    for _ in range(300):
        q[0] += speed * world.time_step
        world.command(q)
        world.step()
    assert (world.held == "cube") is holds


@pytest.mark.parametrize(
    ("size", "point", "face"),
    [
        ((0.1, 0.2, 0.3), (0.049, 0.0, 0.1), "+x"),
        ((0.1, 0.2, 0.3), (0.0, -0.102, 0.1), "-y"),
        ((0.05, 0.2), (0.01, 0.0, -0.1), "-z"),
        ((0.05, 0.2), (0.0, 0.049, 0.02), "mantle"),
        ((0.05,), (0.0, 0.049, 0.02), "sphere"),
    ],
)
def test_faces_are_named_as_the_items_name_them(
    size: tuple[float, ...], point: tuple[float, float, float], face: str
) -> None:
    shape = Shape({3: ShapeKind.BOX, 2: ShapeKind.CYLINDER, 1: ShapeKind.SPHERE}[len(size)], size)
    assert face_at(replace(cube(), shape=shape), np.array(point)) == face
    assert face in shape.face_names
