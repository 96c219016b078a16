"""Consistency of a cell file with the robot's URDF: joints, postures, shapes and limits."""

from __future__ import annotations

from collections.abc import Mapping

from pickcli.cell.checks.gripper_consistency import finger_joints
from pickcli.cell.checks.references import refer
from pickcli.cell.robot import Joint, JointType
from pickcli.cell.robots.urdf import Urdf
from pickcli.cell.robots.urdf_origin import MAX_TURN
from pickcli.cell.schemas.cell_schema import CellModel
from pickcli.files.source import Source

# Limits that no real joint exceeds: m/s or rad/s, and their derivatives.
LINEAR = {"max_velocity": 20.0, "max_acceleration": 500.0, "max_jerk": 1e5}
ANGULAR = {"max_velocity": 60.0, "max_acceleration": 2000.0, "max_jerk": 1e6}


def check_robot(source: Source, model: CellModel, robot: Urdf) -> None:
    """Check the joints, postures, shapes and limits of a cell's robot.

    Args:
        source: Collects the mistakes with their places in the file.
        model: The cell as it stands in the file.
        robot: The robot with the tool.
    """
    _check_joints(source, model, robot)
    _check_posture(source, model, robot)
    _check_shapes(source, model, robot)
    _check_limits(source, model, robot)


def _check_joints(source: Source, model: CellModel, robot: Urdf) -> None:
    """Check that the planned joints are the chain's moving ones in order, without tool and fixed joints."""
    tool_joint, moving = model.tool_joint, robot.driven(robot.way(model.tip))
    expected = [name for name in moving if name != tool_joint and name not in model.robot.posture]
    if list(model.robot.joints) != expected:
        got, is_order = ", ".join(model.robot.joints), sorted(model.robot.joints) == sorted(expected)
        advice = "write them base outwards" if is_order else "one that stands still is named in robot.posture"
        source.add(
            ("robot", "joints"),
            f"expected the chain's moving joints but the tool's: {', '.join(expected)}; got {got}; {advice}",
        )
    for name in model.robot.motor_forces:
        refer(source, ("robot", "motor_forces", name), "moving joint", name, list(moving))
    for name in expected if tool_joint is None else [*expected, tool_joint]:
        if name not in model.robot.motor_forces:
            source.add(("robot", "motor_forces", name), "expected a force in N or Nm, got nothing; add it")


def _check_posture(source: Source, model: CellModel, robot: Urdf) -> None:
    """Check that every joint that is not planned has a position within its limits."""
    posture, of_tool = model.robot.posture, {model.tool_joint, *finger_joints(model, robot)}
    free = robot.driven(robot.joints.values())
    chain = {joint.name for joint in robot.way(model.tip)} | {*model.robot.joints, *of_tool}
    for name in free.keys() - chain - posture.keys():
        source.add(
            ("robot", "posture", name), "is not planned; expected where it stands in rad or m, got nothing"
        )
    for name, position in posture.items():
        refer(source, ("robot", "posture", name), "moving joint", name, list(free))
        if name in of_tool:
            source.add(
                ("robot", "posture", name), "is the tool's; where it stands its states say: leave it out"
            )
        elif name in free and not free[name].lower <= position <= free[name].upper:
            unit = "m, not mm" if free[name].type is JointType.PRISMATIC else "rad, not degrees"
            text = (
                f"expected {free[name].lower:g} to {free[name].upper:g}, got {position:g}; positions are in "
            )
            source.add(("robot", "posture", name), f"{text}{unit}")
    for name, mimic in robot.mimics.items():
        if name not in of_tool and mimic.joint in {*model.robot.joints, *of_tool}:
            text = f"{name!r} mimics it, which cannot be planned; let it stand (robot.posture)"
            source.add(("robot", "joints"), f"{mimic.joint!r}: {text}")


def _check_shapes(source: Source, model: CellModel, robot: Urdf) -> None:
    """Check that no link is ignored in collision checks because it has no collision shape."""
    accepted = model.robot.unshaped
    for i, name in enumerate(accepted):
        refer(source, ("robot", "unshaped", i), "link", name, list(robot.links))
    for name, line in robot.unshaped.items():
        if name not in accepted:
            source.add(
                ("robot", "urdf"),
                f"line {line}: link {name!r} is drawn but has no collision shape, so nothing of it would be "
                "tested; add <collision>, or name it in robot.unshaped",
            )
    moved: dict[str, list[str]] = {}  # links by the last planned joint that moves them
    for name in robot.links:
        movers = [joint.name for joint in robot.way(name) if joint.name in model.robot.joints]
        if movers:
            moved.setdefault(movers[-1], []).append(name)
    for joint, links in moved.items():
        if not any(robot.links[name].bodies for name in links) and not set(links) & set(accepted):
            source.add(
                ("robot", "urdf"),
                f"nothing that {joint!r} moves has a collision shape ({', '.join(links)}); add <collision>, "
                "or name a link of these in robot.unshaped",
            )


def _check_limits(source: Source, model: CellModel, robot: Urdf) -> None:
    joints = robot.driven(robot.way(model.tip))
    _check_magnitudes(source, model, joints)
    for name in model.robot.joints:
        if name not in model.joint_limits:
            source.add(
                ("joint_limits", name),
                "expected velocity, acceleration and jerk limits, got nothing; a URDF has no acceleration "
                "limits and none are assumed: add them here",
            )
    for name, limit in model.joint_limits.items():
        refer(source, ("joint_limits", name), "planned joint", name, model.robot.joints)
        joint = joints.get(name)
        if joint is None:
            continue
        low = joint.lower if limit.min_position is None else limit.min_position
        high = joint.upper if limit.max_position is None else limit.max_position
        if low > high and joint.lower <= high and low <= joint.upper:
            source.add(
                ("joint_limits", name, "max_position"),
                f"expected min_position under max_position, got {low:g} and {high:g}; swap them",
            )
        elif not joint.lower <= low < high <= joint.upper:
            is_turned = joint.type is not JointType.PRISMATIC and max(-low, high) > MAX_TURN
            advice = "positions are in rad, not degrees" if is_turned else "correct them"
            is_upper = limit.max_position is not None and low >= joint.lower
            figure = "max_position" if is_upper else "min_position"
            source.add(
                ("joint_limits", name, figure),
                f"expected positions inside the URDF's {joint.lower:g} to {joint.upper:g}, "
                f"got {low:g} to {high:g}; {advice}",
            )


def _check_magnitudes(source: Source, model: CellModel, joints: Mapping[str, Joint]) -> None:
    """Refuse limits above any real joint's, which were probably written in another unit."""
    for name, limit in model.joint_limits.items():
        is_linear = name in joints and joints[name].type is JointType.PRISMATIC
        most, unit = (LINEAR, "m, not mm") if is_linear else (ANGULAR, "rad, not degrees")
        for figure, value in most.items():
            if getattr(limit, figure) > value:
                source.add(
                    ("joint_limits", name, figure),
                    f"expected at most {value:g}, got {getattr(limit, figure):g}; limits are in {unit}",
                )
