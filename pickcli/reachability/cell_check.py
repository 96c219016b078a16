"""Checks of a cell that can be read: whether configurations are free, and places within reach."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.cell import AllowedPair, Cell
from pickcli.cell.checks.arm_consistency import source_of_arm
from pickcli.cell.checks.inertial_plausibility import warn_of_masses
from pickcli.cell.shapes import Body
from pickcli.cell.station import NO_POD, Obstacles
from pickcli.cell.workcell import Workcell
from pickcli.collision.robot_model import CollisionModel
from pickcli.files.file_kind import CELL
from pickcli.files.file_warnings import ACCEPTED, FEW, FileWarnings
from pickcli.files.source import Key, Source, name_of
from pickcli.files.yaml_reader import read_yaml
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.arm_dynamics import ArmDynamics
from pickcli.planning.assembly.proven_timing import MOTOR_SHARE
from pickcli.precompute.empty_cell_checkers import checker, why_not_free
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.reachability.belt_reachability import HEIGHTS, SPACING, reached_travel
from pickcli.reachability.place_reachability import N_POSES, PlaceReachability, ReachabilityCheck
from pickcli.reachability.untested_pairs import UntestedPair, overlap_note, untested_pairs_of_arms
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.scene.scene import TOTE

MIN_REACHED_SHARE = 0.5  # share of the tool poses in a place, below which it counts as out of reach
ENOUGH_IN_LINE = 0.25  # share of them below which its configuration counts as poor
YARDSTICK = "yardstick"  # kind of configurations that are not goals of motions


@dataclass(frozen=True, eq=False)
class CellCheck:
    """Result of the check of a cell.

    Attributes:
        cell: The cell, as its preferred arm sees it.
        mistakes: Lines about faults that cannot be intended.
        warnings: Lines about probable faults, those about its values first.
        notes: Lines about what is not tested by design.
        reaches: Reachability of each place by each arm.
        n_free: Number of free configurations.
    """

    cell: Cell
    mistakes: tuple[str, ...]
    warnings: tuple[str, ...]
    notes: tuple[str, ...]
    reaches: tuple[PlaceReachability, ...]
    n_free: int


def check_cell(
    workcell: Workcell, n_poses: int = N_POSES, seed: int = 0, on_progress: ProgressObserver = nobody
) -> CellCheck:
    """Check a cell.

    Args:
        workcell: The cell.
        n_poses: Tool poses by which each place is judged.
        seed: Seed of the poses, and of the configurations in which allowed pairs are measured.
        on_progress: Observer of the progress, called for each place.

    Returns:
        The result.
    """
    whole = read_yaml(workcell.preferred.path / "cell.yaml", CELL)
    mistakes, warnings, n_free = list[str](), list[str](), 0
    reaches: list[PlaceReachability] = []
    met: set[str] = set()  # accepted warnings that would have been given
    for arm, cell in workcell.arms.items():
        source = source_of_arm(whole, arm) if arm else whole
        noted = FileWarnings.of(source)
        blocked = why_not_free(cell)
        meant = [named.name for named in cell.configurations.values() if named.kind != YARDSTICK]
        not_free = {name: blocked[name] for name in meant if name in blocked}
        n_free += len(meant) - len(not_free)
        mistakes += _mistakes(source, cell, not_free)
        warn_of_masses(noted, cell)
        _warn_of_motors(noted, cell)
        _warn_of_pairs(noted, cell, not_free)
        reached = tuple(_reaches(cell, n_poses, seed, on_progress))
        _warn_of_configurations(noted, cell, reached)
        reaches += reached
        warnings += [*cell.warnings, *noted.lines]
        met |= cell.accepted | noted.met
    noted, untested = FileWarnings.of(whole), untested_pairs_of_arms(workcell, seed)
    _warn_of_windows(noted, list(workcell.arms.values()))
    _warn_of_untested(noted, workcell.preferred, untested)
    warnings += noted.lines
    met |= noted.met
    note = overlap_note(untested)
    if reaches and not any(each.share for each in reaches):
        mistakes.append(_out_of_reach(whole, len({each.place for each in reaches})))
    elif reaches:
        noted = FileWarnings.of(whole)
        _warn_of_reach(noted, workcell.preferred, reaches)
        warnings += noted.lines
        met |= noted.met
    if not mistakes:
        warnings += _needless(whole, met)
    lines = tuple(dict.fromkeys(warnings))
    notes = () if note is None else (note,)
    return CellCheck(workcell.preferred, tuple(mistakes), lines, notes, tuple(reaches), n_free)


def _needless(source: Source, met: Collection[str]) -> list[str]:
    """Return warnings about accepted warnings that nothing gives, e.g. of a misspelt subject."""
    noted = FileWarnings.of(source)
    for i, name in enumerate(source.data.get(ACCEPTED, ())):
        if name not in met and not name.startswith("needless_acceptance"):
            text = f"{name} is not given, so that there is nothing to accept; delete it, or correct its name"
            noted.add("needless_acceptance", name, (ACCEPTED, i), text)
    return noted.lines


def _mistakes(source: Source, cell: Cell, not_free: dict[str, str]) -> Iterator[str]:
    """Yield the configurations that are not free; of many only the first, because they have one cause."""
    reported = list(not_free.items())[: None if len(not_free) <= FEW else 1]
    names = list(cell.configurations)
    for name, why in reported:
        key: Key = source.stated(("configurations", names.index(name), "q"))
        of_arm = f" of arm {cell.arm}" if cell.arm else ""
        _, line, column = source.place(key)
        text = f"{source.path}:{line}:{column}: {name_of(key)}: {name}{of_arm} is not free, {why}"
        if len(not_free) > len(reported):
            text += (
                f", and {len(not_free) - 1} more configurations are not; look at T_world_base, T_world_pod "
                "and the obstacles"
            )
        else:
            text += "; move it, or what it meets"
        yield text


def _out_of_reach(source: Source, n_places: int) -> str:
    """Return the mistake of a cell whose arm reaches nothing."""
    _, line, column = source.place(("robot", "T_world_base"))
    return (
        f"{source.path}:{line}:{column}: robot.T_world_base: the arm reaches none of the {n_places} places; "
        "turn or move its base, or the places, until it stands before them (x, y, z in m, roll, pitch, yaw "
        "in rad)"
    )


def _reaches(
    cell: Cell, n_poses: int, seed: int, on_progress: ProgressObserver
) -> Iterator[PlaceReachability]:
    if cell.robot.tool.is_bare:
        return
    survey = ReachabilityCheck(cell, cell.robot.tool.default_state, n_poses, seed)
    for i, place in enumerate(cell.places.values()):
        on_progress(Progress(i, len(cell.places), f"reaching into {place.name}"))
        yield survey.judged(place)


def _warn_of_reach(warnings: FileWarnings, cell: Cell, reaches: Sequence[PlaceReachability]) -> None:
    """Warn of places that no arm reaches well."""
    far: dict[str, tuple[Key, str]] = {}
    for place in cell.places:
        each = max((r for r in reaches if r.place == place), key=lambda r: r.share)
        if not len(each.tips):
            text = f"the tool fits at no pose in {place}; correct the size of the place or of the tool"
            far[place] = (_key_of(cell, place), text)
        elif each.share < MIN_REACHED_SHARE:
            text = f"the arm reaches {each.share:.0%} of {len(each.tips)} tool poses in {place}"
            far[place] = (_key_of(cell, place), text)
    cause = "does the base stand before them, turned towards them?"
    warnings.add_alike("out_of_reach", far, ("robot", "T_world_base"), cause)


def _warn_of_configurations(warnings: FileWarnings, cell: Cell, reaches: Sequence[PlaceReachability]) -> None:
    """Warn of configurations from which little of the arm's reach can be reached in a line."""
    poor: dict[str, tuple[Key, str]] = {}
    names = list(cell.configurations)
    for each in reaches:
        if (
            each.share < MIN_REACHED_SHARE
            or each.share_in_line is None
            or each.share_in_line >= ENOUGH_IN_LINE
        ):
            continue
        key = ("configurations", names.index(each.configuration), "q")
        text = f"from {each.configuration} a straight line leads to {each.share_in_line:.0%} of the tool "
        text += f"poses in {each.place}; apc suggest-configurations finds a better one"
        poor[each.configuration] = (key, text)
    warnings.add_alike("poor_configuration", poor, ("configurations",), "are they those of this cell?")


