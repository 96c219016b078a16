"""Making a cell: everything that can be found out is, and what cannot is listed."""

from __future__ import annotations

import json
import logging
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.robots.planning_group import stripped
from pickcli.cell.robots.srdf import Srdf, read_srdf
from pickcli.cell.robots.urdf import Urdf, read_urdf
from pickcli.cell.schemas.cell_schema import CellModel
from pickcli.cell.schemas.joint_limits_file import read_joint_limits, refuse_unknown_joints
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError, UnknownNameError, shortened
from pickcli.files import file_warnings
from pickcli.files.schema import MAX_TEXT
from pickcli.files.yaml_reader import Source
from pickcli.geometry import Array
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.reachability.mount_ranking import reach_ball
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.robot_setup.cell_text import SCHEMA, CellText, JointPosture
from pickcli.robot_setup.chain_selection import PlannedChain, choose_chain
from pickcli.robot_setup.collision_sampling import CollisionCount, CollisionFrequency, count_collisions
from pickcli.robot_setup.package_search import PackageSearch
from pickcli.robot_setup.place_search import PlaceSearch
from pickcli.robot_setup.robot_files import RobotFiles, find_robot_files
from pickcli.robot_setup.stated_limits import (
    StatedLimits,
    limits_of_urdf,
    with_figure,
    without_those_of_file,
)
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
from pickcli.robot_setup.suggested_tool import TOOL_URDF, SuggestedTool, suggest_tool

URDF, SRDF, LIMITS, CELL = "robot.urdf", "robot.srdf", "joint_limits.yaml", "cell.yaml"
_log = logging.getLogger(__name__)

STEPS = 4  # that are told of as progress, without those for each place
STAND_IN = 1.0  # of limits that are missing, while nothing but the robot's shape is looked at


@dataclass(frozen=True)
class StatedLimit:
    """A limit that whoever makes a cell states.

    Attributes:
        kind: "velocity", "acceleration", "jerk" or "effort".
        joint: Whose it is; None for every planned joint that has none.
        value: In rad or m per s, s2 or s3; of an effort N or Nm.
    """

    kind: str
    joint: str | None
    value: float


@dataclass(frozen=True)
class SetupOptions:
    """What a cell is to be made from.

    Attributes:
        urdf: A URDF or xacro file.
        srdf: An SRDF file, if there is one.
        group: Name of the SRDF group that is to be planned.
        tip: Name of the link at the end of what is to be planned.
        without: Names of links that are not there, with all that hangs on them.
        package_path: Folders in which packages are looked for first.
        packages: Folders of packages by name.
        arguments: Of a xacro, by name.
        joint_limits: A ROS ``joint_limits.yaml``.
        figures: Limits that are stated on top of these.
        accepts_unshaped: Whether links without a collision shape may stay untested.
        tool: Kind of the tool, "suction" or "gripper"; None where nothing is to be mounted.
        tool_figures: What is stated of it, by the keys of a cell file.
        places: What is to hold items.
        seed: Of all samples.
    """

    urdf: Path
    srdf: Path | None = None
    group: str | None = None
    tip: str | None = None
    without: Sequence[str] = ()
    package_path: Sequence[Path] = ()
    packages: Mapping[str, Path] = field(default_factory=dict)
    arguments: Mapping[str, str] = field(default_factory=dict)
    joint_limits: Path | None = None
    figures: Sequence[StatedLimit] = ()
    accepts_unshaped: bool = False
    tool: str | None = None
    tool_figures: Mapping[str, float] = field(default_factory=dict)
    places: Sequence[SuggestedPlace] = ()
    seed: int = 0


