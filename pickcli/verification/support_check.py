"""Check that no item is taken away that others rest or lean on, by the statics of the remaining items.

Nor one that touches what nobody recognised: of that nothing is known but where some of it is.
"""

from __future__ import annotations

from pickcli.errors import Reason
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_overlap import TOUCH
from pickcli.verification.pile_statics import may_leave, removal
from pickcli.verification.push_check import pushed_by
from pickcli.verification.separation import separation

HEAVIEST_SLUMP = 0.6  # kg: what is heavier, and falls on one end of another item, may throw that out


def check_support(plan: Plan, scene: Scene) -> tuple[Reason, ...]:
    """Check that no item is taken away that others rest or lean on.

    In a box that is open above, items that lose their support slump. That is allowed, unless they would be
    lifted along, are so high that they could fall over the rim, or so heavy that they could throw others out.
    Items that the plan may push aside may lie on the taken one, if ``check_push`` accepts that.

    Args:
        plan: The plan.
        scene: The plan's scene.

    Returns:
        One fault for every item that would be lifted, fall or roll away, and one if something touches the
        taken item that nobody recognised; () for a plan that takes nothing.
    """
    if plan.grasp is None or all(segment.kind is not SegmentKind.CONTACT for segment in plan.segments):
        return ()
    taken = scene.find(plan.grasp.item)
    effects = removal(scene, taken.id)
    slumping = {name for name in effects.falling if _stays_in(scene, scene.find(name))}
    return (
        *(_fault(taken.id, name, "lies on it") for name in sorted(effects.lifted - pushed_by(plan))),
        *(
            _fault(taken.id, name, "would fall or roll away")
            for name in sorted(effects.falling - effects.lifted - slumping)
        ),
        *_beside_unrecognised(scene, taken),
    )


def _beside_unrecognised(scene: Scene, taken: PlacedItem) -> tuple[Reason, ...]:
    """Return a fault if boxes in which something is that nobody recognised touch an item, or may."""
    shape, T = taken.item.shape, taken.T_world_item
    reach = TOUCH + scene.bound(taken)
    for body in scene.unrecognised_in(taken.location):
        if separation(shape, T, body.shape, body.T_parent_shape) <= reach:
            why = f"{body.name}: nobody recognised what is there, and it may rest or lean on it"
            return (Reason("takes away what others need", taken.id, why),)
    return ()


def _fault(taken: str, name: str, why: str) -> Reason:
    return Reason("takes away what others need", taken, f"{name} {why}", name)


def _stays_in(scene: Scene, placed: PlacedItem) -> bool:
    """Whether an item is in a box that is open above, is light, and cannot get over its rim by falling."""
    place = scene.cell.places.get(placed.location)
    if place is None or not place.is_open_box or placed.item.heaviest > HEAVIEST_SLUMP:
        return False
    return not may_leave(scene, place, placed)
