"""Which pairs are not tested, and why; every other pair is."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.cell.robot import Robot
from pickcli.cell.scene import Scene
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.verification.parts import Part


def releases(plan: Plan) -> tuple[int, ...]:
    """Indices of the segments at whose end the item is let go."""
    held = [segment.held is not None for segment in plan.segments]
    return tuple(k for k in range(len(held) - 1) if held[k] and not held[k + 1])


def may_touch(plan: Plan, k: int) -> bool:
    """Whether segment k may have planned contacts at all.

    The contact; the lift right after it, or at either end of a way out of a stop that goes on with that lift
    or back along it; the place just before the item is let go; and a depart, empty, from where the cup
    touches something: just after that, or at the beginning of a way out of a stop.
    """
    segment, is_way_out = plan.segments[k], plan.recovery is not None
    if segment.kind is SegmentKind.LIFT:
        is_at_an_end = k in (0, len(plan.segments) - 1)
        return (k > 0 and plan.segments[k - 1].kind is SegmentKind.CONTACT) or (is_way_out and is_at_an_end)
    if segment.kind is SegmentKind.PLACE:
        return k in releases(plan)
    if segment.kind is SegmentKind.DEPART:
        return segment.held is None and ((is_way_out and k == 0) or k - 1 in releases(plan))
    return segment.kind is SegmentKind.CONTACT


@dataclass(frozen=True)
class Exemptions:
    """What one segment does not test.

    touching: names that cup and held item are planned to touch here
    """

    touching: frozenset[str]
    neighbours: frozenset[frozenset[str]]  # links that a joint connects
    allowed: frozenset[frozenset[str]]  # the cell's list, each with its reason there

    def is_world_pair_untested(self, part: Part, name: str) -> bool:
        """Whether a part may touch a body or item of the world."""
        if part.is_cup or part.is_held:
            return name in self.touching
        return frozenset((part.name, name)) in self.allowed

    def is_own_pair_untested(self, a: Part, b: Part) -> bool:
        """Whether two parts of the arm, or of arm and held item, are left out."""
        if a.name == b.name:
            return True
        if a.is_held or b.is_held:
            return a.is_cup or b.is_cup
        names = frozenset((a.name, b.name))
        # Where no joint moves between two links their pose is the tool maker's business.
        is_rigid = not ((a.reach > 0.0) != (b.reach > 0.0)).any()
        return is_rigid or names in self.neighbours or names in self.allowed


def exemptions(plan: Plan, scene: Scene, k: int) -> Exemptions:
    """The exemptions of segment k."""
    segment = plan.segments[k]
    return Exemptions(
        touching=frozenset(segment.touching) if may_touch(plan, k) else frozenset(),
        neighbours=_neighbours(scene.cell.robot),
        allowed=frozenset(frozenset((p.a, p.b)) for p in scene.cell.allowed_pairs),
    )


def _neighbours(robot: Robot) -> frozenset[frozenset[str]]:
    return frozenset(frozenset((joint.parent, joint.child)) for joint in robot.joints)
