"""What the parts of a cell file must agree on: names that refer to each other, figures that fit together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

from pickcli.cell.cell_schema import CellModel
from pickcli.cell.pod import flat_from
from pickcli.cell.robot import Joint, JointType
from pickcli.cell.tool import FIXED, MOVING
from pickcli.cell.urdf import Urdf
from pickcli.errors import shortened, suggestion
from pickcli.files.yaml_reader import Key, Source

# The most of any joint that is built: m/s or rad/s, and their derivatives.
LINEAR = {"max_velocity": 20.0, "max_acceleration": 500.0, "max_jerk": 1e5}
ANGULAR = {"max_velocity": 60.0, "max_acceleration": 2000.0, "max_jerk": 1e6}


def check_parts(source: Source, model: CellModel, robot: Urdf, tool: Urdf | None) -> None:
    """Check that what the cell takes off the robot is there, and that its tool can be mounted on it.

    Args:
        source: The file, for places in messages.
        model: The cell as it stands in the file.
        robot: Its robot.
        tool: Its tool, if that has a URDF of its own.

    Raises:
        InputError: With every disagreement.
    """
    for i, name in enumerate(model.robot.without):
        _refer(source, ("robot", "without", i), "link", name, list(robot.links))
        if name == robot.root:
            source.add(("robot", "without", i), f"{name!r} is the root link; name links that hang on it")
    if tool is not None:
        _refer(
            source, ("tool", "flange_link"), "link of the robot", model.tool.flange_link, list(robot.links)
        )
        for name in tool.links.keys() & robot.links.keys():
            source.add(("tool", "urdf"), f"link {name!r} is one of the robot's too; rename one")
        taken = {joint.name for joint in robot.joints.values()}
        for name in sorted(taken & {joint.name for joint in tool.joints.values()}):
            source.add(("tool", "urdf"), f"joint {name!r} is one of the robot's too; rename one")
    elif model.tool.T_flange_tool is not None:
        source.add(
            ("tool", "T_flange_tool"), "is of a tool with a URDF of its own; add tool.urdf or leave it out"
        )
    source.check()


def check_consistency(source: Source, model: CellModel, robot: Urdf) -> None:
    """Check what the parts of a cell file must agree on, among each other and with the robot.

    Args:
        source: The file, for places in messages.
        model: The cell as it stands in the file.
        robot: Its robot with the tool.

    Raises:
        InputError: With every disagreement.
    """
    _check_tool(source, model, robot)
    source.check()  # without a tool there is no chain
    _check_joints(source, model, robot)
    _check_posture(source, model, robot)
    _check_shapes(source, model, robot)
    _check_limits(source, model, robot)
    _check_pod(source, model)
    _check_tote(source, model)
    _check_pairs(source, model, robot)
    _check_configurations(source, model, robot)
    _check_devices(source, model)
    source.check()


def _refer(source: Source, key: Key, kind: str, name: str, known: Sequence[str]) -> None:
    """Note a name that does not exist."""
    if name not in known:
        hint = "" if source.is_full else f"; {suggestion(name, known)}"
        source.add(key, f"no {kind} is named {shortened(name)!r}{hint}")


def _unique(source: Source, keys: Sequence[Key], names: Sequence[str]) -> None:
    """Note names that stand twice."""
    seen: set[str] = set()
    for key, name in zip(keys, names, strict=True):
        if name in seen:
            source.add(key, f"the name {name!r} stands twice; rename one")
        seen.add(name)


def _chain(model: CellModel, robot: Urdf) -> tuple[Joint, ...]:
    """The joints from the base to the cup."""
    return robot.way(model.tool.cup_link)


def _moving(model: CellModel, robot: Urdf) -> dict[str, Joint]:
    """The joints of the chain that a motor moves."""
    return {
        joint.name: joint
        for joint in _chain(model, robot)
        if joint.type is not JointType.FIXED and joint.name not in robot.mimics
    }


def _check_joints(source: Source, model: CellModel, robot: Urdf) -> None:
    """Planned joints are the moving ones of the chain in its order, but the tool's and those that stand."""
    pivot, moving = model.tool.pivot_joint, _moving(model, robot)
    expected = [name for name in moving if name != pivot and name not in model.robot.posture]
    if list(model.robot.joints) != expected:
        got = ", ".join(model.robot.joints)
        source.add(
            ("robot", "joints"),
            f"expected the chain's moving joints but the pivot: {', '.join(expected)}; got {got}; one that "
            "stands still is named in robot.posture",
        )
    for name in model.robot.motor_forces:
        _refer(source, ("robot", "motor_forces", name), "moving joint", name, list(moving))
    for name in expected if pivot is None else [*expected, pivot]:
        if name not in model.robot.motor_forces:
            source.add(("robot", "motor_forces", name), "expected a force in N or Nm, got nothing; add it")


