"""Counting collisions: once each, with place and depth, and never the planned ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import box
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.simulation.contacts import HELD_PRESS, ContactLog
from pickcli.simulation.engine import ContactPoint
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.world import World
from support.pedestal import BuildWorld, cube
from support.tool_states import STRAIGHT

NOTHING = PlannedContacts()


def point(
    a: str = "robot", link: str = "cup", b: str = "shelf", depth: float = 1e-3, link_b: str = ""
) -> ContactPoint:
    return ContactPoint(a, link, b, link_b, depth, (0.1, 0.2, 0.3), 5.0)


def log() -> ContactLog:
    return ContactLog("robot", ("cup",), frozenset({("carriage", "rail")}), max_press=8.0)


def test_an_ongoing_contact_counts_once_with_its_deepest_point() -> None:
    contacts = log()
    for k, depth in enumerate((1e-3, 3e-3, 2e-3)):
        contacts.update([point(depth=depth)], NOTHING, None, 0.01 * k)
    (collision,) = contacts.collisions
    assert (collision.a, collision.b, collision.depth) == ("cup", "shelf", 3e-3)
    assert (collision.t_start, collision.t_end) == (0.0, 0.02)


def test_a_contact_that_comes_back_later_counts_again() -> None:
    contacts = log()
    for t in (0.0, 0.05, 0.5):
        contacts.update([point()], NOTHING, None, t)
    assert len(contacts.collisions) == 2


def test_planned_contacts_are_those_of_cup_and_held_item_only() -> None:
    allowed = NOTHING.also(frozenset({"box"}))
    contacts = log()
    contacts.update([point(b="box"), point(a="tea", link="", b="box")], allowed, "tea", 0.0)
    assert not contacts.collisions
    contacts.update([point(link="lance", b="box")], allowed, "tea", 0.1)
    assert [c.a for c in contacts.collisions] == ["lance"]


def test_a_planned_contact_that_presses_harder_than_the_bellows_is_a_collision() -> None:
    allowed = NOTHING.also(frozenset({"shelf"}))
    contacts = log()
    contacts.update([replace(point(), force=7.9)], allowed, None, 0.0)
    assert not contacts.collisions
    contacts.update([replace(point(), force=8.1)], allowed, None, 0.1)
    assert [(c.a, c.b) for c in contacts.collisions] == [("cup", "shelf")]


def test_a_held_item_that_is_driven_into_what_it_may_touch_is_a_collision() -> None:
    allowed = NOTHING.also(frozenset({"shelf"}))
    contacts = log()
    contacts.update([replace(point(a="tea", link=""), force=HELD_PRESS)], allowed, "tea", 0.0)
    assert not contacts.collisions
    contacts.update([replace(point(a="tea", link=""), force=HELD_PRESS + 0.1)], allowed, "tea", 0.1)
    (found,) = contacts.collisions
    assert (found.a, found.b, found.force) == ("tea", "shelf", HELD_PRESS + 0.1)


def test_a_heavy_held_item_may_stand_on_one_corner() -> None:
    allowed, contacts = NOTHING.also(frozenset({"shelf"})), log()
    for force, weight, n in ((HELD_PRESS, 10.0, 0), (80.0, 80.0, 0), (80.1, 80.0, 1)):
        contacts.update([replace(point(a="tea", link=""), force=force)], allowed, "tea", 0.0, weight)
        assert len(contacts.collisions) == n


def test_what_goes_on_after_a_time_is_told_since_then() -> None:
    contacts = log()
    contacts.update([point(b="gone"), point(b="goes on")], NOTHING, None, 0.0)
    contacts.update([replace(point(b="goes on"), force=70.0)], NOTHING, None, 0.05)
    assert [(c.b, c.force) for c in contacts.since(0.02)] == [("goes on", 70.0)]


def test_links_of_the_robot_that_meet_are_named() -> None:
    contacts = log()
    contacts.update([point(link="cup", b="robot", link_b="support")], NOTHING, None, 0.0)
    assert [(c.a, c.b) for c in contacts.collisions] == [("cup", "support")]


def test_exempt_pairs_and_the_grip_itself_never_count() -> None:
    contacts = log()
    contacts.update([point(link="carriage", b="rail"), point(b="tea")], NOTHING, "tea", 0.0)
    assert not contacts.collisions


def push_forward(world: World, distance: float) -> None:
    q = world.q.copy()
    for _ in range(round(distance / 1e-4)):
        q = q + 1e-4 * (np.arange(8) == 0)
        world.command(q)
        world.step()


def test_running_into_an_item_is_a_collision_unless_it_is_planned(build_world: BuildWorld) -> None:
    for planned in (True, False):
        world = build_world(cube(side=0.08), gap=0.01, tool_state=STRAIGHT)
        if not planned:
            world.planned = NOTHING
        push_forward(world, 0.015)
        found = world.contacts.collisions
        assert [(c.a, c.b) for c in found] == ([] if planned else [("cup", "cube")])
        if found:
            assert 0.0 <= found[0].depth < 5e-3
            assert np.allclose(found[0].position, world.tip[:3, 3], atol=0.03)


def test_what_the_cup_did_not_seal_on_is_met_as_planned_while_the_plan_has_it_held(
    build_world: BuildWorld,
) -> None:
    world = build_world(cube(side=0.08), gap=0.01, tool_state=STRAIGHT)
    world.planned = PlannedContacts(met=frozenset({"cube"}), held=frozenset({"cube"}))
    push_forward(world, 0.015)
    assert world.held is None and world.contacts.collisions == ()


def test_a_held_item_set_down_on_what_it_may_touch_is_none_until_it_is_driven_in(holding: World) -> None:
    x, y, z = holding.engine.pose("cube")[:3, 3]
    table = box("table", (x - 0.1, y - 0.1, z - 0.13), (x + 0.1, y + 0.1, z - 0.03))
    holding.engine.add_static(table, np.eye(4), (1.0, 1.0, 1.0, 1.0))
    holding.planned = NOTHING.also(frozenset({"table"}))
    n_before = len(holding.contacts.collisions)
    q = holding.q.copy()
    found = []
    for _ in range(100):  # the cup points down: the arm lowers it by its elbow
        q[2] += 2e-4
        holding.command(q)
        holding.step()
        forces = [point.force for point in holding.engine.contact_points("cube") if point.b == "table"]
        found.append((max(forces, default=0.0), len(holding.contacts.collisions) - n_before))
    assert any(0.0 < force < HELD_PRESS and n == 0 for force, n in found)
    assert max(force for force, _ in found) > HELD_PRESS
    assert ("cube", "table") in {(c.a, c.b) for c in holding.contacts.collisions[n_before:]}


def test_a_held_item_that_hits_something_is_a_collision(holding: World) -> None:
    x, y, z = holding.engine.pose("cube")[:3, 3]
    wall = box("wall", (x + 0.03, y - 0.1, z - 0.1), (x + 0.05, y + 0.1, z + 0.01))
    holding.engine.add_static(wall, np.eye(4), (1.0, 1.0, 1.0, 1.0))
    n_before = len(holding.contacts.collisions)
    push_forward(holding, 0.02)
    first = holding.contacts.collisions[n_before]
    assert (first.a, first.b) == ("cube", "wall")


def test_what_may_be_pushed_may_be_met_by_item_and_cup_and_by_no_other_link() -> None:
    lift = Segment(SegmentKind.LIFT, 0.0, 1.0, STRAIGHT, "cube", (), ("book",))
    plan = Plan("", "", "", 0, (lift,), Trajectory(("a",), *np.zeros((4, 2, 1))), ())
    planned = PlannedContacts.of(plan, (lift,), load_cell("apc2016_delft").robot.tool)

    def met(*points: ContactPoint) -> list[tuple[str, str]]:
        contacts = log()
        contacts.update(points, planned, "cube", 0.0)
        return [(collision.a, collision.b) for collision in contacts.collisions]

    assert met(point(link="cup", b="book"), point("cube", "", "book")) == []
    assert met(point(link="lance", b="book")) == [("lance", "book")]
