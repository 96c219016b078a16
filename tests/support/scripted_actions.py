"""A trial whose outcomes are written by hand, for strategies that are played without a simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from pickcli.strategy.node_types import ActionKind
from pickcli.strategy.trial_actions import OpenTarget

ACTION_TIME = 10.0  # s per pick or removal
LOOK_TIME = 1.0  # s


@dataclass
class ScriptedActions:
    """A trial with targets and the outcome of each action on them.

    Attributes:
        targets: Open targets, by their lines.
        outcomes: By line, letters of the coming actions: d delivered, f failed, n no plan; for removals
            m moved, s stuck. Without any left, picks fail and removals are stuck.
        limit: s, end of the trial.
        calls: All actions, as "pick 0", "clear 0", "look", "give up 0".
    """

    targets: dict[int, OpenTarget]
    outcomes: dict[int, str]
    limit: float = 900.0
    now: float = 0.0
    calls: list[str] = field(default_factory=list)

    @property
    def time_left(self) -> float:
        return max(0.0, self.limit - self.now)

    @property
    def has_time_to_plan(self) -> bool:
        return self.now + ACTION_TIME <= self.limit

    def open_targets(self) -> Sequence[OpenTarget]:
        return [self.targets[k] for k in sorted(self.targets)]

    def look(self) -> bool:
        self.calls.append("look")
        self.now += LOOK_TIME
        return self.time_left > 0.0

    def pick(self, index: int) -> bool:
        outcome = self._next(f"pick {index}", index)
        target = self.targets[index]
        rates = {ActionKind.PICK: 0.5 * target.rates[ActionKind.PICK], ActionKind.CLEAR: 1e-3}
        if outcome == "d":
            del self.targets[index]
        else:
            self.targets[index] = replace(
                target, n_attempts=target.n_attempts + 1, has_no_plan=outcome == "n", rates=rates
            )
        return outcome == "d"

    def clear(self, index: int) -> bool:
        outcome = self._next(f"clear {index}", index)
        target = self.targets[index]
        only_pick = {ActionKind.PICK: target.rates[ActionKind.PICK]}
        self.targets[index] = replace(target, has_no_plan=outcome != "m", rates=only_pick)
        return outcome == "m"

    def give_up(self, index: int) -> None:
        self.calls.append(f"give up {index}")
        del self.targets[index]

    def _next(self, call: str, index: int) -> str:
        self.calls.append(call)
        self.now += ACTION_TIME
        letters = self.outcomes.get(index, "")
        self.outcomes[index] = letters[1:]
        return letters[:1] or "f"


def scripted(
    outcomes: Mapping[int, str], limit: float = 900.0, **changes: Mapping[int, object]
) -> ScriptedActions:
    """A trial of one target per line, all alike but for changed attributes by line.

    Args:
        outcomes: Outcomes by line, see ``ScriptedActions``.
        limit: s, end of the trial.
        **changes: Values of attributes of ``OpenTarget``, by line.
    """
    targets = {}
    for index in outcomes:
        own = {name: values[index] for name, values in changes.items() if index in values}
        plain = OpenTarget(index, f"item_{index}", f"bin_{index}", 10, rates={ActionKind.PICK: 1.0})
        targets[index] = replace(plain, **own)  # type: ignore[arg-type]
    return ScriptedActions(targets, dict(outcomes), limit)
