"""Reading a cell from its folder: cell.yaml, its URDF and the items, checked against each other."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from pickcli.cell.cell import SRDF_REASON, AllowedPair, Cell, NamedConfiguration
from pickcli.cell.checks.arm_consistency import (
    ArmSource,
    check_arms,
    check_each_arm,
    check_side_by_side,
    model_of_arm,
    source_of_arm,
)
from pickcli.cell.checks.configuration_check import warn_of_configurations, warn_of_missing_configurations
from pickcli.cell.checks.consistency import check_consistency, check_parts
from pickcli.cell.checks.gripper_consistency import check_hand, check_stroke
from pickcli.cell.checks.plausibility import warn_of_figures
from pickcli.cell.checks.references import refer
from pickcli.cell.data_path import data_path
from pickcli.cell.device import Device, pump_flow
from pickcli.cell.item import REFERENCE_FLOW, Item
from pickcli.cell.makers.carrier_builder import build_carrier
from pickcli.cell.makers.pod import build_pod
from pickcli.cell.makers.tote import build_tote
from pickcli.cell.robot import Joint, JointType, Limits, Robot
from pickcli.cell.robots.planning_group import mounted, planning_group, stripped, with_tip, with_whole_finger
from pickcli.cell.robots.robot_tree import WORLD, prefixed, side_by_side
from pickcli.cell.robots.srdf import read_srdf
from pickcli.cell.robots.urdf import Urdf, read_urdf
from pickcli.cell.schemas.cell_schema import (
    BoundsModel,
    CellModel,
    JointLimitModel,
    cell_model,
)
from pickcli.cell.schemas.items_file import load_items
from pickcli.cell.schemas.joint_limits_file import add_joint_limits, refuse_unknown_joints
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file, sensor_names
from pickcli.cell.schemas.tool_schema import GripperModel, SuctionModel
from pickcli.cell.sensors.mounted_camera import MountedCamera, MountError
from pickcli.cell.shapes import Body, box
from pickcli.cell.station import NO_POD, Obstacles
from pickcli.cell.tool import Tool, ToolState
from pickcli.cell.tools.tool_builder import build_tool
from pickcli.cell.workcell import Parking, Workcell
from pickcli.errors import UnknownNameError
from pickcli.files.file_kind import CELL
from pickcli.files.file_warnings import FileWarnings
from pickcli.files.schema import validate
from pickcli.files.source import Key, Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array

CELL_FILE = "cell.yaml"

# Keys that version 1 of the format named differently.
RENAMED = (
    "tool.pivot_joint to joint", "tool.pivot_positions to states", "pivot of configurations to tool_state",
    "the kind pivot of devices to tool_actuator",
)  # fmt: skip


def load_cell(name_or_path: str | Path, arm: str | None = None, items: Path | None = None) -> Cell:
    """Load a cell as seen by one arm, with every other arm parked.

    Args:
        name_or_path: A name under data/cells, a folder, or a cell.yaml.
        arm: Name of the arm; None if the cell has only one.
        items: A file with further items beside those of the package, or a folder of such files.

    Returns:
        The cell.

    Raises:
        InputError: The files are wrong: with file, line and key of every mistake; or the cell has several
            arms and ``arm`` is None.
        UnknownNameError: There is no such cell, or no such arm in it.
    """
    return load_workcell(name_or_path, items).cell(arm)


def load_workcell(name_or_path: str | Path, own_items: Path | None = None) -> Workcell:
    """Load a cell with all its arms, and log warnings about implausible values.

    Args:
        name_or_path: A name under data/cells, a folder, or a cell.yaml.
        own_items: A file with further items beside those of the package, or a folder of such files.

    Returns:
        The workcell.

    Raises:
        InputError: The files are wrong: with file, line and key of every mistake.
        UnknownNameError: There is no such cell.
    """
    path = cell_file(name_or_path)
    source = read_yaml(path, CELL)
    _refuse_version_1(source)
    limits = add_joint_limits(source)
    model = validate(source, cell_model(source.data))
    check_arms(source, model)
    urdf = _urdf(source, model, limits)
    flow = pump_flow(_devices(model).values())  # of the whole cell: a scene is for all of its arms
    items = {key: item.under_pump(flow) for key, item in load_items(own_items).items()}
    if model.arms:
        check_each_arm(source, model, urdf, items.values())
    else:
        check_consistency(source, model, urdf)
        check_stroke(source, model, items.values())
    cameras = _cameras(source, model, urdf)
    disabled = _disabled(source, model, urdf)
    models = {name: model_of_arm(model, name, urdf) for name in model.arms} or {"": model}
    return Workcell.of(
        {
            name: _cell(
                source_of_arm(source, name) if name else source, each, (urdf, disabled), items, cameras
            )
            for name, each in models.items()
        },
        [Parking(name, arm.parked, arm.preference) for name, arm in model.arms.items()],
        urdf,
        model.robot.posture,
    )


def _cell(
    source: Source,
    model: CellModel,
    robot: tuple[Urdf, Sequence[AllowedPair]],
    items: dict[tuple[str, int], Item],
    cameras: dict[str, MountedCamera],
) -> Cell:
    """Build the cell of one arm, of a robot with its disabled pairs."""
    urdf, disabled = robot
    folder = source.path.parent
    tool = build_tool(model.tool, model.tip, urdf, pump_flow(_devices(model).values()))
    cell = Cell(
        name=model.name,
        path=folder,
        robot=_robot(folder, model, urdf, tool),
        T_world_pod=np.eye(4) if model.pod is None else model.pod.T_world_pod.T,
        pod=NO_POD if model.pod is None else build_pod(model.pod),
        tote=None if model.tote is None else build_tote(model.tote),
        obstacles=Obstacles(tuple(_box(o.name, o) for o in model.obstacles)),
        devices=_devices(model),
        configurations={
            c.name: NamedConfiguration(
                c.name,
                np.array(c.q),
                tool.default_state if c.tool_state is None else ToolState(c.tool_state),
                c.kind,
            )
            for c in model.configurations
        },
        allowed_pairs=(
            *(AllowedPair(p.a, p.b, p.reason, p.verified) for p in model.allowed_pairs),
            *disabled,
        ),
        items=items,
        speed_scale=model.speed_scale,
        clearance=model.clearance,
        max_tool_speed=model.max_tool_speed,
        cameras=cameras,
        own_carriers=tuple(build_carrier(name, m, folder) for name, m in model.places.items()),
    )
    warnings = FileWarnings.of(source)
    warn_of_figures(warnings, cell, model)
    warn_of_configurations(warnings, cell)
    if not isinstance(source, ArmSource):  # several arms wait at different places
        warn_of_missing_configurations(warnings, cell)
    warnings.log()
    return replace(cell, warnings=tuple(warnings.lines), accepted=frozenset(warnings.met))


def _devices(model: CellModel) -> dict[str, Device]:
    return {
        name: Device(name, d.kind, d.lead, d.actions, REFERENCE_FLOW if d.flow is None else d.flow)
        for name, d in model.devices.items()
    }


def cell_names() -> list[str]:
    """Names of the cells under data/cells.

    Returns:
        Sorted names.
    """
    return sorted(path.parent.name for path in data_path().glob("cells/*/cell.yaml"))


def cell_file(name_or_path: str | Path) -> Path:
    """Resolve a name, a folder or a path to a cell.yaml.

    Args:
        name_or_path: A name under data/cells, a folder, or a cell.yaml. A text without a separator is a name
            first, a path is looked up as a path first.

    Returns:
        The file.

    Raises:
        UnknownNameError: There is no such cell.
    """
    path = Path(name_or_path)
    shipped, own = data_path() / "cells" / path / "cell.yaml", (path / "cell.yaml", path)
    if isinstance(name_or_path, Path):
        candidates: tuple[Path, ...] = (*own, shipped)
    else:  # with a separator it is a path, even if its last part is a name
        candidates = own if os.sep in name_or_path else (shipped, *own)
    for candidate in candidates:
        with suppress(OSError):  # e.g. a name that is too long for a file
            if candidate.is_file():
                return candidate
    hint = "it is a folder without cell.yaml" if path.is_dir() else ""
    if path.suffix in (".yaml", ".yml") and len(path.parts) > 1:
        hint = "there is no such file; name the folder of a cell.yaml"
    with suppress(OSError):
        beside = sorted(str(file.parent) for file in path.parent.glob("*/cell.yaml"))
    raise UnknownNameError("cell", str(name_or_path), [*cell_names(), *beside], hint=hint)


def _refuse_version_1(source: Source) -> None:
    """Refuse a cell file of version 1, with advice on how to update it."""
    if isinstance(source.data, dict) and source.data.get("version") == 1:
        source.add(("version",), f"1 is the version before; rename {', '.join(RENAMED)}, and write 2")
        source.check()


def _urdf(source: Source, model: CellModel, limits: Source | None) -> Urdf:
    """Read the robot with its tools, without the links under ``robot.without``, which may have limits."""
    folder = source.path.parent
    packages = {name: folder / path for name, path in model.robot.packages.items()}
    robot = _whole(source, model, packages)
    tools = {
        key: (stated, _urdf_of_tool(source, key, stated, packages)) for key, stated in _stated_tools(model)
    }
    check_parts(source, model, robot, tools)
    if limits is not None:
        whole = (robot, *(tool for _, tool in tools.values() if tool is not None))
        refuse_unknown_joints(limits, [joint.name for part in whole for joint in part.joints.values()])
    robot = stripped(robot, model.robot.without)
    for key, (stated, tool) in tools.items():
        if tool is not None:
            mount = stated.T_flange_tool
            robot = mounted(robot, tool, stated.flange_link, np.eye(4) if mount is None else mount.T)
        if isinstance(stated, GripperModel):
            for finger in stated.fingers:
                robot = with_whole_finger(robot, finger)
            check_hand(source if key == ("tool",) else source_of_arm(source, str(key[1])), stated, robot)
            robot = with_tip(robot, stated.hand_link, stated.last_link, stated.T_hand_tip.T)
    return robot


def _whole(source: Source, model: CellModel, packages: dict[str, Path]) -> Urdf:
    """Read all robots of a cell as one tree; a single robot is returned as it is."""
    folder, parts = source.path.parent, dict[str, tuple[Urdf, Array]]()
    for name, stated in model.robots.items():
        urdf = read_urdf(_inside(source, ("robots", name, "urdf"), stated.urdf), folder, packages)
        parts[name] = prefixed(urdf, stated.prefix), stated.T_world_base.T
    if not parts:
        return read_urdf(_inside(source, ("robot", "urdf"), model.robot.urdf or ""), folder, packages)
    check_side_by_side(source, {name: urdf for name, (urdf, _) in parts.items()})
    return side_by_side(model.name, parts)


def _stated_tools(model: CellModel) -> Iterator[tuple[Key, SuctionModel | GripperModel]]:
    """Yield every tool of a cell with its key in the file."""
    if model.tool is not None:
        yield ("tool",), model.tool
    for name, arm in model.arms.items():
        if arm.tool is not None:
            yield ("arms", name, "tool"), arm.tool


def _urdf_of_tool(
    source: Source, key: Key, tool: SuctionModel | GripperModel, packages: dict[str, Path]
) -> Urdf | None:
    """Read the separate URDF of a tool, or return None if the tool is part of the robot's."""
    if tool.urdf is None:
        return None
    return read_urdf(_inside(source, (*key, "urdf"), tool.urdf), source.path.parent, packages)


