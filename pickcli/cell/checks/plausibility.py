"""Warnings for valid but implausible figures of a cell, with what was probably meant."""

from __future__ import annotations

import math

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.checks.place_plausibility import warn_of_places
from pickcli.cell.checks.sensor_plausibility import warn_of_cameras
from pickcli.cell.device import DeviceKind
from pickcli.cell.schemas.cell_schema import CellModel
from pickcli.cell.schemas.tool_schema import GripperModel, SuctionModel
from pickcli.files.file_warnings import FileWarnings
from pickcli.files.source import Key

LARGE_LEAD = 5.0  # s, lead of a device; an ejector builds up its vacuum faster
ATMOSPHERE = 101_325.0  # Pa, upper bound of a cup's vacuum
WEAK = 10_000.0  # Pa, of a cup: a tenth of an ejector's vacuum
LARGE_CUP = {"cup_radius": 0.1, "cup_stroke": 0.05, "cup_length": 0.3}  # m
NEAR_CLEARANCE, FAR_CLEARANCE = 0.0005, 0.03  # m: a robot's repeatability, and the room around a finger
FAST = {"m": (5.0, 100.0), "rad": (15.0, 200.0)}  # velocity and acceleration of the fastest arms on sale
STRONG = 10_000.0  # N or Nm, more than the shoulder of the largest arms
FIRM, STICKY = 500.0, 1.2  # N, force of a pad, and its friction
UNDRAWN = 0.001  # m by which a cup may be larger than its shapes, for rounded figures
SLOW = 10.0, 2.0  # s from rest to a joint's full velocity, and to its full acceleration
SOFT = 0.1  # N that take up a cup's whole stroke: it hangs down under its own weight

# Kinds of devices that a pick commands, with the actions that each needs.
NEEDED = {DeviceKind.PUMP: ("on", "off"), DeviceKind.VALVE: ("on", "off"), DeviceKind.SENSOR: ("read",)}


def warn_of_figures(warnings: FileWarnings, cell: Cell, model: CellModel) -> None:
    """Warn of figures that are possible but probably not meant.

    Args:
        warnings: Collects them.
        cell: The cell.
        model: The cell as it stands in the file.
    """
    _devices(warnings, cell, model)
    if isinstance(model.tool, SuctionModel):
        _cup(warnings, model.tool)
        _drawn_cup(warnings, model.tool, cell)
    elif isinstance(model.tool, GripperModel):
        _gripper(warnings, model.tool)
    _clearance(warnings, model)
    _limits(warnings, cell)
    warn_of_places(warnings, cell, model)
    warn_of_cameras(warnings, cell)


def _devices(warnings: FileWarnings, cell: Cell, model: CellModel) -> None:
    for name, device in cell.devices.items():
        if device.lead > LARGE_LEAD:
            text = f"{device.lead:g} s pass before every pick until it takes effect; is it in s?"
            warnings.add("slow_device", name, ("devices", name, "lead"), text)
        missing = [action for action in NEEDED.get(device.kind, ()) if action not in device.actions]
        if missing:
            text = f"a {device.kind} is switched by {' and '.join(missing)}; name its actions so"
            warnings.add("useless_device", name, ("devices", name, "actions"), text)
    if not cell.places or model.tool is None:
        return
    is_gripper = isinstance(model.tool, GripperModel)
    for kind in (DeviceKind.GRIPPER,) if is_gripper else (DeviceKind.PUMP, DeviceKind.VALVE):
        if not any(device.kind is kind for device in cell.devices.values()):
            text = f"no {kind} is among them, and nothing can be picked without one; add it"
            warnings.add("no_device", kind, ("devices",), text)


