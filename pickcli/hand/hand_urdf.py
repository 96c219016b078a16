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
    palm = hand.palm
    box = _box((palm.depth, palm.width, palm.height), (-palm.depth / 2, 0.0, 0.0))
    about = np.diag(box.shape.inertia_per_mass) * palm.mass + hand.wrist.inertia
    _add_solid(root, PALM, _inertial(palm.mass, about), box)
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        _add_finger(root, hand, side, sign)
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


def _add_finger(root: ElementTree.Element, hand: BeltHand, side: str, sign: float) -> None:
    """Add a finger, on the side of y that the sign says."""
    fingers = hand.fingers
    axis = np.array([0.0, 0.0, -sign])  # positive angles close
    gap = fingers.hinge_radius + PAD_GAP
    y = sign * (fingers.thickness / 2 - pad_offset(hand))
    proximal, distal = f"{side}_proximal", f"{side}_distal"
    for name, start, end in ((proximal, 0.0, fingers.proximal - gap), (distal, gap, fingers.distal)):
        pad = _box((end - start, fingers.thickness, fingers.height), ((start + end) / 2, y, 0.0))
        about = np.diag(pad.shape.inertia_per_mass) * fingers.mass
        centre = pad.T_parent_shape[:3, 3]
        _add_solid(root, name, Inertial(fingers.mass, centre, np.diag(about)), pad)
    at = pose((0.0, sign * fingers.base / 2, 0.0))
    turn = JointType.REVOLUTE
    add_joint(root, Joint(proximal, turn, PALM, proximal, at, axis, -fingers.widest, np.pi / 2))
    hinge = pose((fingers.proximal, 0.0, 0.0))
    add_joint(root, Joint(distal, turn, proximal, distal, hinge, axis, 0.0, fingers.most_bent))
    cylinder = Shape(ShapeKind.CYLINDER, (fingers.hinge_radius, fingers.height))
    _add_solid(
        root, f"{side}_hinge", _inertial(SMALL, np.full(3, SMALL * 1e-2)), Body("hinge", cylinder, np.eye(4))
    )
    add_joint(root, Joint(f"{side}_hinge", JointType.FIXED, proximal, f"{side}_hinge", hinge, axis, 0.0, 0.0))


def _add_solid(root: ElementTree.Element, name: str, inertial: Inertial, body: Body) -> None:
    element = add_link(root, name, inertial)
    for tag in ("visual", "collision"):
        add_shape(element, tag, body)


def _box(size: tuple[float, float, float], centre: tuple[float, float, float]) -> Body:
    return Body("box", Shape(ShapeKind.BOX, size), pose(centre))


def _inertial(mass: float, about: Array) -> Inertial:
    return Inertial(mass, np.zeros(3), np.diag(about))