@dataclass(frozen=True, eq=False)
class CellSetup:
    """A cell that was made.

    Attributes:
        folder: Where it lies.
        draft: What stands in it.
        cell: The cell itself; where something is left to fill in with stand-ins for limits.
        collisions: How often links meet.
        notes: What the SRDF says that could not be used.
        left: What only its owner can fill in.
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
        """Number of pairs of links whose spheres meet always, sometimes and never."""
        return {how: sum(pair.spheres is how for pair in self.collisions) for how in CollisionFrequency}


def set_up_cell(folder: Path, request: SetupOptions, on_progress: ProgressObserver = nobody) -> CellSetup:
    """Make the folder of a new cell. It is there whole, in the end, or not at all.

    Args:
        folder: Where; nothing may be there.
        request: What it is made from.
        on_progress: Told of each step.

    Returns:
        The cell.

    Raises:
        InputError: With every mistake in the files, or with the list of what could be meant.
    """
    if folder.exists():
        raise InputError(f"{folder}: exists already; name another folder, or remove this one first")
    if not folder.parent.is_dir():
        raise InputError(f"{folder}: the folder {folder.parent} does not exist; make it first")
    with _staging(folder, request) as staging:
        with _unheard():
            made = _made(staging, folder, request, on_progress)
        staging.rename(folder)
    for line in made.cell.warnings:
        _log.warning("%s", line.replace(str(staging), str(folder)))
    return replace(made, cell=replace(made.cell, path=folder))


@contextmanager
def _unheard() -> Iterator[None]:
    """No warnings of cells that are not finished: the finished one is warned of in the end."""
    log = logging.getLogger(file_warnings.__name__)
    log.disabled = True
    try:
        yield
    finally:
        log.disabled = False


@contextmanager
def _staging(folder: Path, request: SetupOptions) -> Iterator[Path]:
    """A folder beside the final one; messages that name it are made to name that one or the given files."""
    staging = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    staging.chmod(0o755)
    try:
        yield staging
    except InputError as error:
        told = str(error).replace(str(staging / URDF), str(request.urdf))
        told = told.replace(str(staging / LIMITS), str(request.joint_limits))
        raise InputError(told.replace(str(staging), str(folder))) from None
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _made(staging: Path, folder: Path, request: SetupOptions, on_progress: ProgressObserver) -> CellSetup:
    """Everything in its folder."""
    on_progress(Progress(0, STEPS, "reading the robot"))
    with tempfile.TemporaryDirectory() as scratch:
        packages = PackageSearch(request.urdf, request.package_path, request.packages)
        files = find_robot_files(request.urdf, packages, request.arguments, Path(scratch))
    _copy(files, staging)
    roots = {name: staging / path for name, path in files.packages.items()}
    whole = read_urdf(staging / URDF, staging, roots)
    _refuse_long_names(whole, staging / URDF)
    limits = _limits(request.joint_limits, whole, staging)
    robot = _without(whole, request.without)
    srdf = _srdf(request.srdf, robot, staging)
    draft = _draft(folder, request, files, robot, srdf, limits, staging)
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
    draft, notes = _with_configurations(draft, srdf, cell, places, request.seed)
    home = next((np.array(each.q) for each in draft.configurations if each.name == HOME), None)
    waiting, left = choose_at_places(cell, ranked, home, request.seed)
    unreached += left
    draft = replace(draft, configurations=(*draft.configurations, *waiting))
    cell = replace(_probed(staging, draft), warnings=())
    (staging / CELL).write_text(draft.text())
    blank = tuple(draft.left())
    if not blank:
        cell = load_cell(staging)
    notes += [draft.tool.note] if draft.tool is not None and draft.tool.note else []
    notes += [
        f"{pair.a} and {pair.b} are allowed or nothing could be planned, but their shapes do collide in some "
        "configurations; smaller collision shapes in the URDF would tell these apart"
        for pair in collisions
        if pair.is_doubtful
    ]
    return CellSetup(
        folder, draft, cell, tuple(collisions), tuple(notes), (*blank, *unreached), len(files.meshes)
    )


def _with_place(
    draft: CellText, place: SuggestedPlace, srdf: Srdf | None, staging: Path, seed: int
) -> CellText:
    """The draft with a place where the arm reaches best into it. InputError if it reaches nothing."""
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
    told = f"found: {found.share:.0%} of {found.n_poses} tool poses in it and before it are reached"
    return replace(draft, places=(*draft.places, place.at(found.T_world_carrier, told)))


def _with_configurations(
    draft: CellText, srdf: Srdf | None, cell: Cell, places: Sequence[Array], seed: int
) -> tuple[CellText, list[str]]:
    """The draft with named configurations, and what of the SRDF's states is none, or that none was found."""
    empty = checker(CollisionModel(cell), cell.robot.tool.default_state, PayloadClass.EMPTY)
    known, notes = ([], []) if srdf is None else states_of_srdf(srdf, cell, empty)
    found = suggest(cell, empty, known, seed, places)
    if not known and not found:
        met = empty.explain(samples(cell, seed)[0])
        notes.append(f"none of {N_CANDIDATES} sampled configurations is free, e.g. {met}")
    return replace(draft, configurations=(*known, *found)), notes


