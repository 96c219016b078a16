"""Creates a cell: derives everything that can be derived, and lists what the owner must fill in."""

from __future__ import annotations

import logging
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import cell_names, load_cell
from pickcli.cell.robots.srdf import Srdf
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError
from pickcli.files import file_warnings
from pickcli.geometry import Array
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.reachability.tool_reachability import reach_ball
from pickcli.reachability.untested_pairs import UntestedPair, overlap_note, untested_pairs
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.robot_setup.cell_text import CellText
from pickcli.robot_setup.chain_selection import mimicked_joints
from pickcli.robot_setup.collision_sampling import CollisionCount, CollisionFrequency, count_collisions
from pickcli.robot_setup.place_search import PlaceSearch
from pickcli.robot_setup.robot_reading import read_robot
from pickcli.robot_setup.setup_options import CELL, LIMITS, URDF, SetupOptions
from pickcli.robot_setup.stated_limits import StatedLimits
from pickcli.robot_setup.stated_text import stated_text
from pickcli.robot_setup.suggested_configurations import (
    HOME,
    N_CANDIDATES,
    choose_at_places,
    rank_at_places,
    samples,
    states_of_srdf,
    suggest,
)
from pickcli.robot_setup.suggested_places import OPTION, SuggestedPlace

_log = logging.getLogger(__name__)

STEPS = 4  # number of reported steps, without one for each place
STAND_IN = 1.0  # placeholder for missing limits, while only the robot's geometry is used


@dataclass(frozen=True, eq=False)
class CellSetup:
    """A created cell.

    Attributes:
        folder: Its folder.
        draft: Content of the cell file.
        cell: The cell; with placeholders for limits if something is left to fill in.
        collisions: Collision counts of link pairs.
        notes: Parts of the SRDF that could not be used, and other remarks.
        left: What only the owner can fill in.
        meshes: Number of mesh files.
    """

    folder: Path
    draft: CellText
    cell: Cell
    collisions: tuple[CollisionCount, ...]
    notes: tuple[str, ...]
    left: tuple[str, ...]
    meshes: int

    @property
    def n_pairs(self) -> dict[CollisionFrequency, int]:
        """Number of link pairs whose spheres collide always, sometimes and never."""
        return {how: sum(pair.spheres is how for pair in self.collisions) for how in CollisionFrequency}


def set_up_cell(folder: Path, request: SetupOptions, on_progress: ProgressObserver = nobody) -> CellSetup:
    """Create the folder of a new cell, atomically.

    Args:
        folder: Path of the new folder; must not exist.
        request: Options of the setup.
        on_progress: Called at each step.

    Returns:
        The cell.

    Raises:
        InputError: With every mistake in the files, or with a list of alternatives for an ambiguous option.
    """
    if os.path.lexists(folder):  # also a broken link
        raise InputError(f"{folder}: exists already; name another folder, or remove this one first")
    if folder.name in cell_names():
        raise InputError(
            f"{folder}: {folder.name} is a cell of this package, and scenes go by names; choose another one"
        )
    if not folder.parent.is_dir():
        raise InputError(f"{folder}: the folder {folder.parent} does not exist; make it first")
    try:
        with _staging(folder, request) as staging:
            with _unheard():
                made = _make(staging, folder, request, on_progress)
            staging.rename(folder)
    except OSError as error:  # a full disk, or another command created the folder
        raise InputError(f"{folder}: cannot be made: {error.strerror}; nothing was left") from None
    for line in made.cell.warnings:
        _log.warning("%s", line.replace(str(staging), str(folder)))
    return replace(made, cell=replace(made.cell, path=folder))


@contextmanager
def _unheard() -> Iterator[None]:
    """Suppress warnings about the unfinished cell; the finished one is checked at the end."""
    log = logging.getLogger(file_warnings.__name__)
    log.disabled = True
    try:
        yield
    finally:
        log.disabled = False


