"""What stands in the way after planning: how hard it is hit, and how soon the robot stands.

    python -m bench.intruders [--runs 30] [--seed 0] [--tool-speed V] [--unsupervised]

Picks from fresh orders are planned and then carried out in a world with something that planning did not
know: a box of 10 cm that stands fast, a person's forearm held into the way (both at a random point of the
tool's coarse path), or the pod shifted and turned within what its cell allows. Bodies give way where they
are touched: the forearm as ISO/TS 15066:2016, table A.3 states (40 N/mm, 2 kg, free to be pushed away), the
box like a carton against a wall, the pod like its wooden frame. With ``--tool-speed`` the cell limits the
speed of the tool's tip (``max_tool_speed``), and all motion is planned under it.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from functools import partial

import numpy as np

from bench.warm import context, fresh_scene
from pickcli.cell.item import Item
from pickcli.cell.pod_tolerance import displaced
from pickcli.cell.shapes import Shape, ShapeKind, box
from pickcli.errors import InputError, NoPlanError
from pickcli.geometry import Array, inverse, pose
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.seeds import derived_rng
from pickcli.simulation.execute import execute
from pickcli.simulation.reality import DEFAULT
from pickcli.simulation.world import ROBOT, World

INTRUDER = "intruder"
BOX_SIDE = 0.1  # m
ARM_RADIUS, ARM_LENGTH, ARM_MASS = 0.045, 0.4, 2.0  # m, m, kg
STIFFNESS = {"box": 50e3, "arm": 40e3, "pod": 100e3}  # N/m
DAMPING = 200.0  # Ns/m
TOUCHED = 1.0  # N from which it counts as touched
COARSE = (SegmentKind.TRANSIT, SegmentKind.TRANSFER)
MOST_FORCE, MOST_TIME = 150.0, 0.1  # N, s: what is promised


class Kind(StrEnum):
    """What stands in the way."""

    BOX = "box"
    ARM = "arm"
    POD = "pod"


@dataclass
class Meeting:
    """One run with an intruder: how it was met.

    force: N, the sum over all points, largest of all steps
    touched, noticed: s, simulated: first touch, request of a stop; None if never
    standing: s, simulated: first standstill of all joints; None if never
    speed: m/s of the tool when it touched
    over: m that the tool went on after the request of the stop, at most
    duration: s that the plan takes
    """

    kind: Kind
    seed: int
    force: float = 0.0
    speed: float = 0.0
    touched: float | None = None
    noticed: float | None = None
    standing: float | None = None
    over: float = 0.0
    duration: float = 0.0
    cause: str = ""

    @property
    def is_kept(self) -> bool:
        """Whether force and time are within what is promised."""
        if self.touched is None:
            return True
        return self.force <= MOST_FORCE and self.standing is not None and self.standing_after <= MOST_TIME

    @property
    def standing_after(self) -> float:
        """s from the first touch to standstill; infinite if it never stood."""
        if self.touched is None or self.standing is None:
            return float("inf")
        return self.standing - self.touched


def meet(warm: PlanningContext, kind: Kind, seed: int, is_supervised: bool) -> Meeting | None:
    """Plan a pick, put something in its way, carry it out; None where nothing could be planned."""
    rng = derived_rng(seed, "intruder", kind)
    try:
        order, scene = fresh_scene(warm.cell, seed)
    except InputError:  # an order whose items do not fit
        return None
    plan = _some_plan(warm, scene, [(t.bin, t.item) for t in order.work_order], seed)
    if plan is None:
        return None
    home = warm.cell.configurations["home"]
    reality = replace(DEFAULT, supervision=is_supervised)
    truth = _with_intruder(kind, scene, plan, Arm(warm.cell.robot), rng)
    world = World(truth, home.q, home.tool_state, reality=reality, seed=seed)
    names = {INTRUDER} if kind is not Kind.POD else {body.name for body in truth.cell.pod.bodies}
    for name in sorted(names):
        world.engine.soften(name, STIFFNESS[kind], DAMPING)
    meeting, tips = Meeting(kind, seed, duration=plan.trajectory.duration), [world.tip[:3, 3]]
    run = execute(plan, world, on_step=partial(_watch, meeting, names, tips))
    if run.stop is not None and run.stopping_time is not None:
        meeting.noticed, meeting.cause = run.stop.t, str(run.stop)
        meeting.standing = run.stop.t + run.stopping_time
        meeting.over = _over(np.array(tips), round(run.stop.t / world.time_step))
    world.close()
    return meeting


def _some_plan(
    warm: PlanningContext, scene: Scene, targets: Sequence[tuple[str, str]], seed: int
) -> Plan | None:  # fmt: skip
    home = warm.cell.configurations["home"]
    for bin_name, item in targets:
        copies = [p for p in scene.in_location(bin_name) if p.item.name == item]
        try:
            return plan_pick(
                warm, scene, PickQuery(bin_name, copies[0].id), Start(home.q, home.tool_state), seed
            )
        except NoPlanError:
            continue
    return None


def _with_intruder(kind: Kind, scene: Scene, plan: Plan, arm: Arm, rng: np.random.Generator) -> Scene:
    """The scene as it truly is."""
    if kind is Kind.POD:
        x, y, yaw = rng.uniform(-1.0, 1.0, 3) * (0.05, 0.05, np.radians(3.0))
        shifted = displaced(scene.T_world_pod, x, y, yaw)
        move = shifted @ inverse(scene.T_world_pod)
        items = tuple(replace(i, T_world_item=move @ i.T_world_item) for i in scene.items)
        return replace(scene, T_world_pod=shifted, items=items)
    at = _on_the_way(plan, arm, rng)
    if kind is Kind.BOX:
        half = BOX_SIDE / 2
        body = box(INTRUDER, tuple(at - half), tuple(at + half))
        obstacles = replace(scene.cell.obstacles, bodies=(*scene.cell.obstacles.bodies, body))
        return replace(scene, cell=replace(scene.cell, obstacles=obstacles))
    shape = Shape(ShapeKind.CYLINDER, (ARM_RADIUS, ARM_LENGTH))
    seals = dict.fromkeys(shape.face_names, 0.0)
    source = "ISO/TS 15066:2016"
    forearm = Item(INTRUDER, 2016, shape, ARM_MASS, 0, seals, source, "an arm", 0.0, 1.0, "", source)
    return replace(scene, items=(*scene.items, PlacedItem(INTRUDER, forearm, "outside", pose(at))))


def _on_the_way(plan: Plan, arm: Arm, rng: np.random.Generator) -> Array:
    """A point (3,) near the tool's path in a coarse segment, away from where it begins."""
    coarse = [s for s in plan.segments if s.kind in COARSE]
    segment = coarse[int(rng.integers(len(coarse)))]
    t = segment.t_start + float(rng.uniform(0.3, 0.8)) * (segment.t_end - segment.t_start)
    return arm.tip(plan.trajectory.sample(t)[0], segment.tool_state)[:3, 3] + rng.uniform(-0.02, 0.02, 3)


