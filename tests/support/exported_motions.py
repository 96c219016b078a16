"""Motions to be exported: random ones at rest at both ends, and one of a UR5e with events."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.export.exporter import ExportRequest
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import PoseNoise, Scene
from support.handmade_plans import pick

ANYWHERE = Anchor(AnchorKind.TIME, 0)


@st.composite
def trajectories(draw: st.DrawFn, joint_names: tuple[str, ...] = ("a", "b")) -> Trajectory:
    """At rest at both ends; points from a tenth of a nanosecond to a second apart."""
    gaps = draw(st.lists(st.floats(1e-10, 1.0), min_size=1, max_size=8))
    n = len(joint_names)
    row = st.lists(st.floats(-3.0, 3.0), min_size=n, max_size=n)
    rows = [np.array([draw(row) for _ in range(len(gaps) + 1)]) for _ in range(3)]
    rows[1][[0, -1]] = rows[2][[0, -1]] = 0.0
    return Trajectory(joint_names, np.concatenate([[0.0], np.cumsum(gaps)]), *rows)


@cache
def handmade_pick() -> ExportRequest:
    """A pick in the default cell, its scene, with events of every device."""
    plan, scene = pick()
    return ExportRequest(plan, scene)


@cache
def ur_cell() -> Cell:
    return load_cell("ur5e_crates")


def ur_request(rate: float | None = None, **chosen: int) -> ExportRequest:
    """A move of a UR5e there and back in 2.0013 s, with events between and after."""
    cell = ur_cell()
    home = cell.configurations["home"].q
    turned = home + np.array([0.3, 0.1, -0.1, 0.0, 0.0, 0.2])
    still = np.zeros((3, 6))
    trajectory = Trajectory(
        cell.robot.joint_names, np.array([0.0, 1.0, 2.0013]), np.array([home, turned, home]), still, still
    )
    state = cell.robot.tool.default_state
    segments = (Segment(SegmentKind.TRANSIT, 0.0, 2.0013, state, None),)
    events = tuple(
        Event(device, action, ANYWHERE, 0.0, t, t)
        for device, action, t in (
            ("valve", "off", 2.05),
            ("pump", "on", 0.0),
            ("valve", "on", 0.5013),
            ("vacuum_sensor", "read", 1.0),
        )
    )
    plan = Plan("move there and back", cell.fingerprint, "", 0, segments, trajectory, events)
    return ExportRequest(plan, Scene(cell, cell.T_world_pod, (), PoseNoise()), rate, chosen)


def at_rate(request: ExportRequest, rate: float | None) -> ExportRequest:
    return replace(request, rate=rate)
