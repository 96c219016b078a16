"""Planned contact is a touch, and no deeper than poses and bellows explain: an upper bound per pair.

Measured on the solids as they are perceived, not grown. Two items lie in each other, as their poses say, at
most as deep as both may be off; taken out, the item may go no deeper into a neighbour than it lies, but for
what a pose that is off in angle leads astray. The bellows give along the axis of the cup only: one that is
pressed in by its whole stroke must be clear of what it touches, but for what the pose of that may be off.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pickcli.cell.overlap import TOUCH
from pickcli.cell.scene import Scene
from pickcli.errors import Reason
from pickcli.geometry import Array, pose
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment
from pickcli.verification.arm import T_lance_cup, pivot_angle
from pickcli.verification.contacts import exemptions
from pickcli.verification.lines import FIRST_LIFT
from pickcli.verification.parts import Fixture, Part
from pickcli.verification.standing import Standing
from pickcli.verification.states import States

ROUNDING = 0.0015  # m: lines are followed only nearly, and depths are bounds from above


def check_touch(
    plan: Plan, scene: Scene, states: States, moving: Sequence[tuple[Part, ...]], world: Standing
) -> tuple[Reason, ...]:
    """The depth of every planned contact at every state of its segment."""
    reasons: list[Reason] = []
    for k, segment in enumerate(plan.segments):
        touching = exemptions(plan, scene, k).touching
        if not touching:
            continue
        first, last = states.between(segment.t_start, segment.t_end)
        for fixture in world.of(k):
            if fixture.name not in touching:
                continue
            for part in moving[k]:
                if part.is_cup or part.is_held:
                    of = _Pair(scene, segment, k, _compressed(scene, segment, part), fixture)
                    reasons += of.too_deep(states, range(first, last + 1))
    return tuple(reasons)


def _compressed(scene: Scene, segment: Segment, part: Part) -> Part:
    """The held item as it is; the cup pressed in by the whole stroke of its bellows."""
    if part.is_held:
        return part
    robot = scene.cell.robot
    T_lance_tip = T_lance_cup(robot, pivot_angle(robot, segment.pivot)) @ robot.tool.T_cup_tip
    back = pose(-robot.tool.cup_stroke * T_lance_tip[:3, 2])
    return replace(part, T_link_shape=back @ part.T_link_shape)


class _Pair:
    """One part of the tool and what it may touch in one segment."""

    def __init__(self, scene: Scene, segment: Segment, k: int, part: Part, fixture: Fixture) -> None:
        self.scene, self.segment, self.k, self.part, self.fixture = scene, segment, k, part, fixture

    def too_deep(self, states: States, at: range) -> Iterator[Reason]:
        """At most one reason: the deepest state."""
        depths = [self._depth(states, i) for i in at]
        allowed = self._allowed(depths)
        deepest = max(depths)
        if deepest > allowed:
            t = states.times[at[depths.index(deepest)]]
            depth = f"{deepest * 1e3:.1f} mm deep, {allowed * 1e3:.1f} explained"
            where = f"segment {self.k} ({self.segment.kind})"
            detail = f"{self.part.name} and {self.fixture.name} at {t:.3f} s, {depth}"
            yield Reason("planned contact too deep", where, detail)

    def _depth(self, states: States, i: int) -> float:
        part: Array = states.links[self.part.link, i] @ self.part.T_link_shape
        self.part.solid.place(part)
        return self.part.solid.depth(self.fixture.solid)

    def _allowed(self, depths: Sequence[float]) -> float:
        """m, from the depths in the order of the segment's states."""
        if self.part.is_cup:
            stands = depths[0] if self.k == 0 else 0.0  # where the arm stands already it may go out, not in
            return max(stands, self._uncertain(self.fixture.name)) + ROUNDING
        explained = TOUCH + self._uncertain(self.part.name) + self._uncertain(self.fixture.name)
        # The item rests where it is taken, or where it is let go; nothing is touched at the other end.
        at_rest = max(depths[0], depths[-1])
        return min(explained, at_rest + self.scene.noise.angle * FIRST_LIFT) + ROUNDING

    def _uncertain(self, name: str) -> float:
        """m that any point of a solid may be from where its pose says."""
        found = [placed.item for placed in self.scene.items if placed.id == name]
        if found:
            return self.scene.noise.bound(found[0])
        for body in self.scene.pod_bodies:
            if body.name == name:
                reach = np.linalg.norm(body.T_parent_shape[:2, 3]) + np.linalg.norm(body.shape.extents) / 2
                return self.scene.pod_error.bound(float(reach))
        return 0.0
