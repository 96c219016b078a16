"""Checks of a target before any grasp: whether other items need it, or its pose contradicts others."""

from __future__ import annotations

import numpy as np

from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, inverse
from pickcli.planning.pick_problem import PickProblem
from pickcli.scene.scene import PlacedItem
from pickcli.scene.solid_overlap import TOUCH
from pickcli.statics.pushing import riders
from pickcli.statics.unrecognised import NOT_RECOGNISED, unrecognised_at


def check_target(problem: PickProblem) -> Failures:
    """Find every reason not to pick the target, as the scene is perceived.

    Args:
        problem: The pick.

    Returns:
        The reasons, with the items that must be cleared first at the head; empty if there are none.
    """
    return Failures((*_blocking(problem), *_unrecognised(problem), *_contradictions(problem)))


def _blocking(problem: PickProblem) -> tuple[Reason, ...]:
    """Return the items that would fall or roll away if the target were removed.

    Those that it may push aside only slide off, unless they ride on it.
    """
    supports, target = problem.contacts.supports, problem.target.id
    lying, left_out = supports.graph.lying_on(target), problem.ignored | problem.pushed
    riding = riders(supports, target) if problem.pushed else ()
    return (
        *(Reason("rests on the target", "lift", f"{name} would be carried along", name) for name in riding),
        *(
            Reason(
                "rests on the target" if name in lying else "falls without the target", "lift",
                f"{name} would fall or roll away", name,
            )
            for name in supports.blocking(target)
            if name not in left_out and name not in riding
        ),
    )  # fmt: skip


def _unrecognised(problem: PickProblem) -> tuple[Reason, ...]:
    """Return the nearest thing that nobody recognised, if it may rest on the target or lean on it."""
    target = problem.target
    found = unrecognised_at(problem.scene, target.id)
    if not found:
        return ()
    detail = f"what nobody recognised may rest on {target.id} or lean on it; look again"
    return (Reason(NOT_RECOGNISED, "at rest", f"{found[0]}: {detail}"),)


def _contradictions(problem: PickProblem) -> tuple[Reason, ...]:
    """Return the solids that the target overlaps by more than pose errors explain."""
    scene = problem.scene
    bound = {placed.id: scene.bound(placed) for placed in scene.items}
    for carrier in scene.posed_carriers:
        error = carrier.error.bound(_from_axis(carrier.T_world_carrier, problem.target))
        bound |= dict.fromkeys((body.name for body in carrier.bodies), error)
    ids = {placed.id for placed in scene.items}
    found = []
    for name, c in problem.contacts.near.items():
        explained = TOUCH + problem.uncertainty + bound[name]
        if -c.gap > explained:
            deep = f"{-1e3 * c.gap:.1f} mm inside {name}, {1e3 * explained:.1f} explained; look again"
            blamed = name if name in ids else ""
            found.append(Reason("poses contradict each other", "at rest", deep, blamed))
    return tuple(found)


def _from_axis(T_world_carrier: Array, placed: PlacedItem) -> float:
    """Bound the distance of any point of an item from the z axis of a carrier at a pose (4, 4), m."""
    p = (inverse(T_world_carrier) @ placed.T_world_item)[:2, 3]
    return float(np.linalg.norm(p)) + placed.item.shape.bounding_radius