def _inside(source: Source, key: Key, name: str) -> Path:
    """Return the path of a file named in a cell file. Raise InputError if it is outside the cell's folder."""
    folder = source.path.parent
    path = folder / name
    if not path.resolve().is_relative_to(folder.resolve()):
        source.add(key, f"expected a path inside the cell's folder, got {name!r}; copy it there")
    elif not path.exists():
        source.add(key, f"{name!r}: no such file in the cell's folder; check the name")
    source.check()
    return path


def _cameras(source: Source, model: CellModel, urdf: Urdf) -> dict[str, MountedCamera]:
    """Return the cameras by name. Raise InputError with every unknown link and sensor."""
    found = {}
    for name, stated in model.sensors.items():
        key, is_file = ("sensors", name, "model"), Path(stated.model).suffix in (".yaml", ".yml")
        if stated.link is not None:
            at = ("sensors", name, "link")
            if stated.link == WORLD and WORLD not in urdf.links:
                source.add(at, "no link is named 'world'; leave link out for a camera fixed in the world")
            else:
                refer(source, at, "link", stated.link, list(urdf.links))
        if not is_file and stated.model not in sensor_names():
            refer(source, key, "sensor", stated.model, sensor_names())
            continue
        sensor = read_sensor(_inside(source, key, stated.model) if is_file else sensor_file(stated.model))
        error = MountError(stated.error.position, stated.error.angle)
        found[name] = MountedCamera(name, sensor, stated.link, stated.T_parent_camera.T, error)
    source.check()
    return found


