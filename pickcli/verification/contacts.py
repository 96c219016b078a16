"""Which pairs are not tested, and why; every other pair is."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.cell.robot import Robot
from pickcli.cell.scene import Scene
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.verification.parts import Part

MAY_TOUCH = (SegmentKind.CONTACT, SegmentKind.LIFT)


def may_touch(plan: Plan, k: int) -> bool:
    """Whether segment k may have planned contacts at all.

    Beside contact and lift, a plan may begin with a depart, empty, from where the cup touches something:
    the way to safety after a motion that was stopped.
    """
    segment = plan.segments[k]
    is_way_out = k == 0 and segment.kind is SegmentKind.DEPART and segment.held is None
    return is_way_out or segment.kind in MAY_TOUCH


@dataclass(frozen=True)
class Exemptions:
    """What one segment does not test.

    absent: items that have left their place: in the cup, or released before (the item that falls into
    the tote is not followed). touching: names that cup and held item are planned to touch here.
    """

    absent: frozenset[str]
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
    gone = {s.held for s in plan.segments[: k + 1] if s.held is not None}
    return Exemptions(
        absent=frozenset(gone),
        touching=frozenset(segment.touching) if may_touch(plan, k) else frozenset(),
        neighbours=_neighbours(scene.cell.robot),
        allowed=frozenset(frozenset((p.a, p.b)) for p in scene.cell.allowed_pairs),
    )


def _neighbours(robot: Robot) -> frozenset[frozenset[str]]:
    return frozenset(frozenset((joint.parent, joint.child)) for joint in robot.joints)
