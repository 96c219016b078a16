"""A motion as a table: a row per sample, units in the names of the columns, device events in the last one."""

from __future__ import annotations

import csv
import io
from collections import defaultdict

import numpy as np

from pickcli.export.device_events import DeviceEvent, device_events
from pickcli.export.exporter import Exporter, ExportRequest
from pickcli.export.samples import SECOND, sampled
from pickcli.motion.plan import Plan

QUANTITIES = ("position_{}", "velocity_{}_per_s", "acceleration_{}_per_s2")  # with the joint's unit


def columns(joint_names: tuple[str, ...], units: tuple[str, ...]) -> list[str]:
    """The names of the columns.

    Args:
        joint_names: Names of the n joints.
        units: Of their positions: "m" or "rad".

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
    """A time in s with all its digits.

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
    told = _by_row(device_events(plan, cell), samples.nanoseconds.tolist())
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(columns(plan.trajectory.joint_names, cell.robot.units))
    for row, t in enumerate(samples.nanoseconds.tolist()):
        numbers = map(repr, states[row].ravel().tolist())
        table.writerow([seconds(t), *numbers, *_segment(plan, t / SECOND), told[row]])
    return text.getvalue().encode()


def _by_row(events: tuple[DeviceEvent, ...], nanoseconds: list[int]) -> defaultdict[int, str]:
    """The events that are commanded from each row on and before the next one."""
    rows = np.searchsorted(nanoseconds, [event.nanoseconds for event in events], side="right") - 1
    found: defaultdict[int, str] = defaultdict(str)
    for row, event in zip(rows.tolist(), events, strict=True):
        told = f"{event.device}={event.action}@{seconds(event.nanoseconds)}"
        found[row] = f"{found[row]}; {told}" if found[row] else told
    return found


def _segment(plan: Plan, t: float) -> tuple[str, str]:
    """The kind of the segment at a time, and the item that is held in it."""
    now = next((segment for segment in plan.segments if t < segment.t_end), plan.segments[-1])
    return now.kind.value, now.held or ""


EXPORTER = Exporter("a table of positions, velocities and accelerations, units in its head", ".csv", _encode)
