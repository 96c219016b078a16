"""Which targets of a trial could have been delivered: the question that a share of deliveries is of.

Deliverable is what a tool can hold and what can be planned, for any arm that plays, exactly where it stands,
once everything that a tool can hold is gone from its place: that could have been moved out of the way. Where
nothing of the kind could go first, be it that the target or something that stays rests on it, that is
reported apart. So is, of the rest, what no order of plans leads to, one item after another into the tote:
with exact poses, and with what a plan has to allow for poses that are known as well as in a trial.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.tool import Tool
from pickcli.errors import NoPlanError
from pickcli.geometry import GRAVITY, inverse
from pickcli.grasping.antipodal import pinches
from pickcli.grasping.grasp_target import GraspTarget
from pickcli.grasping.lip_coverage import bearing_share
from pickcli.grasping.method_choice import grasp_method
from pickcli.grasping.search import WIDE_SEARCH
from pickcli.grasping.suction_candidates import HOLDS
from pickcli.grasping.surfaces import faces
from pickcli.planning.blockers import from_the_mouth
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from pickcli.seeds import derived_rng
from pickcli.simulation.reality import Reality
from pickcli.statics.supports import supports_of
from pickcli.trial.pose_noise import DEFAULT_NOISE

CANNOT_BE_HELD = "cannot be held"
NO_PLAN_WHEN_CLEARED = "no plan when cleared"
CANNOT_BE_CLEARED = "cannot be cleared"  # what is in the way stays, or carries what stays
NO_ORDER = "no order of plans leads to it"
NO_ORDER_AS_KNOWN = "no order of plans leads to it as well as poses are known"


def why_not_deliverable(copies: Sequence[PlacedItem], scene: Scene, warm: Sequence[PlanningContext]) -> str:
    """Why none of the copies of a target is deliverable, "" if one is.

    warm: a planner for each arm that plays
    """
    tools = _tools(warm)
    if not any(is_holdable(copy.item, tools) for copy in copies):
        return CANNOT_BE_HELD
    if not any(is_plannable(copy, cleared(scene, copy, tools), warm) for copy in copies):
        return NO_PLAN_WHEN_CLEARED
    if not any(is_plannable(copy, _cleared_as_it_can_be(scene, copy, tools), warm) for copy in copies):
        return CANNOT_BE_CLEARED
    if not any(_leads_to(copy, scene, warm) for copy in copies):
        return NO_ORDER
    if not any(_leads_to(copy, as_known(scene), warm) for copy in copies):
        return NO_ORDER_AS_KNOWN
    return ""


def is_holdable(item: Item, tools: Iterable[Tool]) -> bool:
    """Whether one of the tools bears the item's weight.

    A cup, hanging straight below one of the faces on which it seals; fingers, by its middle between the pads,
    for which they open wide enough.
    """
    return any(_pinches(item, tool) if tool.gripper is not None else _seals(item, tool) for tool in tools)


def _seals(item: Item, tool: Tool) -> bool:
    wrench = np.array([0.0, 0.0, -GRAVITY * item.mass, 0.0, 0.0, 0.0])
    places = ((face.name, face.region.centre()[:3, 3]) for face in faces(item, tool))
    shares = (bearing_share(item, face, tip, tool.cup) for face, tip in places)
    return any(float(tool.cup.limits.ratio(wrench, share)) <= 1.0 for share in shares)


def _pinches(item: Item, tool: Tool) -> bool:
    gripper, widest = tool.gripper, max(tool.positions.values())
    assert gripper is not None
    rng = derived_rng("is holdable", item.name)
    ways_in = np.vstack([np.eye(3), -np.eye(3)])
    found = (p for way in ways_in for p in pinches(item.shape, gripper.pad, way, (0.0,), 0, rng, 0))
    is_light = GRAVITY * item.mass <= gripper.limits.max_shear
    return is_light and any(pinch.width < widest for pinch in found)


def _tools(warm: Sequence[PlanningContext]) -> tuple[Tool, ...]:
    return tuple(context.cell.robot.tool for context in warm)


def cleared(scene: Scene, target: PlacedItem, tools: Sequence[Tool]) -> Scene:
    """The scene with nothing left in the target's bin but the target and what no tool can hold."""
    here = scene.in_location(target.location)
    return _without(scene, (p for p in here if p is not target and is_holdable(p.item, tools)))


def _cleared_as_it_can_be(scene: Scene, target: PlacedItem, tools: Sequence[Tool]) -> Scene:
    """The scene without what could go before the target.

    What carries the target stays, so does what has no grasp as it lies, and what carries that.
    """
    supports = supports_of(scene)
    here = {p.id: p for p in scene.in_location(target.location)}
    todo = [name for name, p in here.items() if p is target or not _has_grasp(p, scene, tools)]
    stay = set(todo)
    while todo:
        below = [name for name in supports.graph.carriers(todo.pop()) if name in here and name not in stay]
        stay.update(below)
        todo += below
    return _without(scene, (p for name, p in here.items() if name not in stay))


def _leads_to(target: PlacedItem, scene: Scene, warm: Sequence[PlanningContext]) -> bool:
    """Whether the target can be planned once whatever can be planned before it is gone, one by one.

    What can be taken out beside an item can be taken out without it: the order makes no difference.
    """
    while not is_plannable(target, scene, warm):
        others = (p for p in scene.in_location(target.location) if p is not target)
        able = (p for p in others if is_holdable(p.item, _tools(warm)))
        first = next((p for p in from_the_mouth(scene, able) if is_plannable(p, scene, warm)), None)
        if first is None:
            return False
        scene = scene.without(first.id)
    return True


def as_known(scene: Scene) -> Scene:
    """The scene with the bounds on errors of poses that a trial states to planning; the poses are true."""
    level = Reality()
    error = Displacement(level.pod_position_error, level.pod_position_error, level.pod_angle_error)
    return replace(scene, noise=DEFAULT_NOISE, pod_error=error)


def _has_grasp(placed: PlacedItem, scene: Scene, tools: Iterable[Tool]) -> bool:
    """Whether a tool would hold an item as it lies, whatever is around it."""
    place = scene.cell.places[placed.location]
    T_entry_item = inverse(scene.T_world_place(place) @ place.T_place_entry) @ placed.T_world_item
    target = GraspTarget(placed.id, placed.item, T_entry_item, place)
    return any(
        grasp_method(tool).sample(target, derived_rng("has grasp", placed.id), WIDE_SEARCH, HOLDS).batches
        for tool in tools
    )


def _without(scene: Scene, gone: Iterable[PlacedItem]) -> Scene:
    for placed in gone:
        scene = scene.without(placed.id)
    return scene


def is_plannable(target: PlacedItem, scene: Scene, warm: Sequence[PlanningContext]) -> bool:
    """Whether an arm can bring the target to the tote or, out of the tote, to any of the bins."""
    return any(_has_plan(target, replace(scene, cell=context.cell), context) for context in warm)


def _has_plan(target: PlacedItem, scene: Scene, context: PlanningContext) -> bool:
    """Whether the target can be brought to the tote or, out of the tote, to any of the bins."""
    home = context.cell.configurations["home"]
    start = Start(home.q, home.tool_state)
    for into in (TOTE,) if target.location != TOTE else context.cell.pod.bins:
        with suppress(NoPlanError):
            plan_pick(context, scene, PickQuery(target.location, target.id, into), start)
            return True
    return False
