"""The controller alone: into envelopes among cans, past obstacles, and after a target that moves.

    python -m bench.control [--scenes 40] [--roll-outs 1000] [--seed 0]

The scenes are those of ``bench.envelopes``. Obstacles: balls, boxes and cylinders at random places around the
way of the hand to a pose; the least distance is judged at the instants and at four places between each two.
Moved target: by 20 mm and 5 degrees at a random moment of the approach; it counts where the hand is in the
envelope when it arrives; a target that is moved into the hand is counted apart. A step is all that an instant
of control takes: rows, hierarchical QP, and proof.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter

import numpy as np
from rich.console import Console
from rich.table import Table

from bench.envelopes import KINDS, Bench, scene_of
from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.checker import SceneChecker
from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.control.roll_out import ControlScene, End, RollOut, Stack, control_step, roll_out
from pickcli.control.tasks.joint_limit_task import JointLimitTask
from pickcli.control.tasks.obstacle_task import ObstacleTask
from pickcli.control.tasks.posture_task import PostureTask
from pickcli.control.tasks.task import ControlState
from pickcli.control.tasks.tool_task import ToolTask
from pickcli.geometry import Array, pose, rotation_from_vector
from pickcli.grasping.envelope import Alignment, Envelope
from pickcli.kernel import SurfaceKind
from pickcli.kinematics.arm import ToolGoal
from pickcli.motion.path import JointPath
from pickcli.path_planning.shortcutting import shorten
from pickcli.planning.envelope_roll_outs import EnvelopeRollOut, best_of, is_at_rest, roll_out_into
from pickcli.planning.region_query import RegionChecks, RegionProblem, plan_to_region
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.seeds import derived_seed

WANTED, BETWEEN_LINKS, INFLUENCE = 0.006, 0.004, 0.06  # m, of the obstacle task
AVOIDANCE, GRASP, POSTURE = 5.0, 3.0, 0.3  # 1/s, gains
MOST_SECONDS = 20.0
MOVED, TURNED = 0.02, np.radians(5.0)  # of the target
BETWEEN = np.linspace(0.0, 1.0, 6)[:-1]


class Control:
    """The bench's cell, and its controller."""

    def __init__(self) -> None:
        self.bench = Bench()

    def checker(self, scene: Scene) -> SceneChecker:
        """Return the checker of the arm, whose fingers may touch the target."""
        names = ["target"] if scene.items and scene.items[0].id == "target" else []
        contacts = AllowedContacts.at_any_depth(names)
        return SceneChecker(self.bench.model, scene, self.bench.state, contacts=contacts)

    def stack(self, checker: SceneChecker, envelope: Envelope, T_world_object: Array) -> Stack:
        """Return limits and obstacles, the envelope, and the posture."""
        bench = self.bench
        goal = ToolGoal(envelope.constraints, T_world_object, envelope.T_tip_palm)
        limits = bench.cell.robot.limits
        avoid = ObstacleTask(
            "obstacles", checker, WANTED, BETWEEN_LINKS, INFLUENCE, AVOIDANCE, limits.acceleration
        )
        grasp = ToolTask("envelope", bench.arm, bench.state, goal, GRASP)
        levels = (
            (JointLimitTask("limits", limits),),
            (avoid,),
            (grasp,),
            (PostureTask("posture", bench.home, POSTURE),),
        )
        return Stack(levels, goal="envelope", deceleration=limits.acceleration)

    def run(self, scene: Scene, envelope: Envelope, start: Array, rates: Array | None = None) -> RollOut:
        """Let the controller run in a scene that does not change."""
        checker = self.checker(scene)
        now = ControlScene(self.stack(checker, envelope, scene.items[0].T_world_item), checker)
        return roll_out(lambda _: now, start, MOST_SECONDS, rates=rates)

    def tool(self, scene: Scene) -> FreeToolChecker:
        """Return the checker of the tool without the arm, whose fingers may touch the target."""
        contacts = AllowedContacts.at_any_depth(["target"])
        return FreeToolChecker(self.bench.model, scene, self.bench.state, np.eye(3), contacts)

    def envelopes(self, scene: Scene) -> tuple[Envelope, ...]:
        """Return the envelopes of the target's side."""
        return self.bench.envelopes(scene, self.tool(scene))

    def best(self, scene: Scene, start: Array) -> EnvelopeRollOut:
        """Run into the envelopes, and if none is reached into what is free of them."""
        ended = roll_out_into(
            lambda envelope, q, rates: self.run(scene, envelope, q, rates),
            "envelope", start, self.envelopes(scene), scene.items[0].T_world_item, self.tool(scene),
        )  # fmt: skip
        return best_of(ended)

    def shortened(self, scene: Scene, run: RollOut, seed: int) -> float:
        """Return the travel in rad of a roll-out that is shortened like a planned path."""
        path = JointPath(self.bench.arm.names, run.Q)
        return travel(shorten(self.checker(scene), self.bench.space, path, seed=seed).waypoints)

    def region(self, scene: Scene, start: Array, seed: int) -> float | None:
        """Return the travel in rad of the region query's path from a start, None without one."""
        bench, tool = self.bench, self.tool(scene)
        problem = RegionProblem(bench.envelopes(scene, tool), scene.items[0].T_world_item, bench.state, start)
        path = plan_to_region(
            bench.arm, bench.space, problem, RegionChecks(tool.are_valid_at, self.checker(scene)), seed
        )
        return None if path is None else travel(path.waypoints)

    def follow(
        self, scene: Scene, nominal: RollOut, envelope: Envelope, rng: np.random.Generator
    ) -> tuple[Scene, RollOut, bool]:
        """Move the target at a moment of a roll-out, and go on; where the controller is stuck, choose anew.

        Returns the scene from then on, the rest of the roll-out, and whether the target was moved into the
        arm.
        """
        target = scene.items[0]
        moved = target.T_world_item.copy()
        moved[:3, 3] += MOVED * _direction(rng)
        moved[:3, :3] = rotation_from_vector(TURNED * _direction(rng)) @ moved[:3, :3]
        later = Scene(
            scene.cell, scene.T_world_pod,
            (PlacedItem(target.id, target.item, target.location, moved), *scene.items[1:]), scene.noise,
        )  # fmt: skip
        k = int(rng.uniform(1.0, len(nominal.Q) - 1.0))
        scenes = []
        for each, T in ((scene, target.T_world_item), (later, moved)):
            checker = self.checker(each)
            scenes.append(ControlScene(self.stack(checker, envelope, T), checker))
        rates = (nominal.Q[k] - nominal.Q[k - 1]) / nominal.period
        run = roll_out(lambda t: scenes[int(t > 0.0)], nominal.Q[k], MOST_SECONDS, rates=rates)
        # It is moved as the first step is made.
        is_hit = float(scenes[1].validator.clearances(run.Q[:2][-1:])[0]) <= 0.0
        if run.end is not End.REACHED and is_at_rest(run) and scenes[1].validator.is_valid(run.Q[-1]):
            run = self.best(later, run.Q[-1]).run
        return later, run, is_hit

    def past_obstacles(self, rng: np.random.Generator) -> tuple[float, End]:
        """Run to a random pose among random bodies; return the least distance, and how it ended."""
        bench = self.bench
        while True:
            q_goal = bench.arm.random_seeds(rng, 1)[0]
            T = bench.arm.tip(q_goal, bench.state)
            if T[2, 3] < 0.85 or not 0.3 < np.linalg.norm(T[:2, 3]) < 0.75:
                continue
            start = bench.arm.tip(bench.home, bench.state)[:3, 3]
            bodies = tuple(self._body(k, start + rng.random() * (T[:3, 3] - start), rng) for k in range(4))
            scene = Scene(bench.cell, bench.cell.T_world_pod, bodies, PoseNoise())
            checker = self.checker(scene)
            if checker.kernel.clearance(bench.home, 1.0)[0] > WANTED:
                break
        box = np.full(3, 0.01)
        aligned = Alignment(np.array([1.0, 0.0, 0.0]), T[:3, 0], 0.1)
        T_surface = pose(T[:3, 3], R=T[:3, :3] @ np.diag([1.0, -1.0, -1.0]))
        goal = Envelope("pose", SurfaceKind.PLANE, T_surface, -box, box, 0.1, aligned)
        now = ControlScene(self.stack(checker, goal, np.eye(4)), checker)
        found = roll_out(lambda _: now, bench.home, MOST_SECONDS)
        steps = np.diff(found.Q, axis=0)
        between = (found.Q[:-1, None] + BETWEEN[:, None] * steps[:, None]).reshape(-1, bench.arm.n)
        return float(checker.kernel.clearances(np.vstack([between, found.Q[-1:]]), 1.0).min()), found.end

    def _body(self, k: int, middle: Array, rng: np.random.Generator) -> PlacedItem:
        """Return a body of a random shape near a point."""
        kind = (ShapeKind.SPHERE, ShapeKind.BOX, ShapeKind.CYLINDER)[int(rng.integers(3))]
        size = rng.uniform(0.02, 0.1, {ShapeKind.SPHERE: 1, ShapeKind.BOX: 3, ShapeKind.CYLINDER: 2}[kind])
        shape = Shape(kind, tuple(size.tolist()))
        seals = dict.fromkeys(shape.face_names, 0.0)
        item = Item(f"body {k}", 2016, shape, 0.3, 0, seals, "made up", "printed", 0.0, 1.0, "", "made up")
        off = middle + rng.normal(size=3) * 0.1
        return PlacedItem(item.name, item, "mat_front", pose(off, R=rotation_from_vector(rng.normal(size=3))))

    def times(self, scene: Scene, n: int) -> Array:
        """Return s (n,) that steps of control take, with proof."""
        checker = self.checker(scene)
        stack = self.stack(checker, self.envelopes(scene)[0], scene.items[0].T_world_item)
        Q, found = self.run(scene, self.envelopes(scene)[0], self.bench.home).Q, []
        for i in range(n):
            state = ControlState(Q[i % len(Q)], np.zeros(self.bench.arm.n), 0.01)
            start = time.perf_counter()
            dq = control_step(stack, state).dq
            checker.is_valid_edge(state.q, state.q + 0.01 * dq)
            found.append(time.perf_counter() - start)
        return np.array(found)


