"""The cup: when it seals on an item, how it holds it, and when the item breaks away.

The cup is a bellows that compresses by its stroke without pushing; contact is a matter of distance from
its uncompressed tip, not of colliding shapes. A seal is a weld in the engine whose load is read every step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pickcli.cell.robot import Tool
from pickcli.geometry import Array, inverse
from pickcli.simulation.engine import Engine
from pickcli.simulation.vacuum import FULL_VACUUM, Vacuum

GAP = 1.5e-3  # m, farthest from the tip at which a cup draws a face on
CONFORMITY = 5e-3  # m, how uneven a face its lip follows: 10 degrees of tilt, or the curve of a bottle
N_RIM = 8  # points of the rim that must all lie on the face
BREAK_TIME = 3 / 240  # s over a limit until the item is off: 3 steps in a row at the measured 240 Hz
STOP_STIFFNESS = 2000.0  # N/m beyond the stroke, when the bellows are solid
DRAG_REACH = 0.01  # m in front of the cup where its open flow still moves things
DRAG_SHARE = 0.05  # of the closed cup's force, at the cup
WELD_FORCE = 1e4  # N, far above every limit: the weld itself never yields
SEAL_VACUUM = 40e3  # Pa in the cup from which it holds, and from which the sensor says so
RELEASE_VACUUM = 5e3  # Pa in the vented cup below which the item comes off
STANDING_SPEED = 2e-3  # m/s between cup and face below which a seal sets
PROBE_BACK = 0.02  # m behind the compressed cup where the probing rays start, so never inside an item


@dataclass(frozen=True)
class Load:
    """What the cup carries. Pull is along the cup's axis away from it, shear across it."""

    pull: float  # N, negative when the item presses against the cup
    shear: float  # N
    moment: float  # Nm about the cup

    def ratio(self, tool: Tool, vacuum: float) -> float:
        """Worst share of the tool's limits, which are stated at full vacuum and fall with it."""
        worst = max(
            self.pull / tool.cup_limits.max_pull,
            self.shear / tool.cup_limits.max_shear,
            self.moment / tool.cup_limits.max_moment,
        )
        return worst * FULL_VACUUM / vacuum if vacuum > 0.0 else math.inf


@dataclass(frozen=True, eq=False)
class Release:
    """An item that left the cup."""

    item: str
    t: float  # s, simulated
    is_wanted: bool  # the valve let go of it, it did not break away
    T_world_item: Array  # (4, 4) when it left
    load: Load  # the last one measured


