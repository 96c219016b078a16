"""Consistency of a cell file: references by name, and figures that must fit together.

Details are in `robot_consistency`, `tool_consistency` and `station_consistency`.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import tau

from pickcli.cell.checks.references import refer, unique
from pickcli.cell.checks.robot_consistency import check_robot
from pickcli.cell.checks.station_consistency import check_places, check_pod, check_tote, own_bodies
from pickcli.cell.checks.tool_consistency import (
    check_devices,
    check_mount,
    check_tip,
    check_tool,
    tool_states,
)
from pickcli.cell.makers.pod import build_pod
from pickcli.cell.makers.tote import build_tote
from pickcli.cell.robot import JointType
from pickcli.cell.robots.urdf import Urdf
from pickcli.cell.robots.urdf_origin import MAX_TURN
from pickcli.cell.schemas.cell_schema import CellModel, JointLimitModel
from pickcli.cell.schemas.tool_schema import ToolModel
from pickcli.files.source import Key, Source

MAX_PLAUSIBLE_POSITION = 10.0  # m; a joint position beyond this was probably written in another unit


def check_parts(
    source: Source, model: CellModel, robot: Urdf, tools: Mapping[Key, tuple[ToolModel, Urdf | None]]
) -> None:
    """Check that links under ``robot.without`` exist, and that the tools can be mounted on the robot.

    Args:
        source: The file, for places in messages.
        model: The cell as it stands in the file.
        robot: The robot.
        tools: The tools by their keys in the file, each with its separate URDF or None.

    Raises:
        InputError: With every disagreement.
    """
    for i, name in enumerate(model.robot.without):
        refer(source, ("robot", "without", i), "link", name, list(robot.links))
        if name == robot.root:
            source.add(("robot", "without", i), f"{name!r} is the root link; name links that hang on it")
    tips: dict[Key, tuple[Key, str | None]] = {
        ("arms", name): (("arms", name, "tip"), arm.tip) for name, arm in model.arms.items()
    }
    for key, (tip_key, tip) in (tips or {(): (("robot", "tip"), model.robot.tip)}).items():
        if (*key, "tool") not in tools:
            check_tip(source, tip_key, tip, robot)
        elif tip is not None:
            text = "is of an arm without a tool, here the chain ends with the tool; leave it out"
            source.add(tip_key, text)
    whole = [robot]
    for tool_key, (stated, tool) in tools.items():
        check_mount(source, tool_key, stated, robot, tool, whole)
        whole += [] if tool is None else [tool]
    source.check()


def check_consistency(source: Source, model: CellModel, robot: Urdf) -> None:
    """Check that the parts of a cell file are consistent with each other and with the robot.

    Args:
        source: The file, for places in messages.
        model: The cell as it stands in the file.
        robot: The robot with the tool.

    Raises:
        InputError: With every disagreement.
    """
    if model.tool is not None:
        check_tool(source, model.tool, robot)
    source.check()  # the further checks need a valid tip
    check_robot(source, model, robot)
    if model.pod is not None:
        check_pod(source, model.pod)
    if model.tote is not None:
        check_tote(source, model.tote)
    check_places(source, model)
    _check_pairs(source, model, robot)
    _check_configurations(source, model, robot)
    check_devices(source, model)
    source.check()
    _check_names(source, model, robot)
    source.check()


def _check_pairs(source: Source, model: CellModel, robot: Urdf) -> None:
    links = list(robot.links)
    obstacles = [obstacle.name for obstacle in model.obstacles]
    unique(source, [("obstacles", i, "name") for i in range(len(obstacles))], obstacles)
    for i, pair in enumerate(model.allowed_pairs):
        refer(source, ("allowed_pairs", i, "a"), "link", pair.a, links)
        refer(source, ("allowed_pairs", i, "b"), "link or obstacle", pair.b, links + obstacles)
        if pair.a == pair.b:
            text = f"{pair.b!r} is never tested against itself; name the other one, or delete the pair"
            source.add(("allowed_pairs", i, "b"), text)


def _check_names(source: Source, model: CellModel, robot: Urdf) -> None:
    """Check that names of links, bodies and obstacles are unique, as contacts and allowed pairs use them."""
    pod = () if model.pod is None else build_pod(model.pod).bodies
    tote = () if model.tote is None else build_tote(model.tote).bodies
    shelf = {body.name for body in (*pod, *tote)}
    known = dict.fromkeys((*robot.links, *(o.name for o in model.obstacles), *shelf), "the cell")
    for name, bodies in own_bodies(source, model).items():
        for body in bodies:
            if body.name in known:
                text = f"its body {body.name!r} has the name of another one in {known[body.name]}; rename it"
                source.add(("places", name), text)
            known[body.name] = f"places.{name}"
    for i, obstacle in enumerate(model.obstacles):
        if obstacle.name in robot.links:
            text = f"{obstacle.name!r} is a link of the robot too; rename the obstacle"
            source.add(("obstacles", i, "name"), text)
        elif obstacle.name in shelf:
            text = f"{obstacle.name!r} is a part of the pod or the tote too; rename the obstacle"
            source.add(("obstacles", i, "name"), text)
    for name in sorted(shelf & robot.links.keys()):
        source.add(
            ("robot", "urdf"), f"link {name!r} has the name of a part of the pod or the tote; rename it"
        )


def _check_configurations(source: Source, model: CellModel, robot: Urdf) -> None:
    driven = robot.driven(robot.way(model.tip))
    joints = [driven.get(name) for name in model.robot.joints]
    named = model.configurations
    unique(source, [("configurations", i, "name") for i in range(len(named))], [c.name for c in named])
    states = tool_states(model)
    for i, configuration in enumerate(named):
        if configuration.tool_state is not None:
            refer(
                source,
                ("configurations", i, "tool_state"),
                "state of the tool",
                configuration.tool_state,
                states,
            )
        if len(configuration.q) != len(joints):
            text = f"expected {len(joints)} numbers, one per planned joint, got {len(configuration.q)}"
            source.add(("configurations", i, "q"), text)
            continue
        for j, (joint, value) in enumerate(zip(joints, configuration.q, strict=True)):
            if joint is None:
                continue
            is_continuous = joint.type is JointType.CONTINUOUS
            lower, upper = (-MAX_TURN, MAX_TURN) if is_continuous else (joint.lower, joint.upper)
            lower, upper = _narrowed(model.joint_limits.get(joint.name), lower, upper)
            if not lower <= value <= upper and lower < upper:
                unit = "m" if joint.type is JointType.PRISMATIC else "rad"
                text = f"expected {joint.name} in {lower:g} to {upper:g} {unit}, got {value:g}; "
                source.add(("configurations", i, "q", j), text + _position_advice(unit, value))


def _position_advice(unit: str, value: float) -> str:
    """Advice on a position beyond its limits; a position far beyond was probably meant in another unit."""
    if abs(value) > (tau if unit == "rad" else MAX_PLAUSIBLE_POSITION):
        return "angles are in rad, not degrees" if unit == "rad" else "lengths are in m, not mm"
    return "correct it; numbers stand in the order of robot.joints"


def _narrowed(limit: JointLimitModel | None, lower: float, upper: float) -> tuple[float, float]:
    """Position limits of a joint, rad or m, narrowed by those of the cell file."""
    low = None if limit is None else limit.min_position
    high = None if limit is None else limit.max_position
    return lower if low is None else low, upper if high is None else high
