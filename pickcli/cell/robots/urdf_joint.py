"""Reads a joint of a URDF: parent and child, type, axis, limits, and the joint that it mimics."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from pickcli.cell.robot import Joint, JointType
from pickcli.cell.robots.urdf_origin import MAX_TURN, read_origin
from pickcli.files.xml_mistakes import XmlMistakes
from pickcli.files.xml_reader import Element
from pickcli.geometry import Array

ENDLESS = 1e4  # rad either way; larger limits mean a joint without limits
MAX_TRAVEL = 100.0  # m, longest rail; larger limits were written in another unit


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: its position is ``multiplier`` times the other's, plus ``offset``.

    Attributes:
        joint: Name of the joint that it follows.
        multiplier: Factor on the position of that joint.
        offset: rad or m.
    """

    joint: str
    multiplier: float
    offset: float


def read_joint(element: Element, mistakes: XmlMistakes) -> Joint:
    """Read a joint.

    Args:
        element: The joint element.
        mistakes: Collects what is wrong with it.

    Returns:
        The joint, with placeholders for wrong values.
    """
    kind = mistakes.tried(lambda: _kind(element), JointType.FIXED)
    lower, upper = mistakes.tried(lambda: _limits(element, kind), (0.0, 0.0))
    return Joint(
        name=element.text("name"),
        type=kind,
        parent=mistakes.tried(lambda: element.one("parent").text("link"), ""),
        child=mistakes.tried(lambda: element.one("child").text("link"), ""),
        T_parent_joint=mistakes.tried(lambda: read_origin(element), np.eye(4)),
        axis=mistakes.tried(lambda: _axis(element, kind), np.zeros(3)),
        lower=lower,
        upper=upper,
        ignored_limits=mistakes.tried(lambda: _ignored_limits(element, kind), None),
    )


def _kind(element: Element) -> JointType:
    kinds = sorted(kind.value for kind in JointType)
    if element.text("type") not in kinds:
        raise element.error(f"expected type {', '.join(kinds)}, got {element.text('type')!r}")
    return JointType(element.text("type"))


def _axis(element: Element, kind: JointType) -> Array:
    if kind is JointType.FIXED:
        return np.array([0.0, 0.0, 1.0])  # moves nothing
    axis_element = element.one("axis")
    axis = np.array(axis_element.numbers("xyz", 3))
    length = math.hypot(*axis)
    if not 1e-6 <= length <= 1e6:
        raise axis_element.error("the axis has no direction; expected a vector of length 1")
    return np.asarray(axis / length)


def _limits(element: Element, kind: JointType) -> tuple[float, float]:
    if kind is JointType.FIXED:
        return 0.0, 0.0
    if kind is JointType.CONTINUOUS:
        return -math.inf, math.inf
    limit = element.one("limit")
    lower, upper = limit.number("lower"), limit.number("upper")
    if lower == upper:
        raise limit.error(f"expected lower under upper, got {lower:g} for both; a joint that stands is fixed")
    if lower > upper:
        raise limit.error(f"expected lower under upper, got {lower:g} and {upper:g}; swap them")
    most, unit = (MAX_TRAVEL, "m, not mm") if kind is JointType.PRISMATIC else (MAX_TURN, "rad, not degrees")
    if max(-lower, upper) > most:
        if kind is JointType.REVOLUTE and min(-lower, upper) > ENDLESS:
            raise limit.error(
                f"got {lower:g} and {upper:g} rad; the type of a joint without limits is continuous"
            )
        raise limit.error(f"expected within {most:g} of 0, got {lower:g} and {upper:g}; limits are in {unit}")
    return lower, upper


def _ignored_limits(element: Element, kind: JointType) -> tuple[float, float] | None:
    """Return the limits of a continuous joint if they leave out a part of the turn; None for all others."""
    limit = element.optional("limit") if kind is JointType.CONTINUOUS else None
    if limit is None or not {"lower", "upper"} <= limit.attributes.keys():
        return None
    lower, upper = limit.number("lower"), limit.number("upper")
    return (lower, upper) if 0.0 < upper - lower < 2.0 * math.pi else None


def read_mimics(elements: dict[str, Element], mistakes: XmlMistakes) -> Iterator[tuple[str, Mimic]]:
    """Read which joints mimic another. Mimics of fixed joints are ignored.

    Args:
        elements: The joint elements by name.
        mistakes: Collects what is wrong with them.

    Yields:
        Name and mimic relation of each following joint.
    """
    for name, element in elements.items():
        if element.attributes.get("type") != JointType.FIXED:
            found = mistakes.tried(partial(_mimic, element, elements), None)
            if found is not None:
                yield name, found


def _mimic(joint: Element, elements: dict[str, Element]) -> Mimic | None:
    mimic = joint.optional("mimic")
    if mimic is None:
        return None
    leader = mimic.text("joint")
    if leader not in elements:
        raise mimic.error(f"no joint is named {leader!r}; add it or correct the name")
    if elements[leader].optional("mimic") is not None:
        raise mimic.error(f"{leader!r} mimics a joint itself; name the one that leads")
    factor = mimic.number("multiplier") if "multiplier" in mimic.attributes else 1.0
    return Mimic(leader, factor, mimic.number("offset") if "offset" in mimic.attributes else 0.0)
