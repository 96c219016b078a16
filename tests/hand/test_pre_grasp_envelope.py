"""Poses before a grasp: the open hand stands level around the object, and touches it nowhere."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse
from pickcli.hand.mounted_hand import flange_to_hand, hand_bodies
from pickcli.hand.pre_grasp_envelope import BESIDE, CONE, NEAR, REACH, aperture, object_envelopes
from support.belt_hands import HAND

BEER, BOX = Shape(ShapeKind.CYLINDER, (0.033, 0.168)), Shape(ShapeKind.BOX, (0.05, 0.05, 0.14))


def nearest_to_pads(shape: Shape, T_hand_object: Array) -> float:
    """Least distance in m of points on the pads from the object."""
    angle = aperture(HAND, shape)
    fingers, found = np.array([[angle, 0.0]] * 2), []
    for body in hand_bodies(HAND, fingers)[1:]:
        half, T = body.shape.extents / 2, inverse(T_hand_object) @ body.T_parent_shape
        grid = np.stack(np.meshgrid(*[np.linspace(-h, h, 25) for h in half]), axis=-1).reshape(-1, 3)
        points = grid @ T[:3, :3].T + T[:3, 3]
        if shape.kind is ShapeKind.CYLINDER:
            found.append(np.hypot(points[:, 0], points[:, 1]).min() - shape.size[0])
        else:
            found.append(np.linalg.norm(np.maximum(np.abs(points) - shape.extents / 2, 0.0), axis=1).min())
    return float(min(found))


@pytest.mark.parametrize("shape", [BEER, BOX], ids=["beer", "box"])
def test_the_open_hand_is_clear_of_the_object_in_every_pose_before_the_grasp(shape: Shape) -> None:
    rng = np.random.default_rng(4)
    for envelope in object_envelopes(HAND, shape):
        for T_object_flange in envelope.sample(rng, 20):
            T_hand_object = inverse(T_object_flange @ flange_to_hand(HAND))
            aside = abs(T_hand_object[1, 3])
            assert nearest_to_pads(shape, T_hand_object) > BESIDE - aside - 0.004
            assert nearest_to_pads(shape, T_hand_object) > 0.002


def test_the_middle_of_the_object_is_between_the_pads_and_the_hand_is_level() -> None:
    (envelope,) = object_envelopes(HAND, BEER)
    for T_object_flange in envelope.sample(np.random.default_rng(5), 50):
        T = T_object_flange @ flange_to_hand(HAND)
        assert inverse(T)[0, 3] == pytest.approx(REACH, abs=NEAR + 0.003)
        assert T[2, 2] > np.cos(2 * CONE)


def test_a_wider_object_needs_a_wider_aperture_and_a_box_more_than_a_can() -> None:
    can = Shape(ShapeKind.CYLINDER, (0.025, 0.14))
    assert -HAND.fingers.widest <= aperture(HAND, BEER) < aperture(HAND, can) < 0.0
    assert aperture(HAND, BOX) < aperture(HAND, can)