def _warn_of_motors(warnings: FileWarnings, cell: Cell) -> None:
    """Warn of motors that do not bear the arm at rest in a named configuration, without a load."""
    robot = cell.robot
    arm, most = Arm(robot), np.array([robot.motor_forces[name] for name in robot.joint_names])
    worst: dict[str, tuple[float, str]] = {}
    for named in cell.configurations.values():
        q = np.asarray(named.q)[None]
        dynamics = ArmDynamics(arm, named.tool_state)
        needed = np.abs(dynamics.efforts(q, 0.0 * q, 0.0 * q))[0]
        for k in np.flatnonzero(needed > MOTOR_SHARE * most).tolist():
            name, effort = robot.joint_names[k], float(needed[k])
            if effort > worst.get(name, (0.0, ""))[0]:
                worst[name] = effort, f"in {named.name} {effort:.3g} {dynamics.units[k]}"
    weak: dict[str, tuple[Key, str]] = {
        name: (
            ("robot", "motor_forces", name),
            f"{needs} bear the arm at rest, over {MOTOR_SHARE:.0%} of its motor: no motion leads there; "
            "correct it, or the masses in the URDF",
        )
        for name, (_, needs) in worst.items()
    }
    warnings.add_alike(
        "weak_motor", weak, ("robot", "motor_forces"), "are the masses in the URDF in kg, not g?"
    )


