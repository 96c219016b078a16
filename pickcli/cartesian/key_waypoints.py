"""Key waypoints up to contact; those after it follow a corridor.

Sources: Delft, section 2.1 (Approach, Contact, Lift, Retreat); KTH, Fig. 5 (the pre-approach runs along the
reversed x axis of the entry frame).
"""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.cartesian.line import shifted
from pickcli.geometry import Array

PREAPPROACH_DISTANCE = 0.06  # m between the tip and the mouth plane at the end of the coarse motion
CONTACT_DISTANCE = 0.012  # m of slow motion before the cup can meet the item


@dataclass(frozen=True, eq=False)
class PickPoses:
    """Tool poses in the world, in their order.

    Attributes:
        preapproach: (4, 4) in front of the mouth, at the end of the coarse motion.
        approach: (4, 4) in front of the surface of the item.
        touch: (4, 4) at the start of the slow contact motion.
        contact: (4, 4) with the cup pressed on by the overtravel.
    """

    preapproach: Array
    approach: Array
    touch: Array
    contact: Array


def pick_poses(
    T_world_entry: Array, T_world_item: Array, T_item_tip: Array, offset: float, overtravel: float,
    slow: float = CONTACT_DISTANCE,
) -> PickPoses:  # fmt: skip
    """Compute the tool poses up to contact.

    Args:
        T_world_entry: (4, 4) entry frame of the place, x pointing inwards.
        T_world_item: (4, 4) pose of the item.
        T_item_tip: (4, 4) tool frame in the item's, the tip on the surface.
        offset: m of approach along the tool axis.
        overtravel: m by which the cup is pressed beyond the surface, so that it meets an item that is farther
            away than its pose states.
        slow: m of slow motion before the cup can meet the item; 0 for fingers, which meet it at rest.

    Returns:
        The poses.
    """
    surface = T_world_item @ T_item_tip
    axis = surface[:3, 2]
    approach = shifted(surface, -offset * axis)
    inwards = T_world_entry[:3, 0]
    depth = float((approach[:3, 3] - T_world_entry[:3, 3]) @ inwards)
    preapproach = shifted(approach, -max(0.0, depth + PREAPPROACH_DISTANCE) * inwards)
    touch = shifted(surface, -min(offset, overtravel + slow) * axis)
    return PickPoses(preapproach, approach, touch, shifted(surface, overtravel * axis))
