"""A hand in the physics engine: the impedance of its wrist, its motors, and belts that pull at contacts."""

from __future__ import annotations

import tempfile
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pickcli.geometry import Array, cross, length
from pickcli.hand.belt_hand import BeltHand
from pickcli.hand.closing_motor import ClosingMotor
from pickcli.hand.hand_urdf import FINGER_JOINTS, HINGES, PALM, WRIST, pad_offset, write_hand_urdf
from pickcli.hand.pad_friction import BeltDrive, PadFriction
from pickcli.hand.wrist_impedance import WristImpedance
from pickcli.simulation.engine import ContactPoint, Engine
from pickcli.simulation.engine_bodies import ITEM_FRICTION

HAND = "hand"
PRESS_TIME = 5e-3  # s over which the force of an object on a pad is averaged
GONE = 1e-2  # N, below which a pad has let go of an object
N_WRIST = len(WRIST)


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
        wrist: Impedance of the wrist.
        motor: The closing motor.
        drives: Motors of the belts, by link.

    Args:
        engine: The engine.
        hand: The figures.
        q: (6,) m and rad, position of the wrist: x, y, z, yaw, pitch, roll.
        friction: Coefficient between belts and objects, if it is not that of the file.
    """

    def __init__(self, engine: Engine, hand: BeltHand, q: Array, friction: float | None = None) -> None:
        self.hand, self._engine = hand, engine
        with tempfile.TemporaryDirectory() as folder:
            engine.load_robot(HAND, write_hand_urdf(hand, Path(folder)), np.eye(4))
        found = engine.joints(HAND)
        self._joints = [found[name] for name in (*WRIST, *FINGER_JOINTS)]
        open_angle = -hand.fingers.widest
        start = [*q.tolist(), open_angle, 0.0, open_angle, 0.0]
        engine.reset_joints(HAND, dict(zip(self._joints, start, strict=True)))
        engine.release_joints(HAND, self._joints)
        for link in FINGER_JOINTS:
            engine.roughen(HAND, link, 0.0)  # the belts' friction is computed here
        for link in (PALM, *HINGES):
            engine.roughen(HAND, link, hand.palm.friction / ITEM_FRICTION)
        mass = hand.wrist.mass + hand.palm.mass + 4 * hand.fingers.mass
        self.wrist = WristImpedance(hand.wrist, mass, q.copy())
        self.motor = ClosingMotor(hand.drive, open_angle)
        self.drives = {link: BeltDrive(hand.belts) for link in FINGER_JOINTS}
        self._friction = hand.belts.friction if friction is None else friction
        self._presses: dict[str, dict[str, _Press]] = {link: {} for link in FINGER_JOINTS}
        self.q, self.dq = np.array(start), np.zeros(len(start))

    @property
    def tips(self) -> Array:
        """(2, 2) m of the end of each pad: along the approach, and inwards of the middle."""
        fingers = self.hand.fingers
        at, turn = self.q[N_WRIST:].reshape(2, 2).T
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
        dt = self._engine.time_step
        self.q, _ = self._engine.joint_states(HAND, self._joints)
        self.dq = self._engine.joint_velocities(HAND, self._joints)
        gravity = self._engine.inverse_dynamics(HAND, self.q, self.dq * 0.0, self.dq * 0.0)[:N_WRIST]
        wrist = self.wrist.efforts(self.q[:N_WRIST], self.dq[:N_WRIST], gravity)
        fingers = self.motor.advance(self.q[N_WRIST:].reshape(2, 2), self.dq[N_WRIST:].reshape(2, 2), dt)
        self._engine.exert(HAND, self._joints, np.concatenate([wrist, fingers.ravel()]))
        for link, drive in self.drives.items():
            drive.advance(self._rub(link, drive.speed, dt), dt)

    def _rub(self, link: str, speed: float, dt: float) -> float:
        """Let a belt act on what presses on it, and return N by which that holds the belt back."""
        presses = self._presses[link]
        points = defaultdict(list)
        for point in self._engine.pressing_points(HAND, link):
            points[point.b].append(point)
        if not points and not presses:
            return 0.0
        axis = self._engine.pose(HAND, link)[:3, 0]
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
        velocity, turning = engine.relative_velocity(name, HAND, link, contact.point)
        rates = np.array([velocity @ contact.along + speed, velocity @ across, turning @ contact.normal])
        along, aside, turn = press.friction.load(rates, press.force, contact.radius, dt)
        force, torque = along * contact.along + aside * across, turn * contact.normal
        engine.apply_force(name, force, contact.point)
        engine.twist(name, torque)
        engine.apply_force(HAND, -force, contact.point, link)
        engine.twist(HAND, -torque, link)
        return -float(along)
