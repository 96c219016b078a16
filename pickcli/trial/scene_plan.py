"""A plan that a trial executed, with the scene that it was certified for, and both as files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from pickcli.motion.plan import Plan
from pickcli.motion.plan_file import write_plan
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import write_scene


@dataclass(frozen=True, eq=False)
class ScenePlan:
    """A plan that was executed.

    Attributes:
        plan: The certified plan.
        seen: The scene that it was certified for.
    """

    plan: Plan
    seen: Scene


def plan_writers(plans: Sequence[ScenePlan]) -> Iterator[tuple[str, Callable[[Path], None]]]:
    """Yield the files of executed plans with their scenes, and what writes them; without wall times.

    Args:
        plans: The plans, in order.

    Yields:
        Names of files, and functions that write to a path.
    """
    for k, each in enumerate(plans, start=1):
        yield f"plan_{k:03}.json", partial(write_plan, replace(each.plan, statistics={}))
        yield f"seen_{k:03}.json", partial(write_scene, each.seen)
