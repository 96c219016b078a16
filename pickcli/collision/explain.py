"""What the numbers of the kernel mean to a person: names, depths and places."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pickcli.errors import Reason
from pickcli.geometry import Array

if TYPE_CHECKING:
    from pickcli.collision.checker import SceneChecker

_SAMPLES = 17  # of an edge, to find where it is worst


@dataclass(frozen=True)
class Contact:
    """The closest pair of a configuration.

    distance: m between spheres of the robot and what they are closest to, negative inside
    a: link name or "held <item>"; b: body name, item id, link name or "held <item>"; "" if nothing is near
    kind: what b is: "pod", "tote", "obstacle", "item", "base", "robot", or ""
    """

    distance: float
    a: str
    b: str
    kind: str = ""

    @property
    def item(self) -> str:
        """Id of the item that b is, or ""."""
        return self.b if self.kind == "item" else ""

    def __str__(self) -> str:
        if not self.b:
            return "nothing near"
        kind = "" if self.kind == "robot" else f"{self.kind} "
        return f"{self.a} against {kind}{self.b}"


def too_deep(checker: SceneChecker, q: Array) -> Reason | None:
    """Why q is not free where it keeps clear of all but what it may touch, and goes too deep into that."""
    if checker.touch is None or checker.touch.kernel.is_free(q, 0.0):
        return None
    distance, frame, _, index = checker.touch.kernel.clearance(q, 1.0)
    solid = int(checker.touch.kept[index])
    name, kind = checker.world.names[solid], checker.world.kinds[solid]
    beyond = f"{-1e3 * distance:.1f} mm beyond what poses and bellows explain"
    detail = f"{_part(checker, frame)} against {kind} {name}, {beyond}"
    return Reason("planned contact too deep", "", detail, name if kind == "item" else "")


def closest(checker: SceneChecker, q: Array, max_distance: float) -> Contact:
    """The closest pair at q within ``max_distance`` that is no planned contact."""
    distance, frame, kind, index = checker.kernel.clearance(q, max_distance)
    if frame < 0:
        return Contact(float(distance), "", "")
    if kind == 1:
        return Contact(float(distance), _part(checker, frame), _part(checker, index), "robot")
    box = int(checker.kept[index])
    return Contact(float(distance), _part(checker, frame), checker.world.names[box], checker.world.kinds[box])


def configuration(checker: SceneChecker, q: Array) -> Reason:
    """Why q is not free."""
    if checker.kernel.is_free(q, checker.margin) and (reason := too_deep(checker, q)) is not None:
        return reason
    return _reason(checker, closest(checker, q, 1.0), checker.is_free(q), "")


def edge(checker: SceneChecker, q0: Array, q1: Array) -> Reason:
    """Why the straight edge is not free: its deepest place among even samples and the kernel's witness."""
    result = checker.kernel.check_edge(q0, q1, checker.margin)
    if result.free and checker.touch is not None:
        touch = checker.touch.kernel.check_edge(q0, q1, 0.0)
        if not touch.free and (reason := too_deep(checker, (1 - touch.t) * q0 + touch.t * q1)) is not None:
            return reason
    fractions = np.linspace(0.0, 1.0, _SAMPLES)
    if not result.free:
        fractions = np.append(fractions, result.t)
    Q = np.outer(1 - fractions, q0) + np.outer(fractions, q1)
    # What is farther away than the margin does not count, and need not be measured.
    t = float(fractions[np.argmin(checker.kernel.clearances(Q, checker.margin))])
    contact = closest(checker, (1 - t) * q0 + t * q1, 1.0)
    return _reason(checker, contact, result.free, f" at {100 * t:.0f} % of the edge")


def _reason(checker: SceneChecker, contact: Contact, is_free: bool, place: str) -> Reason:
    millimetres = 1e3 * abs(contact.distance)
    if is_free:
        return Reason("no collision", "", f"{contact}, {millimetres:.0f} mm apart{place}")
    if contact.distance > 0:
        needed = f"{1e3 * checker.margin:.0f} mm are needed"
        return Reason(
            "too close", "", f"{contact}, {millimetres:.1f} mm apart{place} ({needed})", contact.item
        )
    return Reason("collision", "", f"{contact}, {millimetres:.0f} mm deep{place}", contact.item)


def _part(checker: SceneChecker, frame: int) -> str:
    """Name of a frame of the robot; the frame after the last is the held item."""
    if frame < checker.model.n_frames:
        return checker.model.frame_names[frame]
    assert checker.held is not None
    return f"held {checker.held.item.name}"
