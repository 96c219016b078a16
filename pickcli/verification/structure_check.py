"""Check that a plan is consistent: names, times, segments, and when which item is held."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pickcli.cell.tool import MOVING
from pickcli.errors import Reason
from pickcli.geometry import is_pose
from pickcli.motion.plan import MAX_DURATION, MAX_NUMBER, Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import Scene
from pickcli.verification.contact_exemptions import may_touch
from pickcli.verification.query_check import check_query

TIME_TOLERANCE = 1e-9  # s
SHORTEST_STEP = 1e-9  # s between two points: its third power is far from the smallest float
CARRYING = (SegmentKind.LIFT, SegmentKind.TRANSFER, SegmentKind.INSERT, SegmentKind.PLACE)


def check_structure(plan: Plan, scene: Scene) -> tuple[Reason, ...]:
    """Check everything that the other checks assume; they run only if this check finds no fault.

    Args:
        plan: The plan.
        scene: The plan's scene.

    Returns:
        The faults.
    """
    reasons = [*_trajectory(plan, scene)] or [*_magnitudes(plan)]
    if not reasons:
        names = [*_names(plan, scene), *check_query(plan, scene), *_tool_states(plan, scene)]
        reasons = [*_segments(plan), *names, *_beginning(plan, scene), *_holding(plan)]
    return tuple(reasons)


def _trajectory(plan: Plan, scene: Scene) -> Iterator[Reason]:
    trajectory, names = plan.trajectory, scene.cell.robot.joint_names
    if trajectory.joint_names != names:
        yield Reason(
            "joint names",
            "trajectory",
            f"{', '.join(trajectory.joint_names)}; the cell's: {', '.join(names)}",
        )
        return
    shape = (len(trajectory.times), len(names))
    arrays = (trajectory.positions, trajectory.velocities, trajectory.accelerations)
    if shape[0] < 2 or any(a.shape != shape for a in arrays):
        yield Reason("shape", "trajectory", f"expected {shape} everywhere, at least two points")
        return
    if not all(np.isfinite(a).all() for a in (trajectory.times, *arrays)):
        yield Reason("not finite", "trajectory", "a number is nan or infinite")
        return
    if trajectory.times[0] != 0.0:
        yield Reason("time stamps", "trajectory", f"the first is {trajectory.times[0]}, not 0")
    steps = np.diff(trajectory.times)
    if not (steps > 0.0).all():
        i = int(np.argmax(steps <= 0.0)) + 1
        yield Reason(
            "time stamps", f"point {i}", f"{trajectory.times[i]} s does not come after the one before"
        )


def _magnitudes(plan: Plan) -> Iterator[Reason]:
    """Reject numbers that are finite but so large, or times so near to each other, that sums overflow."""
    trajectory, grasp = plan.trajectory, plan.grasp
    if trajectory.duration > MAX_DURATION:
        yield Reason("too long", "trajectory", f"{trajectory.duration:.6g} s, at most {MAX_DURATION:g} s")
    if np.diff(trajectory.times).min() < SHORTEST_STEP:
        yield Reason("time stamps", "trajectory", f"points less than {SHORTEST_STEP:g} s apart")
    numbers = [trajectory.positions, trajectory.velocities, trajectory.accelerations]
    numbers += [np.array([[s.t_start, s.t_end] for s in plan.segments], dtype=np.float64)]
    if grasp is not None:
        loads = (grasp.moment, grasp.pull, grasp.shear, grasp.twist, grasp.load_ratio)
        numbers += [grasp.T_item_tip, np.array([grasp.score, *loads])]
    for event in plan.events:
        times = [t for t in (event.lead, event.t_anchor, event.t_trigger) if t is not None]
        numbers.append(np.array([event.anchor.offset, *times]))
    if not all((np.abs(each) <= MAX_NUMBER).all() for each in numbers):  # false for nan, too
        yield Reason("not a plan's number", "", f"one is not finite, or beyond {MAX_NUMBER:g}")
    if grasp is not None and not is_pose(grasp.T_item_tip):
        yield Reason("not a pose", "grasp", "T_item_tip is no rigid transform")


def _segments(plan: Plan) -> Iterator[Reason]:
    t = 0.0
    for k, segment in enumerate(plan.segments):
        where = f"segment {k} ({segment.kind})"
        if abs(segment.t_start - t) > TIME_TOLERANCE or not segment.t_end > segment.t_start:
            yield Reason("segments not contiguous", where, f"{segment.t_start}..{segment.t_end} after {t}")
        t = segment.t_end
    if abs(t - plan.trajectory.duration) > TIME_TOLERANCE:
        yield Reason(
            "segments not contiguous", "end", f"{t} s, the trajectory's end is {plan.trajectory.duration}"
        )


def _names(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check that the items and bodies that segments and grasp name exist."""
    taken = {placed.id for placed in scene.items} | ({scene.held.id} if scene.held is not None else set())
    bodies = {body.name for body, _ in scene.standing}
    if plan.grasp is not None and plan.grasp.item not in taken:
        yield Reason("unknown item", "grasp", f"{plan.grasp.item} is not in the scene")
    for k, segment in enumerate(plan.segments):
        where = f"segment {k} ({segment.kind})"
        for name in segment.touching:
            if name not in taken | bodies:
                yield Reason("unknown name", where, f"{name} may be touched but is not in the scene")
        if segment.touching and not may_touch(plan, k):
            yield Reason(
                "touching not allowed",
                where,
                f"{', '.join(segment.touching[:3])}; only contact, the lift after it, the way to a "
                "release and the way from it may",
            )
        if segment.held is not None and (plan.grasp is None or segment.held != plan.grasp.item):
            yield Reason("wrong held item", where, f"{segment.held}, not the item of the grasp")