def _without(robot: Urdf, links: Sequence[str]) -> Urdf:
    """The robot without some links. Raises UnknownNameError for one that it does not have."""
    hanging = [name for name in robot.links if name != robot.root]
    for link in links:
        if link not in hanging:
            raise UnknownNameError("link", link, hanging, "--without")
    return stripped(robot, links)


def _copy(files: RobotFiles, staging: Path) -> None:
    (staging / URDF).write_text(files.urdf)
    schema = {"$schema": "http://json-schema.org/draft-07/schema#", **CellModel.model_json_schema()}
    (staging / SCHEMA).write_text(json.dumps(schema, indent=1) + "\n")
    for target, path in files.meshes.items():
        (staging / target).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, staging / target)


def _srdf(path: Path | None, robot: Urdf, staging: Path) -> Srdf | None:
    """The SRDF, copied. Raises InputError for one of another robot."""
    if path is None:
        return None
    srdf = read_srdf(path)
    named = {name for pair in srdf.disabled for name in (pair.a, pair.b)}
    named |= {name for state in srdf.states for name in state.positions}
    named |= {name for group in srdf.groups.values() for name in (*group.joints, *group.links)}
    named |= {name for group in srdf.groups.values() for chain in group.chains for name in chain}
    if named and not named & {*robot.links, *(joint.name for joint in robot.joints.values())}:
        raise InputError(
            f"{path}: names no link or joint of the robot {robot.name!r}, e.g. {min(named)!r}; is it the "
            "SRDF of another one?"
        )
    shutil.copyfile(path, staging / SRDF)
    return srdf


def _refuse_long_names(robot: Urdf, urdf: Path) -> None:
    """Refuse names that no cell file may hold. Raises InputError."""
    for name in (*robot.links, *(joint.name for joint in robot.joints.values())):
        if len(name) > MAX_TEXT:
            told = f"has {len(name)} characters, a cell takes {MAX_TEXT}; rename it"
            raise InputError(f"{urdf}: the name {shortened(name)!r} {told}")


def _limits(path: Path | None, whole: Urdf, staging: Path) -> Source | None:
    """The file of limits, copied. Raises InputError for a mistake in it."""
    if path is None:
        return None
    limits = read_joint_limits(path)
    refuse_unknown_joints(limits, [joint.name for joint in whole.joints.values()])
    shutil.copyfile(path, staging / LIMITS)
    return limits


def _draft(
    folder: Path, request: SetupOptions, files: RobotFiles, robot: Urdf, srdf: Srdf | None,
    file: Source | None, staging: Path,
) -> CellText:  # fmt: skip
    """All but pairs and configurations, for which the robot has to stand."""
    chain = choose_chain(robot, srdf, request.group, request.tip)
    tool = _tool(request, robot, chain, staging)
    limits = limits_of_urdf(robot, staging / URDF, chain.joints)
    if file is not None:
        limits = without_those_of_file(limits, file)
    for figure in request.figures:
        limits = with_figure(limits, figure.kind, figure.joint, figure.value)
    return CellText(
        name=_cell_name(folder),
        source=request.urdf.name,
        srdf=None if srdf is None else SRDF,
        packages=files.packages,
        without=tuple(request.without),
        chain=chain,
        standing=tuple(_standing(robot, srdf, chain, () if tool is None else tool.joints)),
        unshaped=_unshaped(robot, chain, None if tool is None else tool.flange),
        accepts_unshaped=request.accepts_unshaped,
        limits=limits,
        limits_file=None if file is None else LIMITS,
        tool=tool,
    )


