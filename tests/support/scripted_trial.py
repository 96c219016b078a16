"""A trial without physics: plans are empty motions, executions follow a script per item."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.errors import InputError, NoExtractionError, NoPlanError, Reason
from pickcli.geometry import Array, pose, rotation_rpy
from pickcli.motion.plan import Certificate, Certify, Grasp, GraspKind, Plan, RecoveryLevel
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.arm_choice import ArmSuitability
from pickcli.planning.move import MoveGoal
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.pick_settings import Neighbours
from pickcli.planning.recovery.retrace import ItemRecovery, StoppedMotion
from pickcli.planning.start_state import Start
from pickcli.planning.topple import TopplingQuery
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.simulation.contacts import Collision
from pickcli.simulation.places import OUTSIDE
from pickcli.trial.disturbance import Disturbance
from pickcli.trial.order import Order
from pickcli.trial.trial_interfaces import ExecutionResult, TrialInterfaces
from pickcli.trial.trial_perception import LOOK_FROM
from pickcli.verification.verdict import Verdict
from support.tool_states import STRAIGHT

DURATION = 10.0  # s of every fake motion


def scene_of(order: Order, cell: Cell) -> Scene:
    """All items of an order at the middle of their places."""
    items, seen = [], dict[str, int]()
    for bin_name, names in order.contents.items():
        for name in names:
            seen[name] = seen.get(name, 0) + 1
            item_id = name if seen[name] == 1 else f"{name}#{seen[name]}"
            T = middle_of(cell, bin_name)
            items.append(PlacedItem(item_id, cell.item(name, order.year), bin_name, T))
    return Scene(cell, cell.T_world_pod, tuple(items), PoseNoise())


def middle_of(cell: Cell, place: str) -> Array:
    """The middle of a bin, of the tote, or of the hall."""
    if place == TOTE:
        return cell.places["tote"].T_carrier_place @ pose((0.0, 0.0, 0.05))
    if place == OUTSIDE:
        return pose((-2.0, 0.0, 0.05))
    return cell.pod.bins[place].T_carrier_place @ pose((0.2, 0.0, 0.05))


@dataclass
class ScriptedTrial:
    """Plans and executes by script. What is not scripted works.

    full: bins that take nothing
    no_plan: items for which no plan exists; rejects: queries that the verifier refuses (by substring)
    clings: items that stay in the cup when their motion stops
    lying_sensor: it denies whatever is in the cup; clogged: it affirms, whatever is
    durations: s of motions other than the default, by how their query begins
    stuck: levels of recovery that have no plan, by round; the last entry holds for ever
    blocked: items that cannot be picked while another one is in their bin
    standing: items that cannot be picked until they are toppled; fixed: those that never can be toppled
    firm: items that stay as they are when they are pushed; sliding: m by which others, by id, slide then
    heaped: items that, while another one is in their place, can only be picked if it may be pushed aside
    executions: per item, what its executions are, one after the other; then it is delivered
    cells: the cell as each of several arms sees it; able: by item, the arms that can take it, best first
    strays: parking moves after which an arm does not stand where it is parked
    """

    scene: Scene
    no_plan: frozenset[str] = frozenset()
    full: frozenset[str] = frozenset()
    rejects: frozenset[str] = frozenset()
    clings: frozenset[str] = frozenset()
    blocked: dict[str, str] = field(default_factory=dict)
    heaped: dict[str, str] = field(default_factory=dict)
    standing: frozenset[str] = frozenset()
    fixed: frozenset[str] = frozenset()
    firm: frozenset[str] = frozenset()
    sliding: dict[str, float] = field(default_factory=dict)
    lying: set[str] = field(default_factory=set)  # those that were toppled
    lying_sensor: bool = False
    clogged: bool = False
    durations: dict[str, float] = field(default_factory=dict)
    stuck: list[frozenset[str]] = field(default_factory=list)
    executions: dict[str, list[ExecutionResult]] = field(default_factory=dict)
    duration: float = DURATION
    cells: dict[str, Cell] = field(default_factory=dict)
    able: dict[str, tuple[str, ...]] = field(default_factory=dict)
    strays: frozenset[str] = frozenset()
    held: str | None = None
    releases_into: str | None = None
    asked: list[tuple[str, str]] = field(default_factory=list)  # of each plan: item and where to
    ways: list[tuple[str, Neighbours]] = field(default_factory=list)  # of each plan: item and how
    # Of each plan asked for: item, seed, excluded grasps.
    planned: list[tuple[str, int, tuple[Grasp | GraspKind, ...]]] = field(default_factory=list)
    toppled: list[str] = field(default_factory=list)  # asked to be toppled, in the order of time
    perceived: list[Scene] = field(default_factory=list)
    executed: list[Plan] = field(default_factory=list)
    turns: list[str] = field(default_factory=list)  # arms that were let move, in the order of time
    collided: tuple[Collision, ...] = ()  # the world's own record, whatever the executions tell
    disturbed_last: tuple[Disturbance, ...] = ()  # after the last of the executions
    waited: list[float] = field(default_factory=list)
    opened: list[ToolState | None] = field(default_factory=list)  # to what the tool let go, each time
    levels: list[RecoveryLevel] = field(default_factory=list)  # asked for, in the order of time
    q: Array = field(default_factory=lambda: np.zeros(8))
    tool_state: ToolState = STRAIGHT

    def interfaces(self) -> TrialInterfaces:
        """This fake in all its roles."""
        fake = TrialInterfaces(
            self.plan, self.recover, self.bring, self.verify, self, topple=self.topple, move=self.move
        )
        return replace(fake, cells=self.cells, rank=self.rank, park=self.park) if self.cells else fake

    def topple(self, scene: Scene, query: TopplingQuery, start: Start, seed: int, certify: Certify) -> Plan:
        self.toppled.append(query.item)
        if query.item in self.fixed:
            raise NoPlanError(f"topple {query.item}", [Reason("cannot be toppled", query.item)])
        certified = certify(
            self._motion(f"topple {query.item} in {query.out_of}", seed, None, scene.cell.arm)
        )
        assert isinstance(certified, Plan)
        return certified

    def move(self, scene: Scene, start: Start, goal: MoveGoal, seed: int, label: str) -> Plan:
        self.perceived.append(scene)
        if label in self.no_plan:
            raise NoPlanError(label, [Reason("collision", "move", "")])
        return replace(self._motion(label, seed, None), trajectory=self._trajectory(label, goal.q))

    def rank(self, scenes: Sequence[Scene], query: PickQuery, seed: int) -> tuple[ArmSuitability, ...]:
        arms = self.able.get(query.item, tuple(self.cells))
        others = (scene.cell.arm for scene in scenes if scene.cell.arm not in arms)
        unable = (ArmSuitability(arm, 9, 0, 0, Reason("cannot hold it", query.item)) for arm in others)
        return (*(ArmSuitability(arm, k, 1, 1) for k, arm in enumerate(arms)), *unable)

    def park(self, scene: Scene, start: Start, seed: int) -> Plan:
        return self._motion(f"park {scene.cell.arm}", seed, None, scene.cell.arm)

    def let_move(self, cell: Cell) -> None:
        if self.executed and self.executed[-1].query in self.strays:
            raise InputError("it stands elsewhere")
        self.turns.append(cell.arm)
        self.scene = replace(self.scene, cell=cell)

    @property
    def collisions(self) -> tuple[Collision, ...]:
        return self.collided

    def disturbed(self) -> tuple[Disturbance, ...]:
        return self.disturbed_last

    def is_holding(self) -> bool:
        return self.clogged or (self.held is not None and not self.lying_sensor)

    def wait(self, duration: float) -> None:
        self.waited.append(duration)

    def now(self) -> Scene:
        return self.scene if self.held is None else self.scene.without(self.held)

    def plan(self, scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        self.perceived.append(scene)
        item, into = query.item, query.into
        self.planned.append((item, seed, query.exclude))
        self.asked.append((item, into))
        self.ways.append((item, query.neighbours))
        beside = self.heaped.get(item)
        here = {placed.id for placed in scene.in_location(query.out_of)}
        if beside in here and query.neighbours is not Neighbours.PUSH:
            raise NoExtractionError(f"pick {item}", [Reason("rests on the target", "lift", "", beside)])
        if item in self.standing - self.lying:
            raise NoExtractionError(f"pick {item}", [Reason("no face within reach", item)])
        if item in self.no_plan:
            raise NoExtractionError(f"pick {item}", [Reason("does not hold", "grasp 1", "too heavy")])
        if self.blocked.get(item) in {placed.id for placed in scene.in_location(query.out_of)}:
            raise NoExtractionError(f"pick {item}", [Reason("collision", "lift", "", self.blocked[item])])
        if into in self.full:
            raise NoPlanError(f"pick {item}", [Reason("no free place on the floor", into)])
        grasp = Grasp(item, "frontal", "-x", STRAIGHT, np.eye(4), float(len(query.exclude)), *[0.0] * 5)
        query_text = f"pick {item}" + ("" if into == TOTE else f" into {into}")
        motion = self._motion(query_text, seed, grasp, scene.cell.arm)
        if query.neighbours is Neighbours.PUSH:
            pushing = (self.heaped[item],) if item in self.heaped else ()
            lift = Segment(SegmentKind.LIFT, 0.0, motion.trajectory.duration, STRAIGHT, item, (), pushing)
            motion = replace(motion, segments=(lift,))
        certified = certify(motion)
        if isinstance(certified, Plan):
            return certified
        raise NoPlanError(f"pick {item}", certified)

    def recover(
        self, scene: Scene, start: Start, seed: int, level: RecoveryLevel, stopped: StoppedMotion | None
    ) -> Plan:
        self.levels.append(level)
        n_rounds = self.levels.count(RecoveryLevel.AS_PLANNED)
        missing = self.stuck[min(n_rounds, len(self.stuck)) - 1] if self.stuck else frozenset()
        if level in missing:
            raise NoPlanError("the way out", [Reason("collision", "retreat", "")])
        return self._motion(f"recover {level}", seed, None)

    def bring(self, scene: Scene, stopped: StoppedMotion, bringing: ItemRecovery, seed: int) -> Plan:
        assert stopped.plan.grasp is not None
        assert scene.held is not None, "a plan that carries says what"
        if f"bring {bringing}" in self.no_plan:
            raise NoPlanError("bring", [Reason("nothing to bring")])
        return self._motion(f"bring {bringing} {stopped.plan.query}", seed, stopped.plan.grasp)

    def verify(self, plan: Plan, scene: Scene, stopped: object = None) -> Verdict:
        if any(word in plan.query for word in self.rejects):
            return Verdict(None, (Reason("clearance", "lift", "1 mm to bin_A"),))
        return Verdict(Certificate("m", "s", "c", 1, 0.005, 0.01, 0.5, 0.5, 0.5, ("clearance",)), ())

    def execute(self, plan: Plan) -> ExecutionResult:
        assert plan.certificate is not None, "nothing uncertified may be executed"
        self.executed.append(plan)
        if plan.grasp is None:
            assert self.held is None, "recoveries are planned for the empty tool"
            if plan.query.startswith("topple"):
                self._fall(plan.query.split()[1])
                self._slide(plan.query.split()[1])
            if plan.query.startswith(LOOK_FROM):
                self.q = plan.trajectory.positions[-1]
            script = self.executions.get(plan.query, [])
            return script.pop(0) if script else ExecutionResult(plan.trajectory.duration)
        if plan.query.startswith("bring"):
            self.releases_into = TOTE if plan.query.startswith("bring on") else None
            return ExecutionResult(plan.trajectory.duration)
        script = self.executions.get(plan.grasp.item, [])
        if script:
            self.held = plan.grasp.item if plan.grasp.item in self.clings else None
            return script.pop(0)
        self.put(plan.grasp.item, plan.query.partition(" into ")[2] or TOTE)
        return ExecutionResult(plan.trajectory.duration, has_item=True)

    def release(self, open_to: ToolState | None = None) -> ExecutionResult:
        self.opened.append(open_to)
        if self.held is not None and self.releases_into is not None:
            self.put(self.held, self.releases_into)
        self.held = None
        return ExecutionResult(0.5)

    def _fall(self, item: str) -> None:
        """An item turns onto another side, unless it stays as it is."""
        if item not in self.firm:
            self.lying |= {item}
            placed = self.scene.find(item)
            T = placed.T_world_item @ pose((0.0, 0.0, 0.0), R=rotation_rpy(np.pi / 2, 0.0, 0.0))
            self.scene = self.scene.moved(replace(placed, T_world_item=T))

    def _slide(self, item: str) -> None:
        placed = self.scene.find(item)
        T = pose((self.sliding.get(item, 0.0), 0.0, 0.0)) @ placed.T_world_item
        self.scene = self.scene.moved(replace(placed, T_world_item=T))

    def put(self, item: str, location: str) -> None:
        """An item gets elsewhere."""
        T = middle_of(self.scene.cell, location)
        self.scene = self.scene.moved(replace(self.scene.find(item), location=location, T_world_item=T))

    def _motion(self, query: str, seed: int, grasp: Grasp | None, arm: str = "") -> Plan:
        trajectory = self._trajectory(query, np.ones(8))
        return Plan(
            query, "c", "s", seed, (), trajectory, (), grasp, statistics={"planning_ms": 1.0}, arm=arm
        )

    def _trajectory(self, query: str, goal: Array) -> Trajectory:
        """A motion from zero to a configuration."""
        names, zeros = ("rail", "s", "l", "e", "u", "r", "b", "t"), np.zeros((2, 8))
        known = (seconds for begin, seconds in self.durations.items() if query.startswith(begin))
        times = np.array([0.0, next(known, self.duration)])
        return Trajectory(names, times, np.stack([np.zeros(8), goal]), zeros, zeros)
