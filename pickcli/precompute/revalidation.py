"""Revalidation of stored motions after some solids around the robot have changed.

A stored motion was proven to keep its clearance from every solid of the old cell. Removed solids cannot
invalidate that proof. The motion is therefore checked only against the added solids, with the same clearance
and the same kernel. If it keeps the clearance, it is proven in the changed cell. If not, it is proven again
against the whole cell.

A motion proven only for the nominal pod pose may become provable for all poses when any solid is removed: the
new free space may admit a path around the pod's swept volume. The stored path cannot show this, because it
avoids the removed solid. The motion is therefore planned again, unless one of its ends is in collision with
the swept volume.

A changed or moved part of the pod rarely frees space beside its new swept volume, and planning all motions
again takes a large part of a build. Motions are therefore planned again only if the stored path collided with
the swept volume of the old part and collides with no added solid. A build from scratch may find paths for all
pod poses that this misses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from pickcli.cell.cell import Cell
from pickcli.cell.cell_diff import CellChange
from pickcli.cell.pod_tolerance import PodPoses
from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.path_planning.state_space import JointSpace
from pickcli.precompute.empty_cell_checkers import STORED_RESERVE, CheckerKey, checker, checkers
from pickcli.roadmap.trajectory_database import CoarseMotion, PayloadClass
from pickcli.trajopt.proven_clearance import keeps_clearance, proven_clearance


@dataclass(frozen=True, eq=False)
class Revalidation:
    """Proofs in a cell of which only solids changed.

    Attributes:
        cell: The changed cell.
        change: The change since the proofs were made.
    """

    cell: Cell
    change: CellChange

    def is_motion_untouched(self, motion: CoarseMotion) -> bool:
        """Whether a motion keeps its clearance from all added solids.

        Args:
            motion: A stored motion.

        Returns:
            True if it need not be proven again.
        """
        return not self.change.added or self._is_free(motion, self._new[_case(motion)], motion.clearance)

    def proven_motion(self, motion: CoarseMotion) -> CoarseMotion | None:
        """Prove a motion in the changed cell.

        Args:
            motion: A stored motion with its trajectory.

        Returns:
            The motion with its new clearance, or None if it is no longer proven.
        """
        validator = self._all[_case(motion)]
        if motion.trajectory is None or not self._is_free(motion, validator, self.cell.clearance):
            return None
        pod_poses, tool_state, payload = _case(motion)
        validator = checker(self._model, tool_state, payload, pod_poses=pod_poses)
        return replace(motion, clearance=proven_clearance(motion.trajectory, self._space, validator))

    def is_edge_untouched(self, waypoints: Array, pod_poses: PodPoses) -> bool:
        """Whether an edge of the roadmap keeps clear of all added solids.

        Args:
            waypoints: (N, n) of the edge.
            pod_poses: Poses of the pod.

        Returns:
            True if it need not be proven again.
        """
        return not self.change.added or self._new[_edge(pod_poses)].is_valid_path(waypoints)

    def is_edge_proven(self, waypoints: Array, pod_poses: PodPoses) -> bool:
        """Prove an edge of the roadmap in the changed cell.

        Args:
            waypoints: (N, n) of the edge.
            pod_poses: Poses of the pod.

        Returns:
            Whether it is proven.
        """
        return self._all[_edge(pod_poses)].is_valid_path(waypoints)

    def is_worth_replanning(self, waypoints: Array, tool_state: ToolState, payload: PayloadClass) -> bool:
        """Whether a polyline proven for the nominal pod pose might be replaced by one for all pod poses.

        Args:
            waypoints: (N, n) of the polyline.
            tool_state: The narrowest state for its ends.
            payload: Payload class of the held item.

        Returns:
            Whether it should be planned again.
        """
        if not (self.change.frees_space or self._is_way_cleared(waypoints, payload)):
            return False
        return bool(self._all[PodPoses.DISPLACED, tool_state, payload].are_valid(waypoints[[0, -1]]).all())

    def _is_way_cleared(self, waypoints: Array, payload: PayloadClass) -> bool:
        """Whether removed solids blocked a polyline in the pod's sweep, and no added ones block it."""
        case = PodPoses.DISPLACED, MOVING, payload
        if not self.change.removed or self._old[case].is_valid_path(waypoints):
            return False
        return not self.change.added or self._new[case].is_valid_path(waypoints)

    def _is_free(self, motion: CoarseMotion, validator: SceneChecker, clearance: float) -> bool:
        """Whether the motion keeps that clearance, and its polyline the planning margin."""
        assert motion.trajectory is not None
        is_path_free = validator.is_valid_path(motion.path.waypoints)
        return is_path_free and keeps_clearance(motion.trajectory, self._space, validator, clearance)

    @cached_property
    def _space(self) -> JointSpace:
        return JointSpace.of(self.cell.robot, self.cell.speed_scale)

    @cached_property
    def _model(self) -> CollisionModel:
        return CollisionModel(self.cell)

    @cached_property
    def _all(self) -> dict[CheckerKey, SceneChecker]:
        """Checkers of the whole cell."""
        return checkers(self._model, STORED_RESERVE)

    @cached_property
    def _new(self) -> dict[CheckerKey, SceneChecker]:
        """Checkers of only the added solids."""
        return checkers(self._model, STORED_RESERVE, self.change.cell_of_added)

    @cached_property
    def _old(self) -> dict[CheckerKey, SceneChecker]:
        """Checkers of only the removed solids."""
        return checkers(self._model, STORED_RESERVE, self.change.cell_of_removed)


def _case(motion: CoarseMotion) -> CheckerKey:
    return motion.validity.pod_poses, motion.tool_state, motion.key.payload


def _edge(pod_poses: PodPoses) -> CheckerKey:
    return pod_poses, MOVING, PayloadClass.EMPTY
