"""The tool of a new cell as lines of a cell file: a plain suction cup, or the robot's own gripper."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import ceil

from pickcli.errors import InputError, UnknownNameError
from pickcli.robot_setup.stated_limits import FILL_IN

SUCTION, GRIPPER = "suction", "gripper"
KINDS = (SUCTION, GRIPPER)
TOOL_URDF = "tool.urdf"
OPTION = "--tool-figure"


@dataclass(frozen=True)
class ToolFigure:
    """A figure of a tool.

    Attributes:
        key: Key in the cell file.
        value: The figure; None if only the owner of the tool knows it.
        about: Its unit, and its source or how to find it.
    """

    key: str
    value: float | None
    about: str

    def stated(self, value: float) -> ToolFigure:
        """Return the figure with a value stated by the user.

        Args:
            value: In the same unit.

        Returns:
            The figure, with the user as its source.
        """
        return ToolFigure(self.key, value, f"{re.split('[:;]', self.about)[0]}; from the command line")


@dataclass(frozen=True, eq=False)
class SuggestedTool:
    """A tool of a new cell.

    Attributes:
        head: Comments above it.
        flange: Name of the link that it is mounted on.
        links: Its lines in the cell file for links, frames and states.
        figures: Its figures, by the keys of the cell file.
        joints: Names of its own joints.
        travel: m between the widest and narrowest state of a gripper; 0 for a cup.
        drawing: Template of its URDF; None if it is part of the robot's.
        note: Advice for the user; empty without any.
    """

    head: tuple[str, ...]
    flange: str
    links: tuple[str, ...]
    figures: tuple[ToolFigure, ...]
    joints: tuple[str, ...]
    travel: float
    drawing: str | None
    note: str = ""

    @property
    def is_gripper(self) -> bool:
        """Whether it is a gripper."""
        return bool(self.joints)

    @property
    def urdf(self) -> str | None:
        """Text of its URDF; None if it is part of the robot's."""
        if self.drawing is None:
            return None
        values = {figure.key: figure.value or 0.0 for figure in self.figures}
        length, radius = (values[key] for key in ("cup_length", "cup_radius"))
        return self.drawing.format(cup_length=length, cup_half=length / 2, cup_radius=radius)

    def with_figures(self, stated: Mapping[str, float]) -> SuggestedTool:
        """Return the tool with figures stated by the user.

        Args:
            stated: Figures by key.

        Returns:
            The tool.

        Raises:
            UnknownNameError: It has no such figure.
        """
        for key in stated:
            if key not in {figure.key for figure in self.figures}:
                raise UnknownNameError("figure", key, [figure.key for figure in self.figures], OPTION)
        return replace(
            self, figures=tuple(f.stated(stated[f.key]) if f.key in stated else f for f in self.figures)
        )

    def stood_in(self, value: float) -> SuggestedTool:
        """Return the tool with a placeholder for every missing figure.

        Args:
            value: The placeholder, for all units.

        Returns:
            The tool.
        """
        figures = tuple(replace(f, value=value if f.value is None else f.value) for f in self.figures)
        return replace(self, figures=figures)

    def lines(self) -> Iterator[str]:
        """Format the key ``tool`` of a cell file.

        Yields:
            Its lines; missing figures are blank.
        """
        yield from (f"# {line}" for line in self.head)
        yield "tool:"
        yield from (f"  {line}" for line in self.links)
        yield from (f"  {_blank_or(figure.key, figure.value, figure.about)}" for figure in self.figures)

    def device_lines(self) -> Iterator[str]:
        """Format the key ``devices`` of a cell file: the tool's devices.

        Yields:
            Its lines.
        """
        yield "# Switched devices. Lead: s from the command to its full effect. Measure yours."
        yield "devices:"
        if not self.is_gripper:
            yield '  pump: {kind: pump, lead: 2.0, actions: ["on", "off"]}'
            yield '  valve: {kind: valve, lead: 0.05, actions: ["on", "off"]}'
            yield '  vacuum_sensor: {kind: sensor, lead: 0.0, actions: ["read"]}'
            return
        speed = next(figure.value for figure in self.figures if figure.key == "closing_speed")
        lead = None if speed is None else ceil(100.0 * self.travel / speed + 1.0) / 100.0
        yield "  gripper:"
        yield "    kind: gripper"
        about = f"s, the fingers' whole way of {self.travel:g} m at closing_speed"
        yield f"    {_blank_or('lead', lead, f'{about}; add what passes before they start')}"
        yield '    actions: ["open", "closed"]'

    def left(self) -> Iterator[str]:
        """List what only the owner of the tool can fill in.

        Yields:
            Each missing figure, with how to state it.
        """
        for figure in self.figures:
            if figure.value is None:
                yield f"tool.{figure.key}: {figure.about}; add {OPTION} {figure.key}=NUMBER"
        if self.is_gripper and any(f.key == "closing_speed" and f.value is None for f in self.figures):
            yield f"devices.gripper.lead: s, at least {self.travel:g} m / closing_speed"


def tool_kind(text: str) -> str:
    """Parse a kind of tool from the command line.

    Args:
        text: KIND.

    Returns:
        The kind, one of ``KINDS``.

    Raises:
        UnknownNameError: There is no such kind.
    """
    if text not in KINDS:
        raise UnknownNameError("kind of tool", text, list(KINDS), "--tool")
    return text


def figure_of(text: str) -> tuple[str, float]:
    """Parse a figure of a tool from the command line.

    Args:
        text: KEY=NUMBER.

    Returns:
        Key and value.

    Raises:
        InputError: It is not of that form, or the number is not positive.
    """
    key, equals, number = text.partition("=")
    try:
        value = float(number)
    except ValueError:
        value = -1.0
    if not key or not equals or not 0.0 < value < 1e6:
        raise InputError(f"{OPTION} {text}: expected KEY=NUMBER with a number over 0, e.g. friction=0.5")
    return key, value


def _blank_or(key: str, value: float | None, about: str) -> str:
    return f"{key}:  # {FILL_IN}: {about}" if value is None else f"{key}: {value:g}  # {about}"