def _disabled(source: Source, model: CellModel, urdf: Urdf) -> list[AllowedPair]:
    """Return the disabled pairs of the SRDFs, without those of links that the robot does not have."""
    stated: list[tuple[Key, str | None, str]] = [
        (("robots", name, "srdf"), each.srdf, each.prefix) for name, each in model.robots.items()
    ]
    found = []
    for key, path, prefix in stated or [(("robot", "srdf"), model.robot.srdf, "")]:
        file = None if path is None else _inside(source, key, path)
        pairs = () if file is None else read_srdf(file).disabled
        names = {prefix + name for pair in pairs for name in (pair.a, pair.b)}
        if names and not names & urdf.links.keys():
            text = f"names no link of the robot, e.g. {min(names)!r}; is it the SRDF of another one?"
            source.add(key, text)
        for pair in pairs:
            a, b = prefix + pair.a, prefix + pair.b
            if file is not None and {a, b} <= urdf.links.keys():
                reason = f"{SRDF_REASON}{pair.reason}"
                found.append(AllowedPair(a, b, reason, srdf=(file, pair.line)))
    source.check()
    return found


def _robot(folder: Path, model: CellModel, urdf: Urdf, tool: Tool) -> Robot:
    moving = [*model.robot.joints, *tool.joints]
    links, joints = planning_group(urdf, tool.last_link, moving, model.robot.posture)
    return Robot(
        name=urdf.name,
        urdf=folder / (model.robot.urdf or CELL_FILE),
        T_world_base=np.eye(4) if model.robot.T_world_base is None else model.robot.T_world_base.T,
        links=links,
        joints=joints,
        joint_names=model.robot.joints,
        limits=_limits(model, joints),
        motor_forces=dict(model.robot.motor_forces),
        tool=tool,
    )


