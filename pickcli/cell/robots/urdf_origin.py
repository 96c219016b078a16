"""Reads origins of a URDF: poses of joints, collision shapes and centres of mass in their links."""

from __future__ import annotations

import numpy as np

from pickcli.files.xml_reader import Element
from pickcli.geometry import Array, pose

# Larger figures were written in another unit.
MAX_SIZE = 10.0  # m, size of a link and distance between joints
MAX_TURN = 12.6  # rad, position of a joint either way: two turns


def read_origin(element: Element) -> Array:
    """Read the origin of an element; a missing origin means identity, as in the format.

    Args:
        element: A joint, inertial or collision element.

    Returns:
        Pose (4, 4) of the element in its parent frame.

    Raises:
        InputError: The origin is not six finite numbers in m and rad.
    """
    origin = element.optional("origin")
    if origin is None:
        return np.eye(4)
    xyz = origin.numbers("xyz", 3) if "xyz" in origin.attributes else (0.0, 0.0, 0.0)
    rpy = origin.numbers("rpy", 3) if "rpy" in origin.attributes else (0.0, 0.0, 0.0)
    if max(map(abs, xyz)) > MAX_SIZE:
        raise origin.error(f"expected xyz within {MAX_SIZE:g} m, got {xyz}; lengths are in m, not mm")
    if max(map(abs, rpy)) > MAX_TURN:
        raise origin.error(f"expected rpy within {MAX_TURN:g} rad, got {rpy}; angles are in rad, not degrees")
    return pose(xyz, rpy=rpy)
