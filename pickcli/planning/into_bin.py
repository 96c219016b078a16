"""Setting an item down in a bin: a pick from there, backwards.

What leads to an item lying there and brings it out also brings it in and leads away from it, so the lines,
their proofs and the reasons for failures are those of a pick.
"""

from __future__ import annotations

from pickcli.cell.station import Bin
from pickcli.errors import Failures, Reason
from pickcli.motion.segment import SegmentKind
from pickcli.planning.bin_query import BinQuery
from pickcli.planning.landing import Landing, Step
from pickcli.planning.stages.bin_placements import bin_spots
from pickcli.planning.stages.grasp_motion import InBin, plan_in_bin
from pickcli.seeds import derived_rng

WANTED = 2  # landings among which the best whole motion is chosen
COST = 0.1  # s that the next best place is worth


def into_bin(query: BinQuery, chosen: InBin, cell_bin: Bin, seed: int) -> tuple[Landing, ...] | Failures:
    """Places on the floor of a bin whose lines are all proven, the best first; or every reason."""
    planner, target = query.planner, query.target
    spots = bin_spots(planner, query.scene, target, query.T_bin_item[:3, :3], cell_bin)
    if isinstance(spots, Reason):
        return Failures.of(spots)
    rng = derived_rng(seed, "set down", target.id, cell_bin.name)
    found: list[Landing] = []
    failures = Failures()
    for k, spot in enumerate(spots):
        there = BinQuery(planner, query.scene.moved(spot), cell_bin, spot, query.neighbours, seed)
        if there.contacts.beside:
            failures += _too_close(there, there.contacts.beside, f"place {k} in {cell_bin.name}")
            continue
        as_picked = plan_in_bin(there, chosen.grasp, rng)
        if isinstance(as_picked, Failures):
            failures += as_picked
            continue
        found.append(_landing(there, as_picked, COST * k))
        if len(found) >= WANTED:
            break
    return tuple(found) or failures


def _too_close(there: BinQuery, names: frozenset[str], where: str) -> Failures:
    """What else than the floor the item would touch where it is set down."""
    items = frozenset(placed.id for placed in there.scene.items)
    return Failures(
        tuple(Reason("too close", where, name, name if name in items else "") for name in sorted(names))
    )


def _landing(there: BinQuery, as_picked: InBin, cost: float) -> Landing:
    """The lines of a pick from there, each backwards."""
    planner, settings, kind = there.planner, there.planner.settings, SegmentKind
    tool_state, held, contacts = as_picked.grasp.tool_state, as_picked.held, there.contacts
    lowered, pressed = contacts.while_lifting(as_picked.press), contacts.while_pressing(as_picked.press)
    carrying = planner.checker(there.scene, tool_state, held, contacts.while_carrying())
    lowering = planner.checker(there.scene, tool_state, held, lowered)
    empty = planner.checker(there.scene, tool_state, contacts=contacts.while_approaching())
    meeting = planner.checker(there.scene, tool_state, contacts=pressed)
    inward = (
        *(
            Step(kind.INSERT, push.backwards(), carrying, settings.retreat_speed)
            for push in reversed(as_picked.retreat)
        ),
        Step(kind.PLACE, as_picked.lift.backwards(), carrying, settings.lift_speed),
        Step(kind.PLACE, as_picked.freed.backwards(), lowering, settings.lift_speed, lowered.names),
    )
    speed = settings.approach_speed
    away = (
        Step(kind.DEPART, as_picked.contact.backwards(), meeting, speed, pressed.names),
        Step(kind.DEPART, as_picked.approach.backwards(), empty, speed),
        Step(kind.DEPART, as_picked.preapproach.backwards(), empty, settings.preapproach_speed),
    )
    return Landing(inward, away, cost)
