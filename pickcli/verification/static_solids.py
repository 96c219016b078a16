"""Solids that stand in each segment: an item that is set down in a bin stands there from then on."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.item import Item
from pickcli.geometry import Array, inverse, rotation_angle
from pickcli.motion.plan import Plan
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.verification.contact_exemptions import releases
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.moving_parts import Fixture, fixtures

SAME_PLACE = 0.005  # m, beyond twice what poses may be off, up to which what is seen is what the cup holds


@dataclass(frozen=True, eq=False)
class PlanFixtures:
    """The fixtures of a plan's segments.

    Attributes:
        plan: The plan.
        before: What stands before the release.
        set_down: What stands after the release, if that is in a bin; else the item falls into the tote and is
            not followed.
        cloud: What stands in all segments: points of the scene's cloud.
    """

    plan: Plan
    before: tuple[Fixture, ...]
    set_down: tuple[Fixture, ...] | None
    cloud: tuple[Fixture, ...] = ()

    def of(self, k: int) -> tuple[Fixture, ...]:
        """All that stands during a segment, without what is in the cup or fell into the tote.

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
    """The fixtures of every segment.

    Args:
        plan: The plan.
        scene: The plan's scene.
        T_tip_item: (4, 4) the item in the tool frame where one is held.

    Returns:
        The fixtures.
    """
    before = _not_in_the_cup(plan, scene, fixtures(scene))
    ends = releases(plan)
    if not ends or plan.grasp is None or T_tip_item is None:
        return PlanFixtures(plan, before, None)
    T = release_pose(plan, scene, ends[0], T_tip_item)
    where = bin_at(scene, T)
    if where is None:
        return PlanFixtures(plan, before, None)
    name = plan.grasp.item
    placed = PlacedItem(name, scene.item(name), where, T)
    return PlanFixtures(plan, before, fixtures(replace(scene, items=(*scene.without(name).items, placed))))


def _not_in_the_cup(plan: Plan, scene: Scene, found: tuple[Fixture, ...]) -> tuple[Fixture, ...]:
    """What stands when the plan begins: what is seen elsewhere than in the cup stands where it is seen."""
    held = scene.held
    if held is None or plan.segments[0].held != held.id:
        return found
    robot, q = scene.cell.robot, plan.trajectory.sample(0.0)
    T = tip_poses(robot, link_poses(robot, q), plan.segments[0].tool_state)[0] @ held.T_tip_item
    most = SAME_PLACE + 2.0 * scene.noise.bound(held.item)
    return tuple(
        replace(fixture, name=f"{held.id} as seen") if fixture.name == held.id else fixture
        for fixture in found
        if fixture.name != held.id or _apart(fixture.T_world_shape, T, held.item) > most
    )


def _apart(T_a: Array, T_b: Array, item: Item) -> float:
    """m, no point of an item at two poses is farther apart."""
    off = inverse(T_a) @ T_b
    radius = float(np.linalg.norm(item.shape.extents)) / 2
    return float(np.linalg.norm(off[:3, 3])) + rotation_angle(off[:3, :3]) * radius


def release_pose(plan: Plan, scene: Scene, k: int, T_tip_item: Array) -> Array:
    """Pose of the item at the end of a segment, where it is let go.

    Args:
        plan: The plan.
        scene: The plan's scene.
        k: Index of the segment.
        T_tip_item: (4, 4) the item in the tool frame.

    Returns:
        (4, 4) in the world.
    """
    robot, segment = scene.cell.robot, plan.segments[k]
    q = plan.trajectory.sample(segment.t_end)
    return np.asarray(tip_poses(robot, link_poses(robot, q), segment.tool_state)[0] @ T_tip_item)


def bin_at(scene: Scene, T_world_item: Array) -> str | None:
    """The bin that an item's centre is in.

    Args:
        scene: The scene.
        T_world_item: (4, 4) pose of the item.

    Returns:
        Name of the bin, or None.
    """
    for name, place in scene.cell.pod.bins.items():
        if place.holds((inverse(scene.T_world_place(place)) @ T_world_item)[:3, 3]):
            return name
    return None
