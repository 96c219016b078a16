"""Where the lip met a face, by the joints and forces that a guarded move recorded.

The bellows give way like a spring, so the felt force grows with the way since the contact. Its beginning is
where that line fits the whole record best, which is far nearer to it than the first force above the noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.calibration.tote_fit import TouchedPoint
from pickcli.calibration.touch_points import TouchPoint
from pickcli.cell.robot import JointType
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.simulation.guarded_move import GuardedMove
from pickcli.simulation.supervision import FILTER_TIME

STIFFNESS_ERROR = 0.1  # share by which the bellows may be stiffer or softer than stated
DELAY_ERROR = 2e-3  # s by which the delay of the sensing may differ from the stated one
FIT_STEP, FIT_LEAST = 2e-4, 1e-6  # m, steps of the search for the beginning of the contact
UNMODELLED = 2e-5  # m, standard deviation of what else is off: the lip, and the path between two steps


@dataclass(frozen=True)
class EncoderNoise:
    """How far the joints may be from where they are measured, each by itself, the same in all of one touch.

    Attributes:
        turning: rad, either way.
        sliding: m, either way.
    """

    turning: float = 1e-4
    sliding: float = 1e-4

    def of(self, arm: Arm) -> Array:
        """Return the largest error of each joint.

        Args:
            arm: The arm.

        Returns:
            (n,) rad or m.
        """
        joints = {joint.name: joint for joint in arm.robot.joints}
        is_sliding = [joints[name].type is JointType.PRISMATIC for name in arm.names]
        return np.where(is_sliding, self.sliding, self.turning)


@dataclass(frozen=True, eq=False)
class TouchReading:
    """What turns a guarded move into a point.

    Attributes:
        arm: Kinematics of the arm.
        stiffness: N/m of the bellows.
        time_step: s between two samples of a record.
        encoders: Errors of the joints as they are read.
    """

    arm: Arm
    stiffness: float
    time_step: float
    encoders: EncoderNoise

    def touched_point(
        self, aim: TouchPoint, record: GuardedMove, state: ToolState, rng: np.random.Generator
    ) -> TouchedPoint:
        """Compute where the middle of the lip met a face.

        Args:
            aim: What was to be touched.
            record: The guarded move, which felt something.
            state: State of the tool.
            rng: Source of the errors of the joints.

        Returns:
            The point with its errors.
        """
        most = self.encoders.of(self.arm)
        read = record.positions + rng.uniform(-most, most)
        tips = self.arm.tips(read, state)
        axis = tips[-1, :3, 2]
        ways = (tips[:, :3, 3] - tips[-1, :3, 3]) @ axis
        n_late = round(record.lag / self.time_step)
        ways, forces = ways[: len(ways) - n_late], record.forces[n_late:]
        contact = _beginning(ways, forces, self.stiffness)
        pressed = np.maximum(ways - contact, 0.0)
        n_independent = max(1.0, float((pressed > 0.0).sum()) * self.time_step / (2 * FILTER_TIME))
        by_force = record.deviation / self.stiffness / np.sqrt(n_independent)
        by_joints = np.linalg.norm(axis @ self.arm.jacobian(read[-1], state)[:3] * most) / np.sqrt(3.0)
        speed = abs(float(ways[-1] - ways[-2])) / self.time_step
        bias = STIFFNESS_ERROR * 2 / 3 * float(pressed.max()) + DELAY_ERROR * speed
        deviation = float(np.sqrt(by_force**2 + by_joints**2 + UNMODELLED**2))
        return TouchedPoint(aim, tips[-1, :3, 3] + contact * axis, deviation, bias)


def _beginning(ways: Array, forces: Array, stiffness: float) -> float:
    """Way in m at which the forces (K,) in N begin to grow with the ways (K,), by least squares."""

    def cost(start: float) -> float:
        return float(((forces - stiffness * np.maximum(ways - start, 0.0)) ** 2).sum())

    low, high, step = float(ways[0]), float(ways[-1]), FIT_STEP
    while step > FIT_LEAST:
        starts = np.arange(low, high + step, step)
        best = float(starts[int(np.argmin([cost(start) for start in starts]))])
        low, high, step = best - step, best + step, step / 10
    return best
