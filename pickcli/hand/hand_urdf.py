"""Writes a hand on its wrist as a URDF for the physics engine.

The wrist is three linear joints and three rotations (yaw, pitch, roll), on which the arm's impedance acts.
"""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from pickcli.cell.inertial import Inertial
from pickcli.cell.robot import Joint, JointType
from pickcli.cell.robots.urdf_writer import add_joint, add_link, add_shape
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import Array, pose
from pickcli.hand.belt_hand import BeltHand

WRIST = ("wrist_x", "wrist_y", "wrist_z", "wrist_yaw", "wrist_pitch", "wrist_roll")
SIDES = ("left", "right")
FINGER_JOINTS = ("left_proximal", "left_distal", "right_proximal", "right_distal")  # and their links
HINGES = ("left_hinge", "right_hinge")
PALM = "palm"
PAD_GAP = 1e-3  # m between a hinge and the ends of the pads beside it
SMALL = 1e-4  # kg m^2 or kg, of links that only carry a joint
FAR = 5.0  # m or rad, limit of the wrist


def write_hand_urdf(hand: BeltHand, folder: Path) -> Path:
    """Write a hand.

    Args:
        hand: The hand.
        folder: Folder of the file.

    Returns:
        Its path.
    """
    root = ElementTree.Element("robot", name="hand")
    add_link(root, "base", _inertial(1.0, np.ones(3)))
    parent = "base"
    for k, name in enumerate(WRIST):
        axis = np.eye(3)[k] if k < 3 else np.eye(3)[5 - k]
        kind = JointType.PRISMATIC if k < 3 else JointType.REVOLUTE
        child = PALM if name == WRIST[-1] else f"{name}_link"
        add_joint(root, Joint(name, kind, parent, child, np.eye(4), axis, -FAR, FAR))
        parent = child
        if child != PALM:
            # Translation takes place before rotation: what weighs in all directions stands on the third link.
            mass = hand.wrist.mass if name == "wrist_z" else SMALL
            add_link(root, child, _inertial(mass, np.full(3, SMALL)))
    palm, box = hand.palm, palm_body(hand)
    about = np.diag(box.shape.inertia_per_mass) * palm.mass + hand.wrist.inertia
    add_solid(root, PALM, _inertial(palm.mass, about), box)
    add_fingers(root, hand, PALM, np.eye(4))
    path = folder / "hand.urdf"
    ElementTree.indent(root)
    path.write_bytes(ElementTree.tostring(root))
    return path


def pad_offset(hand: BeltHand) -> float:
    """Return how far a pad lies inwards of the axes of its finger.

    Args:
        hand: The hand.

    Returns:
        m.
    """
    return hand.fingers.hinge_radius - hand.fingers.hinge_relief


def palm_body(hand: BeltHand) -> Body:
    """Return the solid of the palm.

    Args:
        hand: The hand.

    Returns:
        A box in the frame of the hand.
    """
    palm = hand.palm
    return _box((palm.depth, palm.width, palm.height), (-palm.depth / 2, 0.0, 0.0))


def pad_bodies(hand: BeltHand, sign: float) -> tuple[Body, Body]:
    """Return the solids of the two phalanges of a finger.

    Args:
        hand: The hand.
        sign: 1 for the left finger, -1 for the right one.

    Returns:
        Boxes in the frames of the proximal and of the distal link.
    """
    fingers = hand.fingers
    gap = fingers.hinge_radius + PAD_GAP
    y = sign * (fingers.thickness / 2 - pad_offset(hand))
    proximal, distal = (
        _box((end - start, fingers.thickness, fingers.height), ((start + end) / 2, y, 0.0))
        for start, end in ((0.0, fingers.proximal - gap), (gap, fingers.distal))
    )
    return proximal, distal


def hinge_body(hand: BeltHand) -> Body:
    """Return the solid of a hinge.

    Args:
        hand: The hand.

    Returns:
        A cylinder in the frame of the hinge.
    """
    cylinder = Shape(ShapeKind.CYLINDER, (hand.fingers.hinge_radius, hand.fingers.height))
    return Body("hinge", cylinder, np.eye(4))


def add_fingers(root: ElementTree.Element, hand: BeltHand, parent: str, T_parent_hand: Array) -> None:
    """Add both fingers with their joints to a robot.

    Args:
        root: The robot's element.
        hand: The hand.
        parent: Name of the link that carries the palm.
        T_parent_hand: (4, 4) pose of the hand's frame in that link.
    """
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        _add_finger(root, hand, side, sign, parent, T_parent_hand)


def _add_finger(
    root: ElementTree.Element, hand: BeltHand, side: str, sign: float, parent: str, T_parent_hand: Array
) -> None:
    """Add a finger, on the side of y that the sign says."""
    fingers = hand.fingers
    axis = np.array([0.0, 0.0, -sign])  # positive angles close
    proximal, distal = f"{side}_proximal", f"{side}_distal"
    for name, pad in zip((proximal, distal), pad_bodies(hand, sign), strict=True):
        about = np.diag(pad.shape.inertia_per_mass) * fingers.mass
        centre = pad.T_parent_shape[:3, 3]
        add_solid(root, name, Inertial(fingers.mass, centre, np.diag(about)), pad)
    at = T_parent_hand @ pose((0.0, sign * fingers.base / 2, 0.0))
    turn = JointType.REVOLUTE
    add_joint(root, Joint(proximal, turn, parent, proximal, at, axis, -fingers.widest, np.pi / 2))
    hinge = pose((fingers.proximal, 0.0, 0.0))
    add_joint(root, Joint(distal, turn, proximal, distal, hinge, axis, 0.0, fingers.most_bent))
    add_solid(root, f"{side}_hinge", _inertial(SMALL, np.full(3, SMALL * 1e-2)), hinge_body(hand))
    add_joint(root, Joint(f"{side}_hinge", JointType.FIXED, proximal, f"{side}_hinge", hinge, axis, 0.0, 0.0))


def add_solid(root: ElementTree.Element, name: str, inertial: Inertial, body: Body) -> None:
    """Add a link of one solid, as it is seen and as it collides.

    Args:
        root: The robot's element.
        name: Name of the link.
        inertial: Its mass properties.
        body: The solid, in the frame of the link.
    """
    element = add_link(root, name, inertial)
    for tag in ("visual", "collision"):
        add_shape(element, tag, body)


def _box(size: tuple[float, float, float], centre: tuple[float, float, float]) -> Body:
    return Body("box", Shape(ShapeKind.BOX, size), pose(centre))


def _inertial(mass: float, about: Array) -> Inertial:
    return Inertial(mass, np.zeros(3), np.diag(about))
