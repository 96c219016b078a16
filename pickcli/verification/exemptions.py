"""Pairs of solids that are exempt from the clearance check, with the reason; every other pair is tested."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pickcli.cell.robot import Robot
from pickcli.cell.tool import MOVING
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import Scene
from pickcli.verification.contact_exemptions import ends_at_rest, may_touch, releases
from pickcli.verification.moving_parts import Part, TestedPairs
from pickcli.verification.state_sampling import States
from pickcli.verification.static_solids import PlanFixtures


@dataclass(frozen=True)
class Exemptions:
    """Pairs that are not tested in one segment.

    Attributes:
        touching: Names that cup and held item are planned to touch here, if near them where the item is at
            rest.
        pinched: Id of the item that fingers close on or open from here, "" if none.
        neighbours: Pairs of links connected by a joint, directly or through links without a shape.
        allowed: The cell's allowed pairs, each with a reason in the cell file, without those that only
            planning leaves out.
        pushed: Ids of items that the held one may push aside here, or the empty cup.
        is_empty: Whether nothing is held.
    """

    touching: frozenset[str]
    pinched: str
    neighbours: frozenset[frozenset[str]]
    allowed: frozenset[frozenset[str]]
    pushed: frozenset[str] = frozenset()
    is_empty: bool = False

    def is_world_pair_untested(self, part: Part, name: str) -> bool:
        """Whether a part may touch a body or item of the world.

        Args:
            part: The part.
            name: Name of the body or item.

        Returns:
            True if it may.
        """
        if part.against is TestedPairs.ROBOT:
            return True
        if part.is_finger:
            return name == self.pinched
        if name in self.pushed and (part.is_cup if self.is_empty else part.is_held):
            return True
        if part.is_cup or part.is_held:
            return name in self.touching
        # Links that never move keep the distance to the world that cell and scene give them.
        return not part.reach.any() or frozenset((part.name, name)) in self.allowed

    def is_own_pair_untested(self, a: Part, b: Part) -> bool:
        """Whether two parts of the arm, or of arm and held item, are not tested.

        Args:
            a: One part.
            b: The other.

        Returns:
            True if they are.
        """
        if a.name == b.name:
            return True
        if TestedPairs.WORLD in (a.against, b.against):
            return True
        if a.is_held or b.is_held:
            return a.is_cup or b.is_cup or a.is_finger or b.is_finger
        names = frozenset((a.name, b.name))
        # If no joint moves between two links, their relative pose is fixed by the tool's design.
        return names in self.neighbours or names in self.allowed or _is_rigid(a, b)


def exemptions(
    plan: Plan, scene: Scene, states: States, moving: Sequence[tuple[Part, ...]], world: PlanFixtures
) -> tuple[Exemptions, ...]:
    """Compute the exemptions of every segment.

    Args:
        plan: The plan.
        scene: The plan's scene.
        states: The motion's states.
        moving: Parts that move in each segment.
        world: Static solids of each segment.

    Returns:
        One for each segment.
    """
    neighbours = _neighbours(scene.cell.robot)
    allowed = frozenset(frozenset((p.a, p.b)) for p in scene.cell.allowed_pairs if not p.verified)
    return tuple(
        Exemptions(
            _touching(plan, scene, states, moving, world, k), pinched(plan, k), neighbours, allowed,
            frozenset(segment.pushing), segment.held is None,
        )
        for k, segment in enumerate(plan.segments)
    )  # fmt: skip


def pinched(plan: Plan, k: int) -> str:
    """Return the item that gripper fingers may touch in a segment: the one they close on or open from.

    Args:
        plan: The plan.
        k: Index of the segment.

    Returns:
        Its id; "" in every segment in which the fingers do not move, or move while nothing is grasped.
    """
    segment = plan.segments[k]
    if plan.grasp is None or segment.tool_state != MOVING or plan.grasp.item not in segment.touching:
        return ""
    is_opening = segment.kind is SegmentKind.DEPART and k - 1 in releases(plan)
    return plan.grasp.item if is_opening or segment.kind is SegmentKind.CONTACT else ""


def _is_rigid(a: Part, b: Part) -> bool:
    """Whether no joint moves between two parts."""
    return bool(((a.reach > 0.0) == (b.reach > 0.0)).all())


def _neighbours(robot: Robot) -> frozenset[frozenset[str]]:
    """Return pairs of links with at most one moving joint, and no shape, between them."""
    shaped = {link.name for link in robot.links if link.bodies}
    by_child = {joint.child: joint for joint in robot.joints}
    found = set()
    for first in robot.joints:
        n_moving, joint = int(first.name in robot.joint_names), first
        while joint.parent not in shaped and joint.parent in by_child:
            joint = by_child[joint.parent]
            n_moving += joint.name in robot.joint_names
        if n_moving <= 1:
            found.add(frozenset((first.child, joint.parent)))
    return frozenset(found)


def _touching(
    plan: Plan, scene: Scene, states: States, moving: Sequence[tuple[Part, ...]], world: PlanFixtures, k: int
) -> frozenset[str]:
    """Return the names that segment k states as touched and that lie within the clearance at rest.

    The clearance is that of the item when it is taken or set down, or the empty cup at the start of a
    recovery motion.
    """
    segment = plan.segments[k]
    if not segment.touching or not may_touch(plan, k):
        return frozenset()
    first, last = states.between(segment.t_start, segment.t_end)
    i = last if ends_at_rest(plan, k) else first
    if segment.kind is SegmentKind.CONTACT:
        held_in = min(k + 1, len(plan.segments) - 1)
    else:
        held_in = k - 1 if segment.kind is SegmentKind.DEPART and k > 0 else k
    resting = [part for part in moving[held_in] if part.is_held and part.against is not TestedPairs.ROBOT]
    resting = resting or [part for part in moving[k] if part.is_cup]
    near = set()
    for fixture in world.of(k):
        if fixture.name in segment.touching:
            for part in resting:
                part.solid.place(states.links[part.link, i] @ part.T_link_shape)
                if part.solid.distance(fixture.solid) - part.slack - fixture.slack <= scene.cell.clearance:
                    near.add(fixture.name)
    for place in scene.cell.places.values():  # an item on a floor may touch all bodies of the floor
        if near & set(place.support):
            near |= set(place.support)
    return frozenset(near & set(segment.touching))
