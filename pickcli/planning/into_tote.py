"""Letting an item go over the tote: straight down between the walls, and straight up again."""

from __future__ import annotations

import numpy as np

from pickcli.cartesian.line_following import follow_line
from pickcli.collision.checker import SceneChecker
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.motion.segment import SegmentKind
from pickcli.planning.bin_query import BinQuery
from pickcli.planning.landing import Landing, Step
from pickcli.planning.stages.grasp_motion import InBin
from pickcli.planning.stages.tote_placements import Spot, spots
from pickcli.seeds import derived_rng

WANTED = 4  # landings among which the best whole motion is chosen
COST = 2.0  # s that a metre of a spot's cost is worth


def into_tote(query: BinQuery, chosen: InBin, seed: int) -> tuple[Landing, ...] | Failures:
    """Spots whose straight lines are proven, the best first; or every reason why there is none."""
    planner, tool_state, target = query.planner, chosen.grasp.tool_state, query.target.id
    places = spots(query.scene, chosen.held, tool_state)
    if isinstance(places, Reason):
        return Failures.of(places)
    rng = derived_rng(seed, "drop", target)
    named = [c.q for c in planner.cell.configurations.values() if c.kind in ("tote", "drop")]
    contacts = query.contacts
    carrying = planner.checker(query.scene, tool_state, chosen.held, contacts.while_transferring())
    empty = planner.checker(query.scene, tool_state, contacts=contacts.after_dropping())
    found: list[Landing] = []
    failures = Failures()
    for spot in places:
        seeds = np.vstack([chosen.retreat[-1].waypoints[-1], *named, planner.arm.random_seeds(rng, 4)])
        solutions = planner.arm.solve(spot.above, tool_state, seeds)
        for q in solutions[carrying.are_valid(solutions)]:
            landing = _landing(query, spot, q, chosen, carrying, empty)
            if not isinstance(landing, Reason):
                found.append(landing)
                break
            failures += landing
        if len(found) >= WANTED:
            break
    none = Reason("no free place in the tote", "place", f"{len(places)} spots tried")
    return tuple(found) or failures + none


def _landing(
    query: BinQuery, spot: Spot, q: Array, chosen: InBin, carrying: SceneChecker, empty: SceneChecker
) -> Landing | Reason:
    """The proven lines of one spot, from a configuration above the tote."""
    planner, speed = query.planner, query.planner.settings.place_speed
    down = follow_line(planner.arm, carrying, spot.above, spot.release, chosen.grasp.tool_state, q, "place")
    if isinstance(down, Reason):
        return down
    # The way up is the way down without the item: a part of the volume that was just proven free.
    place = Step(SegmentKind.PLACE, down, carrying, speed)
    depart = Step(SegmentKind.DEPART, down.backwards(), empty, speed)
    return Landing((place,), (depart,), COST * spot.cost)
