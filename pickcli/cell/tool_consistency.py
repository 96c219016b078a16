"""What a cell file says of its tool, held against the URDF: links, states, devices that change them."""

from __future__ import annotations

from pickcli.cell.cell_schema import CellModel
from pickcli.cell.references import refer
from pickcli.cell.tool import FIXED, MOVING
from pickcli.cell.urdf import Urdf
from pickcli.files.yaml_reader import Source


def check_tool(source: Source, model: CellModel, robot: Urdf) -> None:
    """Check that the chain ends flange, lance, cup, and that the tool's states are positions of its joint.

    Args:
        source: Collects the mistakes with their places in the file.
        model: The cell as it stands in the file.
        robot: Its robot with the tool.
    """
    tool = model.tool
    names = list(robot.links)
    for role in ("flange_link", "lance_link", "cup_link"):
        refer(source, ("tool", role), "link", getattr(tool, role), names)
    last = [robot.root, *(joint.child for joint in robot.way(model.tool.cup_link))][-3:]
    if last != [tool.flange_link, tool.lance_link, tool.cup_link]:
        text = f"expected the chain to end with flange, lance and cup link; it ends {', '.join(last)}"
        source.add(("tool",), text)
    for joint in robot.children(tool.cup_link):
        source.add(("tool", "cup_link"), f"{joint.child!r} hangs on it; the cup is the last link")
    _check_states(source, model, robot)


def tool_states(model: CellModel) -> list[str]:
    """Names of the states that the tool of a cell can rest in.

    Args:
        model: The cell as it stands in the file.

    Returns:
        The names, in the order of the file.
    """
    return list(model.tool.pivot_positions or {FIXED.name: 0.0})


def _check_states(source: Source, model: CellModel, robot: Urdf) -> None:
    """The states of the tool are positions of the last joint of the chain."""
    name, positions = model.tool.pivot_joint, model.tool.pivot_positions
    if name is None or positions is None:
        if name is not None:
            source.add(("tool", "pivot_positions"), "expected a position by state, got nothing; add it")
        elif positions is not None:
            source.add(
                ("tool", "pivot_joint"), "expected the joint that has these positions, got nothing; add it"
            )
        return
    joints = robot.driven(robot.way(model.tool.cup_link))
    refer(source, ("tool", "pivot_joint"), "moving joint", name, list(joints))
    if MOVING.name in positions:
        text = f"{MOVING} means that the tool is between two states; give this one another name"
        source.add(("tool", "pivot_positions", MOVING.name), text)
    joint = joints.get(name)
    if joint is None:
        return
    last = robot.way(model.tool.cup_link)[-1]
    if joint is not last:
        text = f"expected the last joint of the chain, {last.name!r}, got {name!r}; correct it"
        source.add(("tool", "pivot_joint"), text)
    if not all(joint.lower - 1e-9 <= p <= joint.upper + 1e-9 for p in positions.values()):
        source.add(("tool", "pivot_positions"), f"outside of the joint's {joint.lower:g} to {joint.upper:g}")


def check_devices(source: Source, model: CellModel) -> None:
    """Check that what moves the tool is commanded by the names of its states, to each of them.

    Args:
        source: Collects the mistakes with their places in the file.
        model: The cell as it stands in the file.
    """
    states = tool_states(model)
    for name, device in model.devices.items():
        if device.kind != "pivot":
            continue
        for i, action in enumerate(device.actions):
            refer(source, ("devices", name, "actions", i), "state of the tool", action, states)
        missing = [state for state in states if state not in device.actions]
        if missing:
            text = f"no action leads to {', '.join(missing)}; add one by the name of each state of the tool"
            source.add(("devices", name, "actions"), text)
