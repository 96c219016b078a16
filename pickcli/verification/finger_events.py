"""Check events of fingers: they close on and open from the item while the arm rests, by one command each.

On an item that rides on a belt they close while the tool rests relative to that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from pickcli.cell.tool import MOVING, Tool, ToolState
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.event import Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import Scene
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.quintic import positions_at

EVENT_TIME_TOLERANCE = 1e-6  # s
# rad or m by which a resting joint may move: rounding of a motion written as text
JOINT_REST_TOLERANCE = 1e-6


def check_finger_events(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check that fingers close and open where they should, while the arm rests.

    Args:
        plan: The plan, its events resolved.
        scene: The plan's scene, of a cell with a gripper.

    Yields:
        The faults.
    """
    tool = scene.cell.robot.tool
    held = [segment for segment in plan.segments if segment.held is not None]
    contact = next((s for s in plan.segments if s.kind is SegmentKind.CONTACT), None)
    if contact is not None and held:
        yield from _moved_at_rest(plan, scene, contact, "close", lambda width: width < _width(tool, held[0]))
    if held and plan.segments[-1].held is None:
        k = next(k for k, segment in enumerate(plan.segments) if segment is held[-1]) + 1
        opening = plan.segments[k]
        if opening.tool_state != MOVING:
            yield Reason("wrong tool state", f"segment {k} ({opening.kind})", "the fingers have to open here")
        yield from _moved_at_rest(plan, scene, opening, "open", lambda width: width > _width(tool, held[-1]))


def leads_to(tool: Tool, command: ToolState, segment: Segment) -> bool:
    """Whether a command leaves the tool in the state of a segment; closing fingers stop at the item's width.

    Args:
        tool: The tool.
        command: The state that was commanded, or in which the plan begins.
        segment: A segment after that.

    Returns:
        True if it does.
    """
    if segment.held is None or not tool.grip.takes_widths or command.width is not None:
        return command == segment.tool_state
    return tool.positions[command] < _width(tool, segment)


def _width(tool: Tool, segment: Segment) -> float:
    width = segment.tool_state.width
    return tool.positions.get(segment.tool_state, np.inf) if width is None else width


def _commands(plan: Plan, scene: Scene) -> list[Event]:
    devices, mover = scene.cell.devices, scene.cell.robot.tool.mover
    return [event for event in plan.events if devices[event.device].kind is mover]


def _moved_at_rest(
    plan: Plan, scene: Scene, segment: Segment, what: str, is_meant: Callable[[float], bool]
) -> Iterator[Reason]:
    """Check that the arm rests during a segment and exactly one command moves the fingers as intended.

    On a running belt the tool rests as seen from there.
    """
    t_start, t_end = segment.t_start, segment.t_end
    times = np.linspace(t_start, t_end, max(2, int(np.ceil((t_end - t_start) * 1e3)) + 1))
    q = positions_at(plan.trajectory, times)
    rides = plan.tracking is not None and segment.kind is SegmentKind.CONTACT
    resting = _tool_on_belt(scene, segment, q) if rides else q
    moved = float(np.ptp(resting, axis=0).max())
    if moved > JOINT_REST_TOLERANCE:
        has_to, moves = ("tool", "on the belt it moves") if rides else ("arm", "a joint moves")
        detail = (
            f"the {has_to} has to rest from {t_start:.3f} to {t_end:.3f} s; {moves} by {moved:.6f} rad or m"
        )
        yield Reason(f"fingers {what} while the arm moves", f"{segment.kind}", detail)
    inside = [event for event in _commands(plan, scene) if _is_within(event, t_start, t_end)]
    positions = scene.cell.robot.tool.positions
    meant = [event for event in inside if is_meant(positions[ToolState(event.action)])]
    yield from _one(meant, f"fingers {what}", f"from {t_start:.3f} to {t_end:.3f} s")


def _tool_on_belt(scene: Scene, segment: Segment, q: Array) -> Array:
    """Return where the tool is at configurations (N, n) of a robot that is seen from a belt: (N, 4, 4)."""
    robot = scene.cell.robot
    return tip_poses(robot, link_poses(robot, q), segment.tool_state)


def _is_within(event: Event, t_start: float, t_end: float) -> bool:
    assert event.t_trigger is not None and event.t_anchor is not None
    return (
        t_start - EVENT_TIME_TOLERANCE <= event.t_trigger and event.t_anchor <= t_end + EVENT_TIME_TOLERANCE
    )


def _one(events: Sequence[Event], what: str, when: str) -> Iterator[Reason]:
    if len(events) != 1:
        detail = f"{len(events)} commands {when}, needs one that begins and ends there"
        yield Reason("event missing" if not events else "event twice", what, detail)
