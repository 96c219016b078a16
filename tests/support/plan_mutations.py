"""Ways to break a plan, each of which the verifier must reject for its own reason."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from pickcli.cell.tool import MOVING, ToolState
from pickcli.geometry import pose
from pickcli.motion.event import Anchor, AnchorKind
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from support.handmade_plans import CRAYOLA
from support.tool_states import DOWN

Mutation = Callable[[Plan], Plan]


def segment(plan: Plan, kind: SegmentKind) -> int:
    return [s.kind for s in plan.segments].index(kind)


def with_segment(k_of: SegmentKind, **changes: Any) -> Mutation:
    def change(plan: Plan) -> Plan:
        k = segment(plan, k_of)
        segments = list(plan.segments)
        segments[k] = replace(segments[k], **changes)
        return replace(plan, segments=tuple(segments))

    return change


def one_contact(plan: Plan) -> Plan:
    """Approach and contact as one long contact that may touch."""
    k = segment(plan, SegmentKind.CONTACT)
    joined = replace(plan.segments[k], t_start=plan.segments[k - 1].t_start)
    events = tuple(
        replace(e, anchor=replace(e.anchor, segment=e.anchor.segment - (e.anchor.segment >= k)))
        for e in plan.events
    )
    return replace(plan, segments=(*plan.segments[: k - 1], joined, *plan.segments[k + 1 :]), events=events)


def let_go_earlier(by: float) -> Mutation:
    """The place ends, and the valve closes, so many s earlier, while the tool still goes down."""

    def mutate(plan: Plan) -> Plan:
        k = segment(plan, SegmentKind.PLACE)
        t = plan.segments[k].t_end - by
        segments = list(plan.segments)
        segments[k], segments[k + 1] = replace(segments[k], t_end=t), replace(segments[k + 1], t_start=t)
        events = list(plan.events)
        for i in (3, 4):
            event = plan.events[i]
            anchored = t + event.anchor.offset
            events[i] = replace(event, t_anchor=anchored, t_trigger=anchored - event.lead)
        return replace(plan, segments=tuple(segments), events=tuple(events))

    return mutate


def with_points(edit: Callable[[dict[str, np.ndarray], Plan], None]) -> Mutation:
    """Edit copies of times, positions, velocities and accelerations."""

    def change(plan: Plan) -> Plan:
        t = plan.trajectory
        arrays: dict[str, Any] = {
            "times": t.times.copy(),
            "positions": t.positions.copy(),
            "velocities": t.velocities.copy(),
            "accelerations": t.accelerations.copy(),
        }
        edit(arrays, plan)
        return replace(plan, trajectory=replace(t, **arrays))

    return change


def scaled(factor: float) -> Mutation:
    """The same geometry, faster: everything with a time in it shrinks with it."""

    def change(plan: Plan) -> Plan:
        t = plan.trajectory
        trajectory = replace(
            t,
            times=t.times / factor,
            velocities=t.velocities * factor,
            accelerations=t.accelerations * factor**2,
        )
        segments = tuple(
            replace(s, t_start=s.t_start / factor, t_end=s.t_end / factor) for s in plan.segments
        )
        anchors = [segments[e.anchor.segment].t_end + e.anchor.offset for e in plan.events]
        events = tuple(
            replace(e, t_anchor=t, t_trigger=t - e.lead) for e, t in zip(plan.events, anchors, strict=True)
        )
        return replace(plan, trajectory=trajectory, segments=segments, events=events)

    return change


def with_event(i: int, shift_anchor: float = 0.0, shift_trigger: float = 0.0, **changes: Any) -> Mutation:
    def change(plan: Plan) -> Plan:
        event = plan.events[i]
        assert event.t_anchor is not None and event.t_trigger is not None
        times: dict[str, Any] = {
            "t_anchor": event.t_anchor + shift_anchor,
            "t_trigger": event.t_trigger + shift_trigger,
        }
        moved = replace(event, **{**times, **changes})
        return replace(plan, events=(*plan.events[:i], moved, *plan.events[i + 1 :]))

    return change


def moved_event(i: int, by: float) -> Mutation:
    """The whole event later by so many s, consistently: anchor, times and all."""

    def change(plan: Plan) -> Plan:
        anchor = plan.events[i].anchor
        return with_event(i, by, by, anchor=replace(anchor, offset=anchor.offset + by))(plan)

    return change


def without_event(i: int) -> Mutation:
    return lambda plan: replace(plan, events=plan.events[:i] + plan.events[i + 1 :])


def with_further_event(action: str, of: int, by: float) -> Mutation:
    """Another event of the same device, so many s later."""

    def change(plan: Plan) -> Plan:
        event = moved_event(of, by)(plan).events[of]
        return replace(plan, events=(*plan.events, replace(event, action=action)))

    return change


def without_the_way_up(plan: Plan) -> Plan:
    """What comes after the release carries the item on."""
    item = plan.grasp.item if plan.grasp else None
    released = max(k for k, s in enumerate(plan.segments) if s.held is not None)
    rest = tuple(replace(s, kind=SegmentKind.RETREAT, held=item) for s in plan.segments[released + 1 :])
    return replace(plan, segments=(*plan.segments[: released + 1], *rest))


def with_grasp(**changes: Any) -> Mutation:
    def change(plan: Plan) -> Plan:
        assert plan.grasp is not None
        return replace(plan, grasp=replace(plan.grasp, **changes))

    return change


def moved_grasp(xyz: tuple[float, float, float], rpy: tuple[float, float, float] = (0, 0, 0)) -> Mutation:
    def change(plan: Plan) -> Plan:
        assert plan.grasp is not None
        return with_grasp(T_item_tip=plan.grasp.T_item_tip @ pose(xyz, rpy=rpy))(plan)

    return change


def push_into_the_pod(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    """One waypoint in the middle of the pre-approach 0.2 m farther along the rail's sideways neighbour s."""
    s = plan.segments[segment(plan, SegmentKind.PREAPPROACH)]
    i = int(np.searchsorted(arrays["times"], (s.t_start + s.t_end) / 2))
    arrays["positions"][i, 1] += 0.15


