"""The motor that closes both fingers: current control, and a transmission that gives way.

Each finger is underactuated (Birglen, Laliberte and Gosselin, Underactuated Robotic Hands, 2008, ch. 3): one
torque acts on the proximal joint and, by a fixed ratio, on the hinge, which a spring holds straight.
"""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.geometry import Array
from pickcli.hand.belt_hand import ClosingDrive

RAMP = 0.02  # s in which a difference of speed asks for the whole current


@dataclass
class ClosingMotor:
    """The state of the motor.

    Attributes:
        drive: Its figures.
        angle: rad, as its encoder reads; that of straight fingers that point straight ahead is 0.
        rate: rad/s.
        wanted: rad/s, positive to close.
        set_point: A, largest current.
        current: A in the last step.
    """

    drive: ClosingDrive
    angle: float
    rate: float = 0.0
    wanted: float = 0.0
    set_point: float = 0.0
    current: float = 0.0

    def advance(self, fingers: Array, rates: Array, dt: float) -> Array:
        """Advance by a step.

        Args:
            fingers: (2, 2) rad, of the proximal joint and the hinge of each finger.
            rates: (2, 2) rad/s.
            dt: s.

        Returns:
            (2, 2) Nm on these joints.
        """
        drive = self.drive
        followed = fingers[:, 0] + drive.hinge_ratio * fingers[:, 1]
        follow = rates[:, 0] + drive.hinge_ratio * rates[:, 1]
        torques = drive.stiffness * (self.angle - followed) + drive.damping * (self.rate - follow)
        # The current that reaches the speed, given the load; of the whole set point where that is not enough.
        load = float(torques.sum())
        needed = (drive.inertia * (self.wanted - self.rate) / RAMP + load) / drive.torque_constant
        self.current = min(max(needed, -self.set_point), self.set_point)
        self.rate += (drive.torque_constant * self.current - load) / drive.inertia * dt
        self.angle += self.rate * dt
        joints = fingers * 0.0
        joints[:, 0] = torques
        joints[:, 1] = drive.hinge_ratio * torques - drive.spring
        return joints