def _tool(request: SetupOptions, robot: Urdf, chain: PlannedChain, staging: Path) -> SuggestedTool | None:
    """What is mounted, its URDF written. Raises InputError where there is no such tool."""
    if request.tool is None:
        if request.tool_figures:
            raise InputError(
                f"{next(iter(request.tool_figures))} is of a tool; add --tool suction or gripper"
            )
        _refuse_middle(robot, chain)
        return None
    tool = suggest_tool(request.tool, robot, chain).with_figures(request.tool_figures)
    if tool.urdf is not None:
        (staging / TOOL_URDF).write_text(tool.urdf)
    return tool


def _refuse_middle(robot: Urdf, chain: PlannedChain) -> None:
    """Refuse a tip that something with a shape hangs on: a bare arm ends there. Raises InputError."""
    hanging = [
        link
        for link in robot.links
        if robot.links[link].shapes and chain.tip in {joint.parent for joint in robot.way(link)}
    ]
    if hanging:
        first = next(joint.child for joint in robot.way(hanging[0]) if joint.parent == chain.tip)
        free = [f"--tip {link}" for link in chain.other_tips if not robot.children(link)]
        raise InputError(
            f"{first} hangs on {chain.tip}, and an arm ends with its tip; add "
            f"{' or '.join([*free, '--tool gripper', '--tool suction'])}, or leave it out with --without "
            f"{first}"
        )


def _cell_name(folder: Path) -> str:
    plain = re.sub(r"\W", "_", folder.name, flags=re.ASCII)
    return plain if re.match("[A-Za-z]", plain) else f"cell_{plain}"


def _standing(
    robot: Urdf, srdf: Srdf | None, chain: PlannedChain, of_tool: Sequence[str]
) -> Iterator[JointPosture]:
    """Where the joints stand that are not planned: as a state of the SRDF says, else at 0 or next to it."""
    for name, joint in robot.driven(robot.joints.values()).items():
        if name in chain.joints or name in of_tool:
            continue
        states = [] if srdf is None else [s for s in srdf.states if name in s.positions]
        state = next((s for s in states if joint.lower <= s.positions[name] <= joint.upper), None)
        if state is not None:
            yield JointPosture(name, state.positions[name], f"state {state.name} of the SRDF")
        else:
            yield JointPosture(name, float(np.clip(0.0, joint.lower, joint.upper)), "as near to 0 as it goes")


def _unshaped(robot: Urdf, chain: PlannedChain, flange: str | None) -> tuple[str, ...]:
    """Links of which nothing would be tested: drawn without a shape, or alone on their joint without one.

    The tool has shapes, and moves with its flange.
    """
    found = list(robot.unshaped)
    moved: dict[str, list[str]] = {}
    for link in robot.links:
        movers = [joint.name for joint in robot.way(link) if joint.name in chain.joints]
        if movers:
            moved.setdefault(movers[-1], []).append(link)
    for links in moved.values():
        is_shaped = flange in links or any(robot.links[link].shapes for link in links)
        if not is_shaped and not set(links) & set(found):
            found.append(links[0])
    return tuple(found)


def _probed(staging: Path, draft: CellText) -> Cell:
    """The cell as far as its shape goes, with stand-ins for limits that are missing."""
    limits = {name: _stood_in(each) for name, each in draft.limits.items()}
    tool = None if draft.tool is None else draft.tool.stood_in(STAND_IN)
    (staging / CELL).write_text(replace(draft, limits=limits, tool=tool, accepts_unshaped=True).text())
    return load_cell(staging)


def _stood_in(limits: StatedLimits) -> StatedLimits:
    values: dict[str, float | None] = {kind: value or STAND_IN for kind, value in limits.values.items()}
    return replace(limits, effort=limits.effort or STAND_IN, values=values, sources=dict.fromkeys(values, ""))
