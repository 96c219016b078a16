"""An arm in an engine that carries a hand: it follows set points of plans, or holds the hand compliantly."""

from __future__ import annotations

import tempfile
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.inertial import Inertial
from pickcli.cell.robot import Joint, JointType
from pickcli.cell.robots.urdf_writer import add_joint
from pickcli.geometry import Array
from pickcli.hand.arm_impedance import ArmImpedance, limit_efforts
from pickcli.hand.belt_hand import BeltHand
from pickcli.hand.force_observer import ForceObserver
from pickcli.hand.hand_urdf import FINGER_JOINTS, HINGES, PALM, add_fingers, add_solid, palm_body
from pickcli.hand.mounted_hand import flange_to_hand
from pickcli.kinematics.arm import Arm
from pickcli.simulation.engine import Engine
from pickcli.simulation.robot_urdf import write_urdf
from pickcli.simulation.scene_bodies import jointed_pairs, rigid_pairs
from pickcli.simulation.servo import Drives, Servo

ROBOT = "robot"
TIPS = ("left_distal", "right_distal")  # which meet where nothing is between them
HAND_LINKS = (PALM, *FINGER_JOINTS, *HINGES)


class HandArm:
    """An arm in an engine, with a hand on its flange.

    Attributes:
        body: Name of the body.
        joints: Indices of the arm's joints.
        impedance: Its control while it is compliant.
        is_compliant: Whether it is under impedance control; else motors follow ``command``.
        command: (n,) rad, set point.
        q: (n,) rad, as measured in the last step.

    Args:
        engine: The engine.
        cell: The cell, whose arm has a bare flange.
        hand: The hand.
        q: (n,) rad at the start.
    """

    def __init__(self, engine: Engine, cell: Cell, hand: BeltHand, q: Array) -> None:
        self.body, self._engine, robot = ROBOT, engine, cell.robot
        with tempfile.TemporaryDirectory() as folder:
            engine.load_robot(ROBOT, _urdf(cell, hand, Path(folder)), robot.T_world_base)
        found = engine.joints(ROBOT)
        self.joints = [found[name] for name in robot.joint_names]
        self._all = list(found.values())
        self._own = [self._all.index(joint) for joint in self.joints]  # rows of the arm's among all
        engine.reset_joints(ROBOT, dict(zip(self.joints, q.tolist(), strict=True)))
        servo, forces = Servo(), np.array([robot.motor_forces[name] for name in robot.joint_names])
        self._drives = Drives(servo, robot.joint_names, robot.limits, forces, engine.time_step)
        self._arm, self._state = Arm(robot), robot.tool.default_state
        self._T_flange_hand = flange_to_hand(hand)
        self.impedance = ArmImpedance(hand.wrist, hand.wrist.mass + hand.palm.mass + 4 * hand.fingers.mass)
        self.is_compliant = False
        self.command = self.q = q.copy()
        self._torques = np.zeros(len(q))
        self._observer = ForceObserver(len(q))
        self._M = self._mass_matrix()
        self._inertia = self._M[np.arange(len(q)), self._own]
        self._let_pass(cell)

    @property
    def T_world_hand(self) -> Array:
        """(4, 4) pose of the hand by the measured joints."""
        return np.asarray(self._arm.tip(self.q, self._state) @ self._T_flange_hand)

    def comply(self) -> None:
        """Hold the hand where it is by impedance from now on."""
        self.is_compliant = True
        self._engine.release_joints(ROBOT, self.joints)
        self.impedance.hold(self.T_world_hand)
        self._observer, self._M = ForceObserver(len(self.joints)), self._mass_matrix()
        self._inertia = self._M[np.arange(len(self.joints)), self._own]

    def follow(self) -> None:
        """Follow set points from now on, at first where the arm is."""
        self.is_compliant, self.command = False, self.q.copy()

    def reset(self, q: Array) -> None:
        """Stand elsewhere at once, as brought there by hand.

        Args:
            q: (n,) rad.
        """
        self._engine.reset_joints(ROBOT, dict(zip(self.joints, q.tolist(), strict=True)))
        self.q = q.copy()
        self.follow()

    def exert(self) -> None:
        """Let the joints act in the next step."""
        engine = self._engine
        self.q, self._torques = engine.joint_states(ROBOT, self.joints)
        if not self.is_compliant:
            velocities = self._drives.velocities(self.command, self.q, self._torques)
            engine.drive(ROBOT, self.joints, velocities.tolist(), self._drives.forces.tolist())
            return
        q, _ = engine.joint_states(ROBOT, self._all)
        rest = q * 0.0
        gravity = engine.inverse_dynamics(ROBOT, q, rest, rest)[self._own]
        T_flange = self._arm.tip(self.q, self._state)
        T_hand = T_flange @ self._T_flange_hand
        J = self._arm.jacobian(self.q, self._state)
        J[:3] += np.cross(J[3:].T, T_hand[:3, 3] - T_flange[:3, 3]).T
        rates = engine.joint_velocities(ROBOT, self._all)
        efforts = self.impedance.lead(J, self._M[:, self._own], engine.time_step)
        efforts += self.impedance.efforts(T_hand, J, rates[self._own], gravity)
        efforts += limit_efforts(self._arm.limits, self.q, rates[self._own], self._inertia)
        engine.exert(ROBOT, self.joints, efforts)
        self._feel(q, rates, efforts, J)

    def _feel(self, q: Array, rates: Array, efforts: Array, J: Array) -> None:
        """Estimate what pushes the hand, by all joints (m,), efforts (n,) and the hand's Jacobian (6, n)."""
        engine, dt, before = self._engine, self._engine.time_step, self._M
        self._M = self._mass_matrix()
        at_speed = engine.inverse_dynamics(ROBOT, q, rates, q * 0.0)[self._own]
        known = efforts - at_speed + (self._M - before) @ rates / dt
        self._observer.advance(self._M @ rates, known, dt)
        self.impedance.felt = (np.linalg.pinv(J.T) @ self._observer.force)[:3]

    def _mass_matrix(self) -> Array:
        """(n, m) rows of the arm's joints."""
        q, _ = self._engine.joint_states(ROBOT, self._all)
        return self._engine.mass_matrix(ROBOT, q)[self._own]

    def _let_pass(self, cell: Cell) -> None:
        """Leave out pairs of links that overlap, or that the cell allows to touch."""
        robot, flange = cell.robot, cell.robot.tool.flange_link
        pairs = [
            *rigid_pairs(robot),
            *jointed_pairs(robot),
            *((each.a, each.b) for each in cell.allowed_pairs),
        ]
        carried = [(PALM if a == flange else a, PALM if b == flange else b) for a, b in pairs]
        between = [pair for pair in combinations(HAND_LINKS, 2) if set(pair) != set(TIPS)]
        for a, b in [*pairs, *carried, *between]:
            if self._engine.has_link(ROBOT, a) and self._engine.has_link(ROBOT, b) and a != b:
                self._engine.set_collision(ROBOT, a, ROBOT, b, on=False)


def _urdf(cell: Cell, hand: BeltHand, folder: Path) -> Path:
    """Write arm, palm and fingers as one robot."""
    path = write_urdf(cell.robot, folder)
    root = ElementTree.parse(path).getroot()
    palm = palm_body(hand)
    # The robot's description has no rotors; as on the wrist by itself, their inertia is felt at the hand.
    about = palm.shape.inertia_per_mass * hand.palm.mass + hand.wrist.inertia * np.eye(3)
    add_solid(root, PALM, Inertial(hand.palm.mass, palm.T_parent_shape[:3, 3], about), palm)
    flange = cell.robot.tool.flange_link
    at = flange_to_hand(hand)
    add_joint(root, Joint("palm_joint", JointType.FIXED, flange, PALM, at, np.zeros(3), 0.0, 0.0))
    add_fingers(root, hand, PALM, np.eye(4))
    ElementTree.indent(root)
    path.write_bytes(ElementTree.tostring(root))
    return path
