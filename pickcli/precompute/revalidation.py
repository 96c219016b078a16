"""Proving what is stored again, after some solids around the robot have changed.

A motion keeps its clearance from everything. Solids that went away cannot break that; of those that came it
is asked to keep the same clearance, from them alone, with the kernel that proved it at first. Where it does,
it is proven in the changed cell as it was in the old one: nothing else there is new. Only what comes nearer
than that is touched by the change, and proven again against the whole cell.

What holds for the pod in its place alone may be had for any pod once a solid went away, of the pod or not: a
way around the sweep of the pod may lead where it was. The way that is stored says nothing about that, as it
keeps from that solid. So it must be searched for again, unless an end is not free in the sweep.

A part of the pod that is other or elsewhere leaves little room beside what it sweeps now, and to search for
all of them again takes a good part of a build. So that is done only where the stored way met the part in the
sweep, and meets nothing there that came; else a build from nothing may find ways for any pod that we miss.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from pickcli.cell.cell import Cell
from pickcli.cell.cell_diff import CellChange
from pickcli.cell.pod_tolerance import PodStand
from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.path_planning.state_space import JointSpace
from pickcli.precompute.empty_cell_checkers import RESERVE, CheckerKey, checker, checkers
from pickcli.roadmap.trajectory_database import CoarseMotion, PayloadClass
from pickcli.trajopt.certified_clearance import keeps_clearance, proven_clearance


@dataclass(frozen=True, eq=False)
class Revalidation:
    """Proofs in a cell after a change of its solids alone.

    Attributes:
        cell: The cell as it is now.
        change: What changed since the proofs were made.
    """

    cell: Cell
    change: CellChange

    def is_motion_untouched(self, motion: CoarseMotion) -> bool:
        """Tell whether a motion keeps its clearance from all that is new.

        Args:
            motion: A stored motion.

        Returns:
            True if it need not be proven again.
        """
        return not self.change.came or self._is_free(motion, self._new[_case(motion)], motion.clearance)

    def proven_motion(self, motion: CoarseMotion) -> CoarseMotion | None:
        """Prove a motion in the cell as it is now.

        Args:
            motion: A stored motion with its trajectory.

        Returns:
            The motion with the clearance that it has now, or None if it is not proven any more.
        """
        tests = self._all[_case(motion)]
        if motion.trajectory is None or not self._is_free(motion, tests, self.cell.clearance):
            return None
        stand, tool_state, payload = _case(motion)
        tests = checker(self._model, tool_state, payload, stand=stand)
        return replace(motion, clearance=proven_clearance(motion.trajectory, self._space, tests))

    def is_edge_untouched(self, waypoints: Array, stand: PodStand) -> bool:
        """Tell whether an edge of the roadmap keeps clear of all that is new.

        Args:
            waypoints: (N, n) of the edge.
            stand: Where the pod stands.

        Returns:
            True if it need not be proven again.
        """
        return not self.change.came or self._new[_edge(stand)].is_valid_path(waypoints)

    def is_edge_proven(self, waypoints: Array, stand: PodStand) -> bool:
        """Prove an edge of the roadmap in the cell as it is now.

        Args:
            waypoints: (N, n) of the edge.
            stand: Where the pod stands.

        Returns:
            Whether it is proven.
        """
        return self._all[_edge(stand)].is_valid_path(waypoints)

    def is_worth_replanning(self, waypoints: Array, tool_state: ToolState, payload: PayloadClass) -> bool:
        """Tell whether a polyline that holds for the pod in its place alone may give way to one for any pod.

        Args:
            waypoints: (N, n) of the polyline.
            tool_state: The narrowest state that its ends may have.
            payload: Class of what is held.

        Returns:
            Whether it is worth making anew.
        """
        if not (self.change.leaves_room or self._is_way_cleared(waypoints, payload)):
            return False
        return bool(self._all[PodStand.DISPLACED, tool_state, payload].are_valid(waypoints[[0, -1]]).all())

    def _is_way_cleared(self, waypoints: Array, payload: PayloadClass) -> bool:
        """Whether a polyline met what went away in the sweep of the pod, and nothing that came."""
        case = PodStand.DISPLACED, MOVING, payload
        if not self.change.went or self._old[case].is_valid_path(waypoints):
            return False
        return not self.change.came or self._new[case].is_valid_path(waypoints)

    def _is_free(self, motion: CoarseMotion, tests: SceneChecker, clearance: float) -> bool:
        """Whether the motion keeps that clearance, and its polyline what polylines keep."""
        assert motion.trajectory is not None
        is_path_free = tests.is_valid_path(motion.path.waypoints)
        return is_path_free and keeps_clearance(motion.trajectory, self._space, tests, clearance)

    @cached_property
    def _space(self) -> JointSpace:
        return JointSpace.of(self.cell.robot, self.cell.speed_scale)

    @cached_property
    def _model(self) -> CollisionModel:
        return CollisionModel(self.cell)

    @cached_property
    def _all(self) -> dict[CheckerKey, SceneChecker]:
        """Checkers of the whole cell."""
        return checkers(self._model, RESERVE)

    @cached_property
    def _new(self) -> dict[CheckerKey, SceneChecker]:
        """Checkers of what is new alone."""
        return checkers(self._model, RESERVE, self.change.cell_of_came)

    @cached_property
    def _old(self) -> dict[CheckerKey, SceneChecker]:
        """Checkers of what went away alone."""
        return checkers(self._model, RESERVE, self.change.cell_of_went)


def _case(motion: CoarseMotion) -> CheckerKey:
    return motion.mark.stand, motion.tool_state, motion.key.payload


def _edge(stand: PodStand) -> CheckerKey:
    return stand, MOVING, PayloadClass.EMPTY
