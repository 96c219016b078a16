"""The life of a stored file, in any order: built, killed, gone on with, damaged, checked, repaired, read.

And of what is learned meanwhile.

Whatever happened before, a build or a repair that ends leaves the bytes of an undisturbed build, a death
costs no finished task, and what is read is what was built or an error.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from pickcli.errors import ApcError, DamagedError
from pickcli.geometry import Array
from pickcli.jobs import job
from pickcli.jobs.job_run import BuildProgress, RunOptions
from pickcli.jobs.journal import Journal
from pickcli.precompute.coarse_motion_job import CoarseMotionJob
from pickcli.precompute.experience import ExperienceFiles
from pickcli.precompute.refreshing import refresh
from pickcli.precompute.repair import repair
from pickcli.precompute.roadmap_edge_job import RoadmapEdgeJob
from pickcli.roadmap.query_experience import QueryExperience
from pickcli.roadmap.store import surveyed
from pickcli.roadmap.trajectory_database import MotionKey, PayloadClass
from support.dying import dies
from support.stored_kind import EDGES, MOTIONS, StoredKind, cell

PLACES = st.floats(0.0, 1.0, exclude_max=True)


@pytest.fixture(scope="module", autouse=True)
def same_code_and_no_task_done_twice(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Someone may be editing the sources; and a task always leaves and costs the same, so once is enough."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(job, "code_digest", lambda: "the same")
        patch.setattr(os, "fsync", lambda handle: None)  # which matters to a machine that dies, not a process
        for kind in (RoadmapEdgeJob, CoarseMotionJob):
            patch.setattr(kind, "make", _remembered(kind.make))
            patch.setattr(kind, "effort", _remembered(kind.effort))
        # So that those who die while they learn it remember it, too.
        folder = tmp_path_factory.mktemp("learned")
        ExperienceFiles.beside(cell(), folder / "roadmap.h5", folder / "motions.h5").learn_motion(LESSONS[0])
        yield


def _remembered(make: Callable[..., Any]) -> Callable[..., Any]:
    made: dict[Any, Any] = {}

    def remembered(self: Any, key: Any) -> Any:
        at = (self.inputs, key)
        if at not in made:
            made[at] = make(self, key)
        return made[at]

    return remembered


# Of what is left of a file that was cut off, or is gone.
NO_FILE_OF_OURS = ("expected", "no such", "is empty", "neither begins nor ends")


class _Life(RuleBasedStateMachine):
    """One output file, and all that is beside it."""

    kind: ClassVar[StoredKind]

    def __init__(self) -> None:
        super().__init__()
        self.folder = Path(tempfile.mkdtemp())
        self.out = self.folder / "out.h5"
        self.good = self.kind.good()
        self.learner = ExperienceFiles.beside(cell(), self.folder / "roadmap.h5", self.folder / "motions.h5")
        self.learned: set[Any] = set()

    def teardown(self) -> None:
        shutil.rmtree(self.folder)

    @property
    def journal(self) -> Journal:
        return Journal(self.out, self.kind.job().inputs)

    @rule()
    def build(self) -> None:
        """Also after a death: then it goes on, and does only what is left."""
        told: list[BuildProgress] = []
        kept = self.journal.read()
        self.kind.make(self.out, RunOptions(report=told.append))
        assert self.out.read_bytes() == self.good
        assert told[-1].n_kept == len(kept) and told[-1].done == told[-1].total
        assert not self.journal.path.exists()
        assert not list(self.folder.glob(f".{self.out.name}.*.part"))

    @rule(n_calls=st.integers(1, 40))
    def die_while_building(self, n_calls: int) -> None:
        """At any call to the system that changes a disk."""
        before, kept = self._state(), self.journal.read()
        n_appended = dies(n_calls, lambda: self.kind.make(self.out, None))
        if self._state() == before:
            left = self.journal.read()
            assert left.items() >= kept.items() and len(left) - len(kept) - n_appended in (0, 1)
        else:
            assert self.out.read_bytes() == self.good

    @rule(n_done=st.integers(0, 6))
    def interrupt(self, n_done: int) -> None:
        """Ctrl-C after some tasks: they are kept."""
        before, kept = self._state(), self.journal.read()

        def report(progress: BuildProgress) -> None:
            if progress.done - progress.n_kept == n_done:
                raise KeyboardInterrupt

        try:
            self.kind.make(self.out, RunOptions(report=report))
        except KeyboardInterrupt:
            assert self._state() == before
            assert len(self.journal.read()) >= len(kept) + n_done

    @precondition(lambda self: self.out.exists())
    @rule(place=PLACES, bit=st.integers(0, 7))
    def flip_a_bit(self, place: float, bit: int) -> None:
        """Of the file."""
        _flip(self.out, place, bit)

    @precondition(lambda self: self.out.exists())
    @rule(place=PLACES)
    def cut_off(self, place: float) -> None:
        """The end of the file."""
        content = self.out.read_bytes()
        self.out.write_bytes(content[: int(place * len(content))])

    @precondition(lambda self: self.journal.path.exists() and self.journal.path.stat().st_size)
    @rule(place=PLACES, bit=st.integers(0, 7))
    def flip_a_bit_of_the_journal(self, place: float, bit: int) -> None:
        """Costs one record at most. The same bit again, and it is back."""
        before = self.journal.read()
        _flip(self.journal.path, place, bit)
        assert len(before.items() ^ self.journal.read().items()) <= 1

    @precondition(lambda self: self.out.exists())
    @rule()
    def check(self) -> None:
        """Finds damage exactly where there is some."""
        try:
            found = surveyed(self.out)
        except ApcError:
            assert self.out.read_bytes() != self.good
        else:
            assert bool(found.damage) == (self.out.read_bytes() != self.good)

    @precondition(lambda self: self.out.exists())
    @rule(mend=st.sampled_from([repair, refresh]), n_calls=st.integers(0, 20))
    def mend(self, mend: Callable[..., object], n_calls: int) -> None:
        """Repair, or refresh for the same cell; with ``n_calls``, killed on the way.

        What cannot be repaired is left as it is.
        """
        before = self.out.read_bytes()
        try:
            found = surveyed(self.out)
            if n_calls:
                dies(n_calls, lambda: mend(self.out, found, cell()))
                assert self.out.read_bytes() in (before, self.good)
            else:
                mend(self.out, found, cell())
                assert self.out.read_bytes() == self.good
        except ApcError as error:
            assert isinstance(error, DamagedError) or any(why in str(error) for why in NO_FILE_OF_OURS)
            assert self.out.read_bytes() == before

    @precondition(lambda self: self.out.exists())
    @rule()
    def read(self) -> None:
        """What is served is what was built, or nothing."""
        try:
            served = self.kind.content(self.out)
        except ApcError:
            assert self.out.read_bytes() != self.good
        else:
            for part, right in zip(served, self.kind.good_content(), strict=True):
                np.testing.assert_array_equal(part, right)

    @rule(what=st.integers(0, 2), n_calls=st.integers(0, 8))
    def learn(self, what: int, n_calls: int) -> None:
        """An edge or a motion; with ``n_calls``, killed on the way. What was learned before stays."""
        lesson = LESSONS[what]

        def action() -> object:
            if isinstance(lesson, MotionKey):
                return self.learner.learn_motion(lesson)
            return self.learner.learn_edges([_experience(lesson)])

        if n_calls:
            dies(n_calls, action)
        else:
            action()
            self.learned.add(lesson)
        known = self._known()
        assert self.learned <= known <= self.learned | {lesson}
        self.learned = known

    @rule(place=PLACES, bit=st.integers(0, 7), is_edges=st.booleans())
    def damage_what_was_learned(self, place: float, bit: int, is_edges: bool) -> None:
        """It is refused, and after it was deleted, as the message says, learned again."""
        path = self.learner.roadmap if is_edges else self.learner.trajectories
        if path.exists():
            _flip(path, place, bit)
            try:
                assert self._known() == self.learned
            except ApcError as error:
                assert "or delete it" in str(error)
            path.unlink()
            self.learned = self._known()

    def _known(self) -> set[Any]:
        """Of the lessons, those that a later query finds."""
        edges = [edge.tobytes() for edge in self.learner.edges()]
        motions = self.learner.motions() or ()
        steps = {step for step in LESSONS if isinstance(step, float) and _polyline(step).tobytes() in edges}
        return steps | {motion.key for motion in motions}

    @invariant()
    def nothing_else_lies_around(self) -> None:
        """But what a death in the middle of writing leaves, until the same file is written again."""
        left = {path for path in self.folder.iterdir() if path.suffix not in (".part", ".lock")}
        assert left <= {self.out, self.journal.path, self.learner.roadmap, self.learner.trajectories}

    def _state(self) -> tuple[int, bytes] | None:
        """Which file it is, and its bytes."""
        return (self.out.stat().st_ino, self.out.read_bytes()) if self.out.exists() else None


# What is learned: a motion, and straight edges from home by so many rad or m of the second joint.
LESSONS: tuple[Any, ...] = (
    MotionKey("home", "bin_A", PayloadClass.EMPTY),
    0.1,
    0.3,
)


def _polyline(step: float) -> Array:
    home = cell().configurations["home"].q
    return np.stack([home, home + step * (np.arange(len(home)) == 1)])


def _experience(step: float) -> QueryExperience:
    polyline = _polyline(step)
    return QueryExperience(polyline[0], polyline[1], PayloadClass.EMPTY, (polyline,))


def _flip(path: Path, place: float, bit: int) -> None:
    content = bytearray(path.read_bytes())
    if content:
        content[int(place * len(content))] ^= 1 << bit
        path.write_bytes(content)


def _test(kind: StoredKind, max_examples: int, n_steps: int) -> type[Any]:
    machine: Any = type("Life", (_Life,), {"kind": kind})
    case: type[Any] = machine.TestCase
    case.settings = settings(
        max_examples=max_examples, stateful_step_count=n_steps, deadline=None, derandomize=True,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    return case


TestMotions = _test(MOTIONS, 8, 12)
TestEdges = _test(EDGES, 8, 12)
TestMotionsAtLength = pytest.mark.slow(_test(MOTIONS, 25, 40))
TestEdgesAtLength = pytest.mark.slow(_test(EDGES, 25, 40))
