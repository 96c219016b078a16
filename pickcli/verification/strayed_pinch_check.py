"""Check that pads bear an item that stands off from where it is stated by the bounds of its pose error.

Fingers that close centre the item between them, and leave every other error: its centre is off along the
pads, it is turned about the closing direction, and it stands askew between them, as friction on pads and
floor may keep it from being turned flat. At the worst of these poses the contact is found again, by the same
rays, and the wrench with the lever arms that the item has there.

The poses checked are corners around all that the bounds allow: a square around the disc of shifts along the
pads, an octagon around that of the axes about which it stands askew, and both turns about the closing
direction.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.verification.load_check import SAMPLE_TIME, held_tips, wrenches
from pickcli.verification.pinch_check import pads_on

CLOSING = np.array([0.0, 1.0, 0.0])  # the closing direction in the tool frame
N_AXES = 8  # corners around the axes about which the item stands askew


def check_strayed_pinch(plan: Plan, scene: Scene, T_tip_item: Array) -> Iterator[Reason]:
    """Check the load on the pads for every error of the pose in which the item is pinched.

    Args:
        plan: A plan with a grasp.
        scene: The plan's scene, of a cell with a gripper.
        T_tip_item: (4, 4) pose of the item in the tool frame, as planned.

    Yields:
        The worst load, if it is over what the pads bear; or that nothing is left between them.
    """
    gripper = scene.cell.robot.tool.gripper
    assert plan.grasp is not None and gripper is not None
    noise = scene.noise_of(scene.instance(plan.grasp.item))
    times, tips = held_tips(plan, scene.cell.robot)
    if noise == PoseNoise() or len(times) == 0:
        return
    item, worst, when = scene.item(plan.grasp.item), 0.0, 0.0
    off = f"{1e3 * noise.position:.1f} mm and {np.degrees(noise.angle):.1f} degrees off"
    for T in strayed(T_tip_item, noise):
        pads = pads_on(item.shape, inverse(T), gripper)
        if pads is None:
            yield Reason("does not hold", item.name, f"{off} the pads touch it on no common part")
            return
        ratios = pads.ratio(wrenches(tips, T, item, SAMPLE_TIME), gripper)
        i = int(np.argmax(ratios))
        if ratios[i] > worst:
            worst, when = float(ratios[i]), float(times[i])
    if worst > 1.0:
        yield Reason("does not hold", item.name, f"{off}: {worst:.2f} of what the pads bear at {when:.3f} s")


def strayed(T_tip_item: Array, noise: PoseNoise) -> Iterator[Array]:
    """Yield the poses (4, 4) in the tool frame at the corners of what the bounds of a pose error allow.

    Args:
        T_tip_item: (4, 4) pose of the item in the tool frame, as planned.
        noise: Bounds of its error.
    """
    corners = np.arange(N_AXES) * 2.0 * np.pi / N_AXES
    axes = np.column_stack([np.cos(corners), np.zeros(N_AXES), np.sin(corners)]) / np.cos(np.pi / N_AXES)
    for askew, turn in product(noise.angle * axes, (-noise.angle, noise.angle)):
        for x, z in product((-noise.position, noise.position), repeat=2):
            yield closed_on(T_tip_item, np.array([x, 0.0, z]), askew + turn * CLOSING)


def closed_on(T_tip_item: Array, shift: Array, turn: Array) -> Array:
    """Return the pose of an item that stood off from where it was seen, after the fingers have closed.

    Args:
        T_tip_item: (4, 4) pose of the item in the tool frame, as planned.
        shift: (3,) m, error of its centre in the tool frame; along the closing direction it is closed away.
        turn: (3,) rad, rotation vector of its error about its centre.

    Returns:
        (4, 4), with the part between the pads as planned along the closing direction.
    """
    T = T_tip_item.copy()
    T[:3, :3] = Rotation.from_rotvec(turn).as_matrix() @ T_tip_item[:3, :3]
    between = shift + np.cross(-turn, T_tip_item[:3, 3])  # of the part between the pads
    T[:3, 3] += shift - between[1] * CLOSING
    return T