def one_acceleration_less(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    arrays["accelerations"] = arrays["accelerations"][:-1]


def equal_stamps(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    arrays["times"][40] = arrays["times"][39]


def beyond_a_limit(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    arrays["positions"][:, 0] += 0.05 - arrays["positions"][:, 0].min() - 1e-3


def not_at_rest(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    arrays["velocities"][-1, 3] = 0.01


def shake(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    arrays["velocities"][200, 6] += 0.3


def jerk(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    arrays["accelerations"][20, 7] += 6.0


def called(query: str) -> Mutation:
    """State another query."""
    return lambda plan: replace(plan, query=query)


# Each row: what is done to a good pick, and a reason that must be among those given.
MATRIX: dict[str, tuple[Mutation, str, str]] = {
    "a waypoint through the pod": (with_points(push_into_the_pod), "collision", "row_ABC"),
    "speed x 2.2": (scaled(2.2), "velocity limit", ""),
    "speed x 1.8 breaks the acceleration limit": (scaled(1.8), "acceleration limit", ""),
    "speed x 1.5 breaks the jerk limit": (scaled(1.5), "jerk limit", ""),
    "speed x 1.8 at contact": (scaled(1.8), "contact speed", "contact"),
    "a velocity that jumps": (with_points(shake), "jerk limit", "joint_b"),
    "an acceleration that jumps": (with_points(jerk), "jerk limit", "joint_t"),
    "does not stop": (with_points(not_at_rest), "not at rest", "end"),
    "a joint limit": (with_points(beyond_a_limit), "joint limit", "rail"),
    "equal time stamps": (with_points(equal_stamps), "time stamps", "40"),
    "a point without an acceleration": (with_points(one_acceleration_less), "shape", "trajectory"),
    "an event fired 0.3 s late": (with_event(1, 0.0, 0.3), "wrong trigger", "valve on"),
    "an event fired 0.3 s early": (with_event(1, 0.0, -0.3), "wrong trigger", "valve on"),
    "both times of an event shifted": (with_event(1, 0.3, 0.3), "wrong anchor time", "valve on"),
    "valve opened after contact": (moved_event(1, 0.7), "event at the wrong time", "valve on"),
    "valve opened 0.3 s early": (moved_event(1, -0.3), "event at the wrong place", "valve on"),
    "valve closed 0.3 s early": (moved_event(3, -0.3), "event at the wrong place", "valve off"),
    "valve closed 0.3 s late": (moved_event(3, 0.3), "event at the wrong time", "valve off"),
    "vacuum lost on the way": (moved_event(4, -3.0), "vacuum lost", "pump off"),
    "sensor read before the lift": (moved_event(2, -3.0), "event at the wrong time", "sensor read"),
    "pump off again before the contact": (
        with_further_event("off", of=0, by=0.002), "vacuum lost", "before the contact",
    ),
    "ends holding": (without_the_way_up, "not let go", "end"),
    "a second lift that touches": (
        with_segment(SegmentKind.RETREAT, kind=SegmentKind.LIFT, touching=("wall_left",)),
        "touching not allowed", "lift",
    ),
    "a depart at the beginning that touches": (
        with_segment(SegmentKind.TRANSIT, kind=SegmentKind.DEPART, touching=("wall_left",)),
        "touching not allowed", "depart",
    ),
    "pump forgotten": (without_event(0), "event missing", "pump on"),
    "pump too late for its lead": (moved_event(0, 0.3), "event at the wrong time", "pump on"),
    "another lead": (with_event(1, lead=0.1), "wrong lead", "valve on"),
    "a lead shorter than the device's": (with_event(1, 0.0, 0.03, lead=0.02), "wrong lead", "valve on"),
    "another device": (with_event(0, device="vacuum"), "unknown device", "vacuum"),
    "a smaller load than there is": (with_grasp(shear=0.1), "load not as stated", "grasp.shear"),
    "a smaller share of what the cup bears": (
        with_grasp(load_ratio=0.01), "load not as stated", "grasp.load_ratio",
    ),
    "a larger moment than there is": (with_grasp(moment=3.0), "load not as stated", "grasp.moment"),
    "let go in motion": (let_go_earlier(0.4), "released too fast", "valve off"),
    "let go just before the tool stands": (let_go_earlier(0.05), "released too fast", "valve off"),
    "not resolved": (with_event(0, t_trigger=None), "not resolved", "pump"),
    "anchored by the wrong way": (
        with_event(1, anchor=Anchor(AnchorKind.ARC_LENGTH, 2, 0.02)), "wrong anchor time", "valve on",
    ),
    "wrong tool state at the lines": (
        with_segment(SegmentKind.RETREAT, tool_state=DOWN), "wrong tool state", "retreat",
    ),
    "no such state of the tool": (
        with_segment(SegmentKind.LIFT, tool_state=ToolState("sideways")), "unknown tool state", "lift",
    ),
    "grasp for no state of the tool": (
        with_grasp(tool_state=ToolState("sideways")), "unknown tool state", "grasp",
    ),
    "wrong tool state at contact": (
        with_segment(SegmentKind.CONTACT, tool_state=DOWN), "wrong tool state", "contact",
    ),
    "tool changes its state while holding": (
        with_segment(SegmentKind.TRANSFER, tool_state=MOVING), "tool changes its state while holding",
        "transfer",
    ),
    "contact and grasp while the cup turns": (
        lambda p: with_grasp(tool_state=MOVING)(with_segment(SegmentKind.CONTACT, tool_state=MOVING)(p)),
        "wrong tool state", "the cup holds while it stands still",
    ),
    "held item forgotten": (with_segment(SegmentKind.TRANSFER, held=None), "held item forgotten", "transfer"),
    "another item held": (
        with_segment(SegmentKind.RETREAT, held="dove_beauty_bar"), "wrong held item", "retreat",
    ),
    "touching in transfer": (
        with_segment(SegmentKind.TRANSFER, touching=("wall_left",)), "touching not allowed", "transfer",
    ),
    "touching an unknown body": (
        with_segment(SegmentKind.LIFT, touching=("elephant",)), "unknown name", "elephant",
    ),
    "contact that may not touch": (
        with_segment(SegmentKind.CONTACT, touching=()), "collision", "cup and crayola",
    ),
    "lift that may not touch": (with_segment(SegmentKind.LIFT, touching=()), "too close", "row_ABC_floor"),
    "a gap between segments": (with_segment(SegmentKind.LIFT, t_end=4.0), "segments not contiguous", "lift"),
    "coarse motion called a line": (
        with_segment(SegmentKind.TRANSFER, kind=SegmentKind.RETREAT), "not straight", "retreat",
    ),
    "an approach called contact, and the contact a part of it": (
        one_contact, "touching too long", "contact",
    ),
    "an approach called contact": (
        with_segment(SegmentKind.APPROACH, kind=SegmentKind.CONTACT), "held item forgotten", "",
    ),
    "grasp of another item": (with_grasp(item="folgers"), "unknown item", "folgers"),
    "cup aside of the grasp": (moved_grasp((0.004, 0, 0)), "misses the item", "aside"),
    "cup before the item": (moved_grasp((0, 0, 0.02)), "grasp off the surface", CRAYOLA),
    "cup tilted on the face": (moved_grasp((0, 0, 0), (0.2, 0, 0)), "cup not square", CRAYOLA),
    "cup over the edge": (moved_grasp((0, 0.03, 0)), "cup beyond the edge", CRAYOLA),
    "grasp for the other tool state": (with_grasp(tool_state=DOWN), "wrong tool state", "contact"),
    "the grasp on another face than stated": (with_grasp(face="+z"), "wrong face", "-z"),
    "the grasp on a face that boxes do not have": (with_grasp(face="mantle"), "wrong face", "-z"),
    "a frontal grasp called a side grasp": (with_grasp(kind="side"), "wrong kind", "frontal"),
    "a frontal grasp called a top-down one": (with_grasp(kind="top-down"), "wrong kind", "frontal"),
    "called a pick of another item": (
        lambda p: replace(p, query="pick dove_beauty_bar from bin_C"), "wrong query", CRAYOLA,
    ),
    "called a pick from another bin": (
        lambda p: replace(p, query=f"pick {CRAYOLA} from bin_Z into tote"), "wrong query", CRAYOLA,
    ),
    "called a pick into another place": (
        lambda p: replace(p, query=f"pick {CRAYOLA} from bin_B into bin_F"), "wrong query", "tote",
    ),
    "called a pick with another ending": (
        lambda p: replace(p, query=f"pick {CRAYOLA} from bin_B onto bin_F"), "wrong query", CRAYOLA,
    ),
    **{
        f"called {query!r}": (called(query), "wrong query", CRAYOLA)
        for query in (
            "pick x", f"Pick {CRAYOLA} from bin_B", "move from home to bin_C", f"stow {CRAYOLA} into bin_F",
            f"topple {CRAYOLA} in bin_B", f"shift {CRAYOLA} in bin_B", "",
        )
    },
    "carried faster than the plan states": (
        lambda p: replace(p, speed_scale=0.1), "carrying speed limit", "transfer",
    ),
    "joints in another order": (
        lambda p: replace(p, trajectory=replace(p.trajectory, joint_names=p.trajectory.joint_names[::-1])),
        "joint names", "trajectory",
    ),
}  # fmt: skip
