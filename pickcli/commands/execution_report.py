"""What ``apc execute`` says: outcome, events, loads and everything that went wrong."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pickcli.motion.plan import Plan
    from pickcli.simulation.execution import Execution
    from pickcli.simulation.world import World


def trouble(runs: Sequence[Execution]) -> str:
    """Tell what must not happen in one sentence. A lost item is a result, not trouble.

    Args:
        runs: What was executed.

    Returns:
        The sentence, "" if nothing of the kind happened.
    """
    counts = (
        (sum(len(run.collisions) for run in runs), "collision"),
        (sum(len(run.limit_violations) for run in runs), "limit violation"),
        (sum(len(run.missed) for run in runs), "missed event"),
    )
    return ", ".join(f"{n} {what}{'' if n == 1 else 's'}" for n, what in counts if n)


def execution_summary(plans: Sequence[Plan], runs: Sequence[Execution], world: World) -> dict[str, Any]:
    """Sum up an execution: the outcome, and the record of the plan and of the bridge to it.

    Args:
        plans: The bridge, if there was one, and the plan.
        runs: Their executions, as far as they were begun.
        world: The simulated world afterwards.

    Returns:
        JSON values by name.
    """
    bridge, main = _told_apart(plans, runs)
    item, where = _whereabouts(plans[-1], world)
    return {
        "query": plans[-1].query,
        "item": item,
        "item_is_in": where,
        "in_tote": None if item is None else where == "tote",
        "simulated_s": sum(run.duration for run in runs),
        "collisions": sum(len(run.collisions) for run in runs),
        "limit_violations": sum(len(run.limit_violations) for run in runs),
        "bridge": None if bridge is None else _record(bridge),
        "execution": None if main is None else _record(main),
    }


def execution_text(plans: Sequence[Plan], runs: Sequence[Execution], world: World) -> str:
    """Sum up an execution in a few lines.

    Args:
        plans: The bridge, if there was one, and the plan.
        runs: Their executions, as far as they were begun.
        world: The simulated world afterwards.

    Returns:
        The text.
    """
    lines = []
    for plan, run in zip(plans, runs, strict=False):
        told = f"{plan.query}: {run.stopped or 'done'}, {run.duration:.2f} s simulated"
        lines += [told, *_lines(run, _holder(world))]
    item, where = _whereabouts(plans[-1], world)
    if len(runs) < len(plans):
        lines.append(f"{plans[-1].query}: not started")
    if item is not None:
        place = {
            "tote": "in the tote",
            _holder(world): f"still in the {_holder(world)}",
            "outside": "in no place",
        }
        lines.append(f"  {item} is {place.get(where or '', f'in {where}')}")
    return "\n".join(lines)


def _told_apart(
    plans: Sequence[Plan], runs: Sequence[Execution]
) -> tuple[Execution | None, Execution | None]:
    """The run of the bridge and that of the plan; None for what was not carried out."""
    if len(plans) == 1:
        return None, runs[0]
    return runs[0], runs[1] if len(runs) > 1 else None


def _whereabouts(plan: Plan, world: World) -> tuple[str | None, str | None]:
    """The item that the plan is about, and where it is now."""
    if plan.grasp is None:
        return None, None
    item = plan.grasp.item
    return item, _holder(world) if world.held == item else world.placed(item).location


def _holder(world: World) -> str:
    """What holds items: the cup, or the gripper."""
    return world.robot.tool.grip.holder


def _record(run: Execution) -> dict[str, Any]:
    return {
        "stopped": run.stopped,
        "stop_cause": None if run.stop_cause is None else str(run.stop_cause),
        "stopping_s": run.stopping_time,
        "stopped_in": None if run.stopped_in is None else str(run.stopped_in),
        "simulated_s": run.duration,
        "sensor_reads_held": run.has_item,
        "held": run.held,
        "max_lag_m": run.max_lag,
        "max_load": run.max_load,
        "events": [
            {
                "device": fired.event.device,
                "action": fired.event.action,
                "t_s": fired.t - run.t_start,
                "distance_m": fired.distance,
                "reading": fired.reading,
            }
            for fired in run.events
        ],
        "missed_events": [f"{event.device} {event.action}" for event in run.missed],
        "collisions": [
            {"a": c.a, "b": c.b, "t_s": c.t_start - run.t_start, "depth_m": c.depth, "at_m": c.position}
            for c in run.collisions
        ],
        "limit_violations": [str(violation) for violation in run.limit_violations],
        "falls": [{"item": f.item, "height_m": f.height, "is_wanted": f.is_wanted} for f in run.falls],
    }


def _lines(run: Execution, holder: str) -> list[str]:
    load = f"; {holder} loaded to {run.max_load:.0%} of its limits" if run.max_load else ""
    lines = [f"  tool at most {1e3 * run.max_lag:.1f} mm behind its command{load}"]
    for fired in run.events:
        reading = "" if fired.reading is None else f": {'held' if fired.reading else 'nothing held'}"
        lines.append(
            f"  {fired.t - run.t_start:7.3f} s  {fired.event.device} {fired.event.action}{reading} "
            f"({1e3 * fired.distance:.2f} mm from its trigger)"
        )
    lines += [f"  missed: {event.device} {event.action}" for event in run.missed]
    lines += [
        f"  collision: {c.a} and {c.b}, {1e3 * c.depth:.1f} mm deep at "
        f"({', '.join(f'{x:.3f}' for x in c.position)}), {c.t_start - run.t_start:.3f} s"
        for c in run.collisions
    ]
    lines += [f"  limit: {violation}" for violation in run.limit_violations]
    lines += [f"  {f.item} fell {1e3 * f.height:.0f} mm" for f in run.falls if not f.is_wanted]
    return lines