def travel(Q: Array) -> float:
    """Return the sum of the ways of all joints along configurations (N, n)."""
    return float(np.abs(np.diff(Q, axis=0)).sum())


def _direction(rng: np.random.Generator) -> Array:
    v = rng.normal(size=3)
    return np.asarray(v / np.linalg.norm(v))


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--roll-outs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    control = Control()
    table = Table(
        "scene", "reached", "more by region", "s, mean", "travel, rad", "of region's", "shortened", "ends",
        "moved: in it", "more by region", "hit by it",
    )  # fmt: skip
    for kind in KINDS:
        rng = np.random.default_rng([options.seed, len(kind)])
        ends, lengths, seconds, ratios, followed = Counter[str](), [], [], [], []
        handed_over = handed_over_moved = hit = 0
        for k in range(options.scenes):
            scene = scene_of(control.bench, rng, kind)
            best = control.best(scene, control.bench.home)
            ends[best.run.end.value] += 1
            seed = derived_seed("bench", options.seed, k)
            if not best.is_reached:
                handed_over += control.region(scene, best.run.Q[-1], seed) is not None
                continue
            lengths.append(best.travel)
            seconds.append(best.run.duration)
            theirs = control.region(scene, control.bench.home, seed)
            if theirs is not None:
                ratios.append((lengths[-1], control.shortened(scene, best.run, seed), theirs))
            draws = np.random.default_rng([options.seed, k])
            later, run, is_hit = control.follow(scene, best.run, best.envelope, draws)
            if is_hit:  # whatever came of it
                hit += 1
                continue
            followed.append(run.end is End.REACHED)
            if not followed[-1]:
                handed_over_moved += control.region(later, run.Q[-1], seed) is not None
        ours, shortened, by_region = np.sum(ratios, axis=0) if ratios else (np.nan,) * 3
        told = ", ".join(f"{n} {end}" for end, n in ends.most_common() if end != End.REACHED.value)
        table.add_row(
            kind, f"{len(lengths)} of {options.scenes}", f"{handed_over}",
            f"{np.mean(seconds):.2f}", f"{np.mean(lengths):.2f}",
            f"{ours / by_region:.2f}", f"{shortened / by_region:.2f}", told,
            f"{sum(followed)} of {len(followed)}", f"{handed_over_moved}", f"{hit}",
        )  # fmt: skip
    Console().print(table)
    rng = np.random.default_rng([options.seed, 99])
    distances, ended = zip(*(control.past_obstacles(rng) for _ in range(options.roll_outs)), strict=True)
    counted = Counter(end.value for end in ended)
    print(f"obstacles: least distance {1e3 * min(distances):.2f} mm of {1e3 * WANTED:.0f} wanted, in "
          f"{options.roll_outs} roll-outs: {dict(counted)}")  # fmt: skip
    t = 1e3 * control.times(scene_of(control.bench, rng, "all round"), 2000)
    print(
        f"a step of control with its rows and proof: {np.median(t):.2f} ms, p99 {np.percentile(t, 99):.2f} ms"
    )


if __name__ == "__main__":
    main()
