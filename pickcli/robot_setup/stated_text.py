"""Builds the part of a new cell that files and options state, before any search."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from pickcli.cell.robots.srdf import Srdf
from pickcli.cell.robots.urdf import Urdf
from pickcli.errors import InputError
from pickcli.robot_setup.cell_text import CellText, JointPosture
from pickcli.robot_setup.chain_selection import PlannedChain, choose_chain
from pickcli.robot_setup.robot_reading import RobotSource
from pickcli.robot_setup.setup_options import LIMITS, SRDF, URDF, SetupOptions
from pickcli.robot_setup.stated_limits import limits_of_urdf, with_figure, without_those_of_file
from pickcli.robot_setup.suggested_tool import TOOL_URDF, SuggestedTool
from pickcli.robot_setup.tool_suggestion import suggest_tool


def stated_text(folder: Path, request: SetupOptions, source: RobotSource, staging: Path) -> CellText:
    """Build a cell's content except pairs, places and configurations, which need the robot's geometry.

    Args:
        folder: Folder of the cell, which is named after it.
        request: Options of the setup.
        source: The robot.
        staging: The folder with the robot's files; a tool's URDF is written there.

    Returns:
        The content of the cell file.

    Raises:
        InputError: There is no such chain, limit or tool.
    """
    robot, srdf, file = source.robot, source.srdf, source.limits
    chain = choose_chain(robot, srdf, request.group, request.tip)
    tool = _tool(request, robot, chain, staging)
    limits = limits_of_urdf(robot, staging / URDF, chain.joints)
    if file is not None:
        limits = without_those_of_file(limits, file)
    for figure in request.figures:
        limits = with_figure(limits, figure.kind, figure.joint, figure.value)
    return CellText(
        name=_cell_name(folder),
        source=request.urdf.name,
        srdf=None if srdf is None else SRDF,
        packages=source.files.packages,
        without=tuple(request.without),
        chain=chain,
        standing=tuple(_standing(robot, srdf, chain, () if tool is None else tool.joints)),
        unshaped=_unshaped(robot, chain, None if tool is None else tool.flange),
        accepts_unshaped=request.accepts_unshaped,
        limits=limits,
        limits_file=None if file is None else LIMITS,
        tool=tool,
    )


def _tool(request: SetupOptions, robot: Urdf, chain: PlannedChain, staging: Path) -> SuggestedTool | None:
    """Suggest the tool and write its URDF. Raises InputError if there is no such tool."""
    if request.tool is None:
        if request.tool_figures:
            raise InputError(
                f"--tool-figure {next(iter(request.tool_figures))}: there is no tool; add --tool"
            )
        _refuse_middle(robot, chain)
        return None
    tool = suggest_tool(request.tool, robot, chain).with_figures(request.tool_figures)
    if tool.urdf is not None:
        (staging / TOOL_URDF).write_text(tool.urdf)
    return tool


def _refuse_middle(robot: Urdf, chain: PlannedChain) -> None:
    """Refuse a tip to which links with shapes are attached: without a tool the arm must end there."""
    hanging = [
        link
        for link in robot.links
        if robot.links[link].bodies and chain.tip in {joint.parent for joint in robot.way(link)}
    ]
    if hanging:
        first = next(joint.child for joint in robot.way(hanging[0]) if joint.parent == chain.tip)
        free = [f"--tip {link}" for link in chain.other_tips if not robot.children(link)]
        raise InputError(
            f"{first} hangs on {chain.tip}, and an arm ends with its tip; add "
            f"{' or '.join([*free, '--tool gripper', '--tool suction'])}, or leave it out with --without "
            f"{first}"
        )


def _cell_name(folder: Path) -> str:
    plain = re.sub(r"\W", "_", folder.name, flags=re.ASCII)
    return plain if re.match("[A-Za-z]", plain) else f"cell_{plain}"


def _standing(
    robot: Urdf, srdf: Srdf | None, chain: PlannedChain, of_tool: Sequence[str]
) -> Iterator[JointPosture]:
    """Positions of the joints that are not planned: of an SRDF state, else 0 or the nearest limit."""
    for name, joint in robot.driven(robot.joints.values()).items():
        if name in chain.joints or name in of_tool:
            continue
        states = [] if srdf is None else [s for s in srdf.states if name in s.positions]
        state = next((s for s in states if joint.lower <= s.positions[name] <= joint.upper), None)
        if state is not None:
            yield JointPosture(name, state.positions[name], f"state {state.name} of the SRDF")
        else:
            yield JointPosture(name, float(np.clip(0.0, joint.lower, joint.upper)), "as near to 0 as it goes")


def _unshaped(robot: Urdf, chain: PlannedChain, flange: str | None) -> tuple[str, ...]:
    """Links without collision checks: visible links without a shape, and joints that move no shape at all.

    A tool has shapes, and moves with its flange.
    """
    found = list(robot.unshaped)
    moved: dict[str, list[str]] = {}
    for link in robot.links:
        movers = [joint.name for joint in robot.way(link) if joint.name in chain.joints]
        if movers:
            moved.setdefault(movers[-1], []).append(link)
    for links in moved.values():
        is_shaped = flange in links or any(robot.links[link].bodies for link in links)
        if not is_shaped and not set(links) & set(found):
            found.append(links[0])
    return tuple(found)
