"""Where items are by their prints in looks from several places, solved together.

A print that two looks recognise at one place is there: no two do by chance. So its pose needs no depth, and
what the matches of all looks leave open bounds its error, where hardly any depth comes back, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from pickcli.cell.item import Item
from pickcli.geometry import Array, length, transform_points
from pickcli.perception.textures.joint_pose import JointPose, PrintSighting, joint_pose

_TOGETHER = 0.02  # m of the surface, up to which sightings of different looks are of one copy
_LEAST_COUNTED = 0.5  # of all matches, weighed by how well they agree with the pose


def joint_print_poses(
    item: Item, looks: Sequence[tuple[Array, Sequence[PrintSighting]]], apart: float
) -> list[JointPose]:
    """Solve for the poses of an item and its copies.

    Args:
        item: The item.
        looks: Of each look the pose (4, 4) of its camera in the world, and where it recognised the print.
        apart: m between cameras, from which on a look is a second opinion.

    Returns:
        Poses that looks from two places agree with, those with most matches of one look first.
    """
    left = [list(found) for _, found in looks]
    joint = []
    while any(left):
        at = max(range(len(left)), key=lambda k: max((len(each.points) for each in left[k]), default=0))
        first = max(left[at], key=lambda each: len(each.points))
        T = looks[at][0] @ first.T_camera_item
        own = {at: first}
        for k, (T_camera, _) in enumerate(looks):
            near = [each for each in left[k] if _off(item, T, T_camera @ each.T_camera_item) < _TOGETHER]
            if k != at and near:
                own[k] = max(near, key=lambda each: len(each.points))
        left = [[each for each in found if each is not own.get(k)] for k, found in enumerate(left)]
        aside = [looks[k][0][:3, 3] - looks[at][0][:3, 3] for k in own]
        if max(map(length, aside)) > apart:
            solved = joint_pose([(looks[k][0], each) for k, each in own.items()])
            joint += [solved] if solved.counted >= _LEAST_COUNTED else []
    return joint


def _off(item: Item, T: Array, T_other: Array) -> float:
    """By how much (m) the surface is off, with no symmetry set aside: prints tell all faces."""
    corners = np.array(list(product((-0.5, 0.5), repeat=3))) * item.shape.extents
    apart = transform_points(T, corners) - transform_points(T_other, corners)
    return float(np.linalg.norm(apart, axis=1).max())
