"""Check that planned contact is no deeper than pose errors and bellows explain: an upper bound per pair.

Depth is measured on the solids at their perceived poses, not enlarged. Two items overlap by at most the sum
of their pose errors. While it is taken out, the item may not go deeper into a neighbour than at rest, except
for the effect of an angular pose error; a neighbour that it does not touch at rest it may meet, and not
enter. The same holds in reverse when it is set down.

The bellows give way only along the axis of the cup: a cup pressed in by its whole stroke must be clear of
what it touches, except for the pose error of that; and in a motion that is not along that axis the cup goes
no deeper than at rest.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pickcli.errors import Reason
from pickcli.geometry import Array, pose
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import Scene
from pickcli.scene.solid_overlap import TOUCH
from pickcli.verification.contact_exemptions import ends_at_rest
from pickcli.verification.exemptions import Exemptions
from pickcli.verification.forward_kinematics import T_lance_last
from pickcli.verification.moving_parts import Fixture, Part, TestedPairs
from pickcli.verification.pile_statics import removal
from pickcli.verification.solid_arrays import SolidArrays
from pickcli.verification.state_sampling import States
from pickcli.verification.static_solids import PlanFixtures
from pickcli.verification.straightness_check import FIRST_LIFT

DEPTH_TOLERANCE = 0.0015  # m: lines are followed only approximately, and depths are upper bounds
PUSH_TOLERANCE = 0.001  # m that the item may come nearer to an item that rolls if pushed: deviation of lines
TOUCHING_DEPTH = 1e-4  # m that solids which just touch may measure


def check_touch(
    plan: Plan, scene: Scene, states: States, moving: Sequence[tuple[Part, ...]], world: PlanFixtures,
    exempt: Sequence[Exemptions],
) -> tuple[Reason, ...]:  # fmt: skip
    """Check the depth of every planned contact at every state of its segment.

    Args:
        plan: The plan.
        scene: The plan's scene.
        states: The motion's states.
        moving: Parts that move in each segment.
        world: Static solids of each segment.
        exempt: Exemptions of each segment.

    Returns:
        The faults.
    """
    reasons: list[Reason] = []
    takes = any(segment.kind is SegmentKind.CONTACT for segment in plan.segments)
    rolling = (
        removal(scene, scene.find(plan.grasp.item).id).rolling if plan.grasp is not None and takes else ()
    )
    for k, segment in enumerate(plan.segments):
        if not exempt[k].touching:
            continue
        first, last = states.between(segment.t_start, segment.t_end)
        at_rest = last if ends_at_rest(plan, k) else first
        for fixture in world.of(k):
            if fixture.name not in exempt[k].touching:
                continue
            for part in moving[k]:
                if part.against is TestedPairs.ROBOT:
                    continue
                if part.is_cup or (part.is_held and fixture.name not in exempt[k].pushed):
                    pair = _Pair(scene, segment, k, part, fixture, states)
                    reasons += pair.too_deep(range(first, last + 1), at_rest)
                    if part.is_held and fixture.name in rolling and segment.kind is SegmentKind.LIFT:
                        reasons += pair.pushed(range(first, last + 1))
    return tuple(reasons)


class _Pair:
    """A part of the tool, or the held item, and a fixture that it may touch in one segment."""

    def __init__(
        self, scene: Scene, segment: Segment, k: int, part: Part, fixture: Fixture, states: States
    ) -> None:
        self.scene, self.segment, self.k, self.states = scene, segment, k, states
        self.part, self.fixture = part, fixture

    def too_deep(self, at: range, at_rest: int) -> Iterator[Reason]:
        """Yield a fault if the deepest state is too deep. at_rest: state at which the touched solid rests."""
        if self.part.is_held:
            yield from self._deeper(self.part, at, self._explained(self._gap(at_rest)))
            return
        stands = self._depth(self.part, at_rest)
        off = self._uncertain(self.fixture.name)
        if self.segment.kind is not SegmentKind.CONTACT:  # that moves along the axis of the cup
            yield from self._deeper(self.part, at, max(stands, off) + DEPTH_TOLERANCE)
        pressed = self._pressed_in()
        stands = self._depth(pressed, at_rest) if self.k == 0 else 0.0  # the cup may start in contact
        yield from self._deeper(pressed, at, max(stands, off) + DEPTH_TOLERANCE)

    def pushed(self, at: range) -> Iterator[Reason]:
        """Yield a fault if the item comes nearer to the fixture than in the first state."""
        gaps = [self._gap(i) for i in at]
        if min(gaps) < gaps[0] - PUSH_TOLERANCE:
            t = self.states.times[at[gaps.index(min(gaps))]]
            by = f"{(gaps[0] - min(gaps)) * 1e3:.1f} mm nearer at {t:.3f} s, it rolls away"
            where = f"segment {self.k} ({self.segment.kind})"
            yield Reason("pushes what rolls", where, f"{self.part.name} comes to {self.fixture.name}, {by}")

    def _deeper(self, part: Part, at: range, allowed: float) -> Iterator[Reason]:
        """Yield a fault if the deepest state is deeper than allowed, m."""
        depths = self._depths(part, at)
        deepest = float(depths.max())
        if deepest > allowed:
            t = self.states.times[at[int(np.argmax(depths))]]
            depth = f"{deepest * 1e3:.1f} mm deep, {allowed * 1e3:.1f} explained"
            where = f"segment {self.k} ({self.segment.kind})"
            detail = f"{self.part.name} and {self.fixture.name} at {t:.3f} s, {depth}"
            yield Reason("planned contact too deep", where, detail)

    def _explained(self, gap: float) -> float:
        """Return the allowed depth (m) of the held item in a fixture. gap: m at rest, below 0 in overlap."""
        explained = TOUCH + self._uncertain(self.part.name) + self._uncertain(self.fixture.name)
        angle = self.scene.noise_of(self.scene.instance(self.part.name)).angle
        return max(TOUCHING_DEPTH, min(explained, angle * FIRST_LIFT - gap) + DEPTH_TOLERANCE)

    def _gap(self, i: int) -> float:
        """Return the gap (m) at state i, negative if they overlap."""
        depth = self._depth(self.part, i)
        return -depth if depth > 0.0 else self.part.solid.distance(self.fixture.solid)

    def _depths(self, part: Part, at: range) -> Array:
        """Return depths (m) at the states; fcl measures only states without a gap."""
        i = np.arange(at.start, at.stop)
        one, other = np.zeros_like(i), np.ones_like(i)
        solids = SolidArrays.of((replace(part, slack=0.0), replace(self.fixture, slack=0.0)))
        is_apart = solids.gaps(self.states, one, other, i) > 0.0
        return np.array([0.0 if is_apart[k - at.start] else self._depth(part, k) for k in at])

    def _depth(self, part: Part, i: int) -> float:
        at: Array = self.states.links[part.link, i] @ part.T_link_shape
        part.solid.place(at)
        return part.solid.depth(self.fixture.solid)

    def _pressed_in(self) -> Part:
        """Return the cup with the whole stroke of its bellows pressed in."""
        robot = self.scene.cell.robot
        T_lance_tip = T_lance_last(robot, self.segment.tool_state) @ robot.tool.T_last_tip
        back = pose(-robot.tool.grip.gives_way * T_lance_tip[:3, 2])
        return replace(self.part, T_link_shape=back @ self.part.T_link_shape)

    def _uncertain(self, name: str) -> float:
        """Return an upper bound of the distance (m) of any point of a solid from its nominal position."""
        if (name == self.part.name and self.part.is_held) or any(p.id == name for p in self.scene.items):
            return self.scene.bound(self.scene.instance(name))
        return next(
            (
                carrier.uncertainty(body)
                for carrier in self.scene.posed_carriers
                for body in carrier.grown
                if body.name == name
            ),
            0.0,
        )