@contextmanager
def _staging(folder: Path, request: SetupOptions) -> Iterator[Path]:
    """A temporary folder beside the final one; messages refer to the final one or the given files instead."""
    staging = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    staging.chmod(0o755)
    try:
        yield staging
    except InputError as error:
        message = str(error).replace(str(staging / URDF), str(request.urdf))
        message = message.replace(str(staging / LIMITS), str(request.joint_limits))
        raise InputError(message.replace(str(staging), str(folder))) from None
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _make(staging: Path, folder: Path, request: SetupOptions, on_progress: ProgressObserver) -> CellSetup:
    """Create everything in the folder."""
    on_progress(Progress(0, STEPS, "reading the robot"))
    source = read_robot(request, staging)
    draft, srdf = stated_text(folder, request, source, staging), source.srdf
    steps = STEPS + len(request.places)
    on_progress(Progress(1, steps, "sampling which links collide"))
    collisions = count_collisions(_probed(staging, draft), request.seed)
    draft = replace(draft, pairs=tuple(pair.allowed for pair in collisions if pair.allowed is not None))
    for k, place in enumerate(request.places):
        on_progress(Progress(2 + k, steps, f"looking where {place.name} stands best"))
        draft = _with_place(draft, place, srdf, staging, request.seed)
    on_progress(Progress(steps - 2, steps, "looking for configurations at the places"))
    cell = _probed(staging, draft)
    ranked, unreached = rank_at_places(cell, request.seed)
    on_progress(Progress(steps - 1, steps, "looking for configurations"))
    places = [np.stack([each.configuration.q for each in found]) for found in ranked.values()]
    draft, notes, unparked = _with_configurations(draft, srdf, cell, places, request.seed)
    home = next((np.array(each.q) for each in draft.configurations if each.name == HOME), None)
    waiting, left = choose_at_places(cell, ranked, home, request.seed)
    unreached += [*left, *unparked]
    draft = replace(draft, configurations=(*draft.configurations, *waiting))
    cell = replace(_probed(staging, draft), warnings=())
    (staging / CELL).write_text(draft.text())
    blank = tuple(draft.left())
    if not blank:
        cell = load_cell(staging)
    notes += [
        f"{name} moves the arm and stands all the same: joints that others mimic ({', '.join(followers)}) "
        "cannot be planned; to plan it, leave out with --without what these move"
        for name, followers in mimicked_joints(source.robot, draft.chain.tip).items()
    ]
    notes += [draft.tool.note] if draft.tool is not None and draft.tool.note else []
    untested = untested_pairs(cell, request.seed)
    notes += [_located(each) for each in untested if each.is_sometimes]
    overlap = overlap_note(untested)
    notes += [] if overlap is None else [overlap]
    return CellSetup(
        folder, draft, cell, tuple(collisions), tuple(notes), (*blank, *unreached), len(source.files.meshes)
    )


def _located(found: UntestedPair) -> str:
    """Return the text about a pair that is never tested, with the line of the SRDF that disables it."""
    srdf = found.pair.srdf
    return found.text if srdf is None else f"{srdf[0].name}:{srdf[1]}: {found.text}"


def _with_place(
    draft: CellText, place: SuggestedPlace, srdf: Srdf | None, staging: Path, seed: int
) -> CellText:
    """Add a place to the draft at the pose best reached by the arm. InputError if it reaches none."""
    cell = _probed(staging, replace(draft, places=(*draft.places, place)))
    without = _probed(staging, draft)
    empty = checker(CollisionModel(without), without.robot.tool.default_state, PayloadClass.EMPTY)
    states = [] if srdf is None else states_of_srdf(srdf, without, empty)[0]
    keeps_free = np.array([state.q for state in states]).reshape(-1, without.robot.n_joints)
    found = PlaceSearch(cell, cell.carriers[place.name], place.level, keeps_free, seed).best()
    if not found.share:
        _, radius = reach_ball(cell.robot)
        raise InputError(
            f"{OPTION} {place.name}={place.kind}: the arm takes none of {found.n_poses} tool poses in it, "
            f"from any of {found.n_tried} poses around it (it reaches {radius:.2f} m at most); leave it out, "
            "and write a place of another size, or elsewhere, into cell.yaml"
        )
    comment = f"found: {found.share:.0%} of {found.n_poses} tool poses in it and before it are reached"
    return replace(draft, places=(*draft.places, place.at(found.T_world_carrier, comment)))


def _with_configurations(
    draft: CellText, srdf: Srdf | None, cell: Cell, places: Sequence[Array], seed: int
) -> tuple[CellText, list[str], list[str]]:
    """Add named configurations to the draft.

    Also returns notes on omitted ones, or if none was found, and advice if the arm is parked nowhere.
    """
    empty = checker(CollisionModel(cell), cell.robot.tool.default_state, PayloadClass.EMPTY)
    known, notes = ([], []) if srdf is None else states_of_srdf(srdf, cell, empty)
    found, unparked = suggest(cell, empty, known, seed, places)
    if not known and not found:
        met = empty.explain(samples(cell, seed)[0])
        notes.append(f"none of {N_CANDIDATES} sampled configurations is free, e.g. {met}")
    return replace(draft, configurations=(*known, *found)), notes, unparked


def _probed(staging: Path, draft: CellText) -> Cell:
    """Load the draft with placeholders for missing limits, for its geometry."""
    limits = {name: _stood_in(each) for name, each in draft.limits.items()}
    tool = None if draft.tool is None else draft.tool.stood_in(STAND_IN)
    (staging / CELL).write_text(replace(draft, limits=limits, tool=tool, accepts_unshaped=True).text())
    return load_cell(staging)


def _stood_in(limits: StatedLimits) -> StatedLimits:
    values: dict[str, float | None] = {kind: value or STAND_IN for kind, value in limits.values.items()}
    return replace(limits, effort=limits.effort or STAND_IN, values=values, sources=dict.fromkeys(values, ""))
