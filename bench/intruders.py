"""What stands in the way after planning: how hard it is hit, and how soon the robot stands.

    python -m bench.intruders [--runs 30] [--seed 0] [--pace 1.0] [--unsupervised]

Picks from fresh orders are planned and then carried out in a world with something that planning did not
know: a box of 10 cm that stands fast, a person's forearm held into the way (both at a random point of the
tool's coarse path), or the pod shifted and turned within what its cell allows. Bodies give way where they
are touched: the forearm as ISO/TS 15066:2016, table A.3 states (40 N/mm, 2 kg, free to be pushed away), the
box like a carton against a wall, the pod like its wooden frame.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from enum import StrEnum
from functools import partial

import numpy as np

from bench.warm import fresh_scene, planner
from pickcli.cell.displacement import displaced
from pickcli.cell.item import Item
from pickcli.cell.robot import PivotState
from pickcli.cell.scene import PlacedItem, Scene
from pickcli.cell.shapes import Shape, ShapeKind, box
from pickcli.errors import InputError, NoPlanError
from pickcli.geometry import Array, inverse, pose
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.context import Planner
from pickcli.planning.pick import Start, plan_pick
from pickcli.seeds import derived_rng
from pickcli.simulation.execute import execute
from pickcli.simulation.reality import DEFAULT
from pickcli.simulation.stream import slowed
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
    touched, noticed, standing: s, simulated: first touch, request of a stop, standstill; None if never
    speed: m/s of the tool when it touched
    """

    kind: Kind
    seed: int
    force: float = 0.0
    speed: float = 0.0
    touched: float | None = None
    noticed: float | None = None
    standing: float | None = None
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


def meet(warm: Planner, kind: Kind, seed: int, pace: float, is_supervised: bool) -> Meeting | None:
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
    world = World(truth, home.q, home.pivot, reality=reality, seed=seed)
    names = {INTRUDER} if kind is not Kind.POD else {body.name for body in truth.cell.pod.bodies}
    for name in sorted(names):
        world.engine.soften(name, STIFFNESS[kind], DAMPING)
    meeting, before = Meeting(kind, seed), [world.tip[:3, 3]]
    watch = partial(_watch, meeting, names, before)
    run = execute(plan, world, pace=slowed(pace), on_step=watch)
    if run.stop is not None and run.stopping_time is not None:
        meeting.noticed, meeting.cause = run.stop.t, str(run.stop)
        meeting.standing = run.stop.t + run.stopping_time
    world.close()
    return meeting


def _some_plan(
    warm: Planner, scene: Scene, targets: Sequence[tuple[str, str]], seed: int
) -> Plan | None:  # fmt: skip
    home = warm.cell.configurations["home"]
    for bin_name, item in targets:
        copies = [p for p in scene.in_location(bin_name) if p.item.name == item]
        try:
            return plan_pick(warm, scene, bin_name, copies[0].id, Start(home.q, home.pivot), seed)
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
    return arm.tip(plan.trajectory.sample(t)[0], PivotState.STRAIGHT)[:3, 3] + rng.uniform(-0.02, 0.02, 3)


def _watch(meeting: Meeting, names: set[str], before: list[Array], world: World) -> None:
    """Note the largest force, and when it began. A forearm is held up as its person would."""
    if meeting.kind is Kind.ARM:
        middle = world.engine.pose(INTRUDER)[:3, 3]
        world.engine.keep_awake(INTRUDER, on=True)
        world.engine.push(INTRUDER, np.array([0.0, 0.0, 9.81 * world.engine.mass(INTRUDER)]), middle)
    touches = world.engine.touches(ROBOT)
    touches += world.engine.touches(world.held) if world.held is not None else []
    force = sum(t.force for t in touches if {t.a, t.b} & names - world.touching)
    if force > TOUCHED and meeting.touched is None:
        meeting.touched = world.t
        meeting.speed = float(np.linalg.norm(world.tip[:3, 3] - before[0])) / world.time_step
    meeting.force = max(meeting.force, force)
    before[0] = world.tip[:3, 3]


def measure(seeds: Sequence[int], pace: float = 1.0, is_supervised: bool = True) -> list[Meeting]:
    """One meeting of every kind per seed."""
    warm = planner()
    found = []
    for seed in seeds:
        for kind in Kind:
            meeting = meet(warm, kind, seed, pace, is_supervised)
            if meeting is not None:
                found.append(meeting)
                print(json.dumps(asdict(meeting)), flush=True)
    return found


def lines(meetings: Sequence[Meeting]) -> Iterator[str]:
    """What they have in common, by kind."""
    for kind in Kind:
        met = [m for m in meetings if m.kind is kind and m.touched is not None]
        if not met:
            yield f"{kind}: never touched"
            continue
        after, speeds = [m.standing_after for m in met], [m.speed for m in met]
        yield (
            f"{kind}: {len(met)} touched at {min(speeds):.2f} to {max(speeds):.2f} m/s; "
            f"force {np.median([m.force for m in met]):.0f} N median, {max(m.force for m in met):.0f} N "
            f"largest; standing {np.median(after):.3f} s after the touch, {max(after):.3f} s at the latest; "
            f"{sum(m.is_kept for m in met)} within {MOST_FORCE:.0f} N and {MOST_TIME} s"
        )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=30, help="of which a third each kind")
    parser.add_argument("--seed", type=int, default=0, help="of the first order")
    parser.add_argument("--pace", type=float, default=1.0, help="share of the planned speed")
    parser.add_argument("--unsupervised", action="store_true", help="nothing is watched, to compare")
    given = parser.parse_args()
    seeds = range(given.seed, given.seed + max(1, given.runs // 3))
    for line in lines(measure(seeds, given.pace, not given.unsupervised)):
        print(line)


if __name__ == "__main__":
    main()