def _limits(model: CellModel, chain: Iterable[Joint]) -> Limits:
    """Return limits in the order of the planned joints; the cell may narrow the URDF's position limits."""
    by_name = {joint.name: joint for joint in chain}
    limits = [model.joint_limits[name] for name in model.robot.joints]
    joints = [by_name[name] for name in model.robot.joints]
    bounds = [_bounds(limit, joint) for limit, joint in zip(limits, joints, strict=True)]
    return Limits(
        lower=np.array([lower for lower, _ in bounds]),
        upper=np.array([upper for _, upper in bounds]),
        velocity=np.array([m.max_velocity for m in limits]),
        acceleration=np.array([m.max_acceleration for m in limits]),
        jerk=np.array([m.max_jerk for m in limits]),
    )


def _bounds(limit: JointLimitModel, joint: Joint) -> tuple[float, float]:
    """Position limits. A continuous joint narrowed on one side is limited to half a turn on the other."""
    lower, upper = joint.lower, joint.upper
    if joint.type is JointType.CONTINUOUS and not limit.min_position is limit.max_position is None:
        lower, upper = -np.pi, np.pi
    return _or(limit.min_position, lower), _or(limit.max_position, upper)


def _or(stated: float | None, otherwise: float) -> float:
    return otherwise if stated is None else stated


def _box(name: str, bounds: BoundsModel) -> Body:
    (x0, y0, z0), (x1, y1, z1) = bounds.lower, bounds.upper
    return box(name, (x0, y0, z0), (x1, y1, z1))
