"""The arm of a commission with the hand with belts, which grasps and sets down from the side.

Plans lead to before a grasp, over the place and home, each certified with the hand as it stands and what it
holds; in between the arm is compliant, and the hand's own controller acts (``pickcli.hand``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pickcli.commission.commission import LOAD, PALLET
from pickcli.commission.commission_arm import (
    AT_HOME,
    QUERY_CHARGE,
    RESET_TIME,
    CommissionArm,
    CommissionTransfer,
    LoadWorld,
)
from pickcli.commission.commission_result import ActionError
from pickcli.errors import NoPlanError
from pickcli.hand.arm_handling import ArmGrasp, ArmHandling, HandStoppedError
from pickcli.hand.arm_world import ArmWorld
from pickcli.hand.cluster import Cluster
from pickcli.hand.grasp_trial import GraspEnd
from pickcli.hand.pre_grasp_envelope import object_envelopes
from pickcli.hand.pre_grasps import FRICTION_SPREAD
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
        """Take an item from the load to its place on the pallet; of a cluster, whichever the hand gets.

        Args:
            name: Id of the item.

        Returns:
            What came of it.

        Raises:
            ActionError: There is no certified plan to it, and the arm is where it was or at home.
        """
        world, seen = self._there(), self._looked()
        if not self.is_on_load(name):
            raise ActionError(f"{name} is not on the load")
        world.wait(QUERY_CHARGE)
        cluster, n_before = Cluster.around(seen, name), len(self._handling.stages)
        try:
            grasp = self._grasped_from_here(seen, cluster)
            name = self._stand_in(name, grasp)
            trouble = self._set_down(name, grasp)
        except NoPlanError as error:
            self._note()
            raise ActionError(str(error)) from None
        except HandStoppedError as error:
            trouble = self._stopped(str(error), cluster.names)
        self._note()
        world.wait(SETTLING)
        stages = tuple((str(s.name), s.end - s.start) for s in self._handling.stages[n_before:])
        return CommissionTransfer(name, self.set_down_of(name), trouble, stages)

    def go_home(self) -> None:
        """Move home by a certified plan.

        Raises:
            ActionError: There is no certified plan, or the arm was stopped on the way.
        """
        if self.is_home:
            return
        self.look()
        try:
            self._to_home()
        except NoPlanError as error:
            raise ActionError(str(error)) from None
        except HandStoppedError as error:
            raise ActionError(self._stopped(str(error), ())) from None
        finally:
            self._note()
        if not self.is_home:
            raise ActionError("the arm is not at home")

    def _grasped_from_here(self, seen: Scene, cluster: Cluster) -> ArmGrasp:
        """Grasp from where the arm is, or by way of home if it has no room to open there, or no plan."""
        if not self.is_home:
            try:
                if self._handling.has_room_to_open(seen):
                    return self._grasped(seen, cluster)
            except NoPlanError:
                pass
            self._to_home()
        return self._grasped(seen, cluster)

    def _grasped(self, seen: Scene, cluster: Cluster) -> ArmGrasp:
        """Grasp the only item of a cluster, or one of several without singling it out."""
        hand, handling, first = self.station.hand, self._handling, seen.find(cluster.names[0])
        assert hand is not None
        kind, shape = hand.objects[first.item.name], first.item.shape
        if len(cluster.names) > 1:
            return handling.grasp_cluster(seen, cluster, kind)
        handling.prepare(shape)
        handling.approach(seen, object_envelopes(hand, shape), first.T_world_item)
        return handling.grasp(kind, cluster.names)

    def _stand_in(self, name: str, grasp: ArmGrasp) -> str:
        """Exchange the places of an item and of the one that was taken from its cluster; returns that one."""
        if len(grasp.held) != 1:
            return name
        (held,) = grasp.held
        places = self._placements
        places[name], places[held] = places[held], places[name]
        return held

    def _set_down(self, name: str, grasp: ArmGrasp) -> str:
        """Set down what was grasped: an item in its place; returns what went wrong."""
        handling = self._handling
        if grasp.end is GraspEnd.STOPPED:
            raise HandStoppedError(str(grasp.end))
        if not grasp.held:
            handling.leave()
            return str(grasp.end)
        if len(grasp.held) > 1:
            handling.put_back()
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

    def _to_home(self) -> None:
        """Move home, if the arm is not there. Raises NoPlanError and HandStoppedError."""
        if self.is_home:
            return
        try:
            self._handling.go_home(self._looked())
        except NoPlanError:
            # The compliant arm gave way as it set down: it may stand nearer to the pallet than plans keep.
            self._handling.rise()
            self._handling.go_home(self._looked())

    @property
    def is_home(self) -> bool:
        """Whether the arm is at home by its measured joints."""
        q = self._at.q if self._world is None else self._handling.world.q
        return bool(np.abs(q - self._home.q).max() <= AT_HOME)

    def _stopped(self, why: str, held: Sequence[str]) -> str:
        """Bring the arm home by hand after a stop; returns why it stopped."""
        self.n_stops += 1
        self._bring_home(held)
        return why

    def _bring_home(self, held: Sequence[str]) -> None:
        """Bring the arm home by hand, without what it may hold."""
        world = self._handling.world
        world.reset(self._home.q, [name for name in held if self._is_off_support(name)])
        world.wait(RESET_TIME)

    def _is_off_support(self, name: str) -> bool:
        """Whether an item is in the hand, or has fallen off load and pallet."""
        world, carriers = self._handling.world, self.station.cell.carriers
        supports = {body.name for carrier in (LOAD, PALLET) for body in carriers[carrier].bodies}
        return not supports & world.contacts(name).keys()

    def _note(self) -> None:
        """Note plans and faults so far."""
        handling = self._handling
        self.plans = [ScenePlan(each.plan, each.scene) for each in handling.motions]
        self.collisions = handling.world.collisions
        self.n_limit_violations = sum(len(each.limit_violations) for each in handling.records)
