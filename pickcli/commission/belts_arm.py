"""The arm of a commission with the hand with belts, which grasps and sets down from the side.

Plans lead to before a grasp, over the place and home, each certified with the hand as it stands and what it
holds; in between the arm is compliant, and the hand's own controller acts (``pickcli.hand``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pickcli.commission.commission import LOAD, PALLET
from pickcli.commission.commission_arm import (
    QUERY_CHARGE,
    RESET_TIME,
    CommissionArm,
    CommissionTransfer,
    LoadWorld,
)
from pickcli.commission.commission_result import ActionError
from pickcli.errors import NoPlanError
from pickcli.hand.arm_handling import ArmHandling, HandStoppedError
from pickcli.hand.arm_world import ArmWorld
from pickcli.hand.pre_grasp_envelope import object_envelopes
from pickcli.hand.pre_grasps import FRICTION_SPREAD
from pickcli.planning.start_state import Start
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_rng
from pickcli.simulation.scene_bodies import true_masses
from pickcli.trial.scene_plan import ScenePlan

SETTLING = 0.2  # s after which an item that was set down is at rest


class BeltsArm(CommissionArm):
    """The arm with the hand of the station, and the world around it."""

    _handling: ArmHandling

    def _world_of(self, scene: Scene) -> LoadWorld:
        assert self.station.hand is not None
        friction = 1.0 + FRICTION_SPREAD * float(derived_rng("belts", self.seed).uniform(-1.0, 1.0))
        masses = true_masses(scene, self.reality, self.seed)
        world = ArmWorld(scene, self.station.hand, self._home.q, masses, friction)
        world.observer = self.recorder.look
        self._handling = ArmHandling(world, self._home.q, self.noise, self.recorder, self.seed)
        return world

    def transfer(self, name: str) -> CommissionTransfer:
        """Take an item from the load to its place on the pallet.

        Args:
            name: Id of the item.

        Returns:
            What came of it.

        Raises:
            ActionError: There is no certified plan to it, and the arm did not move.
        """
        hand, world, seen = self.station.hand, self._there(), self._looked()
        assert hand is not None
        if not self.is_on_load(name):
            raise ActionError(f"{name} is not on the load")
        world.wait(QUERY_CHARGE)
        placed, n_before = seen.find(name), len(self._handling.stages)
        try:
            self._handling.prepare(placed.item.shape)
            self._handling.approach(seen, object_envelopes(hand, placed.item.shape), placed.T_world_item)
        except NoPlanError as error:
            raise ActionError(str(error)) from None
        trouble = self._tried(lambda: self._taken(name, placed.item.name), (name,))
        trouble = self._tried(self._to_home, ()) or trouble
        self._note()
        world.wait(SETTLING)
        stages = tuple((str(s.name), s.end - s.start) for s in self._handling.stages[n_before:])
        return CommissionTransfer(self.item_off(name) if self._has(name) else None, trouble, stages)

    def go_home(self) -> None:
        """Do nothing: the arm comes home after every item."""

    def _taken(self, name: str, product: str) -> str:
        """Grasp an item and set it down; returns what went wrong."""
        hand, handling = self.station.hand, self._handling
        assert hand is not None
        grasp = handling.grasp(hand.objects[product], (name,))
        if not grasp.held:
            if grasp.stages[-1].ended_by == "torque threshold":
                raise HandStoppedError(str(grasp.end))
            handling.leave()
            return str(grasp.end)
        self.look()
        seen, station = self._looked(), self.station
        place = seen.T_world_place(station.cell.places[PALLET])
        try:
            handling.transfer(seen, grasp.held, place @ station.stated(self._placements[name]).T_place_item)
        except NoPlanError as error:
            handling.put_back()
            return str(error)
        handling.set_down()
        return ""

    def _to_home(self) -> str:
        if not self.is_home_now:
            self.look()
            self._handling.go_home(self._looked())
        return ""

    @property
    def is_home_now(self) -> bool:
        """Whether the arm is at home by its measured joints."""
        return bool(np.abs(self._handling.world.q - self._home.q).max() < 1e-3)

    def _tried(self, act: Callable[[], str], held: Sequence[str]) -> str:
        """Act; if that is stopped or has no plan, bring the arm home by hand. Returns what went wrong."""
        world = self._handling.world
        try:
            return act()
        except NoPlanError as error:
            why = str(error)
        except HandStoppedError as error:
            why, self.n_stops = str(error), self.n_stops + 1
        world.reset(self._home.q, [name for name in held if self._is_off_support(name)])
        world.wait(RESET_TIME)
        return why

    def _is_off_support(self, name: str) -> bool:
        """Whether an item is in the hand, or has fallen off load and pallet."""
        world, carriers = self._handling.world, self.station.cell.carriers
        supports = {body.name for carrier in (LOAD, PALLET) for body in carriers[carrier].bodies}
        return not supports & world.contacts(name).keys()

    def _note(self) -> None:
        """Note plans and faults so far."""
        handling = self._handling
        self.plans = [ScenePlan(each.plan, each.scene) for each in handling.motions]
        self.n_collisions = len(handling.world.collisions)
        self.n_limit_violations = sum(len(each.limit_violations) for each in handling.records)
        self._at = Start(handling.world.q.copy(), self._home.tool_state)
