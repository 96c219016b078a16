"""Static solids of each segment: an item that is set down in a place stands there from then on."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.geometry import Array, inverse, rotation_angle
from pickcli.motion.plan import Plan
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.verification.contact_exemptions import releases
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.moving_parts import Fixture, around_hollow, fixtures
from pickcli.verification.quintic import positions_at

# m, besides twice the pose errors, within which a perceived item counts as the held one
HELD_ITEM_DISTANCE = 0.005


@dataclass(frozen=True, eq=False)
class PlanFixtures:
    """The fixtures of a plan's segments.

    Attributes:
        plan: The plan.
        before: Static solids before the release.
        set_down: Static solids after the release, if the item is set down; None if it falls between walls,
            where it is not followed.
        cloud: Points of the scene's cloud, static in all segments.
    """

    plan: Plan
    before: tuple[Fixture, ...]
    set_down: tuple[Fixture, ...] | None
    cloud: tuple[Fixture, ...] = ()

    def of(self, k: int) -> tuple[Fixture, ...]:
        """Return the static solids of a segment, without items that are held or fell between walls.

        Args:
            k: Index of the segment.

        Returns:
            The fixtures.
        """
        if self.set_down is not None and k > releases(self.plan)[0]:
            return self.set_down + self.cloud
        gone = {segment.held for segment in self.plan.segments[: k + 1]}
        return tuple(fixture for fixture in self.before if fixture.name not in gone) + self.cloud


def plan_fixtures(plan: Plan, scene: Scene, T_tip_item: Array | None) -> PlanFixtures:
    """Compute the fixtures of every segment.

    Args:
        plan: The plan.
        scene: The plan's scene.
        T_tip_item: (4, 4) pose of the item in the tool frame, if one is held.

    Returns:
        The fixtures.
    """
    before = around_hollow(_not_in_the_cup(plan, scene, fixtures(scene)), plan, scene)
    ends = releases(plan)
    if not ends or plan.grasp is None or T_tip_item is None:
        return PlanFixtures(plan, before, None)
    T = release_pose(plan, scene, ends[0], T_tip_item)
    place = place_at(scene, T)
    if place is None or place.is_open_box:
        return PlanFixtures(plan, before, None)
    name = plan.grasp.item
    taken = scene.instance(name)
    placed = PlacedItem(name, taken.item, place.name, T, taken.noise)
    there = fixtures(replace(scene, items=(*scene.without(name).items, placed)))
    return PlanFixtures(plan, before, around_hollow(there, plan, scene))


def _not_in_the_cup(plan: Plan, scene: Scene, found: tuple[Fixture, ...]) -> tuple[Fixture, ...]:
    """Return the fixtures at the start; the held item is one, too, if it is perceived away from the cup."""
    held = scene.held
    if held is None or plan.segments[0].held != held.id:
        return found
    robot, q = scene.cell.robot, positions_at(plan.trajectory, 0.0)
    T = tip_poses(robot, link_poses(robot, q), plan.segments[0].tool_state)[0] @ held.T_tip_item
    most = HELD_ITEM_DISTANCE + 2.0 * scene.bound(held)
    return tuple(
        replace(fixture, name=f"{held.id} as seen") if fixture.name == held.id else fixture
        for fixture in found
        if fixture.name != held.id or _apart(fixture.T_world_shape, T, held.item) > most
    )


def _apart(T_a: Array, T_b: Array, item: Item) -> float:
    """Bound the distance in m between the same point of an item at two poses."""
    off = inverse(T_a) @ T_b
    radius = float(np.linalg.norm(item.shape.extents)) / 2
    return float(np.linalg.norm(off[:3, 3])) + rotation_angle(off[:3, :3]) * radius


def release_pose(plan: Plan, scene: Scene, k: int, T_tip_item: Array) -> Array:
    """Return the pose of the item at the end of a segment, at which it is released.

    Args:
        plan: The plan.
        scene: The plan's scene.
        k: Index of the segment.
        T_tip_item: (4, 4) pose of the item in the tool frame.

    Returns:
        (4, 4) in the world.
    """
    robot, segment = scene.cell.robot, plan.segments[k]
    q = positions_at(plan.trajectory, segment.t_end)
    return np.asarray(tip_poses(robot, link_poses(robot, q), segment.tool_state)[0] @ T_tip_item)


def place_at(scene: Scene, T_world_item: Array) -> Place | None:
    """Find the place that an item is released in.

    Args:
        scene: The scene.
        T_world_item: (4, 4) pose of the item.

    Returns:
        The place open to the front whose room contains the item's centre; else, of the places open above,
        the highest one below its centre, or the one nearest to it horizontally. None if the cell has none.
    """
    places = scene.cell.places.values()
    at = {place.name: (inverse(scene.T_world_place(place)) @ T_world_item)[:3, 3] for place in places}
    for place in places:
        if not place.access.is_from_above and place.holds(at[place.name]):
            return place
    open_above = [place for place in places if place.access.is_from_above]
    return min(open_above, key=lambda place: _beside(place, at[place.name]), default=None)


def _beside(place: Place, p: Array) -> tuple[float, float]:
    """Return how far a point (3,) in the frame of a place is beside its room, and over its floor, m."""
    low, high = place.room.low[:2], place.room.high[:2]
    beside = float(np.linalg.norm(np.maximum(np.maximum(low - p[:2], p[:2] - high), 0.0)))
    over = float(p[2]) - place.room.floor_back
    return beside, over if over > 0.0 else np.inf