def _check_posture(source: Source, model: CellModel, robot: Urdf) -> None:
    """Every joint that is not planned stands somewhere, within its limits."""
    pivot, posture = model.tool.pivot_joint, model.robot.posture
    free = {
        joint.name: joint
        for joint in robot.joints.values()
        if joint.type is not JointType.FIXED and joint.name not in robot.mimics
    }
    chain = {joint.name for joint in _chain(model, robot)} | {*model.robot.joints, pivot}
    for name in free.keys() - chain - posture.keys():
        source.add(
            ("robot", "posture", name), "is not planned; expected where it stands in rad or m, got nothing"
        )
    for name, position in posture.items():
        _refer(source, ("robot", "posture", name), "moving joint", name, list(free))
        if name == pivot:
            source.add(
                ("robot", "posture", name), "is the tool's; where it stands its states say: leave it out"
            )
        elif name in free and not free[name].lower <= position <= free[name].upper:
            source.add(
                ("robot", "posture", name),
                f"expected {free[name].lower:g} to {free[name].upper:g}, got {position:g}; correct it",
            )
    for name, mimic in robot.mimics.items():
        if mimic.joint in model.robot.joints or mimic.joint == pivot:
            text = f"{name!r} mimics it, which cannot be planned; let it stand (robot.posture)"
            source.add(("robot", "joints"), f"{mimic.joint!r}: {text}")


def _check_shapes(source: Source, model: CellModel, robot: Urdf) -> None:
    """No link passes as free because nothing of it is tested."""
    accepted = model.robot.unshaped
    for i, name in enumerate(accepted):
        _refer(source, ("robot", "unshaped", i), "link", name, list(robot.links))
    for name, line in robot.unshaped.items():
        if name not in accepted:
            source.add(
                ("robot", "urdf"),
                f"line {line}: link {name!r} is drawn but has no collision shape, so nothing of it would be "
                "tested; add <collision>, or name it in robot.unshaped",
            )
    moved: dict[str, list[str]] = {}  # links by the planned joint that moves them last
    for name in robot.links:
        movers = [joint.name for joint in robot.way(name) if joint.name in model.robot.joints]
        if movers:
            moved.setdefault(movers[-1], []).append(name)
    for joint, links in moved.items():
        if not any(robot.links[name].shapes for name in links) and not set(links) & set(accepted):
            source.add(
                ("robot", "urdf"),
                f"nothing that {joint!r} moves has a collision shape ({', '.join(links)}); add <collision>, "
                "or name a link of these in robot.unshaped",
            )


def _check_limits(source: Source, model: CellModel, robot: Urdf) -> None:
    joints = _moving(model, robot)
    _check_magnitudes(source, model, joints)
    for name in model.robot.joints:
        if name not in model.joint_limits:
            source.add(
                ("joint_limits", name),
                "expected velocity, acceleration and jerk limits, got nothing; a URDF has no acceleration "
                "limits and none are assumed: add them here",
            )
    for name, limit in model.joint_limits.items():
        _refer(source, ("joint_limits", name), "planned joint", name, model.robot.joints)
        joint = joints.get(name)
        if joint is None:
            continue
        low = joint.lower if limit.min_position is None else limit.min_position
        high = joint.upper if limit.max_position is None else limit.max_position
        if not joint.lower <= low < high <= joint.upper:
            source.add(
                ("joint_limits", name),
                f"expected positions inside the URDF's {joint.lower:g} to {joint.upper:g}, "
                f"got {low:g} to {high:g}; correct them",
            )


def _check_magnitudes(source: Source, model: CellModel, joints: Mapping[str, Joint]) -> None:
    """Limits that no joint has were written in another unit."""
    for name, limit in model.joint_limits.items():
        is_linear = name in joints and joints[name].type is JointType.PRISMATIC
        most, unit = (LINEAR, "m, not mm") if is_linear else (ANGULAR, "rad, not degrees")
        for figure, value in most.items():
            if getattr(limit, figure) > value:
                source.add(
                    ("joint_limits", name, figure),
                    f"expected at most {value:g}, got {getattr(limit, figure):g}; limits are in {unit}",
                )


def _check_tool(source: Source, model: CellModel, robot: Urdf) -> None:
    """The chain ends flange, lance, cup."""
    tool = model.tool
    names = list(robot.links)
    for role in ("flange_link", "lance_link", "cup_link"):
        _refer(source, ("tool", role), "link", getattr(tool, role), names)
    last = [robot.root, *(joint.child for joint in _chain(model, robot))][-3:]
    if last != [tool.flange_link, tool.lance_link, tool.cup_link]:
        text = f"expected the chain to end with flange, lance and cup link; it ends {', '.join(last)}"
        source.add(("tool",), text)
    for joint in robot.children(tool.cup_link):
        source.add(("tool", "cup_link"), f"{joint.child!r} hangs on it; the cup is the last link")
    _check_states(source, model, robot)


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
    joints = _moving(model, robot)
    _refer(source, ("tool", "pivot_joint"), "moving joint", name, list(joints))
    if MOVING.name in positions:
        text = f"{MOVING} means that the tool is between two states; give this one another name"
        source.add(("tool", "pivot_positions", MOVING.name), text)
    joint = joints.get(name)
    if joint is None:
        return
    last = _chain(model, robot)[-1]
    if joint is not last:
        text = f"expected the last joint of the chain, {last.name!r}, got {name!r}; correct it"
        source.add(("tool", "pivot_joint"), text)
    if not all(joint.lower - 1e-9 <= p <= joint.upper + 1e-9 for p in positions.values()):
        source.add(("tool", "pivot_positions"), f"outside of the joint's {joint.lower:g} to {joint.upper:g}")


