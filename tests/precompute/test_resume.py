"""A build is the same bytes on one process or two, and however often it was killed."""

from __future__ import annotations

import hashlib
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import pickcli
from pickcli.cell.cell import Cell
from pickcli.errors import InputError
from pickcli.jobs import job
from pickcli.jobs.executors import ProcessExecutor, SerialExecutor
from pickcli.jobs.job_run import BuildProgress, RunOptions
from pickcli.jobs.journal import Journal
from pickcli.kernel import _kernel
from pickcli.precompute.coarse_motion_job import CoarseMotionJob
from pickcli.roadmap.store import read_roadmap
from pickcli.trajopt.trajectory_settings import TrajectorySettings
from support.small_cell import LEAST_EFFORT, small_cell
from support.stored_kind import KINDS, MOTIONS
from support.stored_kind import cell as stored_cell

CODE_DIGEST = job.code_digest


@pytest.fixture(scope="module", autouse=True)
def same_code() -> Iterator[None]:
    """Someone may be editing the sources while the tests run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(job, "code_digest", lambda: "the same")
        yield


@pytest.fixture(scope="module")
def cell() -> Cell:
    return stored_cell()


@pytest.fixture(scope="module")
def good() -> dict[str, bytes]:
    """The bytes of undisturbed builds on one process."""
    return {name: kind.good() for name, kind in KINDS.items()}


def _built(folder: Path, kind: str, run_options: RunOptions | None = None) -> bytes:
    KINDS[kind].make(folder / kind, run_options)
    return (folder / kind).read_bytes()


@pytest.mark.parametrize("kind", KINDS)
def test_two_jobs_make_the_same_bytes_as_one(kind: str, good: dict[str, bytes], tmp_path: Path) -> None:
    assert _built(tmp_path, kind, RunOptions(ProcessExecutor(2))) == good[kind]
    assert [path.name for path in tmp_path.iterdir()] == [kind]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("n_jobs", [1, 2])
def test_an_interrupted_build_does_only_the_rest_and_ends_in_the_same_bytes(
    kind: str, n_jobs: int, good: dict[str, bytes], tmp_path: Path
) -> None:
    told: list[BuildProgress] = []

    def interrupt(progress: BuildProgress) -> None:
        if progress.done == 4:
            raise KeyboardInterrupt

    executor = SerialExecutor() if n_jobs == 1 else ProcessExecutor(n_jobs)
    with pytest.raises(KeyboardInterrupt):
        _built(tmp_path, kind, RunOptions(executor, report=interrupt))
    assert not (tmp_path / kind).exists()
    assert _built(tmp_path, kind, RunOptions(executor, report=told.append)) == good[kind]
    assert told[0].n_kept == told[0].done == 4
    assert told[-1].done == told[-1].total and told[-1].n_kept == 4
    assert [path.name for path in tmp_path.iterdir()] == [kind]


def test_a_journal_of_other_settings_is_neither_used_nor_lost(
    good: dict[str, bytes], cell: Cell, tmp_path: Path
) -> None:
    other = Journal(tmp_path / "motions", CoarseMotionJob(cell, TrajectorySettings(seed=9)).inputs)
    other.append(("home", "bin_A", "empty"), b"of another build")
    assert _built(tmp_path, "motions") == good["motions"]
    assert other.path.exists()


def test_other_configurations_or_code_are_other_inputs(cell: Cell, monkeypatch: Any) -> None:
    inputs = CoarseMotionJob(cell, LEAST_EFFORT).inputs
    names = list(cell.configurations)
    assert CoarseMotionJob(small_cell(*names), LEAST_EFFORT).inputs == inputs
    assert CoarseMotionJob(small_cell(*names[:-1]), LEAST_EFFORT).inputs != inputs
    monkeypatch.setattr(job, "code_digest", lambda: "other")
    assert CoarseMotionJob(cell, LEAST_EFFORT).inputs != inputs


def test_another_kernel_is_other_code(monkeypatch: Any, tmp_path: Path) -> None:
    digest = CODE_DIGEST.__wrapped__
    before = digest()
    (tmp_path / "kernel.so").write_bytes(b"another")
    monkeypatch.setattr(_kernel, "__file__", str(tmp_path / "kernel.so"))
    assert digest() != before


def test_only_code_that_makes_results_decides_about_kept_tasks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A changed help text leaves every journal and every worker of a cluster usable."""
    package = tmp_path / "pickcli"
    shutil.copytree(Path(pickcli.__file__).parent, package, ignore=shutil.ignore_patterns("*.so", "src"))
    monkeypatch.setattr(pickcli, "__file__", str(package / "__init__.py"))
    digest = CODE_DIGEST.__wrapped__
    before, everything = digest(), job.sources_digest()
    for name in ("commands/plan_pick.py", "trial/score.py", "drawing/png.py"):
        (package / name).write_text((package / name).read_text() + "# another word\n")
        assert digest() == before and job.sources_digest() != everything
    for name in ("precompute/repair.py", "jobs/job_run.py", "cell/cell.py", "errors.py"):
        (package / name).write_text((package / name).read_text() + "# another word\n")
        assert digest() != before
        before = digest()


