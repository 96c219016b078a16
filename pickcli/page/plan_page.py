"""Page of one plan: its motion in its scene, with the verifier's verdict."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from pickcli.errors import Reason
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Certificate, Plan
from pickcli.page.cell_parts import node_parts, robot_part
from pickcli.page.failure_marks import failure_marks, named_parts
from pickcli.page.motion_parts import (
    carried_items,
    device_lanes,
    limit_signals,
    motion_part,
    riding_tracks,
    samples_of,
    segment_lane,
)
from pickcli.page.page_document import PageDocument
from pickcli.page.page_scene import Fact, Tone, rounded
from pickcli.page.path_clearance import path_clearance
from pickcli.page.scene_page import standing_page
from pickcli.scene.scene import Scene
from pickcli.verification.verify import verify


def plan_page(plan: Plan, scene: Scene) -> PageDocument:
    """Create the page of a plan with the verdict of the verifier.

    Args:
        plan: The plan.
        scene: The scene of the plan.

    Returns:
        The page.

    Raises:
        StaleError: The plan was made for another cell or another scene.
    """
    verdict = verify(plan, scene)
    cell, samples, carried = scene.cell, samples_of(plan, scene.cell.robot), carried_items(plan, scene)
    item = "" if plan.grasp is None else plan.grasp.item
    middle = Arm(cell.robot).tip(samples.Q[len(samples.Q) // 2], cell.robot.tool.default_state)[:3, 3]
    subtitle = f"cell {cell.name}, {plan.trajectory.duration:.2f} s, seed {plan.seed}"
    return replace(
        standing_page(scene, "plan", plan.query, subtitle),
        facts=(*_facts(plan, scene), *_verdict(verdict.certificate, verdict.reasons)),
        robot=robot_part(cell, samples.Q[0]),
        nodes=node_parts(cell),
        motion=motion_part(samples, carried, riding_tracks(plan, scene)),
        lanes=(segment_lane(plan.segments), *device_lanes(plan.events, cell, plan.trajectory.duration)),
        signals=limit_signals(plan.trajectory, cell, samples.times),
        clearance=path_clearance(_standing(plan, scene), plan.segments, samples.times, samples.Q, carried),
        marks=failure_marks(verdict.reasons, named_parts(scene), item),
        focus=rounded(middle),
    )


def _standing(plan: Plan, scene: Scene) -> Scene:
    """Return the scene without the items that ride on a running conveyor, besides the one that is taken."""
    if plan.tracking is None or plan.grasp is None:
        return scene
    places = scene.cell.carriers[plan.tracking.conveyor].places
    kept = (p for p in scene.items if p.location not in places or p.id == plan.grasp.item)
    return replace(scene, items=tuple(kept))


def _facts(plan: Plan, scene: Scene) -> Iterator[Fact]:
    if (grasp := plan.grasp) is not None:
        yield Fact("item", f"{grasp.item}, {1e3 * scene.item(grasp.item).mass:.0f} g")
        yield Fact("grasp", f"{grasp}, tool {grasp.tool_state}")
        yield Fact("load", f"{grasp.load_ratio:.0%} of what the tool bears")
    if plan.speed_scale < 1.0:
        yield Fact("carried at", f"{plan.speed_scale:.0%} of full speed")
    if plan.recovery is not None:
        yield Fact("recovery", str(plan.recovery))
    if plan.arm:
        yield Fact("arm", plan.arm)
    if (tracking := plan.tracking) is not None:
        yield Fact(
            "conveyor",
            f"{tracking.conveyor} runs at {tracking.speed:g} m/s; the curve of the clearance "
            "is to what stands",
        )


def _verdict(certificate: Certificate | None, reasons: tuple[Reason, ...]) -> Iterator[Fact]:
    if certificate is None:
        yield Fact("verifier", f"rejects it: {len(reasons)} reasons", Tone.BAD)
        return
    yield Fact("verifier", "accepts it", Tone.GOOD)
    yield Fact("clearance", f"at least {certificate.clearance_mm:.1f} mm outside of planned contacts")
    for name in ("velocity", "acceleration", "jerk"):
        yield Fact(name, f"{getattr(certificate, f'max_{name}_ratio'):.1%} of the limit")
    yield Fact("looked at", f"{certificate.n_states} states")
