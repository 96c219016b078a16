"""``apc inspect CELL``: a summary of a cell, with the named configurations that are not free."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pickcli.commands.options.arm_options import ArmRequest
from pickcli.commands.options.scene_options import allowed

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.place import Place
    from pickcli.cell.tool import Tool


def cell_summary(path: Path, arms: ArmRequest) -> dict[str, Any]:
    """Summarise a cell as one arm sees it; if it has several and none is named, each arm by itself.

    Args:
        path: Name, folder or file of the cell.
        arms: The arms stated on the command line.

    Returns:
        JSON values by name.

    Raises:
        InputError: The cell cannot be read.
    """
    from pickcli.cell.cell_file import load_workcell

    workcell = load_workcell(path)
    if arms != ArmRequest() or not workcell.parked:
        return _of_one_arm(arms.cell_of(workcell))
    each = {name: _of_one_arm(cell) for name, cell in workcell.arms.items()}
    common = {k: v for k, v in each[workcell.preferred.arm].items() if all(o[k] == v for o in each.values())}
    own = {
        name: {
            "preference": workcell.preferences[name],
            "parked": str(workcell.parked[name]),
            **{key: value for key, value in values.items() if key not in common},
        }
        for name, values in each.items()
    }
    return {**common, "arms": own}


def _of_scenes(cell: Cell) -> dict[str, str]:
    """Return what scenes and streams of the cell state, if that is not the arm's own fingerprint."""
    stated = cell.scene_fingerprint
    return {} if stated == cell.fingerprint else {"scene_fingerprint": stated}


def _of_one_arm(cell: Cell) -> dict[str, Any]:
    from pickcli.precompute.empty_cell_checkers import why_not_free

    robot = cell.robot
    by_kind: dict[str, list[str]] = {}
    for configuration in cell.configurations.values():
        by_kind.setdefault(configuration.kind, []).append(configuration.name)
    return {
        "format": "apc cell",
        "name": cell.name,
        "path": str(cell.path),
        "fingerprint": cell.fingerprint,
        **_of_scenes(cell),
        "robot": robot.name,
        "joints": list(robot.joint_names),
        "links": len(robot.links),
        "link_shapes": sum(len(link.bodies) for link in robot.links),
        "tool": _tool(robot.tool),
        "spheres": _spheres(cell),
        "bins": list(cell.pod.bins),
        "places": {name: _place(place) for name, place in cell.places.items() if name not in cell.pod.bins},
        **_conveyors(cell),
        "pod_may_be_off_by": allowed(cell),
        "bodies": {
            "pod": len(cell.pod.bodies),
            "tote": len(cell.tote_bodies),
            "obstacles": len(cell.obstacles.bodies),
            **{carrier.name: len(carrier.bodies) for carrier in cell.own_carriers},
        },
        "devices": {d.name: f"{d.kind}, lead {d.lead} s" for d in cell.devices.values()},
        "cameras": {
            camera.name: f"{camera.model.name} on {camera.link or 'the world'}"
            for camera in cell.cameras.values()
        },
        "configurations": by_kind,
        "not_free": why_not_free(cell),
        "allowed_pairs": {f"{p.a} - {p.b}": p.reason for p in cell.allowed_pairs},
        "items": len(cell.items),
        "speed_scale": cell.speed_scale,
        "max_tool_speed": cell.max_tool_speed,
        "clearance_m": cell.clearance,
    }


def _tool(tool: Tool) -> dict[str, Any]:
    """Return the kind of the tool, and its states: positions of its joint, or widths between its pads."""
    return {
        "kind": tool.grip.kind,
        **{f"state {state}": position for state, position in tool.positions.items()},
    }


def _place(place: Place) -> str:
    """Describe size and access of a place."""
    size = " x ".join(f"{1e3 * side:.0f}" for side in place.room.size)
    way = "above" if place.access.is_from_above else "the front"
    return f"{size} mm, from {way}, part of {place.carrier}"


def _conveyors(cell: Cell) -> dict[str, dict[str, Any]]:
    """Return the figures of each conveyor, with the travel within which the arm reaches its items."""
    from pickcli.reachability.belt_reachability import HEIGHTS, reached_travel

    found = {}
    for carrier in cell.own_carriers:
        if (belt := carrier.conveyor) is not None:
            reached = {height: reached_travel(cell, carrier, height) for height in HEIGHTS}
            found[carrier.name] = {
                "belt": f"{belt.length:g} x {belt.width:g} m, {belt.nominal_speed:g} m/s, "
                f"at most {belt.max_speed:g} m/s and {belt.max_acceleration:g} m/s2",
                "window": _travel(belt.window),
                **{f"reached_at_{1e3 * z:.0f}_mm": _travel(at) for z, at in reached.items()},
            }
    return {"conveyors": found} if found else {}


def _travel(stretch: tuple[float, float] | None) -> str:
    """Describe a stretch of a belt."""
    return "nowhere" if stretch is None else f"{stretch[0]:.2f} to {stretch[1]:.2f} m from the infeed"


def _spheres(cell: Cell) -> dict[str, dict[str, Any]]:
    """Return the spheres of each moving link, and how far they stick out of its shapes."""
    from pickcli.collision.robot_model import CollisionModel
    from pickcli.robot_setup.sphere_excess import sphere_excess

    return {
        each.link: {
            "count": each.n_spheres,
            "mean_excess_m": round(each.mean_excess, 5),
            "max_excess_m": round(each.max_excess, 5),
        }
        for each in sphere_excess(cell, CollisionModel(cell))
    }
