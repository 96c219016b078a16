"""Proof that a blended path is free, by chords with tubes around them that a collision checker validates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.timing.corner_blending import BlendedPath, blend, distinct, smoothed
from pickcli.timing.limit_check import POSITION_TOLERANCE
from pickcli.timing.path_parts import PathParts

IsFree: TypeAlias = Callable[[int, Array, Array], int]
"""(part, Q (K, n), slack (K - 1, n)) -> index of the first chord whose tube is not proven free, or -1."""

_HALVINGS = 6  # of a corner's tolerance, before the motion has to stop at the corner


@dataclass(frozen=True, eq=False)
class ChordTube:
    """Chords with a tube around each: along chord k the path stays within slack[k] of it, joint by joint.

    Attributes:
        s: (K,) path parameters of the chord ends.
        configurations: (K, n) chord ends.
        slack: (K - 1, n), 0 on straight lines.
    """

    s: Array
    configurations: Array
    slack: Array


def chord_tube(curve: BlendedPath, start: float = 0.0, end: float | None = None) -> ChordTube:
    """Compute chords and their tubes for a part of a blended path.

    The path leaves a chord by at most the square of the chord's length in s times the largest second
    derivative, over eight; that derivative is bounded joint by joint
    (``BlendedPath.second_derivative_bound``).

    Args:
        curve: The blended path.
        start: Path parameter s at the start of the part.
        end: Path parameter s at its end; the end of the path if None.

    Returns:
        The chords and their slack.
    """
    end = curve.length if end is None else end
    inner = curve.knots[(curve.knots > start) & (curve.knots < end)]
    s = distinct(np.concatenate([inner, [end]]) - start) + start if end > start else np.zeros(0)
    s = np.concatenate([[start], s[s > start]])
    width = np.diff(s)[:, None]
    slack = curve.second_derivative_bound(s[:-1], s[1:]) * width**2 / 8
    return ChordTube(s, curve.evaluate(s), np.where(curve.is_line(s[:-1], s[1:])[:, None], 0.0, slack))


def proven_blend(parts: PathParts, limits: Limits, is_free: IsFree | None) -> BlendedPath:
    """Blend the corners of a polyline so that every part is proven free and within the position limits.

    If the blend of a corner is not proven, its tolerance is halved, up to six times; after that the corner
    becomes a stop, at which the path is the polyline itself.

    Args:
        parts: The polyline in parts.
        limits: Position limits.
        is_free: Checks that chords of a part are free; None trusts the tolerances.

    Returns:
        The blended path.

    Raises:
        NoPlanError: If a straight edge is not proven: the polyline was not free.
    """
    waypoints, tolerances = parts.waypoints, parts.tolerances
    try:
        return _proven(blend(waypoints, tolerances), parts, limits, is_free)
    except NoPlanError:
        # Dropping waypoints moved an edge slightly; without that the polyline is the caller's.
        return _proven(blend(waypoints, tolerances, simplify=0.0), parts, limits, is_free)


def _proven(curve: BlendedPath, parts: PathParts, limits: Limits, is_free: IsFree | None) -> BlendedPath:
    tolerances = parts.tolerances
    nearest = np.abs(curve.waypoint_s[:, None] - curve.corner_s).argmin(axis=0)
    wanted = tolerances[nearest].astype(float)
    floor = wanted / 2.0**_HALVINGS
    while (failure := _first_failure(curve, parts, limits, is_free)) is not None:
        reason, start, end = failure
        near = np.abs(curve.corner_s - np.clip(curve.corner_s, start, end)) < curve.half_lengths
        if not near.any():
            raise NoPlanError("a timed path", [reason])
        wanted = np.where(near, np.where(wanted / 2 > floor, wanted / 2, 0.0), wanted)
        curve = smoothed(replace(curve, half_lengths=np.zeros(len(wanted))), tolerances, wanted)
    return curve


def _first_failure(
    curve: BlendedPath, parts: PathParts, limits: Limits, is_free: IsFree | None
) -> tuple[Reason, float, float] | None:
    """Return a reason and the s range of the first chord outside the position limits or not proven free."""
    if is_free is None and _beyond(curve.evaluate(curve.knots), limits).max() <= POSITION_TOLERANCE:
        return None
    at = parts.boundaries(curve)
    for part in range(len(at) - 1):
        tube = chord_tube(curve, float(at[part]), float(at[part + 1]))
        if len(tube.s) < 2:
            continue
        q = tube.configurations
        beyond = _beyond(q, limits)
        if beyond.max() > POSITION_TOLERANCE:
            k = min(int(np.argmax(beyond)), len(tube.s) - 2)
            reason = Reason(
                "joint limit", f"part {part}", f"{beyond.max():.3g} outside at s = {tube.s[k]:.3f}"
            )
            return reason, float(tube.s[max(k - 1, 0)]), float(tube.s[k + 1])
        k = -1 if is_free is None else is_free(part, q, tube.slack)
        if k >= 0:
            detail = f"not proven free from s = {tube.s[k]:.3f} to {tube.s[k + 1]:.3f} of {curve.length:.3f}"
            return Reason("collision", f"part {part}", detail), float(tube.s[k]), float(tube.s[k + 1])
    return None


def _beyond(q: Array, limits: Limits) -> Array:
    """Return (K,) how far configurations (K, n) are outside the position limits, negative inside."""
    return np.asarray(np.maximum(limits.lower - q, q - limits.upper).max(axis=1))
