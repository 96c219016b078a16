"""Consistency of a cell's tool with the URDF: links, states, and the devices that change states."""

from __future__ import annotations

from collections.abc import Sequence

from pickcli.cell.checks.gripper_consistency import check_gripper
from pickcli.cell.checks.references import refer
from pickcli.cell.device import DeviceKind
from pickcli.cell.robots.urdf import Urdf
from pickcli.cell.schemas.cell_schema import CellModel
from pickcli.cell.schemas.tool_schema import GripperModel, SuctionModel, ToolModel
from pickcli.cell.tool import FIXED, MOVING
from pickcli.files.source import Key, Source


def check_tip(source: Source, key: Key, tip: str | None, robot: Urdf) -> None:
    """Check that an arm without a tool names the last link of its chain.

    Args:
        source: Collects the mistakes with their places in the file.
        key: Key of the last link in the file.
        tip: Name of the last link; None if the file has none.
        robot: The robot's URDF.
    """
    if tip is None:
        source.add(key, "expected the last link of the chain, got nothing; add it, or a tool")
    else:
        refer(source, key, "link", tip, list(robot.links))


def check_mount(
    source: Source, key: Key, stated: ToolModel, robot: Urdf, tool: Urdf | None, mounted: Sequence[Urdf]
) -> None:
    """Check that a tool with a separate URDF can be mounted on the robot.

    Args:
        source: Collects the mistakes with their places in the file.
        key: Key of the tool in the file.
        stated: The tool as it stands in the file.
        robot: The robot's URDF.
        tool: The tool's URDF, or None if it is part of the robot's.
        mounted: The robot, and the tools of other arms.
    """
    if tool is None:
        if stated.T_flange_tool is not None:
            text = "is of a tool with a URDF of its own; add tool.urdf or leave it out"
            source.add((*key, "T_flange_tool"), text)
        return
    refer(source, (*key, "flange_link"), "link of the robot", stated.flange_link, list(robot.links))
    links = {name for part in mounted for name in part.links}
    for name in sorted(tool.links.keys() & links):
        source.add((*key, "urdf"), f"link {name!r} is one of the robot's too; rename one")
    taken = {joint.name for part in mounted for joint in part.joints.values()}
    for name in sorted(taken & {joint.name for joint in tool.joints.values()}):
        source.add((*key, "urdf"), f"joint {name!r} is one of the robot's too; rename one")


def check_tool(source: Source, tool: SuctionModel | GripperModel, robot: Urdf) -> None:
    """Check the links of the tool and its states.

    Args:
        source: Collects the mistakes with their places in the file.
        tool: The tool as it stands in the file.
        robot: The robot with the tool.
    """
    if isinstance(tool, GripperModel):
        check_gripper(source, tool, robot)
    else:
        _check_suction_tool(source, tool, robot)


def _check_suction_tool(source: Source, tool: SuctionModel, robot: Urdf) -> None:
    """Check that the chain ends with flange, lance and cup, and that states are positions of its joint."""
    names = list(robot.links)
    for role in ("flange_link", "lance_link", "cup_link"):
        refer(source, ("tool", role), "link", getattr(tool, role), names)
    last = [robot.root, *(joint.child for joint in robot.way(tool.cup_link))][-3:]
    if last != [tool.flange_link, tool.lance_link, tool.cup_link]:
        text = f"expected the chain to end with flange, lance and cup link; it ends {', '.join(last)}"
        source.add(("tool",), text)
    for joint in robot.children(tool.cup_link):
        source.add(("tool", "cup_link"), f"{joint.child!r} hangs on it; the cup is the last link")
    _check_states(source, tool, robot)


def tool_states(model: CellModel) -> list[str]:
    """Return the names of the states that the tool of a cell can rest in.

    Args:
        model: The cell as it stands in the file.

    Returns:
        The names, in the order of the file.
    """
    positions = None if model.tool is None else model.tool.states
    return list(positions or {FIXED.name: 0.0})


def _check_states(source: Source, tool: SuctionModel, robot: Urdf) -> None:
    """Check that the states of the tool are positions of the last joint of the chain."""
    name, positions = tool.joint, tool.states
    if name is None or positions is None:
        if name is not None:
            source.add(("tool", "states"), "expected a position by state, got nothing; add it")
        elif positions is not None:
            source.add(("tool", "joint"), "expected the joint that has these positions, got nothing; add it")
        return
    joints = robot.driven(robot.way(tool.cup_link))
    refer(source, ("tool", "joint"), "moving joint", name, list(joints))
    if MOVING.name in positions:
        text = f"{MOVING} means that the tool is between two states; give this one another name"
        source.add(("tool", "states", MOVING.name), text)
    joint = joints.get(name)
    if joint is None:
        return
    last = robot.way(tool.cup_link)[-1]
    if joint is not last:
        text = f"expected the last joint of the chain, {last.name!r}, got {name!r}; correct it"
        source.add(("tool", "joint"), text)
    if not all(joint.lower - 1e-9 <= p <= joint.upper + 1e-9 for p in positions.values()):
        source.add(("tool", "states"), f"outside of the joint's {joint.lower:g} to {joint.upper:g}")


def check_devices(source: Source, model: CellModel) -> None:
    """Check that the tool's actuators have one action for each of its states.

    Args:
        source: Collects the mistakes with their places in the file.
        model: The cell as it stands in the file.
    """
    states, is_gripper = tool_states(model), isinstance(model.tool, GripperModel)
    mover = DeviceKind.GRIPPER if is_gripper else DeviceKind.TOOL_ACTUATOR
    for name, device in model.devices.items():
        if device.kind not in (DeviceKind.TOOL_ACTUATOR, DeviceKind.GRIPPER):
            continue
        if device.kind != mover:
            text = f"expected {mover}, which moves this tool, got {device.kind}; correct it, or "
            text += "state its arm if it moves the tool of one of several"
            source.add(("devices", name, "kind"), text)
        if isinstance(model.tool, GripperModel):
            _check_lead(source, model.tool, name, device.lead)
        elif len(states) > 1 and device.lead <= 0.0:
            text = f"expected over 0 s, which the tool takes from one state to the other, got {device.lead:g}"
            source.add(("devices", name, "lead"), text)
        for i, action in enumerate(device.actions):
            refer(source, ("devices", name, "actions", i), "state of the tool", action, states)
        missing = [state for state in states if state not in device.actions]
        if missing:
            text = f"no action leads to {', '.join(missing)}; add one by the name of each state of the tool"
            source.add(("devices", name, "actions"), text)


def _check_lead(source: Source, tool: GripperModel, device: str, lead: float) -> None:
    """Check that the lead of a gripper covers the largest change of width between two states."""
    least = (max(tool.states.values()) - min(tool.states.values())) / tool.closing_speed
    if lead < least:
        text = f"expected at least {least:.3g} s, which the fingers need for the way between their states at "
        text += f"closing_speed, got {lead:g}; correct one of them"
        source.add(("devices", device, "lead"), text)
