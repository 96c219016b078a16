"""What speaks against picking a target: others need it, or its pose cannot be right."""

from __future__ import annotations

import numpy as np

from pickcli.errors import Failures, Reason
from pickcli.geometry import inverse
from pickcli.planning.pick_problem import PickProblem
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_overlap import TOUCH


def check_target(problem: PickProblem) -> Failures:
    """Find every reason not to pick the target as the scene is seen.

    Args:
        problem: The pick.

    Returns:
        The reasons, what must be cleared first at the head; empty if nothing speaks against it.
    """
    return Failures((*_blocking(problem), *_contradictions(problem)))


def _blocking(problem: PickProblem) -> tuple[Reason, ...]:
    """Items that would fall or roll away if the target went."""
    supports, target = problem.contacts.supports, problem.target.id
    lying = supports.lying_on(target)
    return tuple(
        Reason(
            "rests on the target" if name in lying else "falls without the target", "lift",
            f"{name} would fall or roll away", name,
        )
        for name in supports.falling(target)
        if name not in problem.ignored
    )  # fmt: skip


def _contradictions(problem: PickProblem) -> tuple[Reason, ...]:
    """What the target overlaps with, as its pose says, deeper than poses may be off."""
    scene = problem.scene
    bound = {placed.id: scene.noise.bound(placed.item) for placed in scene.items}
    pod_error = scene.pod_error.bound(_from_axis(scene, problem.target))
    found = []
    for name, c in problem.contacts.near.items():
        explained = TOUCH + problem.uncertainty + bound.get(name, pod_error)
        if -c.gap > explained:
            deep = f"{-1e3 * c.gap:.1f} mm inside {name}, {1e3 * explained:.1f} explained; look again"
            blamed = name if name in bound else ""
            found.append(Reason("poses contradict each other", "at rest", deep, blamed))
    return tuple(found)


def _from_axis(scene: Scene, placed: PlacedItem) -> float:
    """How far from the pod's z axis any point of an item may be, m."""
    p = (inverse(scene.T_world_pod) @ placed.T_world_item)[:2, 3]
    return float(np.linalg.norm(p)) + float(np.linalg.norm(placed.item.shape.extents)) / 2
