"""The way to a touch, and the slow line on which the tool meets the tote, wherever within bounds that is.

The way there is a planned move like every other, with the tote as the volume that it may fill. On the line
the touched side of the tote is left out, and the rest of it is not: all that the line can meet is that side.
That the cup alone meets it is proven with that side where it is believed to be: until the bellows are fully
compressed all other parts keep clear of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.calibration.touch_points import TouchPoint
from pickcli.cartesian.line_following import follow_line
from pickcli.cell.pod_tolerance import UNMOVED, Displacement
from pickcli.cell.station import TOTE
from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.collision.stage_contacts import while_touching
from pickcli.errors import Failures, NoPlanError, Reason, RejectedError
from pickcli.geometry import Array, cross, pose, rotation_axis_angle
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.assembly.stitching import stitch_run
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import Scene, tote_pose
from pickcli.seeds import derived_rng
from pickcli.verification.verify import certify, verify

SPEED = 0.02  # m/s on a level line
# m/s on a line downwards. There only the strong joints measure the force, with ten times the noise, which
# more readings make up for.
DOWN_SPEED = 0.006
STEEP = 0.7  # of the axis downwards, from which on a line is one
BEFORE = 0.012  # m of the line before anything can be met: it is where the force is zeroed
BEYOND = 0.003  # m of the line behind all that can be met, besides the stroke of the bellows
ROLLS = np.radians(np.arange(0.0, 360.0, 30.0))  # of the tool about its axis
N_SEEDS = 16  # of inverse kinematics, for each of these
MOST_LINES = 6  # configurations from which a motion is planned


@dataclass(frozen=True, eq=False)
class ToteBelief:
    """Where the tote is believed to stand.

    Attributes:
        T_world_tote: (4, 4) pose.
        error: Bounds of its error in x, y and yaw, in the tote's frame.
        height: m, bound of its error in z.
    """

    T_world_tote: Array
    error: Displacement
    height: float

    def scene(self, scene: Scene) -> Scene:
        """Return a scene with the tote where it is believed to stand.

        Args:
            scene: The scene.

        Returns:
            The scene.
        """
        at = tote_pose(scene.cell, self.T_world_tote, self.error)
        return replace(scene, carriers={**scene.carriers, TOTE: at})

    def reach(self, aim: TouchPoint, lip_radius: float) -> float:
        """Bound by how far a face may be off along its normal, under the whole lip.

        Args:
            aim: The point that is touched.
            lip_radius: m.

        Returns:
            m.
        """
        across = float(np.abs(aim.face.normal[:2]) @ [self.error.x, self.error.y])
        lever = float(np.linalg.norm(cross(aim.face.normal, aim.point)[2:])) + lip_radius
        return across + self.error.yaw * lever + abs(float(aim.face.normal[2])) * self.height


@dataclass(frozen=True, eq=False)
class PlannedTouch:
    """The motions of one touch.

    Attributes:
        aim: The point.
        way: Certified motion to the start of the line.
        line: The line; verified with the touched side of the tote left out.
        tool_state: State of the tool on it.
    """

    aim: TouchPoint
    way: Plan
    line: Plan
    tool_state: ToolState


def plan_touch(
    context: PlanningContext, scene: Scene, belief: ToteBelief, aim: TouchPoint, start: Start, seed: int
) -> PlannedTouch:
    """Plan the way to a touch and the line of it, and have both verified.

    Args:
        context: The cell with what motions are planned by.
        scene: The scene without regard to where the tote is.
        belief: Where it is.
        aim: The point to be touched.
        start: Where the robot is, at rest.
        seed: Seed of all random choices.

    Returns:
        The motions.

    Raises:
        NoPlanError: The tool cannot be brought there, or not along the line, with the reasons.
    """
    believed = belief.scene(scene)
    lines, failures = _lines(context, believed, belief, aim, seed)
    for line in sorted(lines, key=lambda line: _travel_time(context, start.q, line.start))[:MOST_LINES]:
        planned = _planned(context, believed, aim, line, start, seed)
        if isinstance(planned, PlannedTouch):
            return planned
        failures += planned
    raise NoPlanError(f"touch {aim.name}", failures)


def _lines(
    context: PlanningContext, believed: Scene, belief: ToteBelief, aim: TouchPoint, seed: int
) -> tuple[list[MotionSegment], Failures]:
    """Find lines of a touch that are proven free, and why there are no others."""
    found, failures = [], Failures()
    for state in context.cell.robot.tool.states:
        search = _LineSearch.of(context, believed, belief, aim, state)
        for roll in ROLLS:
            rng = derived_rng(seed, aim.name, state, round(float(np.degrees(roll))))
            line = search.line(float(roll), rng)
            if isinstance(line, Failures):
                failures += line
            else:
                found.append(line)
    return found, failures


@dataclass(frozen=True, eq=False)
class _LineSearch:
    """Search for the line of a touch in one state of the tool.

    Attributes:
        arm: Kinematics of the arm.
        aim: The point that is touched.
        tool_state: State of the tool.
        before: Checker with the tote as the volume that it may fill.
        on_line: The same without the touched side.
        pressing: Checker with the tote where it is believed to be, which the cup alone may touch.
        p: (3,) m in the world, the point where it is believed to be.
        axis: (3,) unit vector of the line.
        ways: m from the point along the axis to start and end of the line, and to full compression.
    """

    arm: Arm
    aim: TouchPoint
    tool_state: ToolState
    before: SceneChecker
    on_line: SceneChecker
    pressing: SceneChecker
    p: Array
    axis: Array
    ways: tuple[float, float, float]

    @classmethod
    def of(
        cls, context: PlanningContext, believed: Scene, belief: ToteBelief, aim: TouchPoint, state: ToolState
    ) -> _LineSearch:
        """Prepare the search."""
        exact = replace(belief, error=UNMOVED, height=0.0).scene(believed)
        mode = Mode(state)
        checkers = (
            context.checker_for(believed, mode),
            context.checker_for(without_side(believed, aim), mode),
            context.checker_for(exact, replace(mode, contacts=while_touching(aim.face.bodies))),
        )
        grip = context.cell.robot.tool.grip
        p = (belief.T_world_tote @ [*aim.point, 1.0])[:3]
        axis = -belief.T_world_tote[:3, :3] @ aim.face.normal
        first = _first_contact(believed, belief, aim, p, axis)
        last = belief.reach(aim, grip.tip_radius) + BEYOND + grip.gives_way
        return cls(context.arm, aim, state, *checkers, p, axis, (-first - BEFORE, last, grip.gives_way))

    def line(self, roll: float, rng: np.random.Generator) -> MotionSegment | Failures:
        """Find a line with the tool turned about its axis by an angle in rad, or say why there is none."""
        R = _looking(self.axis, roll)
        T_start, T_end, T_pressed = (pose(self.p + way * self.axis, R=R) for way in self.ways)
        where, limits = f"touch {self.aim.name}", SegmentLimits(max_tool_speed=self._speed)
        Q = self.arm.solve_spread(T_start, self.tool_state, rng, N_SEEDS)
        failures = Failures()
        for q in Q[self.before.are_valid(Q)] if len(Q) else ():
            path = follow_line(self.arm, self.on_line, T_start, T_end, self.tool_state, q, where)
            pressed = follow_line(self.arm, self.pressing, T_start, T_pressed, self.tool_state, q, where)
            if not isinstance(path, Failures) and not isinstance(pressed, Failures):
                return MotionSegment(SegmentKind.PREAPPROACH, path, limits, mode=Mode(self.tool_state))
            for each in (path, pressed):
                failures += each if isinstance(each, Failures) else Failures()
        return (
            failures
            if failures.parts
            else Failures.of(Reason("no free configuration", where, "at its start"))
        )

    @property
    def _speed(self) -> float:
        """Speed in m/s on the line."""
        return DOWN_SPEED if self.axis[2] < -STEEP else SPEED


def _planned(
    context: PlanningContext, believed: Scene, aim: TouchPoint, line: MotionSegment, start: Start, seed: int
) -> PlannedTouch | Failures:
    """Plan the way to a line, and have both verified; or say why not."""
    opened, state = without_side(believed, aim), line.mode.tool_state
    timed = stitch_run(context, opened, [line], f"touch {aim.name}", seed)
    if isinstance(timed, Failures):
        return timed
    verdict = verify(timed, opened)
    if verdict.reasons:
        return Failures(verdict.reasons).within("rejected by the verifier")
    goal, label = MoveGoal(line.start, state), f"move to touch {aim.name}"
    try:
        way = certify(plan_move(context, believed, start, goal, seed, label), believed)
    except NoPlanError as error:
        return error.failures
    except RejectedError as error:
        return Failures(error.reasons).within("rejected by the verifier")
    return PlannedTouch(aim, way, timed, state)


def without_side(scene: Scene, aim: TouchPoint) -> Scene:
    """Return a scene without the side of the tote that a touch may meet.

    Args:
        scene: The scene.
        aim: The point that is touched.

    Returns:
        The scene, of a cell whose tote lacks those solids.
    """
    tote = scene.cell.tote
    assert tote is not None
    kept = tuple(body for body in tote.bodies if body.name not in aim.face.bodies)
    return replace(scene, cell=replace(scene.cell, tote=replace(tote, bodies=kept)))


def _first_contact(believed: Scene, belief: ToteBelief, aim: TouchPoint, p: Array, axis: Array) -> float:
    """Way in m before a point (3,) of a face along an axis (3,) at which its side may be met first."""
    tote = next(each for each in believed.posed_carriers if each.name == TOTE)
    ways = [0.0]
    for body in tote.grown:
        if body.name in aim.face.bodies:
            T = tote.T_world_carrier @ body.T_parent_shape
            ways.append(
                float((p - T[:3, 3]) @ axis) + float(body.shape.extents / 2 @ np.abs(T[:3, :3].T @ axis))
            )
    return max(ways) + abs(float(axis[2])) * belief.height


def _looking(axis: Array, roll: float) -> Array:
    """Rotation (3, 3) of a tool along an axis (3,); with roll 0 its x is up, or along the world's x."""
    up = np.array([0.0, 0.0, 1.0]) if abs(axis[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    x = up - (up @ axis) * axis
    x /= np.linalg.norm(x)
    return np.stack([x, cross(axis, x), axis], axis=1) @ rotation_axis_angle((0.0, 0.0, 1.0), roll)


def _travel_time(context: PlanningContext, q: Array, goal: Array) -> float:
    """Least time in s of a straight motion between two configurations (n,)."""
    near = unwound_towards(context.arm.limits, goal, q)
    return estimated_duration(context.space, np.stack([q, near]))
