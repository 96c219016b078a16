"""The motion of a whole arm along a running conveyor, made of a motion that is planned as if it stood.

Where no linear axis runs along the belt, all joints follow it: the tool is where the planned motion has it,
displaced along the belt. The displacement is that of ``line_tracking``: it begins and ends at rest by smooth
ramps. Joint velocities are those of least norm, each by its limit, that move the tool so (Whitney, Resolved
motion rate control of manipulators and human prostheses, 1969); what redundancy leaves open does what it does
in the planned motion. The kernel integrates them from the contact both ways.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.kernel import TrackEnd
from pickcli.kinematics.arm import Arm
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.line_tracking import SAME_TIME, TrackedMotion

STEP = 0.02  # s between points of the motion at most
NEARBY = 1e-4  # s over which accelerations are differences of velocities
FASTEST = 3.0  # times the limit of a joint, from which on an arm counts as singular


@dataclass(frozen=True, eq=False)
class _Wanted:
    """What is wanted at N times.

    positions, velocities: (N, n) of the planned motion
    poses: (N, 4, 4) of the tool in the hall
    twists: (N, 6) of the tool in the hall
    """

    positions: Array
    velocities: Array
    poses: Array
    twists: Array


@dataclass(frozen=True, eq=False)
class ArmTracking:
    """An arm that follows a belt with all of its joints.

    Attributes:
        arm: Its kinematics.
        tool_state: Any state of the tool: the tool as a whole is displaced.
        along: (3,) unit vector in the world, in which the belt runs.
        relative: The motion as if the belt stood, at rest at both ends.
        tracked: The displacement along the belt, as the motion of an axis.
        t_met: s at which both motions coincide: where the item is taken.
    """

    arm: Arm
    tool_state: ToolState
    along: Array
    relative: Trajectory
    tracked: TrackedMotion
    t_met: float

    def followed(self) -> Trajectory | Reason:
        """Compute the motion in the hall.

        Returns:
            The motion, with further points; or why the arm cannot follow.
        """
        if (unreached := self._unreached_end()) is not None:
            return unreached
        times = self._times()
        here, between = self._wanted(times), self._wanted((times[:-1] + times[1:]) / 2.0)
        met = int(np.argmin(np.abs(times - self.t_met)))
        Q, end, at, joint = self.arm.chain(self.tool_state).track_tip(
            times, here.velocities, here.poses, here.twists, between.velocities, between.twists, met,
            here.positions[met], self.arm.robot.tool.T_last_tip, *self.arm.window,
            self.arm.limits.velocity, FASTEST,
        )  # fmt: skip
        if end is not TrackEnd.DONE:
            where = f"following the belt at {times[at]:.2f} s"
            if end is TrackEnd.SINGULAR:
                return Reason("singular", where, "joints would be many times too fast")
            return Reason("joint limit", where, self.arm.names[joint])
        dQ = self.arm.rates(Q, here.velocities, here.twists, self.tool_state)
        ddQ = self._accelerations(times, Q, dQ)
        dQ[[0, -1]] = ddQ[[0, -1]] = 0.0
        return Trajectory(self.relative.joint_names, times, Q, dQ, ddQ)

    def _unreached_end(self) -> Reason | None:
        """Say which end of the motion the arm does not reach at all, at little effort."""
        ends = np.array([0.0, self.relative.duration])
        for t, T in zip(ends.tolist(), self._wanted(ends).poses, strict=True):
            if len(self.arm.solve(T, self.tool_state, self.relative.sample(t))) == 0:
                where = f"following the belt at {t:.2f} s"
                return Reason("out of reach", where, f"tool at {_metres(T[:3, 3])}")
        return None

    def _times(self) -> Array:
        """Return the times (N,) of all points: those of the planned motion, of the ramps, and between."""
        ramps = (self.tracked.t_synchronous, self.tracked.t_leaving, self.t_met)
        given = np.sort(np.concatenate([self.relative.times, np.asarray(ramps)]))
        given = given[np.insert(np.diff(given) > SAME_TIME, 0, True)]
        pieces = [
            np.linspace(t, end, int(np.ceil((end - t) / STEP)) + 1)[:-1]
            for t, end in pairwise(given.tolist())
        ]
        return np.concatenate([*pieces, given[-1:]])

    def _wanted(self, times: Array) -> _Wanted:
        """Return what is wanted at times (N,)."""
        states = self.relative.states(times)
        moved = self.arm.tip_motion(*states, self.tool_state)
        offset, speed, _ = self.tracked.offset(times)
        met = float(self.tracked.offset(np.array([self.t_met]))[0][0])
        poses = moved.poses.copy()
        poses[:, :3, 3] += np.outer(offset - met, self.along)
        twists = np.hstack([moved.velocity + np.outer(speed, self.along), moved.angular_velocity])
        return _Wanted(states[0], states[1], poses, twists)

    def _accelerations(self, times: Array, Q: Array, dQ: Array) -> Array:
        """Joint accelerations (N, n) along the motion, as differences of velocities."""
        starts, ends = np.maximum(times - NEARBY, 0.0), np.minimum(times + NEARBY, times[-1])
        low, high = (starts - times)[:, None], (ends - times)[:, None]
        before, after = self._wanted(starts), self._wanted(ends)
        state = self.tool_state
        later = self.arm.rates(Q + high * dQ, after.velocities, after.twists, state)
        earlier = self.arm.rates(Q + low * dQ, before.velocities, before.twists, state)
        return np.asarray((later - earlier) / (high - low))


def _metres(p: Array) -> str:
    return "(" + ", ".join(f"{x:.3f}" for x in p) + ") m"
