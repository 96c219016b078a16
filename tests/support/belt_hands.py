"""Hands with belts for tests: the one of the data folder, and what it grasps."""

from __future__ import annotations

from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import pose
from pickcli.hand.belt_hand import BeltHand, GraspObject
from pickcli.hand.hand_file import hand_file, read_hand
from pickcli.hand.hand_urdf import pad_offset

HAND = read_hand(hand_file("apple"))


def post(mass: float, hand: BeltHand = HAND) -> GraspObject:
    """A round post on which straight fingers are parallel, so that they press it square on."""
    shape = Shape(ShapeKind.CYLINDER, ((hand.fingers.base - 2 * pad_offset(hand)) / 2, 0.12))
    return GraspObject("post", mass, (Body("post", shape, pose((0.0, 0.0, 0.06))),), 2.0, 4.0)
