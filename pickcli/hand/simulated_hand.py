"""A hand in the physics engine: its motors, and belts that pull at contacts. An arm or a wrist carries it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pickcli.geometry import Array, cross, length
from pickcli.hand.belt_hand import BeltHand
from pickcli.hand.closing_motor import ClosingMotor
from pickcli.hand.hand_urdf import FINGER_JOINTS, HINGES, PALM, pad_offset
from pickcli.hand.mounted_hand import open_fingers
from pickcli.hand.pad_friction import BeltDrive, PadFriction
from pickcli.simulation.engine import ContactPoint, Engine
from pickcli.simulation.engine_bodies import ITEM_FRICTION

PRESS_TIME = 5e-3  # s over which the force of an object on a pad is averaged
GONE = 1e-2  # N, below which a pad has let go of an object
N_FINGER_JOINTS = len(FINGER_JOINTS)


class HandImpedance(Protocol):
    """Impedance with which a hand is held.

    Attributes:
        wanted: (6,) m and rad of the hand: x, y, z, yaw, pitch, roll.
        is_level_soft: Whether it is soft in the horizontal plane.
        measured: (6,) m and rad, as ``wanted``, in the last step.
    """

    wanted: Array
    is_level_soft: bool
    measured: Array

    @property
    def felt(self) -> Array:
        """Force (3,) in N with which something pushes the hand, estimated from encoders and torques."""

    @property
    def is_overloaded(self) -> bool:
        """Whether a force or torque is beyond its threshold."""

    @property
    def lifting(self) -> float:
        """N upwards with which it bears what the hand holds."""


class HandCarrier(Protocol):
    """What carries a hand in an engine.

    Attributes:
        body: Name of the body whose links are palm and fingers.
        impedance: With which it holds the hand.
        joints: Indices of its own joints.
    """

    body: str
    joints: list[int]

    @property
    def impedance(self) -> HandImpedance:
        """With which it holds the hand."""

    def exert(self) -> None:
        """Let its own joints act in the next step of the engine."""


@dataclass(frozen=True, eq=False)
class PadContact:
    """How an object presses on a pad.

    Attributes:
        point: (3,) m in the world, middle of the contact.
        normal: (3,) from the object to the pad.
        along: (3,) along the pad to the tip.
        radius: m, mean distance of the contact points from the middle.
        force: N.
    """

    point: Array
    normal: Array
    along: Array
    radius: float
    force: float

    @staticmethod
    def of(points: Sequence[ContactPoint], axis: Array) -> PadContact:
        """Sum contact points up.

        Args:
            points: Points of one object on one pad.
            axis: (3,) of the pad, to the tip.

        Returns:
            Their sum.
        """
        forces = np.array([each.force for each in points])
        at = np.array([each.position for each in points])
        total = float(forces.sum())
        point = forces @ at / total
        normal = forces @ np.array([each.normal for each in points])
        normal = normal / length(normal)
        along = axis - (axis @ normal) * normal
        radius = float(forces @ np.linalg.norm(at - point, axis=1)) / total
        return PadContact(point, normal, along / length(along), radius, total)


@dataclass
class _Press:
    """An object on a pad: the last contact, its averaged force, and the friction."""

    contact: PadContact
    friction: PadFriction
    force: float = 0.0


class SimulatedHand:
    """A hand in an engine.

    Attributes:
        hand: Its figures.
        carrier: What carries it.
        motor: The closing motor.
        drives: Motors of the belts, by link.
        q: m and rad of the carrier's joints, then (4,) rad of those of the fingers.

    Args:
        engine: The engine.
        hand: The figures.
        carrier: What carries it, which is in the engine.
        friction: Coefficient between belts and objects, if it is not that of the file.
    """

    def __init__(
        self, engine: Engine, hand: BeltHand, carrier: HandCarrier, friction: float | None = None
    ) -> None:
        self.hand, self.carrier, self._engine, body = hand, carrier, engine, carrier.body
        found = engine.joints(body)
        fingers = [found[name] for name in FINGER_JOINTS]
        self._joints = [*carrier.joints, *fingers]
        engine.reset_joints(body, dict(zip(fingers, open_fingers(hand).ravel().tolist(), strict=True)))
        engine.release_joints(body, fingers)
        for link in FINGER_JOINTS:
            engine.roughen(body, link, 0.0)  # the belts' friction is computed here
        for link in (PALM, *HINGES):
            engine.roughen(body, link, hand.palm.friction / ITEM_FRICTION)
        self.motor = ClosingMotor(hand.drive, -hand.fingers.widest)
        self.drives = {link: BeltDrive(hand.belts) for link in FINGER_JOINTS}
        self._friction = hand.belts.friction if friction is None else friction
        self._presses: dict[str, dict[str, _Press]] = {link: {} for link in FINGER_JOINTS}
        self.q, _ = engine.joint_states(body, self._joints)

    @property
    def body(self) -> str:
        """Name of the body in the engine whose links are palm and fingers."""
        return self.carrier.body

    @property
    def wrist(self) -> HandImpedance:
        """Impedance with which the hand is held."""
        return self.carrier.impedance

    @property
    def fingers(self) -> Array:
        """(2, 2) rad, of the proximal joint and the hinge of the left and the right finger."""
        return self.q[-N_FINGER_JOINTS:].reshape(2, 2)

    def reset(self) -> None:
        """Open the fingers at once, as by hand, with nothing between them."""
        fingers = self._joints[-N_FINGER_JOINTS:]
        stand = dict(zip(fingers, open_fingers(self.hand).ravel().tolist(), strict=True))
        self._engine.reset_joints(self.body, stand)
        self.motor.angle, self.motor.rate, self.motor.wanted = -self.hand.fingers.widest, 0.0, 0.0
        self.run_belts(0.0, 0.0)
        for presses in self._presses.values():
            presses.clear()

    @property
    def tips(self) -> Array:
        """(2, 2) m of the end of each pad: along the approach, and inwards of the middle."""
        fingers = self.hand.fingers
        at, turn = self.fingers.T
        turn = at + turn
        along = fingers.proximal * np.cos(at) + fingers.distal * np.cos(turn)
        inwards = fingers.proximal * np.sin(at) + fingers.distal * np.sin(turn) - fingers.base / 2
        offset = pad_offset(self.hand)
        return np.array([along - offset * np.sin(turn), inwards + offset * np.cos(turn)]).T

    def pressing(self, link: str) -> dict[str, float]:
        """Return the objects on a pad.

        Args:
            link: The phalanx.

        Returns:
            N by object.
        """
        return {name: press.force for name, press in self._presses[link].items()}

    @property
    def slipping(self) -> tuple[str, ...]:
        """Links whose belts slip on an object."""
        return tuple(
            link
            for link, presses in self._presses.items()
            if any(press.friction.is_sliding for press in presses.values())
        )

    def run_belts(self, left: float, right: float) -> None:
        """Let belts run.

        Args:
            left: m/s of those of the left finger, positive towards the palm.
            right: m/s of those of the right finger.
        """
        for link, drive in self.drives.items():
            drive.wanted = left if link.startswith("left") else right

    def exert(self) -> None:
        """Let motors and belts act in the next step of the engine."""
        engine, body, dt = self._engine, self.body, self._engine.time_step
        self.q, _ = engine.joint_states(body, self._joints)
        rates = engine.joint_velocities(body, self._joints[-N_FINGER_JOINTS:])
        self.carrier.exert()
        efforts = self.motor.advance(self.fingers, rates.reshape(2, 2), dt)
        engine.exert(body, self._joints[-N_FINGER_JOINTS:], efforts.ravel())
        for link, drive in self.drives.items():
            drive.advance(self._rub(link, drive.speed, dt), dt)

    def _rub(self, link: str, speed: float, dt: float) -> float:
        """Let a belt act on what presses on it, and return N by which that holds the belt back."""
        presses = self._presses[link]
        points = defaultdict(list)
        for point in self._engine.pressing_points(self.body, link):
            points[point.b].append(point)
        if not points and not presses:
            return 0.0
        axis = self._engine.pose(self.body, link)[:3, 0]
        held_back = 0.0
        for name in sorted(points.keys() | presses.keys()):
            contact = PadContact.of(points[name], axis) if points[name] else None
            held_back += self._rub_object(link, name, contact, speed, dt)
        return held_back

    def _rub_object(self, link: str, name: str, found: PadContact | None, speed: float, dt: float) -> float:
        presses, engine = self._presses[link], self._engine
        if name not in presses:
            if found is None or not engine.is_free(name):
                return 0.0
            belts = self.hand.belts
            presses[name] = _Press(found, PadFriction(belts, self._friction))
        press = presses[name]
        press.contact = contact = found or press.contact
        press.force += ((found.force if found else 0.0) - press.force) * min(1.0, dt / PRESS_TIME)
        if found is None and press.force < GONE:
            del presses[name]
            return 0.0
        across = cross(contact.normal, contact.along)
        velocity, turning = engine.relative_velocity(name, self.body, link, contact.point)
        rates = np.array([velocity @ contact.along + speed, velocity @ across, turning @ contact.normal])
        along, aside, turn = press.friction.load(rates, press.force, contact.radius, dt)
        force, torque = along * contact.along + aside * across, turn * contact.normal
        engine.apply_force(name, force, contact.point)
        engine.twist(name, torque)
        engine.apply_force(self.body, -force, contact.point, link)
        engine.twist(self.body, -torque, link)
        return -float(along)