def _warn_of_windows(warnings: FileWarnings, cells: Sequence[Cell]) -> None:
    """Warn of windows of conveyors in parts of which no arm, by its cell, reaches items from above."""
    for carrier in cells[0].own_carriers:
        if carrier.conveyor is None or any(cell.robot.tool.is_bare for cell in cells):
            continue
        first, last = carrier.conveyor.window
        found = (reached_travel(cell, carrier, HEIGHTS[0]) for cell in cells)
        reached = sorted(stretch for stretch in found if stretch is not None)
        covered = first
        for begin, end in reached:
            covered = max(covered, end + SPACING) if begin - SPACING <= covered else covered
        if covered >= last:
            continue
        where = " and ".join(f"from {begin:.2f} to {end:.2f} m" for begin, end in reached)
        where = f"{where} only" if reached else "nowhere"
        subject = "the arm reaches" if len(cells) == 1 else "the arms reach"
        text = (
            f"its window is {first:g} to {last:g} m, {subject} items of {1e3 * HEIGHTS[0]:.0f} mm over "
            f"the whole width {where}; correct the window, or move belt or base"
        )
        warnings.add("unreached_window", carrier.name, ("places", carrier.name, "window"), text)


def _key_of(cell: Cell, place: str) -> Key:
    """Return the key of a place in the file."""
    if place in cell.pod.bins:
        return ("pod",)
    own = (carrier.name for carrier in cell.own_carriers if place in carrier.places)
    return ("places", next(own)) if place != TOTE else ("tote",)


def _warn_of_pairs(warnings: FileWarnings, cell: Cell, not_free: dict[str, str]) -> None:
    """Warn of allowed pairs of a link and an obstacle that are apart somewhere: contacts are not tested."""
    obstacles = {body.name: body for body in cell.obstacles.bodies}
    for i, pair in enumerate(cell.allowed_pairs):
        body = obstacles.get(pair.b) or obstacles.get(pair.a)
        if body is not None and (name := _apart_in(cell, pair, body, not_free)):
            text = f"{pair.a} and {pair.b} are apart in {name}, and are never tested where they may meet; "
            subject = f"{pair.a}-{pair.b}"
            warnings.add("untested_pair", subject, ("allowed_pairs", i), f"{text}leave the pair out")


def _warn_of_untested(warnings: FileWarnings, cell: Cell, untested: Sequence[UntestedPair]) -> None:
    """Warn of allowed pairs of links that collide in some configurations, each by itself."""
    known = {each.names: each for each in untested if each.is_sometimes}
    for i, pair in enumerate(cell.allowed_pairs):
        found = known.pop(frozenset((pair.a, pair.b)), None)
        if found is not None:
            key: Key = ("allowed_pairs", i) if pair.srdf is None else ("disable_collisions",)
            if pair.srdf is not None:
                warnings.source.origins[key] = (*pair.srdf, 1)
            warnings.add("colliding_pair", f"{pair.a}-{pair.b}", key, found.text)


def _apart_in(cell: Cell, pair: AllowedPair, body: Body, not_free: dict[str, str]) -> str:
    """Return the first free configuration in which the robot is clear of an obstacle; "" without one."""
    alone = replace(
        cell,
        pod=NO_POD,
        tote=None,
        own_carriers=(),
        obstacles=Obstacles((body,)),
        allowed_pairs=tuple(each for each in cell.allowed_pairs if each is not pair),
    )
    model = CollisionModel(alone)
    by_state = {state: checker(model, state, PayloadClass.EMPTY) for state in cell.robot.tool.states}
    free = (each for each in cell.configurations.values() if each.name not in not_free)
    return next((each.name for each in free if by_state[each.tool_state].is_valid(each.q)), "")
