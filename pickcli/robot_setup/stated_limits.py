"""Stated limits of joints: from the URDF, a ``joint_limits.yaml``, or the user."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from pickcli.cell.checks.robot_consistency import ANGULAR, LINEAR
from pickcli.cell.robot import JointType
from pickcli.cell.robots.urdf import Urdf
from pickcli.cell.schemas.joint_limits_file import stated_limits
from pickcli.errors import InputError, UnknownNameError
from pickcli.files.source import Source
from pickcli.files.xml_reader import Element, read_xml

FILL_IN = "fill in"  # begins the comment on a value to be filled in by the owner of a cell
KINDS = ("velocity", "acceleration", "jerk")
EFFORT = "effort"


@dataclass(frozen=True)
class StatedLimits:
    """Stated limits of one joint, with their sources.

    Attributes:
        unit: "rad" or "m".
        effort: N or Nm; None if not stated.
        values: By kind, in unit/s, unit/s2 and unit/s3; None if not stated.
        sources: Source of each value; kinds stated by the cell's limits file are not among the values.
        ignored: Velocity of the URDF that no joint has, unit/s; None if it states none or a plausible one.
    """

    unit: str
    effort: float | None
    values: dict[str, float | None]
    sources: dict[str, str]
    ignored: float | None = None

    def most(self, kind: str) -> tuple[float, str]:
        """Return the bound of plausible limits of any real joint.

        Args:
            kind: "velocity", "acceleration" or "jerk".

        Returns:
            The bound, and its unit in words.
        """
        is_linear = self.unit == "m"
        return (LINEAR if is_linear else ANGULAR)[
            f"max_{kind}"
        ], "m, not mm" if is_linear else "rad, not degrees"

    def lines(self) -> Iterator[str]:
        """Format the limits as lines of a cell file.

        Yields:
            One line for each key; missing values are blank.
        """
        for power, kind in enumerate(KINDS, start=1):
            if kind in self.values:
                unit = f"{self.unit}/s{power if power > 1 else ''}"
                yield f"has_{kind}_limits: true"
                value = self.values[kind]
                said = f"{self.sources[kind]}, {unit}" if value is not None else f"{FILL_IN}: {unit}"
                yield f"max_{kind}:{'' if value is None else f' {value:g}'}  # {said}"


def limits_of_urdf(robot: Urdf, urdf: Path, joints: tuple[str, ...]) -> dict[str, StatedLimits]:
    """Read the limits of velocity and effort in a URDF; implausible velocities are ignored.

    Args:
        robot: The robot.
        urdf: Its file.
        joints: Names of the planned joints.

    Returns:
        Limits by joint.
    """
    elements = {e.attributes.get("name", ""): e for e in read_xml(urdf).all("joint")}
    by_name = {joint.name: joint for joint in robot.joints.values()}
    found = {}
    for name in joints:
        limit = elements[name].optional("limit")
        unit = "m" if by_name[name].type is JointType.PRISMATIC else "rad"
        velocity = _positive(limit, "velocity")
        values = dict[str, float | None].fromkeys(KINDS)
        stated = StatedLimits(unit, _positive(limit, "effort"), values, {"velocity": "the URDF's"})
        if velocity is not None and velocity <= stated.most("velocity")[0]:
            values["velocity"] = velocity
            velocity = None
        found[name] = replace(stated, ignored=velocity)
    return found


def without_those_of_file(limits: Mapping[str, StatedLimits], file: Source) -> dict[str, StatedLimits]:
    """Remove the limits that a ``joint_limits.yaml`` states.

    Args:
        limits: Limits by joint.
        file: The file.

    Returns:
        The remaining limits by joint.

    Raises:
        InputError: The file states no limit of any of these joints.
    """
    stated = {name: stated_limits(file, name) for name in limits}
    if not any(stated.values()):
        raise InputError(
            f"{file.path}: states no limits of {', '.join(limits)}; expected joint_limits with an entry by "
            "joint, as ROS has it"
        )
    return {
        name: replace(each, values={k: v for k, v in each.values.items() if f"max_{k}" not in stated[name]})
        for name, each in limits.items()
    }


def with_figure(
    limits: Mapping[str, StatedLimits], kind: str, joint: str | None, value: float
) -> dict[str, StatedLimits]:
    """Add a limit stated by the user, which overrides all others.

    Args:
        limits: Limits by joint.
        kind: "velocity", "acceleration", "jerk" or "effort".
        joint: Name of the joint; None for all joints without such a limit.
        value: In the joint's unit per s, s2 or s3.

    Returns:
        The new limits by joint.

    Raises:
        UnknownNameError: There is no such joint.
        InputError: It is larger than that of any real joint.
    """
    if joint is not None and joint not in limits:
        raise UnknownNameError("joint", joint, list(limits), option_of(kind))
    for name in [name for name in limits if joint in (None, name) and kind != EFFORT]:
        most, unit = limits[name].most(kind)
        if value > most:
            fault = f"expected at most {most:g} for {name}, got {value:g}; limits are in {unit}"
            raise InputError(f"{option_of(kind)}: {fault}")
    found = dict(limits)
    for name, each in limits.items():
        if kind == EFFORT:
            is_meant = name == joint or (joint is None and each.effort is None)
            found[name] = replace(each, effort=value) if is_meant else each
        elif name == joint or (joint is None and kind in each.values and each.values[kind] is None):
            values = {k: each.values.get(k) for k in KINDS if k in each.values or k == kind} | {kind: value}
            found[name] = replace(
                each, values=values, sources={**each.sources, kind: "from the command line"}
            )
    return found


def option_of(kind: str) -> str:
    """Return the option of ``apc init`` that states figures of a kind.

    Args:
        kind: "velocity", "acceleration", "jerk" or "effort".

    Returns:
        Name of the option.
    """
    return "--motor-force" if kind == EFFORT else f"--max-{kind}"


def _positive(limit: Element | None, attribute: str) -> float | None:
    """Return an attribute if it is positive, else None."""
    if limit is None or attribute not in limit.attributes:
        return None
    value = limit.number(attribute)
    return value if value > 0.0 else None
