"""The search for what to move aside, item after item, until a target can be picked."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

from pickcli.cell.tool import Tool
from pickcli.errors import NoPlanError
from pickcli.grasping.method_choice import may_hold
from pickcli.motion.plan import Grasp
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.trial.attempt_runner import AttemptRunner
from pickcli.trial.blocking_items import in_the_way, worth_moving
from pickcli.trial.trial_result import Attempt


class Clearing:
    """What is in the way of one target in one scene, the most blamed first.

    Attributes:
        is_reachable: Whether the target itself was planned for as it is seen: then nothing need go.

    Args:
        runner: Who plans, charged to its clock.
        wanted: The attempt at the target, the arms ranked for it.
        scene: The scene as it is seen.
        tools: Of every arm.
        exclude: Grasps of the target that failed before.
    """

    def __init__(
        self,
        runner: AttemptRunner,
        wanted: Attempt,
        scene: Scene,
        tools: Sequence[Tool],
        exclude: Sequence[Grasp],
    ) -> None:
        self._runner, self._wanted, self._scene = runner, wanted, scene
        self._tools, self._exclude = tools, exclude
        self._queue: list[str] = []
        self._asked: set[str] = set()
        self.is_reachable = False

    def blame(self, is_hopeful: bool, blamed: Sequence[str] | None) -> None:
        """Find what the target cannot be picked with.

        Args:
            is_hopeful: Whether what is blamed counts although moving it is not known to be enough.
            blamed: Items that a plan blamed in this very scene, if one was refused in it.
        """
        self._queue += in_the_way(self._what_if, self._scene, self._target, is_hopeful, blamed)

    def next_item(self) -> str | None:
        """Name the next item that a tool may hold, each once.

        Returns:
            Its id; None where there is none left.
        """
        left = (name for name in self._promising() if name not in self._asked)
        name = next((name for name in left if may_hold(self._tools, self._scene.find(name).item)), None)
        self._asked |= set() if name is None else {name}
        return name

    def also(self, names: Sequence[str]) -> None:
        """Look at more items, of the target's place: what cannot be moved may lie under something that can.

        Args:
            names: Their ids; those in other places are left out.
        """
        here = {p.id for p in self._scene.in_location(self._target.location)} - {self._target.id}
        self._queue += [name for name in names if name in here]

    @cached_property
    def _target(self) -> PlacedItem:
        return self._scene.find(self._wanted.item)

    @cached_property
    def _others(self) -> tuple[str, ...]:
        """The rest of the place: costs a planning call, asked for when nothing blamed can be moved."""
        return worth_moving(self._what_if, self._scene, self._target, self._tools)

    def _promising(self) -> Iterator[str]:
        yield from self._queue
        yield from self._others

    def _what_if(self, without: Scene) -> None:
        """Plan the pick in another scene. Raises NoPlanError if there is no plan, or no time for one."""
        if not self._runner.has_time_to_plan:
            raise NoPlanError("a pick without what is in its way", [])
        self._runner.plan(without, self._wanted, self._exclude)
        self.is_reachable = self.is_reachable or without is self._scene
