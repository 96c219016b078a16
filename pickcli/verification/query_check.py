"""Check that a plan's query, which messages and records repeat, says what its motion does."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from pickcli.cell.station import TOTE
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.verification.contact_exemptions import releases
from pickcli.verification.push_check import pushed_by
from pickcli.verification.static_solids import place_at, release_pose
from pickcli.verification.topple_check import is_toppling

ITEM_VERBS = ("pick", "shift", "stow", "topple", "push")  # first words of queries that move an item
_INTO = re.compile(r" into (?P<place>\S+)(?: at \S+ mm and \S+ deg)?")
_BY = re.compile(r" by \S+ mm(?: and \S+ deg)?")
_MOVE = re.compile(r"move from (?P<start>\S+) to (?P<end>\S+)")
_SAME = 1e-6  # rad and m by which the ends of a move may differ from the configurations that it names


def check_query(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check the kind of a query, and the item and the place that it names.

    A pick, a shift, or a push of the empty tool is called so, with the item and the place of the motion; all
    other motions are called what one likes, but none of these. If a move names configurations of the cell,
    it leads from the one to the other. Ids may have blanks: the query is compared, not split.

    Args:
        plan: The plan.
        scene: Its scene.

    Yields:
        The faults.
    """
    if plan.grasp is not None and plan.recovery is None and scene.held is None:
        yield from _picks(plan, scene)
    elif is_toppling(plan):
        yield from _pushes(plan, scene)
    elif plan.query.split(" ")[0].casefold() in ITEM_VERBS and plan.grasp is None:
        yield _wrong(plan, "the motion takes and pushes no item")
    else:
        yield from _moves(plan, scene)


def check_destination(plan: Plan, scene: Scene, T_tip_item: Array | None) -> Iterator[Reason]:
    """Check that an item that is picked is let go in the place that the query names, else in the tote.

    Args:
        plan: The plan.
        scene: Its scene.
        T_tip_item: (4, 4) pose of the item in the tool frame, if one is held.

    Yields:
        The faults; none for plans that are no picks.
    """
    placed = _taken(plan, scene)
    if placed is None or plan.recovery is not None or T_tip_item is None:
        return
    called = _pick_of(placed)
    if not plan.query.startswith(called):
        return
    found = _INTO.fullmatch(plan.query[len(called) :])
    stated = TOTE if found is None else found["place"]
    for k in releases(plan):
        place = place_at(scene, release_pose(plan, scene, k, T_tip_item))
        if place is not None and place.name != stated:
            yield _wrong(plan, f"the motion lets {placed.id} go in {place.name}")


def _taken(plan: Plan, scene: Scene) -> PlacedItem | None:
    """Return the item in its place that the plan takes."""
    if plan.grasp is None or scene.held is not None:
        return None
    return next((placed for placed in scene.items if placed.id == plan.grasp.item), None)


def _pick_of(placed: PlacedItem) -> str:
    return f"pick {placed.id} from {placed.location}"


def _picks(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check the query of a motion that takes an item."""
    if (placed := _taken(plan, scene)) is None:
        return  # reported as unknown
    pick, shift = _pick_of(placed), f"shift {placed.id} in {placed.location}"
    for called, ending in ((pick, _INTO), (shift, _BY)):
        if plan.query.startswith(called) and ending.fullmatch(plan.query[len(called) :]):
            return
    if plan.query != pick:
        yield _wrong(plan, f"the motion picks {placed.id} from {placed.location}")


def _pushes(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check the query of a motion of which the empty tool pushes items."""
    pushed = [placed for placed in scene.items if placed.id in pushed_by(plan)]
    called = [f"topple {each.id} in {each.location}" for each in pushed]
    called += [f"push {each.id} off others in {each.location}" for each in pushed]
    if pushed and plan.query not in called:
        yield _wrong(plan, f"the motion pushes {', '.join(f'{p.id} in {p.location}' for p in pushed[:3])}")


def _moves(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check the ends of a move between configurations of the cell."""
    if (found := _MOVE.fullmatch(plan.query)) is None:
        return
    robot, positions = scene.cell.robot, plan.trajectory.positions
    for at, q in (("start", positions[0]), ("end", positions[-1])):
        named = scene.cell.configurations.get(found[at])
        if named is None:
            continue
        off = q - named.q
        off = np.where(robot.limits.is_continuous, np.angle(np.exp(1j * off)), off)
        if np.abs(off).max() > _SAME:
            yield _wrong(plan, f"the {at} of the motion is not {found[at]}")


def _wrong(plan: Plan, motion: str) -> Reason:
    return Reason("wrong query", "query", f"{plan.query!r}, but {motion}")
