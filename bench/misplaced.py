"""What happens where an item is nearer to the cup, or farther from it, than it was seen.

    python -m bench.misplaced [--picks 10] [--seed 0] [--cell apc2016_delft] [--json FILE]

Picks from fresh orders, as many as can be of every direction in which the cup is put on (from above, from the
front, from the side), are planned with the target seen off by so much along the tool's axis, and carried out
where it truly is, by the arm of the cell that acts first. One pose in fifty is off by more than planning
knows (``pose_outlier_share``), by up to 6 mm.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import count
from pathlib import Path

import numpy as np

from bench.warm import fresh_scene, planners
from pickcli.errors import InputError, NoPlanError
from pickcli.geometry import Array, pose
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.world import World
from pickcli.trial.pose_noise import DEFAULT_NOISE

OFFSETS = (-0.006, -0.0045, -0.003, 0.0, 0.003, 0.0045, 0.006)  # m
ABOVE, FRONTAL, SIDE = "above", "frontal", "side"
DIRECTIONS = (ABOVE, FRONTAL, SIDE)
STEEP = 0.7  # cosine from which on an axis points down, or into the pod


@dataclass(frozen=True)
class Met:
    """One pick of a target that was seen somewhere else.

    direction: from where the cup is put on
    nearer: m along the tool's axis by which the item is nearer than it was seen
    force: N, largest between bellows and item
    overrun: m, most that the bellows were pressed in beyond their stroke; negative if never so far
    contacts: unplanned ones
    outcome: where the target ended, or why it was not picked
    """

    seed: int
    item: str
    direction: str
    nearer: float
    force: float
    overrun: float
    contacts: int
    outcome: str


@dataclass(frozen=True)
class Pick:
    """A pick that can be planned where its target is seen as it stands."""

    seed: int
    scene: Scene
    query: PickQuery
    direction: str
    axis: Array  # (3,) of the tool, in the world, when it is pressed on


def picks(warm: PlanningContext, n: int, first_seed: int) -> list[Pick]:
    """The first picks of fresh orders, none of a direction more than its share."""
    most, found = -(-n // len(DIRECTIONS)), list[Pick]()
    for seed in count(first_seed):
        if len(found) >= n or seed > first_seed + n:
            return found[:n]
        try:
            order, scene = fresh_scene(warm.cell, seed)
        except InputError:  # an order whose items do not fit
            continue
        scene = replace(scene, noise=DEFAULT_NOISE)
        for target in order.work_order:
            copies = [p for p in scene.in_location(target.bin) if p.item.name == target.item]
            query = PickQuery(target.bin, copies[0].id)
            plan = _planned(warm, scene, query, seed)
            if plan is None:
                continue
            axis = _axis(plan, Arm(warm.cell.robot))
            direction = _direction(axis, scene)
            if sum(pick.direction == direction for pick in found) < most:
                found.append(Pick(seed, scene, query, direction, axis))
    return found


def meet(warm: PlanningContext, pick: Pick, nearer: float) -> Met | None:
    """Plan with the target seen off, carry out; None where nothing can be planned for what is seen."""
    target = pick.scene.find(pick.query.item)
    T_seen = pose(nearer * pick.axis) @ target.T_world_item
    items = (replace(p, T_world_item=T_seen) if p is target else p for p in pick.scene.items)
    plan = _planned(warm, replace(pick.scene, items=tuple(items)), pick.query, pick.seed)
    if plan is None:
        return None
    axis = _axis(plan, Arm(warm.cell.robot))
    home = warm.cell.configurations["home"]
    world = World(pick.scene, home.q, home.tool_state, seed=pick.seed)
    force, depth = 0.0, 0.0

    def watch(world: World) -> None:
        nonlocal force, depth
        for touch in world.suction.contact_points:
            force, depth = max(force, touch.force), max(depth, touch.depth)

    run = execute(plan, world, on_step=watch)
    where = next((p.location for p in world.now().items if p.id == target.id), "in the cup")
    outcome = where if where == TOTE else run.trouble or where
    overrun = depth - warm.cell.robot.tool.cup.stroke
    world.close()
    along = nearer * float(pick.axis @ axis)
    direction = _direction(axis, pick.scene)
    return Met(
        pick.seed, target.id, direction, along, force, overrun, len(run.collisions), outcome
    )  # fmt: skip


def _planned(warm: PlanningContext, scene: Scene, query: PickQuery, seed: int) -> Plan | None:
    home = warm.cell.configurations["home"]
    try:
        return plan_pick(warm, scene, query, Start(home.q, home.tool_state), seed)
    except NoPlanError:
        return None


def _contact(plan: Plan) -> Segment:
    return next(segment for segment in plan.segments if segment.kind is SegmentKind.CONTACT)


def _axis(plan: Plan, arm: Arm) -> Array:
    segment = _contact(plan)
    q = plan.trajectory.sample(segment.t_end)[0]
    return np.asarray(arm.tip(q, segment.tool_state)[:3, 2])


def _direction(axis: Array, scene: Scene) -> str:
    if -axis[2] > STEEP:
        return ABOVE
    return FRONTAL if axis @ scene.T_world_pod[:3, 0] > STEEP else SIDE


def measure(n_picks: int, seed: int, cell_name: str) -> list[Met]:
    """Every pick with every offset."""
    warm, found = planners(cell_name)[0], list[Met]()
    for pick in picks(warm, n_picks, seed):
        for nearer in OFFSETS:
            if (met := meet(warm, pick, nearer)) is not None:
                found.append(met)
                print(json.dumps(asdict(met)), flush=True)
    return found


def table(met: Sequence[Met]) -> Iterator[str]:
    """By offset: of all picks the largest force and overrun, and what came of them."""
    yield f"{'nearer, mm':>10}{'picks':>7}{'N':>7}{'overrun, mm':>13}{'contacts':>10}{'tote':>6}{'stop':>6}"
    for nearer in OFFSETS:
        those = [m for m in met if abs(m.nearer - nearer) < 5e-4]
        if not those:
            continue
        yield (
            f"{1e3 * nearer:10.1f}{len(those):7}{max(m.force for m in those):7.1f}"
            f"{1e3 * max(m.overrun for m in those):13.2f}{sum(m.contacts > 0 for m in those):10}"
            f"{sum(m.outcome == TOTE for m in those):6}{sum('stopped' in m.outcome for m in those):6}"
        )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--picks", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0, help="of the first order")
    parser.add_argument("--cell", default="apc2016_delft")
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    met = measure(given.picks, given.seed, given.cell)
    for line in table(met):
        print(line)
    if given.json is not None:
        given.json.write_text(json.dumps([asdict(m) for m in met], indent=2) + "\n")


if __name__ == "__main__":
    main()
