"""Report of ``apc execute``: outcome, events, loads and all faults."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING, Any

from pickcli.simulation.protective_stop import StopCause

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pickcli.motion.plan import Plan
    from pickcli.simulation.contacts import Collision
    from pickcli.simulation.plan_record import PlanRecord
    from pickcli.simulation.world import World
    from pickcli.trial.disturbance import Disturbance


HINDERED = (StopCause.FOLLOWING_ERROR, StopCause.CONTACT)  # stops of a robot that cannot move as planned


def trouble(runs: Sequence[PlanRecord]) -> str:
    """Describe the faults of executions in one sentence. A lost item is a result, not a fault.

    Args:
        runs: The executions.

    Returns:
        The sentence, "" if there were no faults.
    """
    counts = (
        (sum(len(_collisions(run)) for run in runs), "collision"),
        (sum(len(run.limit_violations) for run in runs), "limit violation"),
        (sum(len(run.missed) for run in runs), "missed event"),
        (sum(run.stop_cause in HINDERED for run in runs), "protective stop"),
    )
    return ", ".join(f"{n} {what}{'' if n == 1 else 's'}" for n, what in counts if n)


def execution_summary(
    plans: Sequence[Plan], runs: Sequence[PlanRecord], world: World | None
) -> dict[str, Any]:  # fmt: skip
    """Summarise an execution: the outcome, and the records of the plan and of the bridge to it.

    Args:
        plans: The bridge, if there was one, and the plan.
        runs: Their executions, as far as they were started.
        world: The simulated world afterwards; None for another driver, which does not know where items are.

    Returns:
        JSON values by name.
    """
    bridge, main = _bridge_and_main(plans, runs)
    item, where = _whereabouts(plans[-1], world)
    return {
        "query": plans[-1].query,
        "item": item,
        "item_is_in": where,
        "in_tote": None if where is None else where == "tote",
        **runs_counts(runs),
        "disturbed": disturbed_items(plans, world),
        "bridge": None if bridge is None else run_record(bridge),
        "execution": None if main is None else run_record(main),
    }


def runs_counts(runs: Sequence[PlanRecord]) -> dict[str, Any]:
    """Sum counts over several executions.

    Args:
        runs: The executions.

    Returns:
        JSON values by name.
    """
    return {
        "simulated_s": sum(run.duration for run in runs),
        "collisions": sum(len(_collisions(run)) for run in runs),
        "limit_violations": sum(len(run.limit_violations) for run in runs),
    }


def execution_text(plans: Sequence[Plan], runs: Sequence[PlanRecord], world: World | None) -> str:
    """Summarise an execution in a few lines.

    Args:
        plans: The bridge, if there was one, and the plan.
        runs: Their executions, as far as they were started.
        world: The simulated world afterwards; None for another driver, which does not know where items are.

    Returns:
        The text.
    """
    lines = [line for plan, run in zip(plans, runs, strict=False) for line in run_lines(plan, run, world)]
    item, where = _whereabouts(plans[-1], world)
    if len(runs) < len(plans):
        lines.append(f"{plans[-1].query}: not started")
    if item is not None and world is not None:
        lines.append(whereabouts_line(item, where or "", world))
    return "\n".join([*lines, *disturbance_lines(plans, world)])


def disturbed_items(plans: Sequence[Plan], world: World | None) -> list[dict[str, Any]]:
    """Describe the items that moved although no executed plan was to move them.

    Args:
        plans: The executed plans.
        world: The simulated world afterwards; None for another driver.

    Returns:
        JSON values by name for each item.
    """
    return [
        {
            "item": d.item,
            "kind": str(d.kind),
            "moved_m": d.moved,
            "turned_rad": d.turned,
            "out_of": d.out_of,
            "into": d.into,
        }
        for d in _disturbances(plans, world)
    ]


def disturbance_lines(plans: Sequence[Plan], world: World | None) -> list[str]:
    """Describe the items that moved although no executed plan was to move them, one line each.

    Args:
        plans: The executed plans.
        world: The simulated world afterwards; None for another driver.

    Returns:
        The lines.
    """
    return [
        f"  {d.item} was disturbed: {d.kind}, {1e3 * d.moved:.0f} mm, {degrees(d.turned):.0f} deg"
        f"{'' if d.out_of == d.into else f', from {d.out_of} into {d.into}'}"
        for d in _disturbances(plans, world)
    ]


def _disturbances(plans: Sequence[Plan], world: World | None) -> tuple[Disturbance, ...]:
    from pickcli.scene.item_stream import after_travel
    from pickcli.trial.disturbance import MAX_SETTLING, MAX_SETTLING_ANGLE, disturbances
    from pickcli.trial.score import ScoringRules

    if world is None:
        return ()
    meant = {plan.grasp.item for plan in plans if plan.grasp is not None}
    carried, on_belts = world.scene, set[str]()
    for name, belt in world.belts.items():
        carried = after_travel(carried, name, belt.travel)
        on_belts |= set(world.scene.cell.carriers[name].places)
    return tuple(
        d
        for d in disturbances(carried, world.now(), meant, ScoringRules.drop_limit)
        if d.out_of not in on_belts or d.moved > MAX_SETTLING or d.turned > MAX_SETTLING_ANGLE
    )


def run_lines(plan: Plan, run: PlanRecord, world: World | None) -> list[str]:
    """Describe one execution.

    Args:
        plan: The plan.
        run: Its execution.
        world: The simulated world; None for another driver.

    Returns:
        The lines.
    """
    simulated = "" if world is None else " simulated"
    head = f"{plan.query}: {run.stopped or 'done'}, {run.duration:.2f} s{simulated}"
    return [head, *_lines(run, "" if world is None else _holder(world))]


def whereabouts_line(item: str, where: str, world: World) -> str:
    """Describe where an item is.

    Args:
        item: Id of the item.
        where: Name of a place, of the holder of items, or "outside".
        world: The simulated world.

    Returns:
        The line.
    """
    holder = _holder(world)
    place = {"tote": "in the tote", holder: f"still in the {holder}", "outside": "outside all places"}
    return f"  {item} is {place.get(where, f'in {where}')}"


def _bridge_and_main(
    plans: Sequence[Plan], runs: Sequence[PlanRecord]
) -> tuple[PlanRecord | None, PlanRecord | None]:
    """Return the executions of the bridge and of the plan; None for one that was not started."""
    if len(plans) == 1:
        return None, runs[0]
    return runs[0], runs[1] if len(runs) > 1 else None


def _whereabouts(plan: Plan, world: World | None) -> tuple[str | None, str | None]:
    """Return the item of the plan, and its current place, if that is known."""
    if plan.grasp is None:
        return None, None
    item = plan.grasp.item
    if world is None:
        return item, None
    return item, _holder(world) if world.held == item else world.placed(item).location


def _holder(world: World) -> str:
    """Return the holder of items: cup or gripper."""
    return world.robot.tool.grip.holder


def run_record(run: PlanRecord) -> dict[str, Any]:
    """Convert one execution to a record.

    Args:
        run: The execution.

    Returns:
        JSON values by name.
    """
    return {
        "stopped": run.stopped,
        "stop_cause": None if run.stop_cause is None else str(run.stop_cause),
        "stopping_s": run.stopping_time,
        "stopped_in": None if run.stopped_in is None else str(run.stopped_in),
        "simulated_s": run.duration,
        "sensor_reads_held": run.has_item,
        "max_lag_m": run.max_lag,
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
        "limit_violations": [str(violation) for violation in run.limit_violations],
        "operator_stops_s": [[stop.begin, stop.end] for stop in run.operator_stops],
        **({} if run.is_clear is None else {"clear_of_belt": run.is_clear}),
        **({"way_off_stops": [str(stop) for stop in run.stops_on_way_off]} if run.stops_on_way_off else {}),
        **_seen_record(run),
    }


def _seen_record(run: PlanRecord) -> dict[str, Any]:
    """Return the values that are only recorded in the simulated world."""
    from pickcli.simulation.execution import Execution

    if not isinstance(run, Execution):
        return {}
    return {
        "held": run.held,
        "max_load": run.max_load,
        "collisions": [
            {"a": c.a, "b": c.b, "t_s": c.t_start - run.t_start, "depth_m": c.depth, "at_m": c.position}
            for c in run.collisions
        ],
        "falls": [{"item": f.item, "height_m": f.height, "is_wanted": f.is_wanted} for f in run.falls],
    }


def _collisions(run: PlanRecord) -> tuple[Collision, ...]:
    """Return the collisions, which are only recorded in the simulated world."""
    from pickcli.simulation.execution import Execution

    return run.collisions if isinstance(run, Execution) else ()


def _lines(run: PlanRecord, holder: str) -> list[str]:
    from pickcli.simulation.execution import Execution

    seen = run if isinstance(run, Execution) else None
    load = f"; {holder} loaded to {seen.max_load:.0%} of its limits" if seen and seen.max_load else ""
    lines = [f"  tool at most {1e3 * run.max_lag:.1f} mm behind its command{load}"]
    lines += [
        f"  {stop.begin:7.3f} s  stopped by the operator, "
        + ("not resumed" if stop.end is None else f"resumed at {stop.end:.3f} s")
        for stop in run.operator_stops
    ]
    lines += [f"  on the way off the belt: {stop}" for stop in run.stops_on_way_off]
    if run.is_clear is not None:
        lines.append(f"  at rest {'' if run.is_clear else 'not '}clear of all that the belt may bring")
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
        for c in _collisions(run)
    ]
    lines += [f"  limit: {violation}" for violation in run.limit_violations]
    falls = seen.falls if seen else ()
    lines += [f"  {f.item} fell {1e3 * f.height:.0f} mm" for f in falls if not f.is_wanted]
    return lines
