"""Nothing is taken away that others rest on or lean on: by the support relation that is part of a scene."""

from __future__ import annotations

from pickcli.errors import Reason
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import Scene
from pickcli.scene.supports import supports_of


def check_support(plan: Plan, scene: Scene) -> tuple[Reason, ...]:
    """Check that nothing is taken away that others rest on or lean on.

    Args:
        plan: The plan.
        scene: The plan's scene.

    Returns:
        One fault for every item that would fall or roll away; () for a plan that takes nothing.
    """
    if plan.grasp is None or all(segment.kind is not SegmentKind.CONTACT for segment in plan.segments):
        return ()
    taken = plan.grasp.item
    return tuple(
        Reason("takes away what others need", taken, f"{name} would fall or roll away", name)
        for name in supports_of(scene).blocking(taken)
    )
