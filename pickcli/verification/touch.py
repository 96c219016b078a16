"""Planned contact is a touch: cup and held item may not go deeper into what stands firm, nor the cup into
anything, than uncertain poses and the bellows explain. Movable neighbours may be pushed aside by the item.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pickcli.cell.scene import Scene
from pickcli.errors import Reason
from pickcli.motion.plan import Plan
from pickcli.verification.contacts import exemptions
from pickcli.verification.parts import Fixture, Part
from pickcli.verification.standing import Standing
from pickcli.verification.states import MAX_STEP, States

ROUNDING = 0.001  # m


def check_touch(
    plan: Plan, scene: Scene, states: States, moving: Sequence[tuple[Part, ...]], world: Standing
) -> tuple[Reason, ...]:
    """The depth of every planned contact at every state of its segment."""
    reasons: list[Reason] = []
    items = {placed.id for placed in scene.items}
    for k, segment in enumerate(plan.segments):
        touching = exemptions(plan, scene, k).touching
        if not touching:
            continue
        tool = [p for p in moving[k] if p.is_cup or p.is_held]
        first, last = states.between(segment.t_start, segment.t_end)
        for fixture in world.of(k):
            if fixture.name not in touching:
                continue
            for part in tool:
                if part.is_held and fixture.name in items:
                    continue
                where = f"segment {k} ({segment.kind})"
                reasons += _too_deep(scene, states, part, fixture, range(first, last + 1), where)
    return tuple(reasons)


def _too_deep(
    scene: Scene, states: States, part: Part, fixture: Fixture, at: range, where: str
) -> Iterator[Reason]:
    """At most one reason: the deepest state."""
    allowed = scene.cell.robot.tool.cup_stroke + ROUNDING + MAX_STEP / 2
    # Shapes of items are grown by their uncertainty already, so that much more depth says nothing.
    allowed += sum(_grown(scene, name) for name in (part.name, fixture.name))
    depths = []
    for i in at:
        part.solid.place(states.links[part.link, i] @ part.T_link_shape)
        depths.append(part.solid.depth(fixture.solid))
    if at.start == 0:  # where the motion begins the arm stands already: it may go out, not in
        allowed = max(allowed, depths[0] + ROUNDING)
    deepest = max(depths)
    if deepest > allowed:
        t = states.times[at[depths.index(deepest)]]
        depth = f"{deepest * 1e3:.1f} mm deep, {allowed * 1e3:.1f} explained"
        yield Reason(
            "planned contact too deep", where, f"{part.name} and {fixture.name} at {t:.3f} s, {depth}"
        )


def _grown(scene: Scene, name: str) -> float:
    """How much a solid of that name was grown, twice: what the pose may be off lies on either side."""
    found = [placed.item for placed in scene.items if placed.id == name]
    return 2 * scene.noise.bound(found[0]) if found else 0.0
