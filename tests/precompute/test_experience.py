"""What is learned holds in the empty cell, is there for later queries, and survives company and kills."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from pickcli.cell.cell import Cell
from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import Mode
from pickcli.collision.motion_validator import MotionValidator
from pickcli.errors import DamagedError, StaleError
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.coarse_path import CoarsePath
from pickcli.planning.planning_context import PlanningContext
from pickcli.precompute import experience
from pickcli.precompute.experience import ExperienceFiles
from pickcli.precompute.roadmap_edge_job import RoadmapEdgeJob
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.merge_edges import with_polylines
from pickcli.roadmap.query_experience import ExperienceRecorder, QueryExperience
from pickcli.roadmap.store import surveyed
from pickcli.roadmap.trajectory_database import MotionKey, PayloadClass
from pickcli.scene.scene import empty_scene
from support.small_cell import LEAST_EFFORT, small_cell
from support.tool_states import STRAIGHT

Array = NDArray[np.float64]

# From each of the first to each of the second the straight edge is blocked.
BINS, DROPS = ("bin_K", "bin_L"), ("drop_00", "drop_11")


@pytest.fixture(scope="module")
def cell() -> Cell:
    return small_cell("home", "bin_A", "bin_E", "tote", *BINS, *DROPS)


@pytest.fixture(scope="module")
def proof(cell: Cell) -> MotionValidator:
    return RoadmapEdgeJob(cell, RoadmapSettings()).checker


@pytest.fixture
def learner(cell: Cell, tmp_path: Path) -> ExperienceFiles:
    made = ExperienceFiles.beside(cell, tmp_path / "roadmap.h5", tmp_path / "trajectories.h5")
    return ExperienceFiles(cell, made.roadmap, made.trajectories, LEAST_EFFORT)


def _pairs(cell: Cell, proof: MotionValidator, is_free: bool) -> list[Array]:
    """Straight edges between named configurations that are free in the empty cell, or not."""
    named = [c.q for c in cell.configurations.values() if proof.is_valid(c.q)]
    edges = [np.stack(pair) for pair in combinations(named, 2)]
    return [edge for edge in edges if proof.is_valid_edge(*edge) is is_free]


def _experience(*polylines: Array) -> QueryExperience:
    return QueryExperience(polylines[0][0], polylines[0][-1], PayloadClass.EMPTY, polylines)


def test_only_what_is_free_in_the_empty_cell_is_kept_and_only_once(
    cell: Cell, proof: MotionValidator, learner: ExperienceFiles
) -> None:
    free, blocked = _pairs(cell, proof, True)[:2], _pairs(cell, proof, False)[0]
    first = learner.learn_edges([_experience(*free), _experience(blocked)])
    assert (first.edges, first.unproven) == (2, 1)
    assert learner.learn_edges([_experience(free[0][::-1])]).edges == 0
    for kept, given in zip(learner.edges(), free, strict=True):
        np.testing.assert_array_equal(kept, given)


def test_the_oldest_go(
    cell: Cell, proof: MotionValidator, learner: ExperienceFiles, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(experience, "MOST_EDGES", 3)
    free = _pairs(cell, proof, True)[:5]
    for edge in free:
        learner.learn_edges([_experience(edge)])
    kept = learner.edges()
    assert [k.tobytes() for k in kept] == [edge.tobytes() for edge in free[2:]]


def test_a_learned_file_is_sealed_and_belongs_to_its_cell(
    cell: Cell, proof: MotionValidator, learner: ExperienceFiles
) -> None:
    learner.learn_edges([_experience(_pairs(cell, proof, True)[0])])
    assert not surveyed(learner.roadmap).damage
    content = bytearray(learner.roadmap.read_bytes())
    content[content.index(np.asarray(learner.edges()[0]).tobytes()) + 3] ^= 1
    learner.roadmap.write_bytes(content)
    with pytest.raises(DamagedError, match="delete it"):
        learner.edges()
    with pytest.raises(DamagedError, match="delete it"):
        learner.learn_edges([_experience(_pairs(cell, proof, True)[1])])
    assert learner.roadmap.read_bytes() == content


def test_another_cell_does_not_learn_from_it(
    cell: Cell, proof: MotionValidator, learner: ExperienceFiles
) -> None:
    learner.learn_edges([_experience(_pairs(cell, proof, True)[0])])
    other = ExperienceFiles(replace(cell, fingerprint="0" * 64), learner.roadmap, learner.trajectories)
    with pytest.raises(StaleError, match="delete it"):
        other.edges()


@pytest.mark.slow
def test_a_missed_motion_is_made_and_answers_the_next_query(cell: Cell, learner: ExperienceFiles) -> None:
    context = PlanningContext(cell)
    straight = _planned(context, "home", "bin_E")
    assert straight.source == "straight edge" and straight.experience == ()
    found = _planned(context, "bin_L", "drop_00")
    assert found.source == "planner"
    (key,) = learner.missed([*found.experience, *found.experience], None)
    assert key == MotionKey("bin_L", "drop_00", PayloadClass.EMPTY)
    assert learner.learn_motion(key).motions == 1
    assert learner.learn_motion(key.reversed()).motions == 0
    learned = learner.motions()
    assert learned is not None and learner.missed(found.experience, None, learned) == []
    again = PlanningContext(cell, learned=learned)
    for start, goal in ((key.start, key.goal), (key.goal, key.start)):
        answer = _planned(again, start, goal)
        assert answer.source == "database" and answer.experience == ()


def test_learned_edges_answer_where_the_planner_had_to(cell: Cell, learner: ExperienceFiles) -> None:
    recorder = ExperienceRecorder()
    context = PlanningContext(cell)
    for start, goal in product(BINS, DROPS):
        recorder.record(_planned(context, start, goal).experience)
    assert recorder.recorded
    kept = learner.learn_edges(recorder.recorded)
    assert kept.edges >= 1
    empty = Roadmap.empty(cell.robot.joint_names)
    again = PlanningContext(cell, with_polylines(empty, learner.edges()))
    first = learner.edges()[0]
    found = plan_coarse(again, _checker(again), first[0], first[-1][None], [0.0], 1, "again")
    assert isinstance(found, CoarsePath) and found.source == "roadmap"


# Learns edges between configurations of its own in the free space around home, and says so after each.
SCRIPT = """
import sys
from pathlib import Path
import numpy as np
from support.small_cell import small_cell
from pickcli.precompute.experience import ExperienceFiles
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.roadmap.query_experience import QueryExperience
folder, first, count = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
cell = small_cell("home")
learner = ExperienceFiles.beside(cell, folder / "roadmap.h5", folder / "trajectories.h5")
home = cell.configurations["home"].q
print("ready", flush=True)
sys.stdin.readline()
for k in range(first, first + count):
    away = home.copy()
    away[-1] += 0.1 * (k + 1)
    learner.learn_edges([QueryExperience(home, away, PayloadClass.EMPTY, (np.stack([home, away]),))])
    print(k, flush=True)