def _cup(warnings: FileWarnings, tool: SuctionModel) -> None:
    for name, most in LARGE_CUP.items():
        value = getattr(tool, name)
        if value > most:
            text = f"{1e3 * value:g} mm is large for a cup; is it in m?"
            warnings.add("large_cup", name, ("tool", name), text)
    if tool.cup_length < tool.cup_stroke <= LARGE_CUP["cup_stroke"]:
        text = (
            f"{1e3 * tool.cup_stroke:g} mm is more than the cup's {1e3 * tool.cup_length:g} mm; correct one"
        )
        warnings.add("large_cup", "cup_stroke", ("tool", "cup_stroke"), text)
    area = math.pi * tool.cup_radius**2
    pressure = tool.max_pull / area
    size = f"a cup of {1e3 * tool.cup_radius:g} mm radius"
    if pressure > ATMOSPHERE:
        text = f"{size} bears {ATMOSPHERE * area:.3g} N in perfect vacuum, not {tool.max_pull:g}; correct one"
        warnings.add("weak_or_strong_cup", "max_pull", ("tool", "max_pull"), text)
    elif pressure < WEAK:
        text = f"{tool.max_pull:g} N is {pressure / 1e3:.1f} kPa under {size}; is it in N, not kg?"
        warnings.add("weak_or_strong_cup", "max_pull", ("tool", "max_pull"), text)
    if tool.max_moment > 2.0 * tool.max_pull * tool.cup_radius:
        most = tool.max_pull * tool.cup_radius
        text = f"{size} that bears {tool.max_pull:g} N peels off at about {most:.3g} Nm, not "
        text += f"{tool.max_moment:g}; is it in Nm?"
        warnings.add("weak_or_strong_cup", "max_moment", ("tool", "max_moment"), text)
    if tool.max_shear > 2.0 * tool.max_pull:
        text = f"{tool.max_shear:g} N across a cup that pulls {tool.max_pull:g} N needs a friction of "
        text += f"{tool.max_shear / tool.max_pull:.3g}; correct one"
        warnings.add("weak_or_strong_cup", "max_shear", ("tool", "max_shear"), text)
    _bellows_and_twist(warnings, tool)
    if tool.seal_time == 0.0:
        text = "the cup moves an item at once, before it has sealed; state what the vacuum takes"
        warnings.add("no_seal_time", "tool", ("tool", "seal_time"), text)


def _bellows_and_twist(warnings: FileWarnings, tool: SuctionModel) -> None:
    pressed = tool.cup_stiffness * tool.cup_stroke
    if not SOFT <= pressed <= tool.max_pull:
        text = f"{pressed:.3g} N press the cup in by its whole {1e3 * tool.cup_stroke:g} mm, "
        text += (
            "less than its own weight" if pressed < SOFT else f"more than the {tool.max_pull:g} N it pulls"
        )
        text += "; is it in N/m, not N/mm?"
        warnings.add("weak_or_strong_cup", "cup_stiffness", ("tool", "cup_stiffness"), text)
    most = tool.max_shear * tool.cup_radius  # if all friction acted at the rim
    if tool.max_twist is not None and tool.max_twist > 1.01 * most:
        text = f"a cup of {1e3 * tool.cup_radius:g} mm radius that slides at {tool.max_shear:g} N turns at "
        text += f"{most:.3g} Nm at most, not {tool.max_twist:g}; is it in Nm?"
        warnings.add("weak_or_strong_cup", "max_twist", ("tool", "max_twist"), text)


def _drawn_cup(warnings: FileWarnings, tool: SuctionModel, cell: Cell) -> None:
    """Warn of a cup that is longer or wider than its collision shapes: what is over is never tested."""
    shapes = next(link.bodies for link in cell.robot.links if link.name == tool.cup_link)
    if not shapes:
        return
    middles = np.array([body.T_parent_shape[:3, 3] for body in shapes])
    reaches = np.array([body.shape.reach(body.T_parent_shape[:3, :3]) for body in shapes])
    low, high = (middles - reaches).min(axis=0), (middles + reaches).max(axis=0)
    drawn = {"cup_length": float(high[2]), "cup_radius": float((high - low)[:2].min() / 2)}
    for name, size in drawn.items():
        stated = getattr(tool, name)
        if stated > size + UNDRAWN:
            text = f"{1e3 * stated:g} mm, but the shapes of {tool.cup_link} in the URDF end at "
            text += f"{1e3 * size:.3g} mm, and what is beyond is never tested; correct one"
            warnings.add("cup_not_as_drawn", name, ("tool", name), text)


