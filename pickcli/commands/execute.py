"""``apc execute``: carry out one plan in simulation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.options import emit_json, json_option, progress, refuse_existing, scene_option

if TYPE_CHECKING:
    from pickcli.cell.scene import Scene
    from pickcli.motion.plan import Plan
    from pickcli.simulation.camera import Film
    from pickcli.simulation.execution import Execution


@click.command("execute")
@click.argument("plan_path", metavar="PLAN.json", type=click.Path(path_type=Path))
@scene_option
@click.option("--video", type=click.Path(path_type=Path), help="Film it: an animated GIF (needs pillow).")
@click.option("--overwrite", is_flag=True, help="Replace an existing film.")
@click.option("--unverified", is_flag=True, help="Execute a plan that carries no certificate.")
@json_option
def command(
    plan_path: Path, scene_path: Path, video: Path | None, overwrite: bool, unverified: bool, as_json: bool
) -> None:
    """Run PLAN.json in pybullet, from its first point, in a scene as it is given.

    Exit code 6 when something collided, a limit was broken or an item was lost.

    \b
    Example:
      apc execute plan.json --scene scene.json --video pick.gif
    """
    from pickcli.cell.scene_file import read_scene
    from pickcli.motion.plan_file import read_plan

    plan, scene = read_plan(plan_path), read_scene(scene_path)
    _require_certificate(plan, plan_path, unverified)
    film = None
    if video is not None:
        refuse_existing(video, overwrite)
        from pickcli.simulation.camera import Film

        film = Film.named(video)
    record = _run(plan, scene, film)
    if film is not None and video is not None:
        film.write(video)
    if as_json:
        emit_json(_summary(plan, record))
    else:
        click.echo(_text(plan, record))
    if not record.is_clean:
        from pickcli.errors import TrialAbortedError

        raise TrialAbortedError(record.trouble)


def _require_certificate(plan: Plan, path: Path, unverified: bool) -> None:
    """Raise RejectedError for a plan that nobody verified, or that changed since."""
    from pickcli.errors import RejectedError
    from pickcli.motion.plan_file import motion_hash

    if unverified:
        return
    if plan.certificate is None:
        raise RejectedError(
            f"{path}: carries no certificate; run apc verify --write on it, or pass --unverified"
        )
    if plan.certificate.motion_hash != motion_hash(plan):
        raise RejectedError(
            f"{path}: its certificate is of another motion; run apc verify --write on it again"
        )


def _run(plan: Plan, scene: Scene, film: Film | None) -> Execution:
    from pickcli.cell.robot import PivotState
    from pickcli.simulation.execute import execute
    from pickcli.simulation.world import World

    first = plan.segments[0].pivot
    pivot = PivotState.STRAIGHT if first is PivotState.MOVING else first
    world = World(scene, plan.trajectory.positions[0], pivot)

    def look(world: World) -> None:
        if film is not None:
            film.look(world.engine, world.t)

    with progress("executing") as report:
        record = execute(
            plan,
            world,
            on_progress=lambda t, total, what: report(round(10 * t), round(10 * total), what),
            on_step=look if film is not None else None,
        )
    world.close()
    return record


def _summary(plan: Plan, record: Execution) -> dict[str, Any]:
    """The record as JSON values."""
    return {
        "query": plan.query,
        "stopped": record.stopped,
        "simulated_s": record.duration,
        "has_item": record.has_item,
        "held": record.held,
        "max_lag_mm": 1e3 * record.max_lag,
        "max_load": record.max_load,
        "events": [
            {
                "device": fired.event.device,
                "action": fired.event.action,
                "t": fired.t - record.t_start,
                "distance_mm": 1e3 * fired.distance,
                "reading": fired.reading,
            }
            for fired in record.events
        ],
        "missed_events": [f"{event.device} {event.action}" for event in record.missed],
        "collisions": [
            {"a": c.a, "b": c.b, "t": c.t_start - record.t_start, "depth_mm": 1e3 * c.depth, "at": c.position}
            for c in record.collisions
        ],
        "limit_violations": [str(violation) for violation in record.limit_violations],
        "falls": [{"item": f.item, "height": f.height, "is_wanted": f.is_wanted} for f in record.falls],
    }


def _text(plan: Plan, record: Execution) -> str:
    """The record in a few lines."""
    lines = [
        f"{plan.query}: {record.stopped or 'done'}, {record.duration:.2f} s simulated",
        f"  tool at most {1e3 * record.max_lag:.1f} mm behind its command; "
        f"cup loaded to {record.max_load:.0%} of its limits",
    ]
    for fired in record.events:
        reading = "" if fired.reading is None else f": {'held' if fired.reading else 'nothing held'}"
        lines.append(
            f"  {fired.t - record.t_start:7.3f} s  {fired.event.device} {fired.event.action}{reading} "
            f"({1e3 * fired.distance:.2f} mm from its trigger)"
        )
    lines += [f"  missed: {event.device} {event.action}" for event in record.missed]
    lines += [
        f"  collision: {c.a} and {c.b}, {1e3 * c.depth:.1f} mm deep at "
        f"({', '.join(f'{x:.3f}' for x in c.position)}), {c.t_start - record.t_start:.3f} s"
        for c in record.collisions
    ]
    lines += [f"  limit: {violation}" for violation in record.limit_violations]
    return "\n".join(lines)
