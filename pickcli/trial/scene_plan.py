"""A plan that a trial executed, with the scene that it was certified for."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.motion.plan import Plan
from pickcli.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class ScenePlan:
    """A plan that was executed.

    Attributes:
        plan: The certified plan.
        seen: The scene that it was certified for.
    """

    plan: Plan
    seen: Scene
