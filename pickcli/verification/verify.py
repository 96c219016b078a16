"""Verify whether a plan may be executed in a scene.

The verifier shares only the data of cell, scene and plan, and a few laws, with the planner: kinematics,
shapes, distances and limits are computed here by other means. docs/verification.md names all that is shared.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.errors import Failures, Reason, RejectedError, StaleError
from pickcli.geometry import Array
from pickcli.motion.plan import Certificate, Plan, other_arm_elsewhere
from pickcli.motion.plan_file import motion_hash
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import SCENE_FIGURES, scene_hash
from pickcli.verification.belt_view import BeltView, check_tracking
from pickcli.verification.clearance_check import Clearance, check_clearance
from pickcli.verification.cloud_points import near_points
from pickcli.verification.contact_check import check_touch
from pickcli.verification.effort_check import check_efforts
from pickcli.verification.event_check import check_io
from pickcli.verification.exemptions import Exemptions, exemptions
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.hold_choice import check_hold
from pickcli.verification.joint_limit_check import Ratios, check_limits
from pickcli.verification.moving_parts import Part, farthest, parts_of_segments
from pickcli.verification.push_check import check_push, pushed_by
from pickcli.verification.query_check import check_destination
from pickcli.verification.recovery_check import check_opening, check_recovery, needed_clearance
from pickcli.verification.release_check import check_release
from pickcli.verification.state_sampling import MAX_STEP, States, sample_states
from pickcli.verification.static_solids import PlanFixtures, plan_fixtures
from pickcli.verification.straightness_check import check_lines
from pickcli.verification.structure_check import check_structure
from pickcli.verification.support_check import check_support
from pickcli.verification.tipping_check import check_tipping
from pickcli.verification.tool_speed import check_tool_speed
from pickcli.verification.topple_check import check_topple, is_toppling
from pickcli.verification.upright_check import check_upright
from pickcli.verification.verdict import Verdict

MOTION_CHECKS = (
    "structure: names, times, contiguous segments, the item held from contact to release",
    "clearance: arm, tool and held item keep the cell's from world and themselves, exact shapes, at any time",
    "limits: position, velocity, acceleration, jerk at every instant; rest at both ends",
    "lines: straight where stated, contact along the tool axis at the tool's speed",
    "tool speed: nowhere over the cell's limit, where it states one",
    "motors: strong enough for weight, payload and motion, by the masses and inertias of the links",
    "events: anchors, leads, order, tool states",
)
ITEM_CHECKS = (  # of a plan that takes or carries an item
    "planned contacts: only where the item is taken and set down, no deeper than noise and bellows",
    "support: nothing rests or leans on what is taken, and no cup from above tips it over what carries it",
    "grasp: on the surface, inside the face, met at contact, holds under gravity and acceleration",
    "release: between walls that are open above, below the drop limit; or in a place, just over its floor",
)
PUSH_CHECKS = (
    "pushing: only light items in an open box, slowly, outwards, nothing carried along, load in reserve",
)
TOPPLE_CHECKS = (
    "toppling: an empty cup, slowly and not downwards, against light items that cannot leave box or bin",
)
RECOVERY_CHECKS = (
    "recovery: a way out of a stop as its level says, out or back; what is near at its start only opens",
)

TRACKING_CHECKS = (
    "line tracking: within the window; free of all that rides on the belt, at its speed, and of the hall",
)

UPRIGHT_CHECKS = ("upright: the held item is never tilted farther than the plan states",)

MANY_STATES = 30_000  # twenty seconds at full speed: a plan that breaks a limit is not sampled more finely
FAR_BEYOND = 10.0  # times a velocity limit: so much motion would take too long to check


def verify(plan: Plan, scene: Scene, stopped: Trajectory | None = None) -> Verdict:
    """Check a plan against the scene in which it is to be executed.

    Args:
        plan: The plan.
        scene: The scene.
        stopped: For a backward recovery motion, the motion that stopped; without it such a plan may only lead
            out of the pod.

    Returns:
        A certificate, or every reason against the plan.

    Raises:
        StaleError: If the plan was made for another cell or another scene.
    """
    digest = _same_world(plan, scene)
    reasons = check_structure(plan, scene)
    if reasons:
        return Verdict(None, reasons)
    if plan.tracking is not None:
        return _verify_tracked(plan, scene, digest)
    ratios = check_limits(plan, scene)
    if not ratios.velocity <= FAR_BEYOND:
        return Verdict(None, ratios.reasons)
    T_tip_item = pose_in_tool(plan, scene)
    moving = parts_of_segments(plan, scene, T_tip_item)
    states = sampled(plan, scene, moving)
    if ratios.reasons and len(states.times) > MANY_STATES:
        return Verdict(None, ratios.reasons)
    if not states.max_step <= MAX_STEP * 1.001:
        return Verdict(
            None, (Reason("too much motion", "trajectory", "more states than the verifier looks at"),)
        )
    cloud = near_points(plan, scene, states, moving)
    world = replace(plan_fixtures(plan, scene, T_tip_item), cloud=cloud.fixtures)
    exempt = exemptions(plan, scene, states, moving, world)
    opening = check_opening(plan, scene, states, moving, world, exempt)
    clearance = check_clearance(
        plan, states, moving, world, exempt, opening.pairs, needed_clearance(plan, scene)
    )
    reasons = (
        *ratios.reasons,
        *clearance.reasons,
        *opening.reasons,
        *check_recovery(plan, scene, states, ratios.velocity, opening, stopped),
        *check_touch(plan, scene, states, moving, world, exempt),
        *check_support(plan, scene),
        *check_push(plan, scene, T_tip_item),
        *check_topple(plan, scene),
        *check_tipping(plan, scene),
        *check_lines(plan, scene.cell.robot, states),
        *check_tool_speed(plan, scene.cell),
        *check_upright(plan, scene),
        *check_efforts(plan, scene, states, T_tip_item),
        *check_hold(plan, scene, T_tip_item),
        *check_io(plan, scene),
        *check_release(plan, scene, T_tip_item),
        *check_destination(plan, scene, T_tip_item),
    )
    if reasons:
        return Verdict(None, reasons)
    return Verdict(
        _certificate(plan, scene, digest, states, ratios, min(clearance.minimum, cloud.proven)), ()
    )


def _verify_tracked(plan: Plan, scene: Scene, digest: str) -> Verdict:
    """Check a plan that takes its item from a running conveyor, without a fault in its structure."""
    reasons = tuple(check_tracking(plan, scene))
    ratios = check_limits(plan, scene)
    if reasons or not ratios.velocity <= FAR_BEYOND:
        return Verdict(None, (*reasons, *ratios.reasons))
    assert plan.grasp is not None
    view, item = BeltView.of(plan, scene), plan.grasp.item
    T_tip_item = pose_in_tool(plan, view.scene)
    hall = _Judged.of(plan, view.scene, T_tip_item)
    belt = _Judged.of(view.seen, view.seen_scene, T_tip_item)
    work = _Judged.of(view.at_work, view.seen_scene, T_tip_item)
    every = (hall, belt, work)
    if any(not each.states.max_step <= MAX_STEP * 1.001 for each in every):
        return Verdict(None, (Reason("too much motion", "trajectory", "more states than is looked at"),))
    needed = needed_clearance(plan, scene)
    standing = hall.clearance(view.in_hall(hall.world, item), needed)
    riding = belt.clearance(view.on_belt(belt.world), needed)
    reasons = (
        *ratios.reasons,
        *standing.reasons,
        *riding.reasons,
        *check_touch(work.plan, work.scene, work.states, work.moving, work.world, work.exempt(work.world)),
        *check_support(plan, view.scene),
        *check_push(plan, view.scene, T_tip_item),
        *check_tipping(work.plan, work.scene),
        *check_lines(work.plan, work.scene.cell.robot, work.states),
        *check_tool_speed(plan, scene.cell),
        *check_upright(plan, scene),
        *check_efforts(plan, scene, hall.states, T_tip_item),
        *check_hold(plan, view.scene, T_tip_item),
        *check_io(work.plan, work.scene),
        *check_release(plan, view.scene, T_tip_item),
        *check_destination(plan, view.scene, T_tip_item),
    )
    if reasons:
        return Verdict(None, reasons)
    least = min(standing.minimum, riding.minimum)
    return Verdict(_certificate(plan, scene, digest, hall.states, ratios, least), ())


@dataclass(frozen=True, eq=False)
class _Judged:
    """A plan in one frame: its states, the parts that move in each segment, and what stands there."""

    plan: Plan
    scene: Scene
    states: States
    moving: Sequence[tuple[Part, ...]]
    world: PlanFixtures

    @classmethod
    def of(cls, plan: Plan, scene: Scene, T_tip_item: Array | None) -> _Judged:
        """Sample a plan; T_tip_item (4, 4) is the pose of the item in the tool frame."""
        moving = parts_of_segments(plan, scene, T_tip_item)
        states = sampled(plan, scene, moving)
        return cls(plan, scene, states, moving, plan_fixtures(plan, scene, T_tip_item))

    def exempt(self, world: PlanFixtures) -> tuple[Exemptions, ...]:
        """Return the exemptions of every segment."""
        return exemptions(self.plan, self.scene, self.states, self.moving, world)

    def clearance(self, world: PlanFixtures, needed: float) -> Clearance:
        """Prove the clearance to some of the fixtures, m."""
        return check_clearance(self.plan, self.states, self.moving, world, self.exempt(world), needed=needed)


def _certificate(
    plan: Plan, scene: Scene, digest: str, states: States, ratios: Ratios, min_clearance: float
) -> Certificate:
    """Build the certificate of a plan without a fault."""
    return Certificate(
        motion_hash=motion_hash(plan),
        scene_hash=digest,
        cell_fingerprint=scene.cell.fingerprint,
        n_states=len(states.times),
        max_step=states.max_step,
        min_clearance=min_clearance,
        max_velocity_ratio=ratios.velocity,
        max_acceleration_ratio=ratios.acceleration,
        max_jerk_ratio=ratios.jerk,
        checks=(
            *MOTION_CHECKS,
            *(ITEM_CHECKS if plan.grasp is not None else ()),
            *(PUSH_CHECKS if pushed_by(plan) and not is_toppling(plan) else ()),
            *(TOPPLE_CHECKS if is_toppling(plan) else ()),
            *(RECOVERY_CHECKS if plan.recovery is not None else ()),
            *(TRACKING_CHECKS if plan.tracking is not None else ()),
            *(UPRIGHT_CHECKS if plan.upright is not None else ()),
        ),
    )


def certify(plan: Plan, scene: Scene) -> Plan:
    """Verify a plan and add its certificate.

    Args:
        plan: The plan.
        scene: The scene.

    Returns:
        The plan with its certificate.

    Raises:
        RejectedError: If the verifier does not accept it, with all reasons.
        StaleError: If the plan was made for another cell or another scene.
    """
    verdict = verify(plan, scene)
    if verdict.certificate is None:
        raise RejectedError(plan.query, verdict.reasons)
    return replace(plan, certificate=verdict.certificate)


def certifier(scene: Scene) -> Callable[[Plan], Plan | Failures]:
    """Return the function that judges the plans of a query, one after the other, until one is accepted.

    Args:
        scene: The scene in which they are to be executed.

    Returns:
        A function that returns a plan with its certificate, or the reasons for its rejection.
    """

    def certify_or_say_why(plan: Plan) -> Plan | Failures:
        try:
            return certify(plan, scene)
        except RejectedError as error:
            return Failures(error.reasons).within("rejected by the verifier")

    return certify_or_say_why


def _same_world(plan: Plan, scene: Scene) -> str:
    """Return the scene's hash; raise StaleError if cell or scene are not those of the plan."""
    if why := other_arm_elsewhere(plan, scene.cell):
        raise StaleError(f"the plan was {why}")
    digest = scene_hash(scene)
    pairs = (("cell", plan.cell_fingerprint, scene.cell.fingerprint), ("scene", plan.scene_hash, digest))
    for name, made_for, here in pairs:
        if made_for != here:
            mismatch = f"the plan was made for the {name} {made_for}, this is {here}"
            figures = f" ({SCENE_FIGURES})" if name == "scene" else ""
            source = "stream" if name == "scene" and plan.tracking is not None else name
            raise StaleError(f"{mismatch}{figures}; name the {source} that it was made for, or plan it again")
    return digest


def sampled(plan: Plan, scene: Scene, moving: Sequence[tuple[Part, ...]]) -> States:
    """Sample the states at which a plan is checked; ends of segments are among them.

    Args:
        plan: The plan.
        scene: The plan's scene.
        moving: Parts that move in each segment.

    Returns:
        The states.
    """
    reach = np.max([farthest(parts) for parts in moving], axis=0)
    ends = np.array([t for s in plan.segments for t in (s.t_start, s.t_end)])
    return sample_states(scene.cell.robot, plan.trajectory, ends, reach)
