"""A two-finger hand with belts as its file describes it: figures of its parts, and what it grasps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pickcli.cell.shapes import Body


@dataclass(frozen=True)
class HandFingers:
    """Two fingers that mirror each other, each of two phalanges.

    Attributes:
        base: m between the axes of the two proximal joints.
        proximal: m from the proximal joint to the hinge.
        distal: m from the hinge to the tip.
        height: m of the pads, across the fingers' plane.
        thickness: m of a phalanx, from its pad outwards.
        hinge_radius: m, of the hinge between the phalanges, which no belt covers.
        hinge_relief: m by which the hinge stands out beyond straight pads.
        mass: kg of one phalanx.
        widest: rad, by which a proximal phalanx opens outwards from straight ahead.
        most_bent: rad, by which a distal phalanx can bend inwards.
    """

    base: float
    proximal: float
    distal: float
    height: float
    thickness: float
    hinge_radius: float
    hinge_relief: float
    mass: float
    widest: float
    most_bent: float


@dataclass(frozen=True)
class Palm:
    """The palm, a box behind the fingers.

    Attributes:
        depth: m along the approach.
        width: m from finger to finger.
        height: m.
        mass: kg.
        friction: Coefficient against objects; that of the hinges, too, without a belt.
    """

    depth: float
    width: float
    height: float
    mass: float
    friction: float


@dataclass(frozen=True)
class ClosingDrive:
    """The motor that opens and closes both fingers.

    Attributes:
        torque_constant: Nm at the fingers per A.
        speed: rad/s of the motor's angle when nothing is in the way.
        inertia: kg m^2, reflected to the fingers.
        stiffness: Nm/rad of the transmission to each finger.
        damping: Nm s/rad of it.
        hinge_ratio: Torque on a hinge over that on the proximal joint of its finger.
        spring: Nm with which a spring holds a finger straight.
    """

    torque_constant: float
    speed: float
    inertia: float
    stiffness: float
    damping: float
    hinge_ratio: float
    spring: float


@dataclass(frozen=True)
class Belts:
    """The belts, one on each phalanx.

    Attributes:
        speed: m/s.
        force: N, largest force of one belt's motor along its pad.
        friction: Coefficient between belts and objects.
        mass: kg of motor and belt, reflected to the belt.
        stiffness: N/m of the surface along the pad, where an object sticks to it.
        damping: Ns/m of it.
    """

    speed: float
    force: float
    friction: float
    mass: float
    stiffness: float
    damping: float


@dataclass(frozen=True)
class Wrist:
    """The impedance with which the arm holds the hand.

    Attributes:
        mass: kg of the arm as it is felt at the hand, in every direction.
        inertia: kg m^2 of it, about every axis.
        stiff: N/m in every direction while the arm moves.
        level: N/m in the horizontal plane during a grasp.
        turning: Nm/rad about every axis.
        damping: Share of the critical damping.
        most_force: N in any direction; beyond it the arm stops.
        most_torque: Nm about any axis; beyond it the arm stops.
    """

    mass: float
    inertia: float
    stiff: float
    level: float
    turning: float
    damping: float
    most_force: float
    most_torque: float


@dataclass(frozen=True)
class GraspControl:
    """How a grasp is executed.

    Attributes:
        reach: m from the palm to the middle of a single object, where the fingers close.
        cluster_reach: m from the palm to the middle of the nearest object of a cluster, there.
        standing: rad/s below which the encoder of the closing motor stands.
        standing_time: s for which it stands, or a belt blocks, until that counts.
        two_objects: rad; if the fingers stand on something wider than at this angle, two objects are taken.
        separation: s after which belts in opposite directions stop though two objects are still held.
        pull_in: s after which pulling in ends though no belt blocks.
        firm: s for which the higher current builds up.
        lift: m.
        lift_time: s.
        hold: s in which the lifted object is watched.
    """

    reach: float
    cluster_reach: float
    standing: float
    standing_time: float
    two_objects: float
    separation: float
    pull_in: float
    firm: float
    lift: float
    lift_time: float
    hold: float


@dataclass(frozen=True)
class GraspObject:
    """An object that is grasped standing.

    Attributes:
        name: Its name.
        mass: kg.
        parts: Solids in the frame of the object, which stands on z = 0.
        low_current: A, with which the fingers close on it.
        high_current: A, with which they hold it.
    """

    name: str
    mass: float
    parts: tuple[Body, ...]
    low_current: float
    high_current: float

    @property
    def height(self) -> float:
        """Height of the object as it stands, m."""
        return max(float(part.T_parent_shape[2, 3] + part.shape.extents[2] / 2) for part in self.parts)

    @property
    def width(self) -> float:
        """Largest width of a part along x, m."""
        return max(float(part.shape.extents[0]) for part in self.parts)


@dataclass(frozen=True)
class BeltHand:
    """A hand: its parts, its control, and the objects for which it is set up.

    The frame of the hand lies in the palm's surface, x along the approach, y to the left finger, z up.

    Attributes:
        name: Its name.
        fingers: The fingers.
        palm: The palm.
        drive: The closing motor.
        belts: The belts.
        wrist: The wrist's impedance.
        control: The execution of grasps.
        objects: The objects by name.
    """

    name: str
    fingers: HandFingers
    palm: Palm
    drive: ClosingDrive
    belts: Belts
    wrist: Wrist
    control: GraspControl
    objects: Mapping[str, GraspObject]
