"""The arm of a commission: what it sees around the truck, and its motions, in one simulated world.

The world is put up around the truck where it truly stands at the load. There the arm sees load, pallet and
items with errors; every motion is planned, verified and executed as in other trials. As the truck drives on,
the same world is accelerated as its frame is, with the items on the pallet.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import Shape
from pickcli.commission.commission import LOAD, PALLET
from pickcli.commission.commission_result import ActionError
from pickcli.commission.commission_station import CommissionStation, planar
from pickcli.driving.drive_tracking import PERIOD
from pickcli.errors import NoPlanError
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Certify, Plan
from pickcli.pallet_trials.pallet_result import SetDownDeviation
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery, StatedPlace
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.seeds import derived_seed
from pickcli.simulation.contacts import Collision
from pickcli.simulation.engine import Engine
from pickcli.simulation.execute import execute
from pickcli.simulation.motion_recorder import MotionRecorder
from pickcli.simulation.reality import Reality
from pickcli.simulation.world import World
from pickcli.trial.certifier import Certifier
from pickcli.trial.pose_noise import perceive
from pickcli.trial.scene_plan import ScenePlan
from pickcli.trial.standing_items import standing
from pickcli.verification.verify import verify

QUERY_CHARGE = 0.3  # s for each query, in which the arm rests
RESET_TIME = 10.0  # s after a protective stop until the arm is at home again, by hand
AT_HOME = 0.01  # rad, within which the arm counts as at home


@dataclass(frozen=True, eq=False)
class CommissionTransfer:
    """What came of one motion that was to put an item on the pallet.

    Attributes:
        item: Id of the item that was to be put there, or that was taken from its cluster instead.
        set_down: How far it is from its place afterwards; None if it was taken away by hand, or stands on the
            load again.
        trouble: What went wrong on the way; "" if nothing did.
        segments: Kind of each segment of the plan, and the s that it takes.
    """

    item: str
    set_down: SetDownDeviation | None
    trouble: str
    segments: tuple[tuple[str, float], ...]

    @property
    def figures(self) -> dict[str, Any]:
        """Plain values by name."""
        off = self.set_down
        told = {} if off is None else {"aside_m": off.aside, "height_m": off.height, "turn_rad": off.turn}
        return {**told, "segments": [{"kind": kind, "s": seconds} for kind, seconds in self.segments]}


class LoadWorld(Protocol):
    """A world around an arm at a load.

    Attributes:
        scene: The scene.
        engine: The engine.
    """

    scene: Scene
    engine: Engine

    @property
    def cell(self) -> Cell:
        """The cell as the arm sees it."""

    @property
    def t(self) -> float:
        """Time (s) since the world was put up."""

    def wait(self, duration: float) -> None:
        """Let time pass while the arm rests.

        Args:
            duration: s.
        """

    def now(self) -> Scene:
        """Return the scene as it is."""

    def placed(self, item_id: str) -> PlacedItem:
        """Return an item as it is.

        Args:
            item_id: Its id.

        Returns:
            The item where it is now.
        """

    def close(self) -> None:
        """Free the engines of the world."""


class CommissionArm:
    """The arm and the world around it.

    Args:
        station: The commission in its cell.
        context: The station's cell, its models and its precomputed files.
        noise: Bounds of the errors of perceived poses of items.
        reality: Levels of the deviations of the simulated world from its model.
        seed: Seed of all random choices.

    Attributes:
        before: The true scene as the truck came to the load; None before.
        recorder: All motion, on the clock of the world.
        plans: Plans that were executed, in order.
        collisions: All unplanned contacts so far, in order, on the clock of the world.
        n_limit_violations: Number of violated joint limits.
        n_stops: Number of protective stops.
    """

    def __init__(
        self,
        station: CommissionStation,
        context: PlanningContext,
        noise: PoseNoise,
        reality: Reality,
        seed: int,
    ) -> None:
        self.station, self.context = station, context
        self.noise, self.reality, self.seed = noise, reality, seed
        home = station.cell.home
        self._home = self._at = Start(home.q, home.tool_state)
        self._world: LoadWorld | None = None
        self._seen: Scene | None = None
        self._placements = {each.carton.id: each for each in station.placements}
        self._n_looks = 0
        self.before: Scene | None = None
        self.recorder = MotionRecorder()
        self.plans: list[ScenePlan] = []
        self.collisions: tuple[Collision, ...] = ()
        self.n_limit_violations = self.n_stops = 0

    @property
    def is_home(self) -> bool:
        """Whether the arm is at home, where the truck may drive."""
        return bool(np.abs(self._at.q - self._home.q).max() <= AT_HOME)

    @property
    def t(self) -> float:
        """Time (s) since the world was put up; 0 before."""
        return 0.0 if self._world is None else self._world.t

    @property
    def pallet_on_forks(self) -> Array:
        """(3,) m, m, rad: where the pallet was seen last in the frame of the truck, or should be before."""
        if self._seen is None:
            return self.station.pallet_in_truck
        return planar(self._seen.pose_of(self.station.cell.carriers[PALLET]).T_world_carrier)

    def put_up(self, truck: Array, on_forks: Array) -> None:
        """Put the world up around the truck.

        Args:
            truck: (3,) m, m, rad: where it truly stands.
            on_forks: (3,) m, m, rad: where the pallet truly is in its frame.

        Raises:
            ActionError: Load or pallet stand farther off than the cell allows.
        """
        scene = self.station.scene(truck, on_forks)
        if why := self.station.off_bounds(scene):
            raise ActionError(why)
        self.before = scene
        self._world = self._world_of(scene)

    def _world_of(self, scene: Scene) -> LoadWorld:
        """Put the world of a true scene up, with the arm at home."""
        home = self._home
        world = World(scene, home.q, home.tool_state, reality=self.reality, seed=self.seed)
        world.observer = self.recorder.look
        return world

    def close(self) -> None:
        """Free the world."""
        if self._world is not None:
            self._world.close()

    def wait(self, seconds: float) -> None:
        """Let time pass while the arm rests.

        Args:
            seconds: s; nothing happens before the world is put up.
        """
        if self._world is not None:
            self._world.wait(seconds)

    def ride(self, felt: Array) -> None:
        """Let time pass while the truck drives, with the items on the pallet.

        Args:
            felt: (T, 2) m/s^2: accelerations of the frame of the world, ``PERIOD`` apart.
        """
        if self._world is None:
            return
        for name in self._placements:
            if self.has(name):
                self._world.engine.wake(name)
        for x, y in felt.tolist():
            self._world.engine.accelerate((x, y))
            self._world.wait(PERIOD)
        self._world.engine.accelerate((0.0, 0.0))

    def look(self) -> None:
        """See load, pallet and items, with errors; items stand level, at heights that their shapes state."""
        world = self._there()
        self._n_looks += 1
        looked = perceive(world.now(), self.noise, self.seed, self._n_looks, self.reality)
        heights = {each.id: float(each.item.shape.extents[2]) / 2 for each in looked.items}
        self._seen = standing(self.station.seen(looked, self.seed, self._n_looks), heights)

    def transfer(self, name: str) -> CommissionTransfer:
        """Take an item from the load to its place on the pallet.

        Args:
            name: Id of the item.

        Returns:
            What came of the motion.

        Raises:
            ActionError: There is no certified plan, and the arm did not move.
        """
        if not self.is_on_load(name):
            raise ActionError(f"{name} is not on the load")
        place = self.station.stated(self._placements[name])
        query, start = PickQuery(LOAD, name, PALLET, at=place), self._at
        seed = derived_seed("commission pick", self.seed, name, len(self.plans))

        def planned(seen: Scene, certify: Certify) -> Plan:
            return plan_pick(self.context, seen, query, start, seed, certify=certify)

        plan, trouble = self._moved(planned)  # whose end, from the fingers' opening on, lets the item settle
        parts = tuple((str(each.kind), each.t_end - each.t_start) for each in plan.segments)
        return CommissionTransfer(name, self.set_down_of(name), trouble, parts)

    def go_home(self) -> None:
        """Move home; by way of a configuration over the pallet if there is no certified direct way.

        Raises:
            ActionError: There is no certified plan, or the arm did not get there.
        """
        if self.is_home:
            return
        self.look()
        try:
            trouble = self._moved_to(self._home)
        except ActionError as direct:
            over = self.context.configurations_at(self.station.cell.places[PALLET])
            if not over:
                raise
            self._moved_over(over, direct)
            trouble = self._moved_to(self._home)
        if not self.is_home:
            raise ActionError(trouble or "the arm is not at home")

    def _moved_over(self, over: Sequence[Array], direct: ActionError) -> None:
        """Move to one of several configurations. Raises ActionError with all reasons if none is reached."""
        reasons = [str(direct)]
        for q in over:
            try:
                self._moved_to(Start(q, self._home.tool_state))
                return
            except ActionError as error:
                reasons.append(str(error))
        raise ActionError("; then ".join(reasons))

    def _moved_to(self, goal: Start) -> str:
        """Move the empty tool by a certified plan; returns what went wrong. Raises ActionError."""
        start, seed = self._at, derived_seed("commission move", self.seed, self._n_looks, len(self.plans))

        def planned(seen: Scene, certify: Certify) -> Plan:
            target = MoveGoal(goal.q, goal.tool_state)
            plan = certify(plan_move(self.context, seen, start, target, seed, "home"))
            if not isinstance(plan, Plan):
                raise NoPlanError("home", plan)
            return plan

        return self._moved(planned)[1]

    def is_on_load(self, name: str) -> bool:
        """Tell whether an item is on the load.

        Args:
            name: Its id.

        Returns:
            Whether it is; False for one that was taken away by hand.
        """
        return self.has(name) and self._there().placed(name).location == LOAD

    def set_down_of(self, name: str) -> SetDownDeviation | None:
        """Return how far an item that may have been set down is from its place on the pallet.

        Args:
            name: Its id.

        Returns:
            The deviation; None if it was taken away by hand, or stands on the load.
        """
        return self.item_off(name) if self.has(name) and not self.is_on_load(name) else None

    def place_of(self, name: str) -> StatedPlace:
        """Return where an item is to stand on the pallet.

        Args:
            name: Its id.

        Returns:
            Its place in the frame of the pallet; after an exchange with another item the one that it got.
        """
        return self.station.stated(self._placements[name])

    def item_off(self, name: str) -> SetDownDeviation:
        """Return how far an item truly is from its place on the pallet.

        Args:
            name: Id of an item that was not taken away.

        Returns:
            The deviation; its turn is about any axis, of a round item only that of its own axis, of a square
            one to the next quarter turn about that.
        """
        world = self._there()
        at = self.station.stated(self._placements[name]).T_place_item
        T = inverse(world.scene.T_world_place(world.cell.places[PALLET])) @ world.engine.pose(name)
        off = T[:3, 3] - at[:3, 3]
        turned = at[:3, :3].T @ T[:3, :3]
        turn = _turn(turned, world.scene.find(name).item.shape)
        return SetDownDeviation(float(np.hypot(off[0], off[1])), float(off[2]), turn)

    def _there(self) -> LoadWorld:
        if self._world is None:
            raise ActionError("the truck did not stand at the load yet")
        return self._world

    def _looked(self) -> Scene:
        """What was seen last. Raises ActionError."""
        if self._seen is None:
            raise ActionError("nothing was looked at")
        return self._seen

    def has(self, name: str) -> bool:
        """Tell whether an item is there still, and was not taken away by hand.

        Args:
            name: Its id.

        Returns:
            Whether it is.
        """
        return any(placed.id == name for placed in self._there().scene.items)

    def place_in_sequence(self, name: str) -> int:
        """Return when the place of an item is filled.

        Args:
            name: Its id.

        Returns:
            Its number in the sequence of places.
        """
        sequence = [each.carton.id for each in self.station.placements]
        return sequence.index(self._placements[name].carton.id)

    def _moved(self, planned: Callable[[Scene, Certify], Plan]) -> tuple[Plan, str]:
        """Plan and execute a certified motion; returns the plan, and what went wrong. Raises ActionError."""
        world, seen = self._there(), self._looked()
        assert isinstance(world, World)
        world.wait(QUERY_CHARGE)
        try:
            plan = planned(seen, Certifier(verify).within(seen))
        except NoPlanError as error:
            raise ActionError(str(error)) from None
        self.plans.append(ScenePlan(plan, seen))
        return plan, self._executed(plan, world)

    def _executed(self, plan: Plan, world: World) -> str:
        """Execute a plan; after a stop the arm is brought home by hand, without what it holds."""
        noted = self.recorder.begin(plan, world)
        run = execute(plan, world, on_progress=lambda progress: noted.note(world, progress))
        noted.t_end = world.t
        self.collisions += tuple(run.collisions)
        self.n_limit_violations += len(run.limit_violations)
        self.n_stops += run.stop is not None
        if run.stop is None and world.held is None:
            self._at = Start(world.q.copy(), world.tool_state)
            return run.trouble or ""
        if world.held is not None:
            world.take_out(world.held)
        world.let_move(self.station.cell, self._home.q, self._home.tool_state)
        world.wait(RESET_TIME)
        self._at = self._home
        return run.trouble or ""


def _turn(turned: Array, shape: Shape) -> float:
    """Angle (rad) by which an upright item is turned (3, 3), as far as it looks different then."""
    if len(shape.size) == 2:  # round
        cosines = turned[2, 2]
    else:
        length, width = shape.extents[:2]
        quarters = 4 if np.isclose(length, width) else 2
        about = np.arange(quarters) * 2 * np.pi / quarters
        (xx, xy), (yx, yy) = turned[:2, :2]
        along, across = xx + yy, xy - yx  # the trace of turned @ Rz(a) is along cos(a) + across sin(a) + zz
        cosines = (along * np.cos(about) + across * np.sin(about) + turned[2, 2] - 1.0) / 2.0
    return float(np.arccos(np.clip(np.max(cosines), -1.0, 1.0)))
