"""Exports a motion as CSV: a row per sample, units in column names, device events in the last column."""

from __future__ import annotations

import csv
import io
from collections import defaultdict

import numpy as np

from pickcli.export.device_events import DeviceEvent, device_events
from pickcli.export.exporter import Exporter, ExportRequest
from pickcli.export.samples import SECOND, sampled, to_nanoseconds
from pickcli.motion.plan import Plan

QUANTITIES = ("position_{}", "velocity_{}_per_s", "acceleration_{}_per_s2")  # with the joint's unit inserted


def columns(joint_names: tuple[str, ...], units: tuple[str, ...]) -> list[str]:
    """Return the names of the columns.

    Args:
        joint_names: Names of the n joints.
        units: Units of their positions: "m" or "rad".

    Returns:
        ``time_s``, three for each joint, ``segment``, ``held`` and ``events``.
    """
    joints = [
        f"{name}_{quantity.format(unit)}"
        for name, unit in zip(joint_names, units, strict=True)
        for quantity in QUANTITIES
    ]
    return ["time_s", *joints, "segment", "held", "events"]


def seconds(nanoseconds: int) -> str:
    """Format a time in s with nanosecond resolution.

    Args:
        nanoseconds: At least 0.

    Returns:
        Nine decimals.
    """
    return "{}.{:09d}".format(*divmod(int(nanoseconds), SECOND))


def _encode(request: ExportRequest) -> bytes:
    plan, cell = request.plan, request.scene.cell
    samples = sampled(plan.trajectory, request.rate)
    states = np.stack([samples.positions, samples.velocities, samples.accelerations], axis=2)
    event_texts = _by_row(device_events(plan, cell), samples.nanoseconds.tolist())
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(columns(plan.trajectory.joint_names, cell.robot.units))
    for row, t in enumerate(samples.nanoseconds.tolist()):
        numbers = map(repr, states[row].ravel().tolist())
        table.writerow([seconds(t), *numbers, *_segment(plan, t), event_texts[row]])
    return text.getvalue().encode()


def _by_row(events: tuple[DeviceEvent, ...], nanoseconds: list[int]) -> defaultdict[int, str]:
    """Events commanded between each row and the next one."""
    rows = np.searchsorted(nanoseconds, [event.nanoseconds for event in events], side="right") - 1
    found: defaultdict[int, str] = defaultdict(str)
    for row, event in zip(rows.tolist(), events, strict=True):
        text = f"{event.device}={event.action}@{seconds(event.nanoseconds)}"
        found[row] = f"{found[row]}; {text}" if found[row] else text
    return found


def _segment(plan: Plan, nanoseconds: int) -> tuple[str, str]:
    """Kind of the segment that begins at a time or continues, and its held item."""
    later = (segment for segment in plan.segments if nanoseconds < to_nanoseconds(segment.t_end))
    now = next(later, plan.segments[-1])
    return now.kind.value, now.held or ""


EXPORTER = Exporter("a table of positions, velocities and accelerations, units in its head", ".csv", _encode)
