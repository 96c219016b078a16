"""A wrist by itself that carries a hand: three linear joints and three rotations under impedance control."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from pickcli.geometry import Array
from pickcli.hand.belt_hand import BeltHand
from pickcli.hand.hand_urdf import WRIST, write_hand_urdf
from pickcli.hand.wrist_impedance import WristImpedance
from pickcli.simulation.engine import Engine

HAND = "hand"


class FreeWrist:
    """A wrist in an engine.

    Attributes:
        body: Name of the body.
        joints: Indices of the joints of the wrist.
        impedance: Its control.

    Args:
        engine: The engine.
        hand: Figures of wrist and hand.
        q: (6,) m and rad, its position: x, y, z, yaw, pitch, roll.
    """

    def __init__(self, engine: Engine, hand: BeltHand, q: Array) -> None:
        self.body, self._engine = HAND, engine
        with tempfile.TemporaryDirectory() as folder:
            engine.load_robot(HAND, write_hand_urdf(hand, Path(folder)), np.eye(4))
        found = engine.joints(HAND)
        self.joints = [found[name] for name in WRIST]
        self._all = list(found.values())
        engine.reset_joints(HAND, dict(zip(self.joints, q.tolist(), strict=True)))
        engine.release_joints(HAND, self.joints)
        mass = hand.wrist.mass + hand.palm.mass + 4 * hand.fingers.mass
        self.impedance = WristImpedance(hand.wrist, mass, q.copy())

    def exert(self) -> None:
        """Let the wrist act in the next step."""
        engine, n = self._engine, len(self.joints)
        q, _ = engine.joint_states(HAND, self._all)
        dq = engine.joint_velocities(HAND, self.joints)
        rest = q * 0.0
        gravity = engine.inverse_dynamics(HAND, q, rest, rest)[:n]
        engine.exert(HAND, self.joints, self.impedance.efforts(q[:n], dq, gravity, engine.time_step))