def test_what_makes_results_imports_nothing_that_is_left_out() -> None:
    root = Path(pickcli.__file__).parent
    upwards = re.compile(
        rf"^\s*(from|import) pickcli\.({'|'.join(job.PACKAGES_WITHOUT_RESULTS)})\b", re.MULTILINE
    )
    kept = [p for p in root.rglob("*.py") if p.relative_to(root).parts[0] not in job.PACKAGES_WITHOUT_RESULTS]
    assert len(kept) > 100
    assert [path for path in kept if upwards.search(path.read_text())] == []
    assert all((root / package).exists() for package in job.PACKAGES_WITHOUT_RESULTS)


def test_a_file_size_limit_leaves_the_old_file_and_the_build_goes_on(
    good: dict[str, bytes], cell: Cell, tmp_path: Path
) -> None:
    (tmp_path / "motions").write_bytes(b"old")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    for limit in (len(good["motions"]) // 3, len(good["motions"]) - 1):  # reached by the journal, by the file
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limits[1]))
        try:
            with pytest.raises(InputError, match="cannot be written: File too large"):
                _built(tmp_path, "motions")
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert (tmp_path / "motions").read_bytes() == b"old"
    assert _built(tmp_path, "motions") == good["motions"]
    assert [path.name for path in tmp_path.iterdir()] == ["motions"]


PROGRAM = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parents[1])!r})
from pathlib import Path
from support.stored_kind import MOTIONS
from pickcli.jobs import job
from pickcli.jobs.job_run import RunOptions
from pickcli.jobs.executors import runner
job.code_digest = lambda: "the same"
MOTIONS.make(Path(sys.argv[1]), RunOptions(runner(int(sys.argv[2]))))
"""


@pytest.mark.parametrize("n_jobs", [1, 2])
def test_a_killed_build_loses_at_most_what_was_in_hand(
    n_jobs: int, good: dict[str, bytes], tmp_path: Path
) -> None:
    out = tmp_path / "motions.h5"
    journal = Journal(out, MOTIONS.job().inputs)

    def has(n_records: int) -> bool:
        return len(journal.read()) >= n_records

    for n_records in (1, 7):
        command = [sys.executable, "-c", PROGRAM, str(out), str(n_jobs)]
        _killed_when(subprocess.Popen(command), partial(has, n_records))
    assert not out.exists() and has(7)
    told: list[BuildProgress] = []
    MOTIONS.make(out, RunOptions(report=told.append))
    assert told[0].n_kept >= 7
    assert out.read_bytes() == good["motions"]


@pytest.mark.slow
def test_kills_at_random_moments(tmp_path: Path) -> None:
    """Of the command on the real cell. The file that was there always opens; the end is the same."""
    rng, out = random.Random(1), tmp_path / "out.h5"
    command = [str(Path(sys.executable).with_name("apc")), "build-roadmap", "--nearest", "3"]
    command += ["-o", str(out), "--overwrite"]
    subprocess.run([*command, "--jobs", "1"], check=True, capture_output=True)
    good, n_kept = _sha(out), 0
    for _ in range(12):
        building = subprocess.Popen(
            [*command, "--jobs", "2"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        time.sleep(rng.uniform(0.2, 3.0))
        building.kill()
        building.wait()
        assert len(read_roadmap(out).names) > 0 and _sha(out) == good
        n_records = sum(path.read_bytes().count(b"APCTASK\n") for path in tmp_path.glob("*.journal"))
        assert n_records >= n_kept or not n_records  # none: it was done, and began again
        n_kept = n_records
    subprocess.run(command, check=True, capture_output=True)
    assert _sha(out) == good
    assert list(tmp_path.iterdir()) == [out]


def _killed_when(process: subprocess.Popen[bytes], is_time: Callable[[], bool]) -> None:
    while not is_time():
        assert process.poll() is None, "the build ended before it was killed"
        time.sleep(0.001)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()


def _sha(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