def _gripper(warnings: FileWarnings, tool: GripperModel) -> None:
    if tool.force > FIRM:
        text = f"{tool.force:g} N is more than parallel grippers for items have; is it in N?"
        warnings.add("odd_gripper", "force", ("tool", "force"), text)
    if tool.friction > STICKY:
        text = f"{tool.friction:g} is more than rubber has on paper; what slips is planned as if it held"
        warnings.add("odd_gripper", "friction", ("tool", "friction"), text)
    T_hand_tip = tool.T_hand_tip.T
    if float(T_hand_tip[:3, 2] @ T_hand_tip[:3, 3]) < 0.0:
        text = "+z points back into the hand, and the hand would come to items from behind; correct its rpy"
        warnings.add("odd_gripper", "T_hand_tip", ("tool", "T_hand_tip"), text)


def _clearance(warnings: FileWarnings, model: CellModel) -> None:
    if not NEAR_CLEARANCE <= model.clearance <= FAR_CLEARANCE:
        text = f"every motion keeps {1e3 * model.clearance:g} mm from everything: "
        text += "nothing is left for what a robot is off by" if model.clearance < FAR_CLEARANCE else ""
        text += "the tool enters no bin any more; is it in m?" if model.clearance > FAR_CLEARANCE else ""
        warnings.add("odd_clearance", "clearance", ("clearance",), text)


def _limits(warnings: FileWarnings, cell: Cell) -> None:
    robot, limits = cell.robot, cell.robot.limits
    rates = zip(robot.joint_names, robot.units, limits.velocity, limits.acceleration, strict=True)
    for name, unit, velocity, acceleration in rates:
        fast, steep = FAST[unit]
        wrong = "mm" if unit == "m" else "degrees"
        if velocity > fast:
            text = f"{velocity:g} {unit}/s is faster than any commercial arm; is it in {unit}, not {wrong}?"
            warnings.add("fast_joint", name, ("joint_limits", name, "max_velocity"), text)
        if acceleration > steep:
            text = f"{acceleration:g} {unit}/s2 is more than any commercial arm reaches; "
            text += f"is it in {unit}, not {wrong}?"
            warnings.add("fast_joint", name, ("joint_limits", name, "max_acceleration"), text)
    _slow(warnings, cell)
    endless = [
        name for name, is_endless in zip(robot.joint_names, limits.is_continuous, strict=True) if is_endless
    ]
    for joint in robot.joints:
        if joint.ignored_limits is not None and joint.name in endless:
            lower, upper = joint.ignored_limits
            text = (
                f"the URDF limits {joint.name} to {lower:g} to {upper:g} rad, but it is continuous and turns "
            )
            text += "on without end; make it revolute, or state min_position and max_position"
            warnings.add("ignored_limits", joint.name, ("joint_limits", joint.name), text)
    for name, force in robot.motor_forces.items():
        if force > STRONG:
            text = f"{force:g} is more than the largest arms have; is it in N or Nm, not Nmm?"
            warnings.add("strong_motor", name, ("robot", "motor_forces", name), text)


def _slow(warnings: FileWarnings, cell: Cell) -> None:
    """Warn of accelerations and jerks that are small, e.g. one stated in place of the other."""
    robot, limits = cell.robot, cell.robot.limits
    rates = zip(robot.joint_names, limits.velocity, limits.acceleration, limits.jerk, strict=True)
    long_to_velocity, long_to_acceleration = SLOW
    steps: dict[str, dict[str, tuple[Key, str]]] = {"acceleration": {}, "jerk": {}}
    for name, velocity, acceleration, jerk in rates:
        if (time := velocity / acceleration) > long_to_velocity:
            key, text = (
                ("joint_limits", name, "max_acceleration"),
                f"it takes {time:.3g} s to its full velocity",
            )
            steps["acceleration"][name] = key, f"{text}; correct one of them"
        if (time := acceleration / jerk) > long_to_acceleration:
            key, text = ("joint_limits", name, "max_jerk"), f"it takes {time:.3g} s to its full acceleration"
            steps["jerk"][name] = key, f"{text}; correct one of them"
    for step, found in steps.items():
        warnings.add_alike("slow_joint", found, ("joint_limits",), f"is the {step} of all too small?")
