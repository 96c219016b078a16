"""Has the verifier judge the planner's candidates, and keeps rejected plans."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from pickcli.errors import Failures
from pickcli.motion.plan import Certify, Plan
from pickcli.scene.scene import Scene
from pickcli.trial.trial_result import RejectedPlan

if TYPE_CHECKING:
    from pickcli.motion.trajectory import Trajectory
    from pickcli.verification.verdict import Verdict


@dataclass
class Certifier:
    """Requests the certificates of one query's plans from the verifier.

    Attributes:
        verify: The verifier: judges a plan in a scene; the trajectory is that of a stopped motion.
        rejected: Rejected plans, in order.
        seconds: Wall time spent in the verifier.
    """

    verify: Callable[[Plan, Scene, Trajectory | None], Verdict]
    rejected: list[RejectedPlan] = field(default_factory=list)
    seconds: float = 0.0

    def within(self, scene: Scene) -> Certify:
        """Return the function that certifies plans for a scene.

        Args:
            scene: The scene as seen by the plans' arm.

        Returns:
            Function that returns a plan with its certificate, or the reasons for its rejection.
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
