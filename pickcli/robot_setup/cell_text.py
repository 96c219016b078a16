"""Content of a new cell, and its text as a cell file with the source of each value in comments."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass

from pickcli.cell.cell import AllowedPair
from pickcli.files.yaml_reader import quoted
from pickcli.robot_setup.chain_selection import PlannedChain
from pickcli.robot_setup.stated_limits import FILL_IN, KINDS, StatedLimits
from pickcli.robot_setup.suggested_places import POD, SuggestedPlace
from pickcli.robot_setup.suggested_tool import SuggestedTool

SCHEMA = "cell.schema.json"

HEAD = """\
# yaml-language-server: $schema={schema}
#
# {name}: written by `apc init` from {source}. Units: m, rad, s, kg, N.
# World frame: that of the robot's base until T_world_base says otherwise. Every key: docs/formats/cell.md.

format: apc cell
version: 2
name: {name}
"""
TAIL = """
speed_scale: 1.0  # of velocity and acceleration limits, for everything that moves
clearance: 0.003  # kept by every planned motion from everything around it, and by the robot from itself

# Boxes that stand still, e.g. the table that the robot stands on:
#   - {name: table, lower: [-0.5, -0.5, -0.05], upper: [0.5, 0.5, -0.01]}
obstacles: []
"""
NO_TOOL = """
# Switched devices of a tool, e.g. its pump; tool, pod and tote are added as docs/formats/cell.md says.
devices: {}"""


@dataclass(frozen=True)
class JointPosture:
    """Fixed position of a joint that is not planned.

    Attributes:
        name: Name of the joint.
        position: rad or m.
        source: Source of the position.
    """

    name: str
    position: float
    source: str


@dataclass(frozen=True, eq=False)
class SuggestedConfiguration:
    """A named configuration.

    Attributes:
        name: Unique in the cell.
        kind: Kind as in the cell file.
        q: rad or m of the planned joints.
        source: Source of the configuration.
    """

    name: str
    kind: str
    q: tuple[float, ...]
    source: str


@dataclass(frozen=True, eq=False)
class CellText:
    """Content of a cell file.

    Attributes:
        name: Name of the cell.
        source: Name of the file that it was created from.
        srdf: Path of its SRDF relative to its folder; None without one.
        packages: Folders of packages, by name as in ``package://``.
        without: Removed links.
        chain: The planned chain.
        standing: Positions of the joints that are not planned.
        unshaped: Links without a collision shape.
        accepts_unshaped: Whether these may remain without collision checks.
        limits: Limits of the planned joints, by name.
        limits_file: Path of a ``joint_limits.yaml`` relative to its folder; None without one.
        tool: The tool, or None.
        places: Places for items, with their poses.
        pairs: Pairs of links exempt from collision checks.
        configurations: Named configurations.
    """

    name: str
    source: str
    srdf: str | None
    packages: dict[str, str]
    without: tuple[str, ...]
    chain: PlannedChain
    standing: tuple[JointPosture, ...]
    unshaped: tuple[str, ...]
    accepts_unshaped: bool
    limits: dict[str, StatedLimits]
    limits_file: str | None
    tool: SuggestedTool | None = None
    places: tuple[SuggestedPlace, ...] = ()
    pairs: tuple[AllowedPair, ...] = ()
    configurations: tuple[SuggestedConfiguration, ...] = ()

    def text(self) -> str:
        """Format the cell file.

        Returns:
            YAML with comments.
        """
        lines = [HEAD.format(name=quoted(self.name), source=self.source, schema=SCHEMA), *self._robot(), ""]
        lines += [*self._limits(), TAIL, *self._tool(), "", *self._places()]
        lines += [*self._pairs(), "", *self._configurations()]
        return "\n".join(lines) + "\n"

    def left(self) -> Iterator[str]:
        """List what only the owner of the cell can fill in.

        Yields:
            Each key once, with the joints for which it is missing, and how to state it.
        """
        if self.unshaped and not self.accepts_unshaped:
            yield (
                f"robot.unshaped: {', '.join(self.unshaped)}: without a collision shape nothing of them is "
                "tested; give them one in the URDF, or accept that with --accept-unshaped"
            )
        weak = [name for name, limits in self.limits.items() if limits.effort is None]
        if weak:
            listed = ", ".join(weak)
            yield f"robot.motor_forces in N or Nm of {listed}: the URDF states no effort; add --motor-force"
        for kind in KINDS:
            blank = [name for name, limits in self.limits.items() if limits.values.get(kind, 0.0) is None]
            if not blank:
                continue
            why = "no file states it"
            ignored = [self.limits[name] for name in blank if self.limits[name].ignored is not None]
            if kind == "velocity" and ignored:
                limits = ignored[0]
                why = f"the URDF states {limits.ignored:g} {limits.unit}/s, which no joint reaches: limits "
                why += f"are in {limits.most(kind)[1]}"
            yield (
                f"joint_limits: max_{kind} of {', '.join(blank)}: {why}; add --joint-limits FILE, or "
                f"--max-{kind} with your figure"
            )
        if self.tool is not None:
            yield from self.tool.left()

    def _robot(self) -> Iterator[str]:
        chain = self.chain
        why = f"of the SRDF group {chain.group}" if chain.group else "the longest chain of the robot"
        yield "robot:"
        yield "  urdf: robot.urdf"
        if self.srdf is not None:
            yield f"  srdf: {self.srdf}  # its disabled pairs of links are never tested against each other"
        if self.packages:
            yield f"  packages: {_mapping(self.packages)}"
        if self.without:
            yield f"  without: [{', '.join(map(quoted, self.without))}]  # with all that hangs on them"
        yield "  T_world_base: {xyz: [0, 0, 0], rpy: [0, 0, 0]}"
        yield f"  joints: [{', '.join(map(quoted, chain.joints))}]  # the order of every q; {why}"
        others = f"; {', '.join(chain.other_tips)} would do as well" if chain.other_tips else ""
        if self.tool is None:
            yield f"  tip: {quoted(chain.tip)}  # the frame at the end{others}"
        if self.standing:
            yield "  posture:  # where the joints stand that are not planned"
            yield from (f"    {quoted(j.name)}: {j.position:g}  # {j.source}" for j in self.standing)
        if self.unshaped:
            listed = ", ".join(map(quoted, self.unshaped))
            yield "  # Without a collision shape: nothing of these links is tested."
            accepted = f"[{listed}]" if self.accepts_unshaped else f"[]  # {FILL_IN}: {listed}"
            yield f"  unshaped: {accepted}"
        if self.limits_file is not None:
            yield f"  joint_limits: {self.limits_file}  # what it states need not stand below"
        yield "  motor_forces:  # N or Nm, the largest that each motor exerts"
        for name, limits in self.limits.items():
            yield f"    {_line(quoted(name), limits.effort)}"

    def _limits(self) -> Iterator[str]:
        yield "# No limit is ever assumed: what is blank only you know. Data sheets state velocities, some of"
        yield "# them accelerations, few a jerk. Delft's cell builds the whole acceleration up in 0.05 s."
        stated = {name: list(limits.lines()) for name, limits in self.limits.items()}
        if not any(stated.values()):
            yield "joint_limits: {}"
            return
        yield "joint_limits:"
        for name, lines in stated.items():
            if lines:
                yield f"  {quoted(name)}:"
                yield from (f"    {line}" for line in lines)

    def _tool(self) -> Iterator[str]:
        if self.tool is None:
            yield NO_TOOL.lstrip()
            return
        yield from self.tool.lines()
        yield ""
        yield from self.tool.device_lines()

    def _places(self) -> Iterator[str]:
        """The pod and the other places, each followed by a blank line."""
        if self.places:
            yield "# Places of items. Their poses were chosen for the arm's reach: enter the real ones;"
            yield "# apc check prints what is reached there. Frames of places: docs/formats/cell.md."
        for pod in (place for place in self.places if place.kind == POD):
            yield from (*pod.lines(), "")
        own = [place for place in self.places if place.kind != POD]
        if own:
            yield "places:"
            yield from (line for place in own for line in place.lines())
            yield ""

    def _pairs(self) -> Iterator[str]:
        yield "# Links that are never tested against each other, or only by the verifier (verified: true)."
        yield "# Those that a joint connects need none. Pairs that never met in a sample stay tested: a"
        yield "# sample proves nothing, and testing costs little."
        if not self.pairs:
            yield "allowed_pairs: []"
            return
        yield "allowed_pairs:"
        for pair in self.pairs:
            verified = ", verified: true" if pair.verified else ""
            reason = f"{json.dumps(pair.reason)}{verified}"
            yield f"  - {{a: {quoted(pair.a)}, b: {quoted(pair.b)}, reason: {reason}}}"

    def _configurations(self) -> Iterator[str]:
        if not self.configurations:
            yield "configurations: []"
            return
        yield "configurations:"
        for each in self.configurations:
            q = ", ".join(f"{value:.4f}" for value in each.q)
            yield f"  - {{name: {quoted(each.name)}, kind: {each.kind}, q: [{q}]}}  # {each.source}"


def _line(name: str, figure: float | None) -> str:
    return f"{name}:  # {FILL_IN}: N or Nm" if figure is None else f"{name}: {figure:g}"


def _mapping(values: dict[str, str]) -> str:
    return "{" + ", ".join(f"{quoted(key)}: {quoted(value)}" for key, value in values.items()) + "}"