def _tool_states(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check that the cell's tool has the tool states that segments and grasp name."""
    stated = [
        (f"segment {k} ({segment.kind})", segment.tool_state) for k, segment in enumerate(plan.segments)
    ]
    if plan.grasp is not None:
        stated.append(("grasp", plan.grasp.tool_state))
    tool = scene.cell.robot.tool
    for where, state in stated:
        if state == MOVING and not tool.joints:
            yield Reason("unknown tool state", where, f"{MOVING}, but no joint moves the tool of the cell")
        elif state != MOVING and not tool.knows(state):
            yield Reason("unknown tool state", where, f"the tool of the cell has no state {str(state)!r}")


def _beginning(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check that the plan begins with the item held that the scene states as held."""
    first, held = plan.segments[0].held, None if scene.held is None else scene.held.id
    if first != held:
        said = f"the plan begins holding {first or 'nothing'}; by `held` of the scene the cup holds"
        yield Reason("not in the cup", "start", f"{said} {held or 'nothing'}")


def _holding(plan: Plan) -> Iterator[Reason]:
    """Check that the item is held without a gap from the end of contact to its release, and not again."""
    held = [segment.held is not None for segment in plan.segments]
    contacts = [k for k, segment in enumerate(plan.segments) if segment.kind is SegmentKind.CONTACT]
    changes = [k for k in range(1, len(held)) if held[k] != held[k - 1]]
    for k in contacts:
        if held[k] or k + 1 >= len(held) or not held[k + 1]:
            yield Reason(
                "held item forgotten", f"segment {k} (contact)", "the item must be held from here on"
            )
    for k in changes:
        if held[k] and k - 1 not in contacts:
            yield Reason(
                "held without contact", f"segment {k} ({plan.segments[k].kind})", "no contact before"
            )
    if contacts and held[-1]:
        yield Reason("not let go", "end", "what is taken with a contact is let go before the plan ends")
    if len(changes) > 2 or len(contacts) > 1:
        yield Reason("held item forgotten", "", "the item is taken or released more than once")
    for k, segment in enumerate(plan.segments):
        if segment.kind in CARRYING and not held[k]:
            yield Reason("held item forgotten", f"segment {k} ({segment.kind})", "nothing is held")
        if segment.kind in (SegmentKind.TRANSIT, SegmentKind.DEPART) and held[k]:
            yield Reason("wrong held item", f"segment {k} ({segment.kind})", "this kind carries nothing")