def _over(tips: Array, noticed: int) -> float:
    """m that the tip (N, 3) went on in the direction in which it moved at a step, at most."""
    direction = tips[noticed] - tips[noticed - 1]
    onwards = (tips[noticed:] - tips[noticed]) @ direction / max(float(np.linalg.norm(direction)), 1e-9)
    return float(onwards.max())


def _watch(meeting: Meeting, names: set[str], tips: list[Array], world: World) -> None:
    """Note the tip, the largest force, and when it began. A forearm is held up as its person would."""
    if meeting.kind is Kind.ARM:
        middle = world.engine.pose(INTRUDER)[:3, 3]
        world.engine.keep_awake(INTRUDER, on=True)
        world.engine.apply_force(INTRUDER, np.array([0.0, 0.0, 9.81 * world.engine.mass(INTRUDER)]), middle)
    points = world.engine.contact_points(ROBOT)
    points += world.engine.contact_points(world.held) if world.held is not None else []
    force = sum(t.force for t in points if {t.a, t.b} & names - world.planned.touching)
    if force > TOUCHED and meeting.touched is None:
        meeting.touched = world.t
        meeting.speed = float(np.linalg.norm(world.tip[:3, 3] - tips[-1])) / world.time_step
    meeting.force = max(meeting.force, force)
    tips.append(world.tip[:3, 3])


def measure(
    seeds: Sequence[int], tool_speed: float | None = None, is_supervised: bool = True
) -> list[Meeting]:
    """One meeting of every kind per seed."""
    warm = context(tool_speed)
    found = []
    for seed in seeds:
        for kind in Kind:
            meeting = meet(warm, kind, seed, is_supervised)
            if meeting is not None:
                found.append(meeting)
                print(json.dumps(asdict(meeting)), flush=True)
    return found


def table(meetings: Sequence[Meeting]) -> Iterator[str]:
    """Asked and measured, by kind: medians and the worst."""
    yield f"asked: {MOST_FORCE:.0f} N at most, standing after {MOST_TIME} s"
    yield f"{'':5}{'touched':>8}{'m/s':>13}{'N':>12}{'s':>14}{'mm on':>9}{'kept':>6}"
    for kind in Kind:
        met = [m for m in meetings if m.kind is kind and m.touched is not None]
        if not met:
            yield f"{kind:5}{0:8}"
            continue
        speeds, forces = [m.speed for m in met], [m.force for m in met]
        after, over = [m.standing_after for m in met], [1e3 * m.over for m in met]
        yield (
            f"{kind:5}{len(met):8}{min(speeds):7.2f}..{max(speeds):.2f}"
            f"{np.median(forces):6.0f} {max(forces):5.0f}"
            f"{np.median(after):8.3f} {max(after):.3f}{np.median(over):4.0f} {max(over):4.0f}"
            f"{sum(m.is_kept for m in met):6}"
        )
    yield f"the plans take {np.mean([m.duration for m in meetings]):.1f} s"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=30, help="of which a third each kind")
    parser.add_argument("--seed", type=int, default=0, help="of the first order")
    parser.add_argument("--tool-speed", type=float, help="m/s, the cell's limit of the tool's speed")
    parser.add_argument("--unsupervised", action="store_true", help="nothing is watched, to compare")
    given = parser.parse_args()
    seeds = range(given.seed, given.seed + max(1, given.runs // 3))
    for line in table(measure(seeds, given.tool_speed, not given.unsupervised)):
        print(line)


if __name__ == "__main__":
    main()