"""


def _started(folder: Path, first: int, count: int) -> subprocess.Popen[str]:
    """A process that is ready to learn."""
    command = [sys.executable, "-c", SCRIPT, str(folder), str(first), str(count)]
    here = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    process = subprocess.Popen(
        command, env=here, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
    )
    assert process.stdout is not None and process.stdout.readline() == "ready\n"
    return process


def _go(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None
    process.stdin.write("\n")
    process.stdin.flush()


def _turns(learner: ExperienceFiles) -> list[int]:
    """Which of the edges of SCRIPT are kept."""
    return sorted(round(10 * float(edge[-1][-1] - edge[0][-1])) - 1 for edge in learner.edges())


def test_two_processes_learn_at_once(learner: ExperienceFiles) -> None:
    both = [_started(learner.roadmap.parent, first, 6) for first in (0, 6)]
    for process in both:
        _go(process)
    for process in both:
        process.communicate(timeout=60)
        assert process.returncode == 0
    assert _turns(learner) == list(range(12))


@pytest.mark.slow
def test_a_kill_loses_at_most_what_is_in_hand(learner: ExperienceFiles) -> None:
    rng, kept = random.Random(1), 0
    for _ in range(5):
        process = _started(learner.roadmap.parent, 0, 25)
        _go(process)
        time.sleep(rng.uniform(0.01, 0.2))
        process.send_signal(signal.SIGKILL)
        said, _ = process.communicate(timeout=60)
        told = len(said.split())
        there = _turns(learner) if learner.roadmap.exists() else []
        assert there == list(range(len(there))), "a hole, or something that was not given"
        assert len(there) >= max(told, kept)
        kept = len(there)


def _planned(context: PlanningContext, start: str, goal: str) -> CoarsePath:
    q_start, q_goal = (context.cell.configurations[name].q for name in (start, goal))
    found = plan_coarse(context, _checker(context), q_start, q_goal[None], [0.0], 1, f"{start} to {goal}")
    assert isinstance(found, CoarsePath)
    return found


def _checker(context: PlanningContext) -> SceneChecker:
    return context.checker_for(empty_scene(context.cell), Mode(STRAIGHT))
