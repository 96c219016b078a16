"""Poses of the tool at a level push that moves an item off what it lies on."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from pickcli.cartesian.line import shifted
from pickcli.cell.place import Place
from pickcli.geometry import pose
from pickcli.planning.toppling_poses import (
    ABOVE_RIM,
    ASIDE,
    BENDS,
    BESIDE,
    DOWN,
    PushPoses,
    height_of_rim,
    tool_turns,
)
from pickcli.scene.scene import Scene
from pickcli.statics.sliding import Slide

MOST_PUSH = 0.145  # m of the way of the tool; the verifier allows 0.15
# m below the top of the item, at which the rigid part of the cup pushes: the lower the firmer, but the lance,
# which is thicker than the cup, stays above the item
ENGAGED = (0.012, 0.006, 0.002)
SLANT = 0.004  # m over that at which the item is still met, no further on than that
LIFTED = 0.002  # m over the middle of the item, at which the rigid part of the cup meets it at the lowest


def poses_behind(scene: Scene, place: Place, push: Slide) -> Iterator[PushPoses]:
    """Find poses of a push along a level line, behind an item.

    Args:
        scene: The scene.
        place: The box.
        push: The push.

    Yields:
        The poses, through the middle of the item first; none if it is too low or too slanted for the cup.
    """
    grip, clearance = scene.cell.robot.tool.grip, scene.cell.clearance
    lowest = float(push.centre[2]) + LIFTED
    for share, engaged in product(ASIDE, ENGAGED):
        aside = share * push.width
        rigid = push.top_at(aside) - push.bound - engaged - BENDS
        if not rigid >= lowest:
            continue
        height = rigid - grip.gives_way
        met, higher = push.near_side(aside, rigid), push.near_side(aside, rigid + SLANT)
        if not higher - met <= SLANT:  # the tool would pass over it
            continue
        sides = (aside - grip.tip_radius, aside, aside + grip.tip_radius)
        nearest = min(push.near_side(y, z) for y, z in product(sides, (height, rigid, rigid + SLANT)))
        begin = nearest - grip.tip_radius - clearance - push.bound - BESIDE
        length = met - grip.tip_radius + push.way - begin
        if length > MOST_PUSH:
            continue
        start = push.centre + begin * push.direction + aside * push.across
        up = np.array([0.0, 0.0, max(height_of_rim(scene, place), height) + ABOVE_RIM - height])
        for R in tool_turns(DOWN):
            first = pose((start[0], start[1], height), R=R)
            end = shifted(first, length * push.direction)
            yield PushPoses(shifted(first, up), first, (end,), (shifted(end, up),))