def _states(model: CellModel) -> list[str]:
    """Names of the tool's states."""
    return list(model.tool.pivot_positions or {FIXED.name: 0.0})


def _check_devices(source: Source, model: CellModel) -> None:
    """What moves the tool is commanded by the names of its states, to each of them."""
    states = _states(model)
    for name, device in model.devices.items():
        if device.kind != "pivot":
            continue
        for i, action in enumerate(device.actions):
            _refer(source, ("devices", name, "actions", i), "state of the tool", action, states)
        missing = [state for state in states if state not in device.actions]
        if missing:
            text = f"no action leads to {', '.join(missing)}; add one by the name of each state of the tool"
            source.add(("devices", name, "actions"), text)


def _check_pod(source: Source, model: CellModel) -> None:
    pod = model.pod
    _ascending(
        source,
        ("divider", pod.divider + pod.divider_thickness),
        ("post", pod.post),
        ("side_wall", pod.side_wall),
        ("width", pod.width / 2),
    )
    _ascending(
        source,
        ("lip_depth", pod.lip_depth),
        ("hanging_lip_depth", pod.hanging_lip_depth),
        ("floor_slope", flat_from(pod)),  # where the slope ends
        ("back_wall", pod.back_wall),
        ("depth", pod.depth),
    )
    for i, (upper, lower) in enumerate(pairwise(pod.rows)):
        gap = upper.floor_front - pod.board_thickness - lower.ceiling_front
        if abs(gap) > 5e-4:
            source.add(
                ("pod", "rows", i + 1, "ceiling_front"),
                f"expected the underside of the board above, {lower.ceiling_front + gap:.4f} m, "
                f"got {lower.ceiling_front:g}; correct it, floor_front above or board_thickness",
            )
    keys: list[Key] = [("pod", "rows", i, "bins", j) for i in range(len(pod.rows)) for j in range(3)]
    _unique(source, keys, [name for row in pod.rows for name in row.bins])


def _check_tote(source: Source, model: CellModel) -> None:
    """The flange runs around the rim, outside of the walls."""
    tote = model.tote
    for axis, name in enumerate("xy"):
        low = tote.inner.lower[axis] - tote.wall_thickness
        high = tote.inner.upper[axis] + tote.wall_thickness
        if not tote.flange.lower[axis] <= low < high <= tote.flange.upper[axis]:
            source.add(
                ("tote", "inner"),
                f"puts the walls at {name} from {low:g} to {high:g}, expected inside the flange's "
                f"{tote.flange.lower[axis]:g} to {tote.flange.upper[axis]:g}; correct one of the two",
            )


def _ascending(source: Source, *places: tuple[str, float]) -> None:
    """Note every place, on the way outwards or inwards, that does not lie beyond the one before."""
    for (before, low), (name, high) in pairwise(places):
        if not low < high:
            text = f"puts it at {high:.4g} m, expected beyond {low:.4g} m ({before}); correct one of the two"
            source.add(("pod", name), text)


def _check_pairs(source: Source, model: CellModel, robot: Urdf) -> None:
    links = list(robot.links)
    obstacles = [obstacle.name for obstacle in model.obstacles]
    _unique(source, [("obstacles", i, "name") for i in range(len(obstacles))], obstacles)
    for i, pair in enumerate(model.allowed_pairs):
        _refer(source, ("allowed_pairs", i, "a"), "link", pair.a, links)
        _refer(source, ("allowed_pairs", i, "b"), "link or obstacle", pair.b, links + obstacles)


def _check_configurations(source: Source, model: CellModel, robot: Urdf) -> None:
    joints = [_moving(model, robot).get(name) for name in model.robot.joints]
    named = model.configurations
    _unique(source, [("configurations", i, "name") for i in range(len(named))], [c.name for c in named])
    states = _states(model)
    for i, configuration in enumerate(named):
        if configuration.pivot is not None:
            _refer(source, ("configurations", i, "pivot"), "state of the tool", configuration.pivot, states)
        if len(configuration.q) != len(joints):
            text = f"expected {len(joints)} numbers, one per planned joint, got {len(configuration.q)}"
            source.add(("configurations", i, "q"), text)
            continue
        for j, (joint, value) in enumerate(zip(joints, configuration.q, strict=True)):
            if joint is not None and not joint.lower <= value <= joint.upper:
                unit = "m" if joint.type is JointType.PRISMATIC else "rad"
                text = f"expected {joint.name} in {joint.lower:g} to {joint.upper:g} {unit}, got {value:g}; "
                text += "angles are in rad, not degrees" if unit == "rad" else "lengths are in m, not mm"
                source.add(("configurations", i, "q", j), text)
