"""Hand-made plans on the default cell: straight joint moves and straight lines, timed by quintics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array, pose, rotation_vector
from pickcli.grasping.suction_grasping import SuctionGrasping
from pickcli.kinematics.arm import Arm
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from support.tool_states import STRAIGHT

CRAYOLA = "crayola_24_ct"
SEAL_TIME = 0.25  # s, of the default cell


@cache
def cell() -> Cell:
    return load_cell("apc2016_delft")


def tip(q: Array, tool_state: ToolState = STRAIGHT) -> Array:
    """Pose (4, 4) of the tool frame."""
    robot = cell().robot
    return np.asarray(tip_poses(robot, link_poses(robot, np.atleast_2d(q)), tool_state)[0])


def solve(T: Array, q0: Array, tool_state: ToolState = STRAIGHT) -> Array:
    """The configuration near q0 that puts the tool at T."""

    def error(q: Array) -> Array:
        now = tip(q, tool_state)
        turn = now[:3, :3] @ rotation_vector(now[:3, :3].T @ T[:3, :3])
        return np.concatenate([now[:3, 3] - T[:3, 3], turn, 1e-7 * (q - q0)])

    result = least_squares(error, q0, xtol=1e-14, ftol=1e-14, gtol=1e-14)
    assert np.abs(error(result.x)[:6]).max() < 1e-5
    return np.asarray(result.x)


@dataclass
class Builder:
    """Strings moves together; every one starts and ends at rest."""

    q: Array
    times: list[float] = field(default_factory=lambda: [0.0])
    rows: list[Array] = field(default_factory=list)  # p, v, a stacked (3, n) per point
    segments: list[Segment] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.rows.append(np.stack([self.q, 0 * self.q, 0 * self.q]))

    def joint(self, kind: SegmentKind, q: Array, duration: float, **state: Any) -> None:
        """A straight joint move to q."""
        self._move(kind, np.linspace(0, 1, 9)[:, None] * (q - self.q) + self.q, duration, **state)

    def line(
        self, kind: SegmentKind, T: Array, duration: float, tool_state: ToolState = STRAIGHT, **state: Any
    ) -> None:
        """A straight line of the tool to T."""
        T_a, qs = tip(self.q, tool_state), [self.q]
        turn = rotation_vector(T_a[:3, :3].T @ T[:3, :3])
        for s in np.linspace(0, 1, 17)[1:]:
            R = T_a[:3, :3] @ Rotation.from_rotvec(s * turn).as_matrix()
            qs.append(solve(pose((1 - s) * T_a[:3, 3] + s * T[:3, 3], R=R), qs[-1], tool_state))
        self._move(kind, np.array(qs), duration, tool_state=tool_state, **state)

    def wait(self, kind: SegmentKind, duration: float, **state: Any) -> None:
        self._move(kind, np.stack([self.q] * 5), duration, **state)

    def rest(self, duration: float) -> None:
        """Hold still at the end of the last segment, as a part of it."""
        last = self.segments.pop()
        self.wait(last.kind, duration)
        self.segments[-1] = replace(last, t_end=self.times[-1])

    def _move(
        self,
        kind: SegmentKind,
        qs: Array,
        duration: float,
        tool_state: ToolState = STRAIGHT,
        held: str | None = None,
        touching: Sequence[str] = (),
    ) -> None:
        start = self.times[-1]
        path = CubicSpline(np.linspace(0, 1, len(qs)), qs)
        for u in np.linspace(0, 1, max(3, int(duration / 0.04)))[1:]:
            # s(u) from rest to rest without a jump of acceleration; the points by the chain rule
            s = 10 * u**3 - 15 * u**4 + 6 * u**5
            ds = (30 * u**2 - 60 * u**3 + 30 * u**4) / duration
            dds = (60 * u - 180 * u**2 + 120 * u**3) / duration**2
            v, a = path(s, 1) * ds, path(s, 2) * ds**2 + path(s, 1) * dds
            self.rows.append(np.stack([path(s), v, a]))
            self.times.append(start + duration * float(u))
        self.rows[-1][1:] = 0.0
        self.q = qs[-1]
        self.segments.append(Segment(kind, start, self.times[-1], tool_state, held, tuple(touching)))

    def trajectory(self) -> Trajectory:
        p, v, a = np.stack(self.rows, axis=1)
        return Trajectory(cell().robot.joint_names, np.array(self.times), p, v, a)


def place(item_id: str, xyz: tuple[float, float, float], location: str, yaw: float = 0.0) -> PlacedItem:
    return PlacedItem(item_id, cell().item(item_id.split("#")[0]), location, pose(xyz, rpy=(0, 0, yaw)))


def make_scene(*items: PlacedItem, noise: PoseNoise | None = None) -> Scene:
    return Scene(cell(), np.eye(4), items, noise or PoseNoise())


def bound(plan: Plan, scene: Scene) -> Plan:
    """The plan, said to be made for this cell and scene."""
    return replace(plan, cell_fingerprint=scene.cell.fingerprint, scene_hash=scene_hash(scene))


def move_plan(scene: Scene, builder: Builder) -> Plan:
    plan = Plan("move", "", "", 0, tuple(builder.segments), builder.trajectory(), ())
    return bound(plan, scene)


def crayola_scene(noise: PoseNoise | None = None) -> Scene:
    """A box of crayons upright on the flat floor of bin_B, its broad side to the front; two neighbours."""
    floor = 1.5239
    # item frame: x 0.095, y 0.07, z 0.025; turned so that x is up and -z looks out of the bin
    T = np.eye(4)
    T[:3, :3] = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
    T[:3, 3] = (0.30, 0.0, floor + 0.0475 + 2e-4)
    target = PlacedItem(CRAYOLA, cell().item(CRAYOLA), "bin_B", T)
    return make_scene(
        target,
        place("dove_beauty_bar", (0.30, 0.11, floor + 0.017 + 2e-4), "bin_B"),
        place("dasani_water_bottle", (0.30, 0.3, floor + 0.0975 + 2e-4), "bin_A"),
        noise=noise,
    )


SUPPORT = ("row_ABC_floor_flat", "row_ABC_floor_slope")


@cache
def pick() -> tuple[Plan, Scene]:
    """A whole pick from home to the tote and up again, and its scene."""
    scene = crayola_scene()
    return _pick(scene, 0.0), scene


def pick_pushing(aside: float) -> Plan:
    """The same with the first lift so many m along y, too."""
    return _pick(crayola_scene(), aside)


def pick_sealing(seal_time: float) -> Plan:
    """The same with so many seconds of rest on the item."""
    return _pick(crayola_scene(), 0.0, seal_time)


def _pick(scene: Scene, aside: float, seal_time: float = SEAL_TIME) -> Plan:
    target = scene.items[0]
    configurations = {name: c.q for name, c in cell().configurations.items()}
    R = tip(configurations["bin_B"])[:3, :3]
    R_tip = np.column_stack(
        [np.cross([0, np.sign(R[1, 1]), 0], [1.0, 0, 0]), [0, np.sign(R[1, 1]), 0], [1, 0, 0]]
    )
    face = target.T_world_item[:3, 3] + [-0.0125, 0.0, 0.01]
    T_item_tip = np.linalg.inv(target.T_world_item) @ pose(face, R=R_tip)

    def at(dx: float, dz: float = 0.0, dy: float = 0.0) -> Array:
        return pose(face + np.array([dx, dy, dz]), R=R_tip)

    # the preapproach starts 60 mm before the mouth, where the arm stands as in front of the bin
    front = at(-face[0] - 0.06)
    b = Builder(configurations["home"])
    b.joint(SegmentKind.TRANSIT, solve(front, configurations["bin_B"]), 1.8)
    b.line(SegmentKind.PREAPPROACH, at(-0.05), 1.2)
    b.line(SegmentKind.APPROACH, at(-0.012), 0.5)
    b.line(SegmentKind.CONTACT, at(0.002), 0.6, touching=(CRAYOLA,))
    b.rest(seal_time)
    b.line(SegmentKind.LIFT, at(0.002, 0.02, aside), 0.5, held=CRAYOLA, touching=(CRAYOLA, *SUPPORT))
    b.line(SegmentKind.LIFT, at(0.002, 0.055), 0.6, held=CRAYOLA)
    b.line(SegmentKind.RETREAT, at(-face[0] - 0.06, 0.055), 1.5, held=CRAYOLA)
    above = pose((-1.0455, -0.6165, 0.95), R=tip(configurations["tote"])[:3, :3])
    b.joint(SegmentKind.TRANSFER, solve(above, configurations["tote"]), 2.5, held=CRAYOLA)
    b.line(SegmentKind.PLACE, pose((-1.0455, -0.6165, 0.82), R=above[:3, :3]), 0.8, held=CRAYOLA)
    b.line(SegmentKind.DEPART, above, 0.8)
    plan = _with_events(b, T_item_tip)
    pressed = pose((0.0, 0.0, -0.002)) @ np.linalg.inv(T_item_tip)
    return bound(loaded(plan, pressed), scene)


def loaded(plan: Plan, T_tip_item: Array) -> Plan:
    """The plan with the load of its motion on the cup, by the planner's model."""
    assert plan.grasp is not None
    item, robot = cell().item(plan.grasp.item), cell().robot
    held = [s for s in plan.segments if s.held is not None]
    times = np.linspace(held[0].t_start, held[-1].t_end, 8000)
    q, dq, ddq = (plan.trajectory.sample(times, d) for d in range(3))
    motion = Arm(robot).tip_motion(q, dq, ddq, held[0].tool_state)
    load = SuctionGrasping(robot.tool).hold(item, plan.grasp.face, T_tip_item).in_motion(motion)
    return replace(plan, grasp=load.of(plan.grasp))


def _with_events(b: Builder, T_item_tip: Array) -> Plan:
    grasp = Grasp(CRAYOLA, "frontal", "-z", STRAIGHT, T_item_tip, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0)
    kinds = [s.kind for s in b.segments]
    contact, retreat, put = (
        kinds.index(k) for k in (SegmentKind.CONTACT, SegmentKind.RETREAT, SegmentKind.PLACE)
    )
    devices = cell().devices
    events = []
    switching = (
        ("pump", "on", contact, -SEAL_TIME),
        ("valve", "on", contact, -SEAL_TIME),
        ("vacuum_sensor", "read", retreat, 0.0),
        ("valve", "off", put, 0.0),
        ("pump", "off", put, devices["pump"].lead),  # the command comes with the closed valve
    )
    for device, action, k, offset in switching:
        t, lead = b.segments[k].t_end + offset, devices[device].lead
        events.append(Event(device, action, Anchor(AnchorKind.SEGMENT_END, k, offset), lead, t, t - lead))
    return Plan(
        f"pick {CRAYOLA} from bin_B", "", "", 0, tuple(b.segments), b.trajectory(), tuple(events), grasp
    )
