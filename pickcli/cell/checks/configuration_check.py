"""Warnings for named configurations: misspelt or missing ones, and those whose tip is far from their place.

A base that is turned, moved or upside down, an axis with the wrong sign, or a pod in another frame shows up
in the tip poses of all configurations, however plausible the single values look.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.cell.place import Place
from pickcli.cell.robot import joint_motion
from pickcli.files.file_warnings import FileWarnings
from pickcli.files.source import Key
from pickcli.geometry import Array, inverse
from pickcli.name_suggestion import suggestion

ASTRAY = 0.6  # m from the mouth of the place to the tip; Team Delft waits 0.3 m in front of the bins
BESIDE = 0.1  # m beside the mouth of its place, from which a configuration may be meant for another one
BEHIND = -0.2  # least cosine between the tool's direction and the direction into the place
HOME = "home"  # name and kind of the configuration in which commands begin
WAITING = ("bin", "tote", "drop")  # kinds of configurations from which the arm enters a place


def warn_of_configurations(warnings: FileWarnings, cell: Cell) -> None:
    """Warn of configurations of no place, and of those far from their places.

    Args:
        warnings: Collects them.
        cell: The cell.
    """
    if not cell.places or cell.robot.tool.is_bare:
        return
    unknown: dict[str, tuple[Key, str]] = {
        named.name: (
            ("configurations", i, "name"),
            f"no place is called {named.name}, so that nothing waits there; "
            f"{suggestion(named.name, cell.places)}",
        )
        for i, named in enumerate(cell.configurations.values())
        if named.kind == "bin" and named.name not in cell.places
    }
    warnings.add_alike("no_such_place", unknown, ("configurations",), "name each after its place")
    if cell.robot.tool.suction_cup is None:
        return
    astray: dict[str, tuple[Key, str]] = {}
    for i, named in enumerate(cell.configurations.values()):
        if (place := _place_of(cell, named)) is not None and (text := _why_astray(cell, named, place)):
            astray[named.name] = (("configurations", i, "q"), f"{named.name} {text}")
    cause = "do T_world_base, T_world_pod and the URDF's axes say where things are?"
    warnings.add_alike("astray", astray, ("robot", "T_world_base"), cause)


def warn_of_missing_configurations(warnings: FileWarnings, cell: Cell) -> None:
    """Warn of bins without a configuration, and of a cell without a configuration called home.

    Args:
        warnings: Collects them.
        cell: The cell, with a single arm.
    """
    if not cell.places or cell.robot.tool.is_bare:
        return
    if HOME not in cell.configurations:
        meant = suggestion(HOME, cell.configurations)
        text = f"none is called {HOME}, where commands begin unless --from names another; "
        text += "add one" if meant.startswith("known") else meant
        warnings.add("no_configuration", HOME, ("configurations",), text)
    if cell.robot.tool.suction_cup is None:
        return
    names = {named.name for named in cell.configurations.values() if named.kind == "bin"}
    advice = "apc suggest-configurations finds one"
    missing: dict[str, tuple[Key, str]] = {
        name: (("configurations",), f"none of kind bin is called {name}; {advice}")
        for name in cell.pod.bins
        if name not in names
    }
    warnings.add_alike("no_configuration", missing, ("configurations",), "name each after its bin")
    if HOME in cell.configurations and not any(c.kind == HOME for c in cell.configurations.values()):
        text = "none is of kind home, where picks begin and trials end; add one"
        warnings.add("no_configuration", HOME, ("configurations",), text)


def _place_of(cell: Cell, named: NamedConfiguration) -> Place | None:
    """The place that a configuration is meant for, or None if its kind is not in ``WAITING``."""
    if named.kind not in WAITING:
        return None
    if named.kind == "bin" or named.name in cell.places:
        return cell.places.get(named.name)
    return None if cell.tote is None else cell.tote.place


def _why_astray(cell: Cell, named: NamedConfiguration, place: Place) -> str:
    """Why a configuration is implausible: the tip is elsewhere or points away; "" if neither."""
    T_world_tip = _tip(cell, named)
    T_mouth_tip = inverse(cell.T_world_place(place) @ place.access.T_place_mouth) @ T_world_tip
    beside = _beside(cell, place, T_world_tip)
    away = float(np.linalg.norm(beside))
    if away > ASTRAY:
        x, y, z = T_world_tip[:3, 3]
        return f"has the tip at [{x:.2f}, {y:.2f}, {z:.2f}], {away:.2f} m from the mouth of {place.name}"
    lance = T_mouth_tip[:3, :3] @ cell.robot.tool.lance_axis(named.tool_state)
    if float(lance[0]) < BEHIND:
        return f"has the tool point away from {place.name}"
    if named.kind == "bin" and float(np.linalg.norm(beside[1:])) > BESIDE:
        for name, other in cell.places.items():
            if other.access.is_from_above is not place.access.is_from_above:
                continue  # over a crate the tip may be before a shelf as well
            to_other = _beside(cell, other, T_world_tip)
            if not to_other[1:].any() and float(np.linalg.norm(to_other)) < away:
                return f"has the tip before {name}, not {place.name}; were names exchanged?"
    return ""


def _beside(cell: Cell, place: Place, T_world_tip: Array) -> Array:
    """From the nearest point of a place's mouth to the tip (3,), m, in the frame of the mouth."""
    access = place.access
    tip = (inverse(cell.T_world_place(place) @ access.T_place_mouth) @ T_world_tip)[:3, 3]
    half = np.array([0.0, access.width / 2, access.height / 2])
    return np.asarray(tip - np.clip(tip, -half, half))


def _tip(cell: Cell, named: NamedConfiguration) -> Array:
    """Compute the (4, 4) pose of the tip in the world by forward kinematics."""
    robot = cell.robot
    positions = dict(zip(robot.joint_names, named.q, strict=True))
    if robot.tool.joint is not None:
        positions[robot.tool.joint] = robot.tool.position(named.tool_state)
    joint_of = {joint.child: joint for joint in robot.joints}
    T, link = robot.tool.T_last_tip, robot.tool.last_link
    while link in joint_of:
        joint = joint_of[link]
        T = joint.T_parent_joint @ joint_motion(joint, float(positions.get(joint.name, 0.0))) @ T
        link = joint.parent
    return np.asarray(robot.T_world_base @ T)
