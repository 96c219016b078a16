"""What is kept for any displaced pod holds for each of them, and what is not says why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import ANY_POD, PodPoses, PodValidity, displaced
from pickcli.cell.tool import MOVING
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import Reason
from pickcli.jobs.job_result import JobResult
from pickcli.motion.path import JointPath
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.path_planning.planner_names import PlannerName
from pickcli.precompute.coarse_motion_planner import CoarseMotionPlanner
from pickcli.precompute.empty_cell_checkers import representative_item
from pickcli.precompute.roadmap_edge_job import RoadmapEdgeJob, validity_of
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.roadmap.trajectory_database import CoarseMotion, MotionKey, PayloadClass
from pickcli.scene.scene import Scene, empty_scene
from pickcli.scene.scene_file import scene_hash
from pickcli.trajopt.trajectory_settings import TrajectorySettings
from pickcli.verification.verify import verify
from support.small_cell import small_cell

EMPTY, CENTRED = PayloadClass.EMPTY, PayloadClass.CENTRED_CUBE
KEYS = (
    MotionKey("home", "bin_E", EMPTY),
    MotionKey("cam_A", "cam_L", EMPTY),
    MotionKey("bin_E", "drop_00_down", EMPTY),
    MotionKey("bin_C", "tote", CENTRED),
)
CELL = small_cell(*(name for key in KEYS for name in (key.start, key.goal)))
MODEL = CollisionModel(CELL)

shares = st.tuples(*[st.floats(-1.0, 1.0)] * 3)
Share = tuple[float, float, float]
CORNERS: list[Share] = [(x, y, yaw) for x, y, yaw in product((-1.0, 1.0), repeat=3)]


@pytest.fixture(scope="module")
def motions() -> dict[MotionKey, CoarseMotion]:
    maker = CoarseMotionPlanner(CELL, TrajectorySettings())
    made = {key: maker.make(key) for key in KEYS}
    return {key: motion for key, motion in made.items() if isinstance(motion, CoarseMotion)}


def _displaced(share: Share, cell: Cell = CELL) -> Scene:
    """The empty cell with its pod displaced by these shares of the bounds."""
    allowed = cell.pod.displacement
    x, y, yaw = share[0] * allowed.x, share[1] * allowed.y, share[2] * allowed.yaw
    return replace(empty_scene(cell), T_world_pod=displaced(cell.T_world_pod, x, y, yaw))


def _clearance(motion: CoarseMotion, scene: Scene) -> float:
    """m, the least over states 5 ms apart, in double precision."""
    assert motion.trajectory is not None
    tests = SceneChecker(MODEL, scene, motion.tool_state, held=representative_item(motion.key.payload))
    Q = motion.trajectory.sample(np.arange(0.0, motion.duration, 0.005))
    return float(tests.kernel.clearances(Q).min())


def test_all_of_them_hold_for_any_pod(motions: dict[MotionKey, CoarseMotion]) -> None:
    assert [motions[key].validity for key in KEYS] == [ANY_POD] * len(KEYS)


@given(shares)
@settings(max_examples=15, deadline=None)
def test_no_displaced_pod_comes_closer_than_the_motion_says(
    motions: dict[MotionKey, CoarseMotion], share: Share
) -> None:
    scene = _displaced(share)
    assert scene.is_pod_within_bounds
    assert set(motions) == set(KEYS)
    assert all(_clearance(motion, scene) >= motion.clearance for motion in motions.values())


@pytest.mark.parametrize("share", CORNERS, ids=str)
def test_the_second_opinion_accepts_them_at_the_corners_of_the_bounds(
    motions: dict[MotionKey, CoarseMotion], share: Share
) -> None:
    scene = _displaced(share)
    for key in KEYS[:3]:
        motion = motions[key]
        assert motion.trajectory is not None
        segment = Segment(SegmentKind.TRANSIT, 0.0, motion.duration, motion.tool_state, None)
        plan = Plan("stored", CELL.fingerprint, scene_hash(scene), 0, (segment,), motion.trajectory, ())
        verdict = verify(plan, scene)
        assert verdict.certificate is not None, verdict.reasons
        assert verdict.certificate.min_clearance >= motion.clearance - 1e-3


def test_a_motion_for_the_pod_in_its_place_would_hit_some_displaced_pod() -> None:
    """So the proof against the sweep is what makes the difference."""
    cell = replace(
        CELL, pod=replace(CELL.pod, displacement=replace(CELL.pod.displacement, x=0.0, y=0.0, yaw=0.0))
    )
    motion = CoarseMotionPlanner(cell, TrajectorySettings()).make(KEYS[1])
    assert isinstance(motion, CoarseMotion)
    assert min(_clearance(motion, _displaced(share)) for share in CORNERS) < 0.0


def test_an_end_too_near_to_a_swept_pod_leaves_a_motion_for_the_pod_in_its_place() -> None:
    cell = small_cell("cam_E", "home")
    key = MotionKey("home", "cam_E", CENTRED)
    motion = CoarseMotionPlanner(cell, TrajectorySettings()).make(key)
    assert isinstance(motion, CoarseMotion)
    assert motion.validity.pod_poses is PodPoses.NOMINAL
    assert motion.validity.why_nominal.startswith(
        "for a displaced pod: cam_E: collision: held cube against pod"
    )
    assert _clearance(motion, empty_scene(cell)) >= motion.clearance


EDGES = {
    ("bin_E", "home"): PodPoses.DISPLACED,
    ("bin_J", "tote"): PodPoses.DISPLACED,
    ("cam_A", "cam_L"): PodPoses.NOMINAL,  # the line; around the sweep it is a third longer
}


@pytest.fixture(scope="module")
def edges() -> dict[tuple[str, str], JobResult]:
    cell = small_cell(*(name for pair in EDGES for name in pair))
    job = RoadmapEdgeJob(cell, RoadmapSettings(PlannerName.RRT_CONNECT, max_iterations=1000))
    return {pair: job.make(pair) for pair in EDGES}


def test_edges_carry_their_marks(edges: dict[tuple[str, str], JobResult]) -> None:
    validities = {pair: validity_of(record) for pair, record in edges.items()}
    assert {pair: validity.pod_poses for pair, validity in validities.items()} == EDGES
    assert validities["cam_A", "cam_L"].why_nominal.startswith("for a displaced pod its length is ")


@given(shares)
@settings(max_examples=15, deadline=None)
def test_no_displaced_pod_meets_an_edge_for_any(
    edges: dict[tuple[str, str], JobResult], share: Share
) -> None:
    tests = SceneChecker(MODEL, _displaced(share), MOVING)
    held = [record for pair, record in edges.items() if EDGES[pair] is PodPoses.DISPLACED]
    assert held
    assert all(tests.is_valid_path(record.arrays["waypoints"]) for record in held)


@dataclass(frozen=True, eq=False)
class _Given(CoarseMotionPlanner):
    """A maker that finds what it is given, in this duration (s), or nothing."""

    found: Mapping[PodPoses, float | None] = field(default_factory=dict)

    def _for_pod_poses(
        self, key: MotionKey, pod_poses: PodPoses, quicker_than: float = np.inf
    ) -> CoarseMotion | Reason:
        duration = self.found[pod_poses]
        if duration is None or duration >= quicker_than:
            return Reason(f"none, {pod_poses}")
        path = JointPath(("a",), np.array([[0.0], [1.0]]))
        return CoarseMotion(key, MOVING, path, duration, lower_bound=0.9, validity=PodValidity(pod_poses))


def _kept(wide: float | None, nominal: float | None) -> CoarseMotion | Reason:
    found = {PodPoses.DISPLACED: wide, PodPoses.NOMINAL: nominal}
    return _Given(CELL, TrajectorySettings(), found).make(KEYS[0])


@pytest.mark.parametrize(("wide", "nominal"), [(1.004, 1.0), (0.905, 0.9), (2.0, None)])
def test_a_motion_for_any_pod_that_costs_no_time_is_kept(wide: float, nominal: float | None) -> None:
    kept = _kept(wide, nominal)
    assert isinstance(kept, CoarseMotion) and (kept.duration, kept.validity) == (wide, ANY_POD)


def test_one_that_costs_time_gives_way_to_one_for_the_pod_in_its_place() -> None:
    kept = _kept(1.006, 1.0)
    assert isinstance(kept, CoarseMotion) and kept.duration == 1.0
    assert kept.validity == PodValidity(PodPoses.NOMINAL, "for a displaced pod it takes 1.006 s")


def test_where_there_is_none_for_any_pod_the_reason_is_kept() -> None:
    kept = _kept(None, 1.0)
    assert isinstance(kept, CoarseMotion)
    assert kept.validity == PodValidity(PodPoses.NOMINAL, "for a displaced pod: none, displaced")
    assert _kept(None, None) == Reason("none, nominal")
