"""A hand as planner and verifier see it on an arm: rigid shapes on its flange, with what it holds.

The fingers stand while the arm moves as planned. So what the arm carries at one time, the open hand or the
closed one with its object, is the shape of its last link, and every plan is proven and certified with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.fingerprint import fingerprint
from pickcli.cell.inertial import Inertial
from pickcli.cell.robot import Link
from pickcli.cell.shapes import Body
from pickcli.errors import InputError
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.hand.belt_hand import BeltHand
from pickcli.hand.hand_urdf import SIDES, hinge_body, pad_bodies, palm_body


def flange_to_hand(hand: BeltHand) -> Array:
    """Return the pose of the hand's frame in that of the flange.

    Args:
        hand: The hand.

    Returns:
        (4, 4): the approach along the flange's z axis, the hand's upward axis along its x axis.
    """
    R = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
    return pose((0.0, 0.0, hand.palm.depth), R=R)


def hand_bodies(hand: BeltHand, fingers: Array) -> tuple[Body, ...]:
    """Return the solids of a hand whose fingers stand.

    Args:
        hand: The hand.
        fingers: (2, 2) rad, of the proximal joint and the hinge of the left and the right finger.

    Returns:
        The solids in the frame of the hand.
    """
    found = [palm_body(hand)]
    for side, sign, (at, turn) in zip(SIDES, (1.0, -1.0), fingers.tolist(), strict=True):
        axis = (0.0, 0.0, -sign)
        T = pose((0.0, sign * hand.fingers.base / 2, 0.0), R=rotation_axis_angle(axis, at))
        T_hinge = T @ pose((hand.fingers.proximal, 0.0, 0.0))
        frames = (T, T_hinge @ pose(R=rotation_axis_angle(axis, turn)))
        for T_link, name, pad in zip(frames, ("proximal", "distal"), pad_bodies(hand, sign), strict=True):
            found.append(replace(pad, name=f"{side}_{name}", T_parent_shape=T_link @ pad.T_parent_shape))
        found.append(replace(hinge_body(hand), name=f"{side}_hinge", T_parent_shape=T_hinge))
    return tuple(found)


def open_fingers(hand: BeltHand) -> Array:
    """Return the joints of the fingers of the open hand.

    Args:
        hand: The hand.

    Returns:
        (2, 2) rad, of the proximal joint and the hinge of the left and the right finger.
    """
    return np.array([[-hand.fingers.widest, 0.0]] * 2)


def with_hand(
    cell: Cell, hand: BeltHand, fingers: Array, held: Sequence[Body] = (), held_mass: float = 0.0
) -> Cell:
    """Return a cell whose arm carries a hand as a rigid part of its flange.

    Args:
        cell: A cell whose arm has a bare flange.
        hand: The hand.
        fingers: (2, 2) rad, how the fingers stand.
        held: Solids that are held, in the frame of the hand.
        held_mass: kg of them.

    Returns:
        The cell, with a fingerprint of its own.

    Raises:
        InputError: A tool is mounted on the flange already.
    """
    if not cell.robot.tool.is_bare:
        raise InputError(
            f"{cell.path / 'cell.yaml'}: the arm has a tool of its own; a hand needs a cell "
            "whose file states no `tool`, such as apple_booth_belts"
        )
    T, name = flange_to_hand(hand), cell.robot.tool.flange_link
    carried = [
        replace(body, T_parent_shape=T @ body.T_parent_shape) for body in (*hand_bodies(hand, fingers), *held)
    ]
    mass = hand.palm.mass + 4 * hand.fingers.mass
    own = _evenly(mass, carried[: len(carried) - len(held)])
    inertial = own.joined(_evenly(held_mass, carried[-len(held) :])) if held else own
    links = tuple(
        Link(name, (*link.bodies, *carried), inertial) if link.name == name else link
        for link in cell.robot.links
    )
    changed = replace(cell, robot=replace(cell.robot, links=links))
    return replace(changed, fingerprint=fingerprint(changed))


def _evenly(mass: float, bodies: Sequence[Body]) -> Inertial:
    """Return the mass properties of solids of one density."""
    volumes = np.array([body.shape.volume for body in bodies])
    centres = np.array([body.T_parent_shape[:3, 3] for body in bodies])
    whole = Inertial(0.0, np.zeros(3), np.zeros((3, 3)))
    for body, centre, share in zip(bodies, centres, volumes / volumes.sum(), strict=True):
        R = body.T_parent_shape[:3, :3]
        about = mass * share * R @ body.shape.inertia_per_mass @ R.T
        part = Inertial(mass * share, centre, about)
        whole = part if whole.mass == 0.0 else whole.joined(part)
    return whole