class Suction:
    """The cup of one robot in an engine. ``held`` is the id of the welded item or None."""

    def __init__(self, engine: Engine, robot: str, tool: Tool, vacuum: Vacuum) -> None:
        self._engine, self._robot, self._tool = engine, robot, tool
        self.vacuum = vacuum
        self.held: str | None = None
        self.T_tip_item: Array | None = None  # (4, 4) of the held item, as it was welded
        self.load = Load(0.0, 0.0, 0.0)
        self.max_ratio = 0.0  # worst load since the last seal, as a share of the limits
        self.releases: list[Release] = []
        self._weld = -1
        self._last_distance = np.inf
        self._time_over = 0.0
        angles = np.arange(N_RIM) * 2 * np.pi / N_RIM
        rim = tool.cup_radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        self._points = np.concatenate([np.zeros((1, 2)), rim])  # (9, 2) in the tip's x-y plane

    @property
    def is_holding(self) -> bool:
        """What the vacuum sensor says: a closed cup with enough vacuum."""
        return self.held is not None and self.vacuum.cup >= SEAL_VACUUM

    def before_step(self, T_world_tip: Array, time_step: float, is_near: bool) -> None:
        """Pressure, seal and the forces of the open cup; before the engine steps.

        is_near: whether a contact with an item is planned now; else only an open valve makes the cup act
        """
        if self.held is not None or not (is_near or self.vacuum.is_valve_open):
            self.vacuum.advance(time_step, is_sealed=self.held is not None)
            return
        item, distances = self._face(T_world_tip)
        distance = float(distances.min())
        closing = (self._last_distance - distance) / time_step
        self._last_distance = distance
        seals = item is not None and distance <= GAP and float(np.ptp(distances)) <= CONFORMITY
        self.vacuum.advance(time_step, is_sealed=seals)
        if item is None:
            return
        # The bellows give way while the cup moves; what lifts off before they set is not held.
        if seals and abs(closing) < STANDING_SPEED and self.vacuum.cup >= SEAL_VACUUM:
            self._attach(item, T_world_tip)
        else:
            self._act_on(item, T_world_tip, distance, seals)

    def after_step(self, T_world_tip: Array, time_step: float, t: float) -> None:
        """Read the weld's load and let go where the valve or a limit says so; after the engine stepped."""
        if self.held is None:
            return
        self.load = self._measure(T_world_tip)
        ratio = self.load.ratio(self._tool, self.vacuum.cup)
        if not self.vacuum.is_valve_open:
            if ratio > 1.0 or self.vacuum.cup < RELEASE_VACUUM:
                self._detach(t, is_wanted=True)
            return
        self.max_ratio = max(self.max_ratio, ratio)
        self._time_over = self._time_over + time_step if ratio > 1.0 else 0.0
        if self._time_over > BREAK_TIME - time_step / 2:
            self._detach(t, is_wanted=False)
            self.vacuum.burst()

    def _face(self, T_world_tip: Array) -> tuple[str | None, Array]:
        """The item in front of the cup and its distance (9,) from each point of the uncompressed face.

        Negative distances are compression; points that do not meet that item are at infinity.
        """
        back, ahead = self._tool.cup_stroke + PROBE_BACK, DRAG_REACH
        R, tip = T_world_tip[:3, :3], T_world_tip[:3, 3]
        starts = tip + self._points @ R[:, :2].T - back * R[:, 2]
        hits = self._engine.ray_hits(starts, starts + (back + ahead) * R[:, 2])
        nearest = min(hits, key=lambda hit: hit[1])[0]
        if not nearest:
            return None, np.full(len(hits), np.inf)
        reach = np.array([f * (back + ahead) - back if name == nearest else np.inf for name, f in hits])
        return nearest, reach

    def _act_on(self, item: str, T_world_tip: Array, distance: float, seals: bool) -> None:
        """Push with the solid bellows beyond the stroke, or draw with the open flow in front of it."""
        axis = T_world_tip[:3, 2]
        force = STOP_STIFFNESS * max(0.0, -distance - self._tool.cup_stroke)
        if distance > 0.0 and not seals and self.vacuum.is_valve_open:
            area = np.pi * self._tool.cup_radius**2
            force = -DRAG_SHARE * self.vacuum.line * area * (1.0 - distance / DRAG_REACH)
        if force != 0.0:
            self._engine.wake(item)
            self._engine.push(item, force * axis, T_world_tip[:3, 3] + distance * axis)

    def _attach(self, item: str, T_world_tip: Array) -> None:
        T_item_tip = inverse(self._engine.pose(item)) @ T_world_tip
        self._weld = self._engine.weld(
            self._robot, self._tool.cup_link, item, self._tool.T_cup_tip, T_item_tip, WELD_FORCE
        )
        self.held, self.T_tip_item = item, inverse(T_item_tip)
        self._time_over = self.max_ratio = 0.0
        self.load = Load(0.0, 0.0, 0.0)

    def _detach(self, t: float, is_wanted: bool) -> None:
        assert self.held is not None
        self._engine.unweld(self._weld, self.held)
        self.releases.append(Release(self.held, t, is_wanted, self._engine.pose(self.held), self.load))
        self.held, self.T_tip_item, self._last_distance = None, None, np.inf

    def _measure(self, T_world_tip: Array) -> Load:
        force, moment = self._engine.weld_load(self._weld)
        axis = T_world_tip[:3, 2]
        pull = float(force @ axis)
        return Load(pull, float(np.linalg.norm(force - pull * axis)), float(np.linalg.norm(moment)))
