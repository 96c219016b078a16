"""Reads the files of a robot and copies them into the folder of its cell."""

from __future__ import annotations

import json
import re
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pickcli.cell.robots.planning_group import stripped
from pickcli.cell.robots.srdf import Srdf, read_srdf
from pickcli.cell.robots.urdf import Urdf, read_urdf
from pickcli.cell.schemas.cell_schema import CellModel
from pickcli.cell.schemas.joint_limits_file import read_joint_limits, refuse_unknown_joints
from pickcli.errors import InputError, UnknownNameError
from pickcli.files.schema import MAX_TEXT
from pickcli.files.source import Source
from pickcli.files.xml_reader import read_xml
from pickcli.name_suggestion import shortened
from pickcli.robot_setup.cell_text import SCHEMA
from pickcli.robot_setup.chain_selection import choose_chain, rigid_with
from pickcli.robot_setup.finger_shapes import with_whole_fingers
from pickcli.robot_setup.package_search import PackageSearch
from pickcli.robot_setup.robot_files import RobotFiles, find_robot_files
from pickcli.robot_setup.setup_options import LIMITS, SRDF, URDF, SetupOptions
from pickcli.robot_setup.stated_limits import option_of
from pickcli.robot_setup.suggested_tool import GRIPPER

_MESH = re.compile(r"<mesh\b[^>]*(?:/>|>.*?</mesh>)", re.DOTALL)
_STAND_IN = '<box size="1 1 1"/>'  # in place of a mesh, where only the tree of links matters


@dataclass(frozen=True, eq=False)
class RobotSource:
    """A robot as read from its files.

    Attributes:
        files: The files.
        robot: The robot without removed links.
        srdf: Its SRDF, if there is one.
        limits: Its file of limits, if there is one.
    """

    files: RobotFiles
    robot: Urdf
    srdf: Srdf | None
    limits: Source | None


def read_robot(request: SetupOptions, staging: Path) -> RobotSource:
    """Read a robot, and copy its files.

    Args:
        request: Options of the setup.
        staging: The folder that they are copied to.

    Returns:
        The robot.

    Raises:
        InputError: With every mistake in the files.
    """
    with tempfile.TemporaryDirectory() as scratch:
        packages = PackageSearch(request.urdf, request.package_path, request.packages)
        files = find_robot_files(request.urdf, packages, request.arguments, Path(scratch))
    _copy(files, staging)
    _refuse_unknown_names(request, staging / URDF)
    _refuse_unclear_chain(request, files.urdf, staging)
    roots = {name: staging / path for name, path in files.packages.items()}
    whole = read_urdf(staging / URDF, staging, roots)
    _refuse_long_names(whole, staging / URDF)
    limits = _limits(request.joint_limits, whole, staging)
    robot = _without(whole, request.without)
    srdf = _srdf(request.srdf, robot, staging)
    if request.tool == GRIPPER:
        end = choose_chain(robot, srdf, request.group, request.tip).joints[-1]
        (staging / URDF).write_text(with_whole_fingers(files.urdf, robot, rigid_with(robot, end)))
        robot = _without(read_urdf(staging / URDF, staging, roots), request.without)
    return RobotSource(files, robot, srdf, limits)


def _copy(files: RobotFiles, staging: Path) -> None:
    (staging / URDF).write_text(files.urdf)
    schema = {"$schema": "http://json-schema.org/draft-07/schema#", **CellModel.model_json_schema()}
    (staging / SCHEMA).write_text(json.dumps(schema, indent=1) + "\n")
    for target, path in files.meshes.items():
        (staging / target).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, staging / target)


def _refuse_unknown_names(request: SetupOptions, urdf: Path) -> None:
    """Refuse names that the URDF does not have, before its meshes are read, which can take minutes.

    Raises:
        UnknownNameError: There is no such link or joint.
    """
    robot = read_xml(urdf)
    links, joints = ([e.attributes.get("name", "") for e in robot.all(kind)] for kind in ("link", "joint"))
    for option, names in (("--tip", [request.tip] if request.tip else []), ("--without", request.without)):
        for name in names:
            if name not in links:
                raise UnknownNameError("link", name, links, option)
    for figure in request.figures:
        if figure.joint is not None and figure.joint not in joints:
            raise UnknownNameError("joint", figure.joint, joints, option_of(figure.kind))


def _refuse_unclear_chain(request: SetupOptions, urdf: str, staging: Path) -> None:
    """Refuse an unclear choice of the arm before meshes are read. InputError with the candidates."""
    with tempfile.TemporaryDirectory() as scratch:
        sketch = Path(scratch) / URDF
        sketch.write_text(_MESH.sub(_STAND_IN, urdf))
        try:
            whole = read_urdf(sketch)
        except InputError:
            return  # told with the right lines when everything is read
    robot = _without(whole, request.without)
    choose_chain(robot, _srdf(request.srdf, robot, staging), request.group, request.tip)


def _refuse_long_names(robot: Urdf, urdf: Path) -> None:
    """Refuse names that are too long for a cell file. Raises InputError."""
    for name in (*robot.links, *(joint.name for joint in robot.joints.values())):
        if len(name) > MAX_TEXT:
            fault = f"has {len(name)} characters, a cell takes {MAX_TEXT}; rename it"
            raise InputError(f"{urdf}: the name {shortened(name)!r} {fault}")


def _limits(path: Path | None, whole: Urdf, staging: Path) -> Source | None:
    """Read and copy the file of limits. Raises InputError for mistakes in it."""
    if path is None:
        return None
    limits = read_joint_limits(path)
    refuse_unknown_joints(limits, [joint.name for joint in whole.joints.values()])
    shutil.copyfile(path, staging / LIMITS)
    return limits


def _without(robot: Urdf, links: Sequence[str]) -> Urdf:
    """Remove links from the robot. Raises UnknownNameError for a link that it does not have."""
    hanging = [name for name in robot.links if name != robot.root]
    for link in links:
        if link not in hanging:
            text = f"{link} is the root, on which all other links hang; name links beyond it"
            raise UnknownNameError("link", link, hanging, "--without", text=text * (link == robot.root))
    return stripped(robot, links)


def _srdf(path: Path | None, robot: Urdf, staging: Path) -> Srdf | None:
    """Read and copy the SRDF. Raises InputError if it is for another robot."""
    if path is None:
        return None
    srdf = read_srdf(path)
    named = {name for pair in srdf.disabled for name in (pair.a, pair.b)}
    named |= {name for state in srdf.states for name in state.positions}
    named |= {name for group in srdf.groups.values() for name in (*group.joints, *group.links)}
    named |= {name for group in srdf.groups.values() for chain in group.chains for name in chain}
    if named and not named & {*robot.links, *(joint.name for joint in robot.joints.values())}:
        raise InputError(
            f"{path}: names no link or joint of the robot {robot.name!r}, e.g. {min(named)!r}; is it the "
            "SRDF of another one?"
        )
    shutil.copyfile(path, staging / SRDF)
    return srdf
