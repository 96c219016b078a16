"""Has the verifier judge what the planner proposes, and keeps what was rejected."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from pickcli.errors import Failures
from pickcli.motion.plan import Plan
from pickcli.planning.pick_problem import Certify
from pickcli.scene.scene import Scene
from pickcli.trial.trial_result import RejectedPlan

if TYPE_CHECKING:
    from pickcli.motion.trajectory import Trajectory
    from pickcli.verification.verdict import Verdict


@dataclass
class Certifier:
    """Asks the verifier for the certificates of one query's plans.

    Attributes:
        verify: The verifier: judges a plan in a scene; the trajectory is that of a motion that stopped.
        rejected: The plans that it refused, in their order.
        seconds: Wall time that it took.
    """

    verify: Callable[[Plan, Scene, Trajectory | None], Verdict]
    rejected: list[RejectedPlan] = field(default_factory=list)
    seconds: float = 0.0

    def within(self, scene: Scene) -> Certify:
        """What certifies plans that are made in a scene.

        Args:
            scene: The scene, as the arm sees it that the plans are for.

        Returns:
            A function that gives a plan its certificate, or says why it gets none.
        """

        def certify(plan: Plan) -> Plan | Failures:
            began = time.perf_counter()
            verdict = self.verify(plan, scene, None)
            self.seconds += time.perf_counter() - began
            if verdict.certificate is not None:
                return replace(plan, certificate=verdict.certificate)
            self.rejected.append(RejectedPlan(plan.grasp, verdict.reasons))
            return Failures(verdict.reasons).within("rejected by the verifier")

        return certify
